#include <algorithm>
#include <bit>
#include <cmath>

#include "accel/tree/tree.h"
#include "core/count_bits.h"
#include "render/volume/scalar_values.h"
#include "render/volume/volume.h"
#include "render/volume/volume_scratch.h"

/// A volume's rays where the mesh is spread over processes: samples are claimed where their cells
/// are, and gathered where the ray is.
namespace insitu::render {

using math::Vec3d;

VolumeMarcher::Progress::Progress(std::size_t rays) : last_(rays + 1) {}
VolumeMarcher::Progress::Progress(Progress&&) noexcept = default;
VolumeMarcher::Progress::~Progress() = default;
void VolumeMarcher::Progress::keep(std::size_t ray) {
  last_.back() = last_[ray];
}
void VolumeMarcher::Progress::put_back(std::size_t ray) {
  last_[ray] = last_.back();
}

void VolumeMarcher::take_part() {
  takes_part_ = true;
  low_ = inner_low_;
  high_ = inner_high_;
  const mesh::MeshView& mesh = sampler_.mesh();
  has_foreign_ = std::any_of(mesh.pieces, mesh.pieces + mesh.piece_count,
                             [](const mesh::PieceView& piece) { return piece.foreign; });
  const std::vector<OpacityPoint>& points = function_.opacity_points();
  if (points.empty()) { // from 0 at the lower end
    shown_low_ = function_.low();
    return;
  }
  const auto shows = [](const OpacityPoint& p) { return p.opacity > 0; };
  const auto first = std::find_if(points.begin(), points.end(), shows);
  if (first == points.end())
    shown_low_ = HUGE_VAL;
  else if (first != points.begin())
    shown_low_ = (first - 1)->value;
  const auto last = std::find_if(points.rbegin(), points.rend(), shows);
  if (last != points.rend() && last != points.rbegin())
    shown_high_ = (last - 1)->value;
}

void VolumeMarcher::keep_near(RayState& ray) const {
  const accel::Tree& tree = located_.tree();
  const std::optional<Stretch> in =
      tree.empty() ? std::nullopt : stretch_in_box(ray.ray, tree.bounds_min(), tree.bounds_max());
  if (!in) {
    ray.end = ray.next;
    ray.is_thin = false;
    return;
  }
  // A sample on the box's face is within a few roundings of where the ray meets the box.
  const double slack = 1.0 + 1e-9 * (std::fabs(in->from) + std::fabs(in->to)) / step_;
  const double first = in->from / step_ - slack, last = in->to / step_ + slack;
  const std::int64_t next = ray.next, end = ray.end;
  if (first > double(next))
    ray.next = first < double(end) ? std::int64_t(first) : end;
  if (last < double(end))
    ray.end = last > double(ray.next) ? std::int64_t(last) + 1 : ray.next;
  if (levels_ && ray.next < ray.end) { // no step passes a multiple of the longest one
    const std::int64_t longest = StepLevels::stride(levels_->count() - 1);
    ray.next = std::max(next, ray.next / longest * longest);
    ray.end = std::min(end, (ray.end + longest - 1) / longest * longest);
  }
  ray.first = ray.next;
}

/// Which of a group's samples are to be located; false: none.
bool VolumeMarcher::ask(std::span<RayState> rays, std::int64_t first,
                        std::span<const std::uint16_t> open, Scratch& s,
                        VolumeCounts& counts) const {
  s.active.clear();
  s.wanted.assign(rays.size(), 0);
  for (const std::uint16_t r : open)
    if (RayState& ray = rays[r]; ray.next < std::min(ray.end, first + group()))
      if (const std::uint32_t wanted = advance(ray, first, group(), counts.skipped)) {
        s.wanted[r] = wanted;
        s.active.push_back(r);
        counts.samples += core::count_bits(wanted);
      }
  return !s.active.empty();
}

void VolumeMarcher::claim(std::span<RayState> rays, std::span<const query::LatticeRay> lattice,
                          int row, std::int64_t first, int depth, std::int64_t own_cells,
                          std::vector<std::uint16_t>& open, Claims& claims,
                          VolumeCounts& counts) const {
  Scratch& s = scratch();
  claims.wanted.assign(rays.size(), 0);
  claims.rays = rays.size();
  claims.group = group();
  if (levels_)
    claim_levels(rays, first, depth, own_cells, open, claims, counts);
  std::optional<query::RayBundleLocator> locator;
  const ScalarValues values(field_, sampler_.mesh());
  for (int begin = 0; begin < depth && !levels_; begin += group()) {
    if (!ask(rays, first + begin, open, s, counts))
      continue;
    if (!locator) {
      locator.emplace(located_, options_);
      locator->set_rays(lattice, row, step_);
      claims.samples.resize(rays.size() * std::size_t(depth));
      claims.gradients.resize(shader_ ? claims.samples.size() : 0);
      claims.places.resize(is_lit_by_place() ? claims.samples.size() : 0);
      claims.levels.clear();
    }
    const std::size_t block = claims.place(0, begin), size = rays.size() * std::size_t(group());
    s.locations.resize(shader_ ? size : 0);
    locator->locate(first + begin, group(), s.wanted, values,
                    std::span(claims.samples).subspan(block, size), s.locations);
    for (const std::uint32_t r : s.active)
      for (std::uint32_t rest = s.wanted[r]; rest; rest &= rest - 1) {
        const int k = std::countr_zero(rest);
        const std::size_t i = r * std::size_t(group()) + std::size_t(k);
        const auto [cell, value] = claims.samples[block + i];
        if (!is_claimed(cell, own_cells) || !(claims_all() || may_show(value)))
          continue;
        claims.wanted[r] |= std::uint32_t(1) << (begin + k);
        if (shader_)
          claims.gradients[block + i] = gradient(s.locations[i]);
        if (is_lit_by_place())
          claims.places[block + i] = place(s.locations[i]);
      }
  }
  std::erase_if(open, [&](std::uint16_t r) {
    return rays[r].next >= rays[r].end || rays[r].end <= first + depth;
  });
}

void VolumeMarcher::claim_thin(std::span<RayState> rays, std::int64_t own_cells, Claims& claims,
                               VolumeCounts& counts) const {
  Scratch& s = scratch();
  claims.wanted.assign(rays.size(), 0);
  claims.rays = rays.size();
  claims.group = 1;
  claims.samples.resize(rays.size());
  claims.gradients.resize(shader_ ? rays.size() : 0);
  claims.places.resize(is_lit_by_place() ? rays.size() : 0);
  claims.levels.assign(levels_ ? rays.size() : 0, 0);
  locate_thin(rays);
  counts.samples += std::int64_t(s.active.size());
  for (std::size_t a = 0; a < s.active.size(); ++a) {
    const query::Location& at = s.found[a];
    const std::size_t r = s.active[a];
    if (!is_claimed(at.cell, own_cells))
      continue;
    claims.wanted[r] = 1;
    claims.samples[r] = {at.cell, field_.at(sampler_.mesh(), at)};
    if (shader_)
      claims.gradients[r] = gradient(at);
    if (is_lit_by_place())
      claims.places[r] = place(at);
  }
}

namespace {

/// Those of samples [first, first + 32) that the ray has: others may have taken it to be longer.
std::uint32_t within(const RayState& ray, std::int64_t first, std::uint32_t wanted) {
  const auto below = [&](std::int64_t index) {
    const std::int64_t bits = index - first;
    return bits <= 0 ? 0u : bits >= 32 ? ~0u : (std::uint32_t(1) << bits) - 1;
  };
  return wanted & below(ray.end) & ~below(ray.next);
}

} // namespace

void VolumeMarcher::gather(RayState& ray, Progress& progress, std::size_t r, std::int64_t first,
                           std::uint32_t wanted, const query::ValueSample* samples,
                           const query::Location* locations, const std::uint8_t* levels) const {
  if (!ray.is_saturated())
    gather_stretch(ray, progress.last_[r], first, within(ray, first, wanted), samples, locations,
                   levels);
}

std::uint32_t VolumeMarcher::lit_samples(const RayState& of, const Progress& progress,
                                         std::size_t r, std::int64_t first, std::uint32_t wanted,
                                         const query::ValueSample* samples,
                                         const std::uint8_t* levels) const {
  thread_local RayState ray; // kept for the thread's life
  ray = of;                  // light changes nothing of where it goes on
  Gathered last = progress.last_[r];
  std::uint32_t lit = 0;
  const auto note_last = [&](std::int64_t index) {
    if (index >= first)
      lit |= std::uint32_t(1) << (index - first);
  };
  for (std::uint32_t rest = within(ray, first, wanted); rest && !ray.is_saturated();
       rest &= rest - 1) {
    const int k = std::countr_zero(rest);
    const std::int64_t before = ray.lit, open = last.index;
    gather(ray, last, first + k, samples[k].value, {samples[k].cell, {}}, levels_ ? levels[k] : 0);
    if (ray.lit == before)
      continue;
    lit |= std::uint32_t(1) << k;
    note_last(open); // what was behind it may be what was lit
  }
  if (last.index >= 0 && classifiers_[0](last.place.value).alpha > 0)
    note_last(last.index); // so may what is behind it, later
  return lit;
}

Vec3d VolumeMarcher::light_without_rays(const std::optional<SurfacePoint>& at) const {
  SurfaceCounts none;
  const Color sum = at ? (*shader_)(
                             *at, [](const Ray&, double) { return 1.0; }, none)
                       : Color{1, 1, 1};
  return {sum.r, sum.g, sum.b};
}

void VolumeMarcher::gather_thin(RayState& ray, double value, const query::Location& at) const {
  add_value(ray, {ray.near, ray.far}, value, at, 0);
}

void VolumeMarcher::finish(std::span<RayState> rays, Progress& progress) const {
  if (preintegration_)
    for (std::size_t r = 0; r < rays.size(); ++r)
      finish(rays[r], progress.last_[r]);
}

} // namespace insitu::render
