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

  /// Whether rays are sent at other surfaces.
  bool sends_rays() const { return lighting_.shadows || lighting_.occlusion_samples > 0; }

private:
  double sky(const SurfacePoint& at, int samples, double distance, std::uint64_t stream,
             const Open& open) const;

  Lighting lighting_;
};

} // namespace insitu::render
