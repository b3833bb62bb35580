#include "render/surface/surfaces.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/random.h"
#include "render/path/path_tracer.h"
#include "render/surface/surfaces_together.h"
#include "render/surface/tiles/isosurface_rays.h"
#include "render/volume/ray_step.h"

namespace insitu::render {

using math::Vec3d;

namespace {

/// Above a surface by this part of the cell's thickness, a ray does not meet it again for rounding:
/// roots are found to 1e-11 of it.
constexpr double clearance_of_thickness = 1e-5;
/// A position is rounded to 2^-53 of its largest coordinate, a few times over.
constexpr double clearance_of_coordinates = 0x1p-48;
/// Rays of light that are sent before they are answered: some hundred kilobytes.
constexpr std::size_t rays_at_once = 4096;

} // namespace

Surfaces::Surfaces(const query::Sampler& sampler, const FrameSettings& settings,
                   Structures& structures, Parts parts)
    : sampler_(sampler), settings_(settings), diagonal_(mesh_diagonal(sampler)), parts_(parts) {
  const bool has_cells = parts == Parts::whole || !sampler.tree().empty();
  if (!settings.isosurfaces.empty() && has_cells)
    isosurfaces_.emplace(sampler, settings.isosurfaces, structures, settings.lighting.enabled);
  for (const IsosurfaceSettings& surface : settings.isosurfaces)
    first_triangle_surface_ += std::int32_t(surface.values.size());
  if (settings.boundary || !settings.bodies.empty())
    triangles_.emplace(sampler, settings.boundary, settings.bodies, first_triangle_surface_,
                       structures);
  if (settings.outline) {
    const mesh::Box box = settings.outline->box.value_or(sampler.facts().bounds);
    outline_.emplace(*settings.outline, settings.camera, settings.width, settings.height, box.low,
                     box.high, structures.memory());
  }
  if (settings.lighting.enabled)
    shader_.emplace(settings.lighting, 0.1 * diagonal_);
  if (!settings.lighting.volume_shadows || !settings.volume)
    return;
  const VolumeSettings& volume = *settings.volume;
  const auto& tracing = settings.path_tracing;
  const Majorants* const majorants =
      tracing ? &path_majorants(sampler, volume, *tracing, structures)
              : volume_structures(sampler, volume, std::int64_t(settings.width) * settings.height,
                                  structures)
                    .majorants;
  volume_shadow_.emplace(sampler, volume, tracing ? tracing->density : 1.0, majorants,
                         settings.clips);
  if (parts == Parts::shared)
    volume_shadow_->take_part();
}

void Surfaces::find(const Ray& ray, const std::vector<Stretch>* stays,
                    std::vector<SurfaceHit>& hits, SurfaceCounts& counts) const {
  hits.clear();
  if (isosurfaces_)
    isosurfaces_->trace(ray, hits, counts, stays);
  if (triangles_)
    triangles_->trace(ray, hits, stays);
}

void Surfaces::join(std::int32_t layer, std::vector<const Surfaces*> others) {
  layer_ = layer;
  others_ = std::move(others);
}

void Surfaces::find(std::span<RayState> rays, IsosurfaceTile* tile, SurfaceCounts& counts) const {
  const auto width = std::uint64_t(settings_.width);
  for (RayState& state : rays)
    if (tile) {
      tile->hits(int(state.pixel % width), int(state.pixel / width), state.hits);
      if (triangles_)
        triangles_->trace(state.ray, state.hits, stays_of(state));
    } else {
      find(state.ray, stays_of(state), state.hits, counts);
    }
}

void Surfaces::light(std::span<RayState> rays, SurfaceCounts& counts) const {
  thread_local std::vector<Seen> seen; // kept for the thread's life
  seen.clear();
  see(rays, seen);
  if (shader_)
    light(seen, counts);
}

void Surfaces::see(std::span<RayState> rays, std::vector<Seen>& seen) const {
  for (RayState& state : rays) {
    std::uint64_t index = 0;
    for (SurfaceHit& hit : state.hits) {
      const std::uint64_t number = index++;
      if (hit.layer != layer_)
        continue;
      set_color(hit);
      seen.push_back(
          {&state.ray, core::splitmix64(state.pixel ^ (state.sample << 32)) + number, &hit});
    }
  }
}

void Surfaces::add_lines(std::span<RayState> rays) const {
  if (!outline_)
    return;
  const auto width = std::uint64_t(settings_.width);
  for (RayState& state : rays)
    outline_->add(int(state.pixel % width), int(state.pixel / width), state.ray, state.hits);
}

void Surfaces::set_color(SurfaceHit& hit) const {
  if (parts_ == Parts::whole || (hit.cell < 0 && hit.triangle >= 0)) // of a body
    hit.color = color(hit);
}

Color Surfaces::color(const SurfaceHit& hit) const {
  return hit.surface < first_triangle_surface_ ? isosurfaces_->color(hit) : triangles_->color(hit);
}

/// Rays of a batch of hits, by stream (see Shader::send), and what comes through them.
struct Surfaces::LightScratch {
  struct Sent {
    std::uint32_t point;
    math::Vec3d direction;
    double t_max, open;
  };
  std::vector<SurfacePoint> points;
  std::vector<SecondaryStart> starts;
  std::vector<std::vector<Sent>> streams;
  std::vector<std::size_t> next;
  std::size_t sent = 0;

