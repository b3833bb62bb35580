#include "commands/lattice_rays.h"

#include <algorithm>
#include <cmath>

#include "measure.h"
#include "query/ray_bundle/ray_bundle.h"
#include "render/volume/ray_step.h"

namespace insitu::bench {

namespace {

using math::Vec3d;

constexpr int tile = 32;

double step_of(const query::Sampler& sampler, const render::VolumeSettings& volume) {
  return volume.step ? *volume.step : volume.step_factor * render::typical_cell_size(sampler);
}

/// The rays of some tiles, started.
template <class Use>
void for_each_tile(const query::Sampler& sampler, const render::FrameSettings& settings, int every,
                   Use&& use) {
  const render::RayGenerator rays(settings.camera, settings.width, settings.height);
  const render::VolumeMarcher marcher(sampler, *settings.volume);
  const int last = every > 1 ? tile : 1; // all of it where every tile counts
  for (int y0 = 0; y0 + last <= settings.height; y0 += every * tile)
    for (int x0 = 0; x0 + last <= settings.width; x0 += every * tile) {
      std::vector<render::RayState> states;
      for (int y = y0; y < std::min(y0 + tile, settings.height); ++y)
        for (int x = x0; x < std::min(x0 + tile, settings.width); ++x) {
          render::RayState& s = states.emplace_back();
          s.ray = rays(x, y);
          marcher.start(s);
        }
      use(states);
    }
}

} // namespace

render::FrameSettings standard_frame(const query::Sampler& sampler, const mesh::FieldView& field,
                                     double low, double high, int size) {
  render::FrameSettings s;
  s.width = s.height = size;
  const Vec3d least = sampler.tree().bounds_min(), most = sampler.tree().bounds_max();
  s.camera = render::Camera::around(least, most, 30, 20, 1.45);
  s.background = {0, 0, 0};
  s.volume = render::VolumeSettings{
      {field, 0}, {render::ColorMap::built_in("viridis"), low, high, {{low, 0.0}, {high, 0.02}}}};
  s.volume->unit_distance = 0.01 * std::sqrt(dot(most - least, most - least));
  return s;
}

render::FrameSettings workload_frame(const mesh::FieldView& field, std::int64_t cells, int size) {
  constexpr double most = 6.0; // of the field
  const double step = 1.0 / std::cbrt(double(cells)), half = render::srgb_of_linear(0.5);
  std::vector<render::OpacityPoint> opacity;
  constexpr int points = 48;
  for (int i = 0; i <= points; ++i) {
    const double s = double(i) / points;
    const double sigma = 4.0 * (0.5 + 0.5 * std::sin(6.0 * M_PI * s));
    opacity.push_back({most * s, -std::expm1(-sigma * step)});
  }
  render::FrameSettings f;
  f.width = f.height = size;
  f.camera.position = {1.6, 1.3, 2.2};
  f.camera.look_at = {0.5, 0.5, 0.5};
  f.camera.up = {0, 1, 0};
  f.camera.fov = 35;
  f.background = {0, 0, 0};
  f.volume = render::VolumeSettings{
      {field, 0},
      {render::ColorMap("workload", render::ColorSpace::linear, {{0, 0, half, 1}, {1, 1, half, 0}}),
       0.0, most, opacity}};
  f.volume->step = f.volume->unit_distance = step;
  return f;
}

std::vector<Vec3d> lattice_points(const query::Sampler& sampler,
                                  const render::FrameSettings& settings, int every,
                                  std::int64_t* rays) {
  const double step = step_of(sampler, *settings.volume);
  std::vector<Vec3d> points;
  if (rays)
    *rays = 0;
  for_each_tile(sampler, settings, every, [&](const std::vector<render::RayState>& states) {
    if (rays)
      *rays += std::int64_t(states.size());
    for (const render::RayState& s : states) {
      if (s.is_thin)
        points.push_back(s.ray.origin + (0.5 * (s.near + s.far)) * s.ray.direction);
      for (std::int64_t i = s.next; i < s.end; ++i)
        points.push_back(s.ray.origin + ((double(i) + 0.5) * step) * s.ray.direction);
    }
  });
  return points;
}

LatticeCost locate_lattice(const query::Sampler& sampler, const render::FrameSettings& settings,
                           int way, int every) {
  constexpr int most = query::RayBundleLocator::most_depth;
  const double step = step_of(sampler, *settings.volume);
  const query::LocateOptions options{settings.volume->accuracy, 1.0};
  query::RayBundleLocator bundle(sampler, options);
  LatticeCost cost;
  Series time;
  std::vector<query::Location> found(std::size_t(tile * tile * most));
  std::vector<Vec3d> points;
  for_each_tile(sampler, settings, every, [&](const std::vector<render::RayState>& states) {
    std::vector<query::LatticeRay> lattice;
    std::int64_t first = INT64_MAX, end = 0;
    for (const render::RayState& s : states) {
      lattice.push_back({s.ray.origin, s.ray.direction});
      if (s.next < s.end)
        first = std::min(first, s.next);
      end = std::max(end, s.end);
    }
    cost.rays += std::int64_t(states.size());
    if (first >= end)
      return;
    time.time([&] {
      if (way > 0) {
        bundle.set_rays(lattice, tile, step);
        std::vector<std::uint32_t> wanted(lattice.size());
        for (; first < end; first += way) {
          for (std::size_t r = 0; r < states.size(); ++r) {
            wanted[r] = 0;
            for (int k = 0; k < way; ++k)
              if (first + k >= states[r].next && first + k < states[r].end) {
                wanted[r] |= std::uint32_t(1) << k;
                ++cost.samples;
              }
          }
          bundle.locate(first, way, wanted, found);
        }
        return;
      }
      for (const render::RayState& s : states) {
        points.clear();
        for (std::int64_t i = s.next; i < s.end; ++i)
          points.push_back(s.ray.origin + ((double(i) + 0.5) * step) * s.ray.direction);
        cost.samples += std::int64_t(points.size());
        if (found.size() < points.size())
          found.resize(points.size());
        if (way == ray_by_ray) {
          sampler.locate_serial(points, std::span(found).first(points.size()), options);
          continue;
        }
        std::int64_t hint = -1;
        for (std::size_t i = 0; i < points.size(); ++i) {
          found[i] = sampler.locate(points[i], hint, options);
          hint = found[i].cell;
        }
      }
    });
  });
  cost.seconds = time.cpu_sum();
  return cost;
}

} // namespace insitu::bench
