#pragma once

#include <cstdint>

#include "core/parallel.h"
#include "math/vec.h"
#include "render/camera/camera.h"
#include "render/light.h"
#include "render/surface/surface_hit.h"

namespace insitu::render {

/// The point to be lit.
struct SurfacePoint {
  math::Vec3d position;
  math::Vec3d normal;     ///< of length 1, towards the viewer's side
  math::Vec3d to_viewer;  ///< of length 1
  double clearance = 0;   ///< how far above the surface rays start that must not meet it again
  std::uint64_t seed = 0; ///< of its random numbers

  /// Where rays of light start.
  math::Vec3d start() const { return position + clearance * normal; }
};

/// What a volume's light and its scattered light meet of a frame's surfaces.
class SceneSurfaces {
public:
  /// The part of light that surfaces let through from the ray's origin to t_max.
  virtual double open(const Ray& ray, double t_max) const = 0;
  /// The first surface ahead at which the ray ends, by `ends` of each one's opacity in turn; sets
  /// its distance, infinite where there is none, and what is seen of it. seed: of its random
  /// numbers.
  virtual void meet(const Ray& ray, core::FunctionRef<bool(float opacity)> ends, std::uint64_t seed,
                    double& t, Color& color) const = 0;

protected:
  ~SceneSurfaces() = default;
};

/// Lights surfaces as Lighting says, by the side that the viewer sees: a light behind a surface
/// does not reach it. Shadows and ambient occlusion ask other surfaces through `open`; neither
/// costs a ray unless asked for.
class Shader {
public:
  /// occlusion_distance: where lighting leaves it to the mesh's size.
  Shader(const Lighting& lighting, double occlusion_distance);

  /// The part of light that comes through from the ray's origin to t_max.
  using Open = core::FunctionRef<double(const Ray& ray, double t_max)>;

  /// The factor on a surface's colour.
  Color operator()(const SurfacePoint& at, const Open& open, SurfaceCounts& counts) const;

  /// The rays that the factor asks for, in streams: occlusion and each light have one.
  int streams() const { return 1 + int(lighting_.lights.size()); }
  /// At most, of a point.
  std::size_t most_rays() const;
  /// Takes a ray of a stream from the point; its origin is SurfacePoint::start().
  using Send = core::FunctionRef<void(int stream, const math::Vec3d& direction, double t_max)>;
  void send(const SurfacePoint& at, const Send& take, SurfaceCounts& counts) const;
  /// The factor by the answers to these rays: next(stream) is what comes through the stream's next
  /// one.
  Color factor(const SurfacePoint& at, const core::FunctionRef<double(int stream)>& next) const;

  /// Whether there are lights that hang on where the point is.
  bool asks_place() const;
  /// Whether rays are sent at other surfaces.
  bool sends_rays() const { return lighting_.shadows || lighting_.occlusion_samples > 0; }

private:
  /// sky(samples, distance, stream): the open part of the half space above; beam(direction, t_max,
  /// stream): of a single ray.
  template <class Sky, class Beam>
  Color light(const SurfacePoint& at, Sky&& sky, Beam&& beam) const;
  template <class Take>
  void dome(const SurfacePoint& at, int samples, int stream, Take&& take) const;

  Lighting lighting_;
};

} // namespace insitu::render
