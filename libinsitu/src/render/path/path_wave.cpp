#include "render/path/path_wave.h"

#include <algorithm>
#include <cmath>

#include "render/path/phase_function.h"

namespace insitu::render {

namespace {

using math::Vec3d;

/// So many fill the locator's batches, and still fit a core's cache.
constexpr std::size_t side_by_side = 1024;

/// Below this, a shadow ray's share is left to roulette.
constexpr double faint = 0.125;

/// So many samples of a pixel tell its depth.
constexpr std::int64_t most_for_depth = 256;

float largest(const Color& c) {
  return std::max({c.r, c.g, c.b});
}
Color times(const Color& a, const Color& b) {
  return {a.r * b.r, a.g * b.g, a.b * b.b};
}

/// Visits the macrocells of what clips leave of a ray.
template <class Visit>
void for_each_left(const MacrocellGrid& grid, const std::vector<Clip>& clips,
                   std::vector<Stretch>& stays, const Ray& ray, double near, double far,
                   Visit&& visit) {
  if (clips.empty()) {
    for_each_macrocell(grid, ray, near, far, visit);
    return;
  }
  clip_ray(clips, ray, near, far, stays);
  bool goes_on = true;
  for (std::size_t i = 0; i < stays.size() && goes_on; ++i)
    for_each_macrocell(grid, ray, stays[i].from, stays[i].to,
                       [&](std::int64_t macrocell, double from, double to) {
                         return goes_on = visit(macrocell, from, to);
                       });
}

} // namespace

struct PathWave::Scratch {
  /// Where a path first stops, if at all, and in which cell.
  struct Stop {
    double t;
    std::int64_t cell;
  };
  std::vector<Stop> stops; ///< [rays][samples, most_for_depth at most], if depth is asked for
  /// Where a ray enters the medium, for all of its samples; from >= to: never.
  std::vector<Stretch> starts;
  std::vector<std::uint32_t> meets; ///< the rays that do
  std::vector<PathSums::Pixel> sums;
  std::vector<Path> paths;
  std::vector<Vec3d> points;
  std::vector<query::Location> locations;
  std::vector<Stretch> stays;
};

PathWave::Scratch& PathWave::scratch() {
  thread_local Scratch s; // some hundred KB, kept for the thread's life
  return s;
}

PathWave::PathWave(const PathTracer& tracer, std::span<RayState> rays,
                   std::span<const std::int64_t> pixels, PathCounts& counts)
    : tracer_(tracer), settings_(tracer.settings_), medium_(tracer.medium_), rays_(rays),
      pixels_(pixels), counts_(counts), s_(scratch()) {
  if (settings_.sums)
    first_sample_ = settings_.sums->samples;
}

void PathWave::run() {
  find_starts();
  jobs_ = std::int64_t(s_.meets.size()) * settings_.samples;
  s_.sums.assign(rays_.size(), PathSums::Pixel{0, 0, 0, 0});
  counts_.paths += jobs_;
  if (settings_.depth) {
    depth_samples_ = std::min<std::int64_t>(settings_.samples, most_for_depth);
    s_.stops.assign(rays_.size() * std::size_t(depth_samples_), {HUGE_VAL, -1});
  }
  s_.paths.resize(std::size_t(std::min<std::int64_t>(jobs_, side_by_side)));
  std::size_t going = 0;
  for (Path& path : s_.paths)
    if (start_next(path))
      ++going;
    else
      break;
  while (going > 0) {
    s_.paths.resize(going);
    locate();
    going = 0;
    for (std::size_t i = 0; i < s_.paths.size(); ++i) {
      Path& path = s_.paths[i];
      const bool goes_on =
          (resolve(path, s_.locations[i]) && to_next_point(path)) || start_next(path);
      if (goes_on && going++ != i)
        s_.paths[going - 1] = path;
    }
  }
  store();
}

/// What no ray of the tile meets is passed once, not by each sample.
void PathWave::find_starts() {
  s_.starts.assign(rays_.size(), {});
  s_.meets.clear();
  for (std::size_t i = 0; i < rays_.size(); ++i) {
    const RayState& state = rays_[i];
    double near = 0, far = HUGE_VAL;
    if (!tracer_.clip_to_bounds(state.ray, near, far))
      continue;
    if (!state.hits.empty() && state.hits.back().opacity >= 1)
      far = std::min(far, state.hits.back().t);
    if (!(near < far))
      continue;
    for_each_left(medium_.grid(), tracer_.clips_, s_.stays, state.ray, near, far,
                  [&](std::int64_t macrocell, double from, double) {
                    ++counts_.macrocells;
                    if (medium_.majorant(macrocell) > 0)
                      s_.starts[i] = {from, far};
                    return medium_.majorant(macrocell) <= 0;
                  });
    if (s_.starts[i].from < s_.starts[i].to)
      s_.meets.push_back(std::uint32_t(i));
  }
}

/// Begins paths until one has a point to locate.
bool PathWave::start_next(Path& path) {
  while (next_ < jobs_) {
    // Sample by sample, so that neighbours in the wave are neighbours in the image.
    const auto count = std::int64_t(s_.meets.size());
    const std::int64_t sample = next_ / count;
    const std::uint32_t item = s_.meets[std::size_t(next_ % count)];
    ++next_;
    const RayState& state = rays_[item];
    path = {};
    path.item = item;
    path.sample = sample;
    path.random =
        PathRandom(settings_.seed, settings_.cycle, std::uint64_t(pixels_[item]),
                   std::uint64_t(first_sample_ + tracer_.first_sample_ + tracer_.stride_ * sample));
    path.ray = state.ray;
    path.throughput = {1, 1, 1};
    path.t = s_.starts[item].from;
    path.far = s_.starts[item].to;
    for (const SurfaceHit& hit : state.hits)
      if (hit.opacity >= 1 || path.random.unit() < double(hit.opacity)) {
        path.stop = &hit;
        path.far = std::min(path.far, hit.t);
        break;
      }
    if (to_next_point(path))
      return true;
  }
  return false;
}

void PathWave::set_ray(Path& path, const Vec3d& from, const Vec3d& direction, double far) const {
  path.ray = {from, direction};
  path.t = 0;
  path.far = far;
  if (!tracer_.clip_to_bounds(path.ray, path.t, path.far))
    path.t = path.far = 0;
}

bool PathWave::to_next_point(Path& path) {
  while (!advance(path))
    if (!end_of_ray(path))
      return false;
  return true;
}

/// To the next tentative collision; false: the ray ends before.
bool PathWave::advance(Path& path) {
  if (!(path.t < path.far))
    return false;
  double depth = -std::log1p(-path.random.unit());
  bool found = false;
  for_each_left(medium_.grid(), tracer_.clips_, s_.stays, path.ray, path.t, path.far,
                [&](std::int64_t macrocell, double from, double to) {
                  ++counts_.macrocells;
                  const float majorant = medium_.majorant(macrocell);
                  const double across = double(majorant) * (to - from);
                  if (!(depth < across)) {
                    depth -= across;
                    return true;
                  }
                  path.t = std::min(to, from + depth / double(majorant));
                  path.majorant = majorant;
                  found = true;
                  return false;
                });
  return found;
}

bool PathWave::end_of_ray(Path& path) {
  if (path.is_shadow) {
    path.radiance = path.radiance + float(path.transmittance) * path.light;
    return scatter(path);
  }
  const Color& dome = tracer_.lights_.dome();
  if (path.bounces > 0) {
    path.radiance =
        path.radiance + times(path.throughput, path.wall < HUGE_VAL ? path.wall_color : dome);
  } else if (path.stop) {
    path.radiance = path.stop->color;
    path.alpha = 1;
    stop_at(path, path.stop->t, path.stop->cell);
  } else if (settings_.shows_dome) {
    path.radiance = dome;
    path.alpha = 1;
  }
  finish(path);
  return false;
}

bool PathWave::resolve(Path& path, const query::Location& location) {
  ++counts_.locations;
  path.last_cell = location.cell;
  if (!location)
    return true;
  const double value = medium_.value(location);
  double share = medium_.extinction(value) / double(path.majorant);
  if (share > 1) {
    ++counts_.violations;
    share = 1;
  }
  if (path.is_shadow)
    return dim(path, share);
  // What does not show takes no random number: it is as if nothing were there.
  return share > 0 && path.random.unit() < share ? collide(path, value) : true;
}

bool PathWave::dim(Path& path, double share) {
  path.transmittance *= 1 - share;
  if (path.transmittance < faint) {
    if (!(path.random.unit() * faint < path.transmittance))
      return scatter(path); // in the dark
    path.transmittance = faint;
  }
  return true;
}

bool PathWave::collide(Path& path, double value) {
  ++counts_.collisions;
  if (++path.bounces == 1)
    stop_at(path, path.t, path.last_cell);
  path.alpha = 1;
  const Color albedo = medium_.albedo(value);
  const bool ends = settings_.scattering == Scattering::none ||
                    (settings_.scattering == Scattering::single && path.bounces > 1);
  if (settings_.scattering == Scattering::none)
    path.radiance = albedo;
  path.throughput = times(path.throughput, albedo);
  if (!ends && path.bounces > settings_.max_bounces)
    ++counts_.cut;
  if (ends || path.bounces > settings_.max_bounces || !(largest(path.throughput) > 0)) {
    finish(path);
    return false;
  }
  path.at = path.ray.origin + path.t * path.ray.direction;
  path.incoming = path.ray.direction;
  if (!tracer_.lights_.has_small())
    return scatter(path);
  ++counts_.shadow_rays;
  const LightSample light = tracer_.lights_.sample(path.at, path.random.unit());
  const double phase = henyey_greenstein(dot(path.incoming, light.direction), settings_.anisotropy);
  path.light = float(phase) * times(path.throughput, light.irradiance);
  if (tracer_.surfaces_)
    path.light =
        float(tracer_.surfaces_->open({path.at, light.direction}, light.distance)) * path.light;
  path.is_shadow = true;
  path.transmittance = 1;
  set_ray(path, path.at, light.direction, light.distance);
  return true;
}

/// On from path.at in a new direction.
bool PathWave::scatter(Path& path) {
  path.is_shadow = false;
  if (settings_.scattering == Scattering::single) {
    if (!tracer_.lights_.has_dome() && !tracer_.surfaces_) { // nothing more to gather
      finish(path);
      return false;
    }
  } else if (const double left = double(largest(path.throughput)); left < settings_.roulette) {
    if (!(path.random.unit() * settings_.roulette < left)) {
      finish(path);
      return false;
    }
    path.throughput = float(settings_.roulette / left) * path.throughput;
  }
  ++counts_.scatterings;
  const double cosine = sample_henyey_greenstein(settings_.anisotropy, path.random.unit());
  const Vec3d direction = direction_around(path.incoming, cosine, path.random.unit());
  path.wall = HUGE_VAL;
  if (tracer_.surfaces_)
    tracer_.surfaces_->meet(
        {path.at, direction}, [&](float opacity) { return path.random.unit() < double(opacity); },
        std::uint64_t(0x1p53 * path.random.unit()), path.wall, path.wall_color);
  set_ray(path, path.at, direction, path.wall);
  return true;
}

void PathWave::locate() {
  const query::Sampler& sampler = medium_.sampler();
  s_.points.resize(s_.paths.size());
  s_.locations.resize(s_.paths.size());
  for (std::size_t i = 0; i < s_.paths.size(); ++i)
    s_.points[i] = s_.paths[i].ray.origin + s_.paths[i].t * s_.paths[i].ray.direction;
  if (settings_.locate == PathTracingSettings::Locate::batch) {
    sampler.locate_serial(s_.points, s_.locations, tracer_.options_);
    return;
  }
  const bool hints = settings_.locate == PathTracingSettings::Locate::last_cell;
  for (std::size_t i = 0; i < s_.paths.size(); ++i)
    s_.locations[i] =
        sampler.locate(s_.points[i], hints ? s_.paths[i].last_cell : -1, tracer_.options_);
}

void PathWave::stop_at(const Path& path, double t, std::int64_t cell) {
  if (path.sample < depth_samples_)
    s_.stops[std::size_t(path.item * depth_samples_ + path.sample)] = {t, cell};
}

/// The first stop by which half of the samples have come to theirs.
void PathWave::set_depth(std::uint32_t item) const {
  const auto first = s_.stops.begin() + item * depth_samples_;
  const auto middle = first + (depth_samples_ - 1) / 2;
  std::nth_element(first, middle, first + depth_samples_,
                   [](const Scratch::Stop& a, const Scratch::Stop& b) {
                     return a.t != b.t ? a.t < b.t : a.cell < b.cell;
                   });
  rays_[item].depth = middle->t;
  rays_[item].depth_cell = middle->cell;
}

void PathWave::finish(const Path& path) {
  PathSums::Pixel& sum = s_.sums[path.item];
  sum.r += double(path.radiance.r);
  sum.g += double(path.radiance.g);
  sum.b += double(path.radiance.b);
  sum.alpha += double(path.alpha);
}

void PathWave::store() {
  const auto samples = double(first_sample_ + settings_.samples);
  for (const std::uint32_t i : s_.meets) {
    PathSums::Pixel sum = s_.sums[i];
    if (settings_.sums) {
      PathSums::Pixel& all = settings_.sums->pixels[std::size_t(pixels_[i])];
      all.r += sum.r;
      all.g += sum.g;
      all.b += sum.b;
      all.alpha += sum.alpha;
      sum = all;
    }
    RayState& state = rays_[i];
    state.color = {float(sum.r / samples), float(sum.g / samples), float(sum.b / samples)};
    state.alpha = float(sum.alpha / samples);
    state.next_hit = state.hits.size();
    if (settings_.depth)
      set_depth(i);
  }
  if (!settings_.shows_dome)
    return;
  for (std::size_t i = 0; i < rays_.size(); ++i)
    if (!(s_.starts[i].from < s_.starts[i].to)) { // the same as every sample would show
      while (rays_[i].next_hit < rays_[i].hits.size())
        rays_[i].blend_next_hit();
      rays_[i].blend(tracer_.lights_.dome(), 1);
    }
}

} // namespace insitu::render
