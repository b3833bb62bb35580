#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/path/path_random.h"
#include "render/path/path_tracer.h"

namespace insitu::render {

/// A path that is under way, on a flight that may collide or on a shadow ray, and waits for an
/// answer.
struct Path {
  /// What it asks.
  enum class Asks : std::uint8_t {
    value, ///< of the field at its place
    light, ///< how much of it surfaces let through from the ray's origin to far
    wall   ///< which surface ahead on the ray it ends at
  };
  Ray ray;
  double t = 0, far = 0; ///< where it stands, and where the ray ends
  float majorant = 0;    ///< at the tentative collision that it stands at
  bool is_shadow = false;
  Asks asks = Asks::value;
  std::uint16_t medium = 0;         ///< whose that collision is, see PathTracer::media()
  std::uint32_t item = 0;           ///< which of the rays
  int bounces = 0;                  ///< real collisions
  const SurfaceHit* stop = nullptr; ///< the surface behind the medium
  PathRandom random;
  Color throughput, radiance;
  float alpha = 0;
  std::int64_t sample = 0; ///< of the frame
  // Of a shadow ray: what to go on with, the light at its end, and the share that got through.
  math::Vec3d at, incoming;
  Color light;
  double transmittance = 1;
  // Answers.
  PlaceValue found; ///< at its place; the last one until there is another
  double open = 1;
  double wall = HUGE_VAL; ///< distance of the surface that scattered light ends at
  Color wall_color;
  std::uint64_t seed = 0; ///< of the random numbers of that surface's light

  math::Vec3d place() const { return ray.origin + t * ray.direction; }
  /// Whether scattered light ends at the next surface ahead.
  bool ends_at(float opacity) { return random.unit() < double(opacity); }
};

/// The paths of a tile, a few thousand at a time side by side, so that what they ask is answered
/// in batches; a path that ends makes place for the next. One thread's at a time:
///
///     for (wave.begin(tracer, rays); !wave.waiting().empty(); wave.go_on())
///       ... // answers what all in wave.waiting() ask
///     wave.store();
class PathWave {
public:
  /// Tracer and rays must outlive store().
  void begin(const PathTracer& tracer, std::span<RayState> rays);
  std::span<Path> waiting() { return paths_; }
  void go_on();
  void store();

  std::size_t rays() const { return rays_.size(); }
  const PathCounts& counts() const { return counts_; }
  /// What store() took of a ray's samples; null where none has met the medium.
  const PathSums::Pixel* sum(std::size_t ray) const {
    return starts_[ray].from < starts_[ray].to ? &sums_[ray] : nullptr;
  }

  /// So many fill the locator's batches, and still fit a core's cache.
  static constexpr std::size_t side_by_side = 1024;

private:
  enum class Next { ends, flies, asks };
  /// Where a path first stops, if at all, and in which cell.
  struct Stop {
    double t;
    std::int64_t cell;
    std::int32_t layer;
  };

  void find_starts();
  void set_ray(Path& path, const Ray& ray, double far) const;
  // Each says whether the path waits for an answer.
  bool start_next(Path& path);
  bool proceed(Path& path);
  bool to_next_question(Path& path, Next next);

  Next end_of_ray(Path& path);
  Next resolve(Path& path);
  Next dim(Path& path, double share);
  Next collide(Path& path, double value);
  Next scatter(Path& path);
  Next finish(const Path& path);
  static Next ask(Path& path, Path::Asks what);

  bool advance(Path& path);
  bool fly(Path& path, std::uint16_t medium, double from, double to);
  void stop_at(const Path& path, const Stop& stop);
  void set_depth(std::uint32_t item);

  const PathTracer* tracer_ = nullptr;
  const PathTracingSettings* settings_ = nullptr;
  std::span<const Medium> media_;
  std::span<RayState> rays_;
  PathCounts counts_;
  std::vector<Stop> stops_; ///< [rays][samples, most_for_depth at most], if depth is asked for
  /// Where a ray enters the medium, for all of its samples; from >= to: never.
  std::vector<Stretch> starts_;
  std::vector<std::uint32_t> meets_; ///< the rays that do
  std::vector<PathSums::Pixel> sums_;
  std::vector<Path> paths_;
  std::vector<Stretch> stays_;
  std::int64_t first_sample_ = 0, jobs_ = 0, next_ = 0;
  std::int64_t depth_samples_ = 0; ///< 0: no depth is asked for
};

} // namespace insitu::render
