#include "render/processes/tile_data.h"

#include <algorithm>
#include <bit>

namespace insitu::render {

namespace {

struct SentHit {
  SentMeeting met;
  math::Vec3d gradient;
  Color color;
  std::uint16_t ray;
  std::uint16_t none = 0;
};
static_assert(sizeof(SentHit) == std::size_t(bytes_a_hit));

struct SentStart {
  std::int64_t cell;
  double clearance;
};
static_assert(sizeof(SentStart) == std::size_t(bytes_a_start));

} // namespace

void write_hits(std::span<const RayState> rays, const CellKey& key, bool with_starts,
                ByteWriter& to) {
  for (std::size_t r = 0; r < rays.size(); ++r)
    for (const SurfaceHit& hit : rays[r].hits) {
      to.value(SentHit{SentMeeting(hit, key(hit.cell)), hit.gradient, hit.color, std::uint16_t(r)});
      if (with_starts)
        to.value(SentStart{hit.cell, hit.clearance});
    }
}

void read_hits(ByteReader from, bool with_starts, int process, std::span<const std::uint32_t> which,
               std::span<RayState> rays) {
  while (!from.at_end()) {
    const auto sent = from.value<SentHit>();
    SurfaceHit hit = sent.met.hit();
    hit.gradient = sent.gradient;
    hit.color = sent.color;
    hit.process = process;
    if (with_starts) {
      const auto start = from.value<SentStart>();
      hit.process_cell = start.cell;
      hit.clearance = start.clearance;
    }
    rays[which.empty() ? sent.ray : which[sent.ray]].hits.push_back(hit);
  }
}

void write_claims(const VolumeMarcher::Claims& claims, std::size_t first_ray, const CellKey& key,
                  ByteWriter& to) {
  for (std::size_t r = 0; r < claims.wanted.size(); ++r) {
    const std::uint32_t wanted = claims.wanted[r];
    if (!wanted)
      continue;
    std::uint32_t changes = 0;
    std::int64_t last = -1;
    for (std::uint32_t rest = wanted; rest; rest &= rest - 1) {
      const int k = std::countr_zero(rest);
      const std::int64_t cell = claims.samples[claims.place(r, k)].cell;
      if (cell != last)
        changes |= std::uint32_t(1) << k;
      last = cell;
    }
    to.value(std::uint16_t(first_ray + r));
    to.value(wanted);
    to.value(changes);
    for (std::uint32_t rest = wanted; rest; rest &= rest - 1) {
      const int k = std::countr_zero(rest);
      const std::size_t at = claims.place(r, k);
      if (changes >> k & 1)
        to.value(key(claims.samples[at].cell));
      to.value(claims.samples[at].value);
      if (!claims.gradients.empty())
        to.value(claims.gradients[at]);
      if (!claims.places.empty())
        to.value(claims.places[at]);
      if (!claims.levels.empty())
        to.value(claims.levels[at]);
    }
  }
}

void ClaimReader::add(ByteReader claims) {
  begin(runs_.emplace_back(Run{claims, no_ray}));
}

bool ClaimReader::next() {
  ray_ = no_ray;
  for (const Run& run : runs_)
    ray_ = std::min(ray_, run.ray);
  if (ray_ == no_ray)
    return false;
  wanted_ = 0;
  for (Run& run : runs_)
    if (run.ray == ray_)
      take(run);
  return true;
}

void ClaimReader::take(Run& run) {
  ByteReader& from = run.reader;
  const auto wanted = from.value<std::uint32_t>(), changes = from.value<std::uint32_t>();
  std::int64_t key = -1;
  for (std::uint32_t rest = wanted; rest; rest &= rest - 1) {
    const int k = std::countr_zero(rest);
    if (changes >> k & 1)
      key = from.value<std::int64_t>();
    const auto value = from.value<double>();
    math::Vec3d gradient, place;
    if (with_gradients_)
      gradient = from.value<math::Vec3d>();
    if (with_places_)
      place = from.value<math::Vec3d>();
    const std::uint8_t level = with_levels_ ? from.value<std::uint8_t>() : std::uint8_t(0);
    if ((wanted_ >> k & 1) && samples_[k].cell <= key)
      continue;
    wanted_ |= std::uint32_t(1) << k;
    samples_[k] = {key, value};
    locations_[k] = {key, gradient};
    places_[k] = place;
    levels_[k] = level;
  }
  begin(run);
}

} // namespace insitu::render
