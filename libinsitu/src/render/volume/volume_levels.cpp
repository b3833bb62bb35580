#include <algorithm>
#include <cmath>

#include "render/volume/volume_scratch.h"

/// Marching in steps that vary from macrocell to macrocell.
namespace insitu::render {

/// The ray's next samples, `most` of them, or those that begin before `upto` and the ray's end.
/// They depend on the ray and the levels alone: at each place the longest stretch that begins on
/// its own lattice and passes no macrocell that needs a shorter one.
void VolumeMarcher::plan(RayState& ray, std::size_t most, std::int64_t upto, Scratch& s,
                         VolumeCounts& counts) const {
  const std::int64_t longest = StepLevels::stride(levels_->count() - 1);
  upto = std::min(upto, ray.end);
  s.planned.clear();
  while (s.planned.size() < most && ray.next < upto) {
    // What the ray passes, some way ahead.
    const std::int64_t window = std::min(ray.end, ray.next + 16 * longest);
    s.runs.clear();
    std::int64_t at = ray.next;
    // And what it passes behind the window's last step up to the next one's middle.
    for_each_macrocell(levels_->grid(), ray.ray, double(at) * step_, double(window + 1) * step_,
                       [&](std::int64_t m, double, double to) {
                         // A base step is where its middle is.
                         const auto passed = std::int64_t(std::ceil(to / step_ - 0.5));
                         if (at == window && passed > window)
                           return false;
                         const std::int64_t end = std::clamp(passed, at, window);
                         const bool visible = !ray.may_skip || majorants_->opacity(m) > 0;
                         const int level = levels_->level(m);
                         if (end > at) {
                           s.runs.push_back({end, level, visible});
                         } else if (!s.runs.empty()) {
                           s.runs.back().level = std::min(s.runs.back().level, level);
                           s.runs.back().visible = s.runs.back().visible || visible;
                         }
                         at = end;
                         return true;
                       });
    std::size_t run = 0;
    const std::int64_t stop = std::min(upto, window == ray.end ? window : window - longest);
    std::int64_t place = ray.next;
    while (place < stop && s.planned.size() < most) {
      while (s.runs[run].end <= place)
        ++run;
      int level = s.runs[run].level;
      bool visible = false;
      for (;; --level) {
        const std::int64_t end = place + StepLevels::stride(level);
        if (level > 0 && (place % StepLevels::stride(level) != 0 || end > ray.end))
          continue;
        int needed = s.runs[run].level;
        visible = s.runs[run].visible;
        for (std::size_t r = run; s.runs[r].end < end; ++r) {
          needed = std::min(needed, s.runs[r + 1].level);
          visible = visible || s.runs[r + 1].visible;
        }
        if (needed >= level)
          break;
      }
      if (visible)
        s.planned.push_back({place, level});
      else
        ++counts.skipped;
      place += StepLevels::stride(level);
    }
    ray.next = place;
  }
  if (clipped_)
    std::erase_if(s.planned,
                  [&](const Planned& p) { return !stays_at(ray.stays, middle(p.begin, p.level)); });
}

double VolumeMarcher::middle(std::int64_t begin, int level) const {
  return (double(begin) + 0.5 * double(StepLevels::stride(level))) * step_;
}

void VolumeMarcher::march_levels(std::span<RayState> rays, VolumeCounts& counts) const {
  Scratch& s = scratch();
  s.active.clear();
  for (std::size_t r = 0; r < rays.size(); ++r)
    if (rays[r].next < rays[r].end)
      s.active.push_back(std::uint32_t(r));
  while (!s.active.empty()) {
    const auto depth = std::size_t(std::clamp(2048 / int(s.active.size()), 8, 32));
    s.all_planned.clear();
    s.planned_end.clear();
    s.points.clear();
    for (const std::uint32_t r : s.active) {
      plan(rays[r], depth, rays[r].end, s, counts);
      for (const Planned& p : s.planned) {
        s.all_planned.push_back(p);
        s.points.push_back(rays[r].ray.origin + middle(p.begin, p.level) * rays[r].ray.direction);
      }
      s.planned_end.push_back(s.all_planned.size());
    }
    s.found.resize(s.points.size());
    located_.locate_serial(s.points, s.found, options_);
    counts.samples += std::int64_t(s.points.size());
    std::size_t kept = 0, at = 0;
    for (std::size_t a = 0; a < s.active.size(); ++a) {
      RayState& ray = rays[s.active[a]];
      for (; at < s.planned_end[a]; ++at) {
        const Planned& p = s.all_planned[at];
        const query::Location& found = s.found[at];
        if (!found || ray.is_saturated())
          continue;
        add_sample(ray, stretch(ray, p.begin, StepLevels::stride(p.level)), found, p.level);
      }
      if (ray.next < ray.end && !ray.is_saturated())
        s.active[kept++] = s.active[a];
    }
    s.active.resize(kept);
  }
}

/// What claim() does with a tolerance.
void VolumeMarcher::claim_levels(std::span<RayState> rays, std::int64_t first, int depth,
                                 std::int64_t own_cells, std::span<const std::uint16_t> open,
                                 Claims& claims, VolumeCounts& counts) const {
  Scratch& s = scratch();
  claims.group = depth;
  s.active.clear();
  s.all_planned.clear();
  s.planned_end.clear();
  s.points.clear();
  for (const std::uint16_t r : open) {
    if (rays[r].next >= std::min(rays[r].end, first + depth))
      continue;
    plan(rays[r], std::size_t(depth), first + depth, s, counts);
    for (const Planned& p : s.planned) {
      s.all_planned.push_back(p);
      s.points.push_back(rays[r].ray.origin + middle(p.begin, p.level) * rays[r].ray.direction);
    }
    s.active.push_back(r);
    s.planned_end.push_back(s.all_planned.size());
  }
  if (s.points.empty())
    return;
  s.found.resize(s.points.size());
  located_.locate_serial(s.points, s.found, options_);
  counts.samples += std::int64_t(s.points.size());
  const std::size_t size = rays.size() * std::size_t(depth);
  claims.samples.resize(size);
  claims.levels.resize(size);
  claims.gradients.resize(shader_ ? size : 0);
  claims.places.resize(is_lit_by_place() ? size : 0);
  for (std::size_t a = 0, at = 0; a < s.active.size(); ++a)
    for (const std::size_t r = s.active[a]; at < s.planned_end[a]; ++at) {
      const Planned& p = s.all_planned[at];
      const query::Location& found = s.found[at];
      if (!is_claimed(found.cell, own_cells))
        continue;
      const double value = field_.at(sampler_.mesh(), found);
      if (!claims_all() && !(classifiers_[std::size_t(p.level)](value).alpha > 0))
        continue;
      const int k = int(p.begin - first);
      const std::size_t to = claims.place(r, k);
      claims.wanted[r] |= std::uint32_t(1) << k;
      claims.samples[to] = {found.cell, value};
      claims.levels[to] = std::uint8_t(p.level);
      if (shader_)
        claims.gradients[to] = gradient(found);
      if (is_lit_by_place())
        claims.places[to] = place(found);
    }
}

} // namespace insitu::render