  void begin(int stream_count) {
    points.clear();
    starts.clear();
    streams.resize(std::size_t(stream_count));
    for (auto& stream : streams)
      stream.clear();
    next.assign(std::size_t(stream_count), 0);
    sent = 0;
  }
};

Surfaces::LightScratch& Surfaces::scratch() {
  thread_local LightScratch kept; // for the thread's life
  return kept;
}

/// Of length 1, on the side that the ray comes from.
Vec3d Surfaces::normal_of(const Vec3d& gradient, const Ray& ray) {
  // Scaled first: gradients may be as small as their field's values.
  const Vec3d& g = gradient;
  const double largest = std::max({std::fabs(g.x), std::fabs(g.y), std::fabs(g.z)});
  if (!(largest > 0 && std::isfinite(largest)))
    return -ray.direction; // without a direction it faces the viewer
  const Vec3d n = g / largest;
  return n / std::copysign(std::sqrt(dot(n, n)), -dot(n, ray.direction));
}

SurfacePoint Surfaces::point_of(const Seen& seen, SurfaceCounts& counts) const {
  const SurfaceHit& hit = *seen.hit;
  const Ray& ray = *seen.ray;
  SurfacePoint at;
  at.position = ray.origin + hit.t * ray.direction;
  at.to_viewer = -ray.direction;
  const bool is_own = parts_ == Parts::whole; // not of another process's cell
  at.normal = normal_of(is_own && hit.surface < first_triangle_surface_
                            ? isosurfaces_->gradient(hit, at.position, counts)
                            : hit.gradient,
                        ray);
  at.seed = seen.seed;
  if (shader_->sends_rays())
    at.clearance = is_own || hit.cell < 0 ? clearance(hit, at.position, at.normal) : hit.clearance;
  return at;
}

void Surfaces::light(std::span<const Seen> seen, SurfaceCounts& counts) const {
  LightScratch& s = scratch();
  for (std::size_t first = 0; first < seen.size(); first += s.points.size()) {
    s.begin(shader_->streams());
    for (const Seen& at : seen.subspan(first)) {
      if (s.sent >= rays_at_once)
        break;
      const SurfacePoint& point = s.points.emplace_back(point_of(at, counts));
      s.starts.push_back({at.hit->cell, at.hit->surface, point.normal, point.clearance});
      shader_->send(
          point,
          [&](int stream, const Vec3d& direction, double t_max) {
            s.streams[std::size_t(stream)].push_back(
                {std::uint32_t(s.points.size() - 1), direction, t_max, 1.0});
            ++s.sent;
          },
          counts);
    }
    answer(s, counts);
    counts.lit += std::int64_t(s.points.size());
    for (std::size_t i = 0; i < s.points.size(); ++i) {
      shade(*seen[first + i].hit, shader_->factor(s.points[i], [&](int stream) {
        return s.streams[std::size_t(stream)][s.next[std::size_t(stream)]++].open;
      }));
    }
  }
}

/// Finds what comes through the rays that were sent, packets of neighbours in a stream.
void Surfaces::answer(LightScratch& s, SurfaceCounts& counts) const {
  thread_local std::vector<Stretch> stays[RayCells::most]; // kept for the thread's life
  LightRay rays[RayCells::most];
  for (auto& stream : s.streams)
    for (std::size_t first = 0; first < stream.size(); first += RayCells::most) {
      const std::size_t count = std::min<std::size_t>(RayCells::most, stream.size() - first);
      for (std::size_t i = 0; i < count; ++i) {
        const LightScratch::Sent& sent = stream[first + i];
        rays[i] = {
            {s.points[sent.point].start(), sent.direction}, &stays[i], &s.starts[sent.point]};
        clip_ray(settings_.clips, rays[i].ray, 0, sent.t_max, stays[i]);
      }
      open(std::span(rays, count), counts);
      for (std::size_t i = 0; i < count; ++i) {
        LightScratch::Sent& sent = stream[first + i];
        sent.open = through_volumes(rays[i].ray, sent.t_max, rays[i].open, counts);
      }
    }
}

/// What is left of light after the shadows of volumes.
double Surfaces::through_volumes(const Ray& ray, double t_max, double open,
                                 SurfaceCounts& counts) const {
  const auto pass = [&](const Surfaces& of) {
    if (of.volume_shadow_ && open > 0)
      open *= of.volume_shadow_->through(ray, t_max, counts.shadow_samples);
  };
  pass(*this);
  for (const Surfaces* other : others_)
    pass(*other);
  return open;
}

/// How much light surfaces of all meshes let through: of at most RayCells::most rays.
void Surfaces::open(std::span<LightRay> rays, SurfaceCounts& counts) const {
  open_here(rays, counts);
  for (const Surfaces* other : others_) {
    LightRay there[RayCells::most];
    for (std::size_t i = 0; i < rays.size(); ++i)
      there[i] = {rays[i].ray, rays[i].stays};
    other->open_here(std::span(there, rays.size()), counts);
    for (std::size_t i = 0; i < rays.size(); ++i)
      rays[i].open *= there[i].open;
  }
}

void Surfaces::open_here(std::span<LightRay> rays, SurfaceCounts& counts) const {
  thread_local std::vector<SurfaceHit> hits; // kept for the thread's life
  if (isosurfaces_)
    isosurfaces_->trace(rays, counts);
  if (triangles_)
    for (LightRay& ray : rays)
      if (ray.open > 0) {
        hits.clear();
        triangles_->trace(ray.ray, hits, ray.stays);
        ray.open *= open_past(hits);
      }
}

double Surfaces::open(const Ray& ray, double t_max) const {
  thread_local std::vector<Stretch> stays; // kept for the thread's life
  SurfaceCounts none;
  clip_ray(settings_.clips, ray, 0, t_max, stays);
  LightRay alone{ray, &stays};
  open(std::span(&alone, 1), none);
  return alone.open;
}

void Surfaces::meet(const Ray& ray, core::FunctionRef<bool(float)> ends, std::uint64_t seed,
                    double& t, Color& color_seen) const {
  thread_local RayState state; // kept for the thread's life
  SurfaceCounts none;
  t = HUGE_VAL;
  state.begin(ray);
  clip_ray(settings_.clips, ray, 0, HUGE_VAL, state.stays);
  const auto of = [&](std::size_t layer) -> const Surfaces& {
    return layer == 0 ? *this : *others_[layer - 1];
  };
  const std::span<RayState> rays(&state, 1);
  put_hits_together(1 + others_.size(), rays,
                    [&](std::size_t layer) { of(layer).find(rays, nullptr, none); });
  for (SurfaceHit& hit : state.hits)
    if (hit.opacity >= 1 || ends(hit.opacity)) {
      const Surfaces& met = of(std::size_t(hit.layer));
      hit.color = met.color(hit);
      if (met.shader_) {
        const Seen seen{&ray, seed, &hit};
        met.light(std::span(&seen, 1), none);
      }
      t = hit.t;
      color_seen = hit.color;
      return;
    }
}

double Surfaces::clearance(const SurfaceHit& hit, const Vec3d& position,
                           const Vec3d& normal) const {
  double least = HUGE_VAL, most = -HUGE_VAL;
  if (hit.cell >= 0) {
    mesh::CellVertices cell;
    mesh::gather(sampler_.mesh(), hit.cell, cell);
    for (int v = 0; v < cell.count; ++v) {
      const double height = dot(cell.x[v] - position, normal);
      least = std::min(least, height);
      most = std::max(most, height);
    }
  }
  const double largest =
      std::max({std::fabs(position.x), std::fabs(position.y), std::fabs(position.z)});
  return std::max(clearance_of_thickness * (most > least ? most - least : 0.0),
                  clearance_of_coordinates * largest);
}

} // namespace insitu::render
