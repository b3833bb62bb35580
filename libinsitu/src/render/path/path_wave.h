#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/path/path_random.h"
#include "render/path/path_tracer.h"

namespace insitu::render {

/// A path that is under way: on a flight that may collide, or on a shadow ray.
struct Path {
  Ray ray;
  double t = 0, far = 0; ///< where it stands, and where the ray ends
  float majorant = 0;    ///< at the tentative collision that it stands at
  bool is_shadow = false;
  std::uint32_t item = 0;           ///< which of the rays
  int bounces = 0;                  ///< real collisions
  const SurfaceHit* stop = nullptr; ///< the surface behind the medium
  double wall = HUGE_VAL;           ///< distance of the surface that scattered light ends at
  Color wall_color;
  PathRandom random;
  Color throughput, radiance;
  float alpha = 0;
  std::int64_t last_cell = -1;
  std::int64_t sample = 0; ///< of the frame
  // Of a shadow ray: what to go on with, the light at its end, and the share that got through.
  math::Vec3d at, incoming;
  Color light;
  double transmittance = 1;
};

/// The paths of a tile, a few thousand at a time side by side, so that their points are located in
/// batches; a path that ends makes place for the next. One thread's.
class PathWave {
public:
  PathWave(const PathTracer& tracer, std::span<RayState> rays, std::span<const std::int64_t> pixels,
           PathCounts& counts);
  void run();

private:
  struct Scratch;
  static Scratch& scratch();

  void find_starts();
  bool start_next(Path& path);
  void set_ray(Path& path, const math::Vec3d& from, const math::Vec3d& direction, double far) const;
  // Each says whether the path goes on.
  bool to_next_point(Path& path);
  bool end_of_ray(Path& path);
  bool resolve(Path& path, const query::Location& location);
  bool dim(Path& path, double share);
  bool collide(Path& path, double value);
  bool scatter(Path& path);

  bool advance(Path& path);
  void locate();
  void stop_at(const Path& path, double t, std::int64_t cell);
  void set_depth(std::uint32_t item) const;
  void finish(const Path& path);
  void store();

  const PathTracer& tracer_;
  const PathTracingSettings& settings_;
  const Medium& medium_;
  std::span<RayState> rays_;
  std::span<const std::int64_t> pixels_;
  PathCounts& counts_;
  Scratch& s_;
  std::int64_t first_sample_ = 0, jobs_ = 0, next_ = 0;
  std::int64_t depth_samples_ = 0; ///< 0: no depth is asked for
};

} // namespace insitu::render
