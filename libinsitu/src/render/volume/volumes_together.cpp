#include "render/volume/volumes_together.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace insitu::render {

namespace {

/// How far a volume's stretches have been blended.
struct Place {
  const VolumeStretch *at, *end; ///< the stretch that comes next, or that is being blended
  double begin;                  ///< of that: its own, but for rounding
  std::int32_t layer;
  bool is_done() const { return at == end; }
  void go_to(double t) {
    for (bool is_new = at->to <= t; is_new && ++at != end; is_new = at->to <= t)
      begin = std::max(at->from, t);
  }
  /// A part of it from where the last one ended.
  double from(double t) const { return t == begin ? at->from : t; }
  double part(double t, double to) const { return (to - from(t)) / (at->to - at->from); }
};

/// Adds what the stretches in [from, to] make together.
void blend_piece(RayState& ray, std::span<const Place> places, double from, double to) {
  const Place* only = nullptr;
  int count = 0, opaque = 0;
  for (const Place& p : places)
    if (!p.is_done() && p.begin <= from) {
      only = &p;
      ++count;
      opaque += p.at->alpha >= 1;
    }
  if (count == 1) {
    const VolumeStretch& s = *only->at;
    const bool whole = from == only->begin && to == s.to;
    ray.volume_layer = only->layer;
    ray.blend_stretch(s.color, whole ? s.alpha : Classifier::partial(s.alpha, only->part(from, to)),
                      only->from(from), to, s.cell);
    return;
  }
  double depth = 0, greatest = 0;
  std::int64_t cell = -1;
  math::Vec3d color;
  for (const Place& p : places)
    if (!p.is_done() && p.begin <= from && (opaque == 0 || p.at->alpha >= 1)) {
      const VolumeStretch& s = *p.at;
      const double own = opaque > 0 ? 1 : -std::log1p(-double(s.alpha)) * p.part(from, to);
      depth += own;
      if (own > greatest) { // of equals the first
        greatest = own;
        cell = s.cell;
        ray.volume_layer = p.layer;
      }
      color += own * math::Vec3d{s.color.r, s.color.g, s.color.b};
    }
  color = color / depth;
  ray.blend_stretch({float(color.x), float(color.y), float(color.z)},
                    opaque > 0 ? 1.0f : float(-std::expm1(-depth)), from, to, cell);
}

} // namespace

void blend_together(RayState& ray, std::span<const LayerStretches> volumes) {
  thread_local std::vector<Place> places; // kept for the thread's life
  places.clear();
  for (const auto& [of, layer] : volumes)
    if (!of.empty())
      places.push_back({of.data(), of.data() + of.size(), of.front().from, layer});
  double t = -HUGE_VAL;
  while (!ray.is_saturated()) {
    double from = HUGE_VAL, to = HUGE_VAL;
    for (Place& p : places)
      if (!p.is_done()) {
        p.go_to(t);
        if (!p.is_done())
          from = std::min(from, std::max(p.begin, t));
      }
    if (from == HUGE_VAL)
      return;
    for (const Place& p : places)
      if (!p.is_done())
        to = std::min(to, p.begin > from ? p.begin : p.at->to);
    if (ray.next_hit < ray.hits.size() && ray.hits[ray.next_hit].t < to) {
      if (ray.hits[ray.next_hit].t <= from) {
        ray.blend_next_hit();
        continue;
      }
      to = ray.hits[ray.next_hit].t;
    }
    blend_piece(ray, places, from, to);
    t = to;
  }
}

void begin_alone(RayState& alone, const RayState& ray) {
  alone.begin(ray.ray);
  alone.pixel = ray.pixel;
  alone.sample = ray.sample;
  alone.stays = ray.stays;
  if (!ray.hits.empty())
    alone.hits.push_back(ray.hits.back());
  alone.keeps_stretches = true;
}

VolumeCounts march_together(std::span<const VolumeMarcher* const> volumes,
                            std::span<const std::int32_t> layers, std::span<RayState> rays,
                            int row) {
  thread_local std::vector<std::vector<RayState>> alone; // by volume; these for the thread's life
  thread_local std::vector<LayerStretches> stretches;
  VolumeCounts counts;
  alone.resize(std::max(alone.size(), volumes.size()));
  for (std::size_t v = 0; v < volumes.size(); ++v) {
    std::vector<RayState>& states = alone[v];
    states.resize(std::max(states.size(), rays.size()));
    for (std::size_t r = 0; r < rays.size(); ++r) {
      begin_alone(states[r], rays[r]);
      volumes[v]->start(states[r]);
      states[r].hits.clear();
    }
    counts += volumes[v]->march(std::span(states.data(), rays.size()), row);
  }
  stretches.resize(volumes.size());
  for (std::size_t r = 0; r < rays.size(); ++r) {
    for (std::size_t v = 0; v < volumes.size(); ++v)
      stretches[v] = {alone[v][r].stretches, layers[v]};
    blend_together(rays[r], stretches);
  }
  return counts;
}

} // namespace insitu::render
