#include "render/path/path_wave.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "render/path/phase_function.h"

namespace insitu::render {

namespace {

using math::Vec3d;

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

void PathWave::begin(const PathTracer& tracer, std::span<RayState> rays) {
  tracer_ = &tracer;
  settings_ = &tracer.settings_;
  media_ = tracer.media_;
  rays_ = rays;
  counts_ = {};
  first_sample_ = settings_->sums ? settings_->sums->samples : 0;
  find_starts();
  jobs_ = std::int64_t(meets_.size()) * settings_->samples;
  next_ = 0;
  sums_.assign(rays_.size(), PathSums::Pixel{0, 0, 0, 0});
  counts_.paths += jobs_;
  depth_samples_ =
      settings_->depth ? std::min<std::int64_t>(settings_->samples, most_for_depth) : 0;
  stops_.assign(rays_.size() * std::size_t(depth_samples_), {HUGE_VAL, -1, 0});
  paths_.resize(std::size_t(std::min<std::int64_t>(jobs_, side_by_side)));
  std::size_t going = 0;
  while (going < paths_.size() && start_next(paths_[going]))
    ++going;
  paths_.resize(going);
}

void PathWave::go_on() {
  std::size_t going = 0;
  for (std::size_t i = 0; i < paths_.size(); ++i) {
    Path& path = paths_[i];
    if ((proceed(path) || start_next(path)) && going++ != i)
      paths_[going - 1] = path;
  }
  paths_.resize(going);
}

/// What no ray of the tile meets is passed once, not by each sample.
void PathWave::find_starts() {
  starts_.assign(rays_.size(), {});
  meets_.clear();
  for (std::size_t i = 0; i < rays_.size(); ++i) {
    const RayState& state = rays_[i];
    double near = 0, far = HUGE_VAL;
    if (!tracer_->clip_to_bounds(state.ray, near, far))
      continue;
    if (!state.hits.empty() && state.hits.back().opacity >= 1)
      far = std::min(far, state.hits.back().t);
    double first = far;
    for (const Medium& medium : media_) {
      double from = near, to = first;
      if (!clip_to_box(state.ray, medium.bounds(), from, to))
        continue;
      for_each_left(medium.grid(), tracer_->clips_, stays_, state.ray, from, to,
                    [&](std::int64_t macrocell, double in, double) {
                      ++counts_.macrocells;
                      if (medium.majorant(macrocell) > 0)
                        first = in;
                      return medium.majorant(macrocell) <= 0;
                    });
    }
    if (first < far)
      starts_[i] = {first, far};
    if (starts_[i].from < starts_[i].to)
      meets_.push_back(std::uint32_t(i));
  }
}

/// Begins paths until one has a point to locate.
bool PathWave::start_next(Path& path) {
  while (next_ < jobs_) {
    // Sample by sample, so that neighbours in the wave are neighbours in the image.
    const auto count = std::int64_t(meets_.size());
    const std::int64_t sample = next_ / count;
    const std::uint32_t item = meets_[std::size_t(next_ % count)];
    ++next_;
    const RayState& state = rays_[item];
    path = {};
    path.item = item;
    path.sample = sample;
    path.random = PathRandom(
        settings_->seed, settings_->cycle, rays_[item].pixel,
        std::uint64_t(first_sample_ + tracer_->first_sample_ + tracer_->stride_ * sample));
    path.ray = state.ray;
    path.throughput = {1, 1, 1};
    path.t = starts_[item].from;
    path.far = starts_[item].to;
    for (const SurfaceHit& hit : state.hits)
      if (hit.opacity >= 1 || path.random.unit() < double(hit.opacity)) {
        path.stop = &hit;
        path.far = std::min(path.far, hit.t);
        break;
      }
    if (to_next_question(path, Next::flies))
      return true;
  }
  return false;
}

void PathWave::set_ray(Path& path, const Ray& ray, double far) const {
  path.ray = ray;
  path.t = 0;
  path.far = far;
  if (!tracer_->clip_to_bounds(path.ray, path.t, path.far))
    path.t = path.far = 0;
}

PathWave::Next PathWave::ask(Path& path, Path::Asks what) {
  path.asks = what;
  return Next::asks;
}

/// On with the answer.
bool PathWave::proceed(Path& path) {
  Next next = Next::flies;
  switch (path.asks) {
  case Path::Asks::value:
    next = resolve(path);
    break;
  case Path::Asks::light:
    path.light = float(path.open) * path.light;
    set_ray(path, path.ray, path.far);
    break;
  case Path::Asks::wall:
    set_ray(path, path.ray, path.wall);
    break;
  }
  return to_next_question(path, next);
}

bool PathWave::to_next_question(Path& path, Next next) {
  while (next == Next::flies)
    next = advance(path) ? ask(path, Path::Asks::value) : end_of_ray(path);
  return next == Next::asks;
}

/// To the next tentative collision, the nearest of all media; false: the ray ends before.
bool PathWave::advance(Path& path) {
  const double begin = path.t;
  double end = path.far;
  bool found = false;
  for (std::uint16_t m = 0; m < media_.size(); ++m) {
    double from = begin, to = end; // for one medium that is within its bounds
    if (!(from < to) || (media_.size() > 1 && !clip_to_box(path.ray, media_[m].bounds(), from, to)))
      continue;
    if (!fly(path, m, from, to))
      continue;
    end = path.t;
    found = true;
  }
  return found;
}

/// To where a medium's flight ends, if it does between two places of the ray.
bool PathWave::fly(Path& path, std::uint16_t medium, double from, double to) {
  const Medium& through = media_[medium];
  double depth = -std::log1p(-path.random.unit());
  bool found = false;
  for_each_left(through.grid(), tracer_->clips_, stays_, path.ray, from, to,
                [&](std::int64_t macrocell, double near, double far) {
                  ++counts_.macrocells;
                  const float majorant = through.majorant(macrocell);
                  const double across = double(majorant) * (far - near);
                  if (!(depth < across)) {
                    depth -= across;
                    return true;
                  }
                  path.t = std::min(far, near + depth / double(majorant));
                  path.majorant = majorant;
                  if (path.medium != medium)
                    path.found = {}; // a cell of another mesh
                  path.medium = medium;
                  found = true;
                  return false;
                });
  return found;
}

PathWave::Next PathWave::end_of_ray(Path& path) {
  if (path.is_shadow) {
    path.radiance = path.radiance + float(path.transmittance) * path.light;
    return scatter(path);
  }
  const Color& dome = tracer_->lights_.dome();
  if (path.bounces > 0) {
    path.radiance =
        path.radiance + times(path.throughput, path.wall < HUGE_VAL ? path.wall_color : dome);
  } else if (path.stop) {
    path.radiance = path.stop->color;
    path.alpha = 1;
    stop_at(path, {path.stop->t, path.stop->cell, path.stop->layer});
  } else if (settings_->shows_dome) {
    path.radiance = dome;
    path.alpha = 1;
  }
  return finish(path);
}

PathWave::Next PathWave::resolve(Path& path) {
  ++counts_.locations;
  if (path.found.cell < 0)
    return Next::flies;
  const double value = path.found.value;
  double share = media_[path.medium].extinction(value) / double(path.majorant);
  if (share > 1) {
    ++counts_.violations;
    share = 1;
  }
  if (path.is_shadow)
    return dim(path, share);
  // What does not show takes no random number: it is as if nothing were there.
  return share > 0 && path.random.unit() < share ? collide(path, value) : Next::flies;
}

PathWave::Next PathWave::dim(Path& path, double share) {
  path.transmittance *= 1 - share;
  if (path.transmittance < faint) {
    if (!(path.random.unit() * faint < path.transmittance))
      return scatter(path); // in the dark
    path.transmittance = faint;
  }
  return Next::flies;
}

PathWave::Next PathWave::collide(Path& path, double value) {
  ++counts_.collisions;
  if (++path.bounces == 1)
    stop_at(path, {path.t, path.found.cell, tracer_->layers_[path.medium]});
  path.alpha = 1;
  const Color albedo = media_[path.medium].albedo(value);
  const bool ends = settings_->scattering == Scattering::none ||
                    (settings_->scattering == Scattering::single && path.bounces > 1);
  if (settings_->scattering == Scattering::none)
    path.radiance = albedo;
  path.throughput = times(path.throughput, albedo);
  if (!ends && path.bounces > settings_->max_bounces)
    ++counts_.cut;
  if (ends || path.bounces > settings_->max_bounces || !(largest(path.throughput) > 0))
    return finish(path);
  path.at = path.place();
  path.incoming = path.ray.direction;
  if (!tracer_->lights_.has_small())
    return scatter(path);
  ++counts_.shadow_rays;
  const LightSample light = tracer_->lights_.sample(path.at, path.random.unit());
  const double phase =
      henyey_greenstein(dot(path.incoming, light.direction), settings_->anisotropy);
  path.light = float(phase) * times(path.throughput, light.irradiance);
  path.is_shadow = true;
  path.transmittance = 1;
  const Ray ray{path.at, light.direction};
  if (tracer_->surfaces_) {
    path.ray = ray;
    path.far = light.distance;
    return ask(path, Path::Asks::light);
  }
  set_ray(path, ray, light.distance);
  return Next::flies;
}

/// On from path.at in a new direction.
PathWave::Next PathWave::scatter(Path& path) {
  path.is_shadow = false;
  if (settings_->scattering == Scattering::single) {
    if (!tracer_->lights_.has_dome() && !tracer_->surfaces_)
      return finish(path); // nothing more to gather
  } else if (const double left = double(largest(path.throughput)); left < settings_->roulette) {
    if (!(path.random.unit() * settings_->roulette < left))
      return finish(path);
    path.throughput = float(settings_->roulette / left) * path.throughput;
  }
  ++counts_.scatterings;
  const double cosine = sample_henyey_greenstein(settings_->anisotropy, path.random.unit());
  const Vec3d direction = direction_around(path.incoming, cosine, path.random.unit());
  const Ray ray{path.at, direction};
  path.wall = HUGE_VAL;
  if (tracer_->surfaces_) {
    path.ray = ray;
    path.seed = std::uint64_t(0x1p53 * path.random.unit());
    return ask(path, Path::Asks::wall);
  }
  set_ray(path, ray, path.wall);
  return Next::flies;
}

void PathWave::stop_at(const Path& path, const Stop& stop) {
  if (path.sample < depth_samples_)
    stops_[std::size_t(path.item * depth_samples_ + path.sample)] = stop;
}

/// The first stop by which half of the samples have come to theirs.
void PathWave::set_depth(std::uint32_t item) {
  const auto first = stops_.begin() + item * depth_samples_;
  const auto middle = first + (depth_samples_ - 1) / 2;
  std::nth_element(first, middle, first + depth_samples_, [](const Stop& a, const Stop& b) {
    return std::tie(a.t, a.layer, a.cell) < std::tie(b.t, b.layer, b.cell);
  });
  rays_[item].depth = middle->t;
  rays_[item].depth_cell = middle->cell;
  rays_[item].depth_layer = middle->layer;
}

PathWave::Next PathWave::finish(const Path& path) {
  PathSums::Pixel& sum = sums_[path.item];
  sum.r += double(path.radiance.r);
  sum.g += double(path.radiance.g);
  sum.b += double(path.radiance.b);
  sum.alpha += double(path.alpha);
  return Next::ends;
}

void PathWave::store() {
  const auto samples = double(first_sample_ + settings_->samples);
  for (const std::uint32_t i : meets_) {
    const PathSums::Pixel& sum =
        settings_->sums ? settings_->sums->add(rays_[i].pixel, sums_[i]) : sums_[i];
    RayState& state = rays_[i];
    state.color = {float(sum.r / samples), float(sum.g / samples), float(sum.b / samples)};
    state.alpha = float(sum.alpha / samples);
    state.next_hit = state.hits.size();
    if (settings_->depth)
      set_depth(i);
  }
  if (!settings_->shows_dome)
    return;
  for (std::size_t i = 0; i < rays_.size(); ++i)
    if (!(starts_[i].from < starts_[i].to)) { // the same as every sample would show
      while (rays_[i].next_hit < rays_[i].hits.size())
        rays_[i].blend_next_hit();
      rays_[i].blend(tracer_->lights_.dome(), 1);
    }
}

} // namespace insitu::render
