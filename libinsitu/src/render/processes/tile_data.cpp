#include "render/processes/tile_data.h"

#include <algorithm>
#include <bit>

#include "core/count_bits.h"

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
               std::span<RayState> rays, std::int32_t layer) {
  while (!from.at_end()) {
    const auto sent = from.value<SentHit>();
    SurfaceHit hit = sent.met.hit();
    hit.gradient = sent.gradient;
    hit.color = sent.color;
    hit.layer = layer;
    hit.process = process;
    if (with_starts) {
      const auto start = from.value<SentStart>();
      hit.process_cell = start.cell;
      hit.clearance = start.clearance;
    }
    rays[which.empty() ? sent.ray : which[sent.ray]].hits.push_back(hit);
  }
}

void write_claims(const VolumeMarcher::Claims& claims, std::size_t first_ray, const CellKey* key,
                  ByteWriter& to) {
  for (std::size_t r = 0; r < claims.wanted.size(); ++r) {
    const std::uint32_t wanted = claims.wanted[r];
    if (!wanted)
      continue;
    std::uint32_t changes = 0;
    std::int64_t last = -1;
    for (std::uint32_t rest = key ? wanted : 0; rest; rest &= rest - 1) {
      const int k = std::countr_zero(rest);
      const std::int64_t cell = claims.samples[claims.place(r, k)].cell;
      if (cell != last)
        changes |= std::uint32_t(1) << k;
      last = cell;
    }
    to.value(std::uint16_t(first_ray + r));
    to.value(wanted);
    if (key)
      to.value(changes);
    const auto for_each = [&](std::uint32_t samples, auto&& visit) {
      for (std::uint32_t rest = samples; rest; rest &= rest - 1)
        visit(claims.place(r, std::countr_zero(rest)));
    };
    for_each(changes, [&](std::size_t at) { to.value((*key)(claims.samples[at].cell)); });
    double values[ClaimReader::most_depth];
    std::size_t count = 0;
    for_each(wanted, [&](std::size_t at) { values[count++] = claims.samples[at].value; });
    to.array(std::span<const double>(values, count));
    if (!claims.gradients.empty())
      for_each(wanted, [&](std::size_t at) { to.value(claims.gradients[at]); });
    if (!claims.places.empty())
      for_each(wanted, [&](std::size_t at) { to.value(claims.places[at]); });
    if (!claims.levels.empty())
      for_each(wanted, [&](std::size_t at) { to.value(claims.levels[at]); });
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
  is_tied_ = false;
  for (Run& run : runs_)
    if (run.ray == ray_)
      take(run);
  return true;
}

void ClaimReader::take(Run& run) {
  ByteReader& from = run.reader;
  const auto wanted = from.value<std::uint32_t>();
  const auto changes = with_cells_ ? from.value<std::uint32_t>() : 0;
  is_tied_ = is_tied_ || (!with_cells_ && (wanted_ & wanted));
  std::int64_t keys[most_depth];
  double values[most_depth];
  const auto key_count = std::size_t(core::count_bits(changes));
  from.array(std::span(keys, key_count));
  from.array(std::span(values, std::size_t(core::count_bits(wanted))));
  const std::int64_t* key = keys;
  const double* value = values;
  std::int64_t cell = 0;
  std::uint32_t lowest = 0;
  for (std::uint32_t rest = wanted; rest; rest &= rest - 1, ++value) {
    const int k = std::countr_zero(rest);
    if (changes >> k & 1)
      cell = *key++;
    if ((wanted_ >> k & 1) && samples_[k].cell <= cell)
      continue;
    lowest |= std::uint32_t(1) << k;
    samples_[k] = {cell, *value};
  }
  const auto read = [&](auto&& put) {
    for (std::uint32_t rest = wanted; rest; rest &= rest - 1)
      if (const auto vector = from.value<math::Vec3d>(); lowest & rest & -rest)
        put(std::countr_zero(rest), vector);
  };
  if (with_gradients_)
    read([&](int k, const math::Vec3d& v) { locations_[k] = {samples_[k].cell, v}; });
  if (with_places_)
    read([&](int k, const math::Vec3d& v) { places_[k] = v; });
  if (with_levels_)
    for (std::uint32_t rest = wanted; rest; rest &= rest - 1)
      if (const auto level = from.value<std::uint8_t>(); lowest & rest & -rest)
        levels_[std::countr_zero(rest)] = level;
  wanted_ |= wanted;
  begin(run);
}

} // namespace insitu::render
