#include <utility>

#include "query/chart_image.h"
#include "render/processes/shared_frame.h"

/// Normals that are central differences: the places about a hit may be in other processes' cells.
namespace insitu::render {

namespace {

struct SentPlace {
  math::Vec3d at;
  std::int32_t surface;
  std::int32_t none = 0;
};
static_assert(sizeof(SentPlace) == std::size_t(bytes_a_place_about));

struct SentValue {
  std::int64_t key;
  double value;
};
static_assert(sizeof(SentValue) == std::size_t(bytes_a_place_value));

/// visit(hit, ray, half the length of its differences) for the hits that need some.
template <class Visit>
void for_each_central_hit(const IsosurfaceTracer& surfaces, std::span<RayState> rays,
                          Visit&& visit) {
  for (RayState& ray : rays)
    for (SurfaceHit& hit : ray.hits)
      if (surfaces.is_central(hit.surface))
        visit(hit, ray.ray, surfaces.half_length(hit));
}

} // namespace

/// Of the hits of a near tile.
struct SharedFrame::Differences {
  std::vector<IsosurfaceTracer::PlaceValue> values; ///< place by place, hit by hit; cells are keys
  std::vector<std::vector<std::uint32_t>> asked;    ///< by process: of these places
  std::vector<ByteWriter> questions;                ///< by process
};

/// In slices of tiles, as memory allows.
void SharedFrame::find_central_normals() {
  for (std::size_t begin = 0, end = 0;; begin = end) {
    std::vector<Differences> of;
    std::vector<TileParcel> parcels;
    part_.world.agree_after([&] {
      std::size_t bytes = 0;
      for (; end < near_count_ && bytes < part_.most_bytes; ++end)
        for (const RayState& ray : rays_of(near_[end]))
          bytes += ray.hits.size() * IsosurfaceTracer::places_about * sizeof(SentPlace);
      of.resize(end - begin);
      for_tiles(of.size(), [&](std::size_t i) { of[i] = places_about_hits(near_[begin + i]); });
      for (std::size_t i = 0; i < of.size(); ++i)
        for (std::size_t p = 0; p < of[i].questions.size(); ++p)
          if (ByteWriter& question = of[i].questions[p]; !question.empty())
            parcels.push_back({int(p), near_[begin + i].slot, std::exchange(question, {}).bytes()});
    });
    const std::vector<TileParcel> asked = mail_.exchange(std::exchange(parcels, {}));
    part_.world.agree_after([&] {
      parcels.resize(asked.size());
      for_tiles(asked.size(), [&](std::size_t q) {
        parcels[q] = {asked[q].rank, asked[q].slot, answer_places(asked[q].reader())};
      });
    });
    const std::vector<TileParcel> answers = mail_.exchange(std::move(parcels));
    part_.world.agree_after([&] {
      for_tiles(of.size(), [&](std::size_t i) {
        NearTile& near = near_[begin + i];
        for (const TileParcel& answer : answers)
          if (answer.slot == near.slot)
            take_places(answer, of[i]);
        set_central_normals(near, of[i]);
      });
    });
    std::int64_t left = std::int64_t(near_count_ - end);
    part_.world.reduce(std::span(&left, 1), parallel::Reduction::greatest);
    if (left == 0)
      return;
  }
}

/// What this process's own cells hold of the places, and what others are asked of them.
SharedFrame::Differences SharedFrame::places_about_hits(NearTile& near) const {
  Differences found;
  const auto processes = std::size_t(part_.world.size());
  found.asked.resize(processes);
  found.questions.resize(processes);
  if (!surfaces_ || !surfaces_->isosurfaces())
    return found;
  const IsosurfaceTracer& surfaces = *surfaces_->isosurfaces();
  const query::ChartImage* const chart = sampler_.chart();
  for_each_central_hit(
      surfaces, rays_of(near), [&](const SurfaceHit& hit, const Ray& ray, double half) {
        const math::Vec3d p = ray.origin + hit.t * ray.direction;
        for (int i = 0; i < IsosurfaceTracer::places_about; ++i) {
          const SentPlace place{IsosurfaceTracer::place_about(p, half, i), hit.surface};
          const math::Vec3d image = chart ? (*chart)(place.at) : place.at;
          for (std::size_t other = 0; other < processes; ++other)
            if (int(other) != part_.world.rank() && where_->may_hold(int(other), image)) {
              found.asked[other].push_back(std::uint32_t(found.values.size()));
              found.questions[other].value(place);
            }
          found.values.push_back(own_value(hit.surface, place.at, hit.cell));
        }
      });
  return found;
}

/// Of a place that an own cell holds, and the cell's key.
IsosurfaceTracer::PlaceValue SharedFrame::own_value(std::int32_t surface, const math::Vec3d& place,
                                                    std::int64_t hint) const {
  const auto found = surfaces_->isosurfaces()->value_at(surface, place, hint);
  if (found.cell < 0 || found.cell >= part_.own_cells || !sampler_.mesh().is_own(found.cell))
    return {};
  return {part_.key(found.cell), found.value};
}

/// A bit a place, and the values at those that own cells hold.
std::vector<std::byte> SharedFrame::answer_places(ByteReader asked) const {
  ByteWriter writer, values;
  std::vector<std::uint64_t> bits;
  for (std::size_t i = 0; !asked.at_end(); ++i) {
    const auto place = asked.value<SentPlace>();
    const auto found = own_value(place.surface, place.at, -1);
    bits.resize(words_of(i + 1));
    if (found.cell < 0)
      continue;
    bits[i / 64] |= std::uint64_t(1) << (i % 64);
    values.value(SentValue{found.cell, found.value});
  }
  writer.array(std::span<const std::uint64_t>(bits));
  const std::vector<std::byte> behind = values.bytes();
  writer.array(std::span<const std::byte>(behind));
  return writer.bytes();
}

/// Of the processes that hold a place that of the lowest cell counts.
void SharedFrame::take_places(const TileParcel& answer, Differences& to) {
  const std::vector<std::uint32_t>& asked = to.asked[std::size_t(answer.rank)];
  ByteReader reader = answer.reader();
  const auto bits = reader.array<std::uint64_t>(words_of(asked.size()));
  for (std::size_t i = 0; i < asked.size(); ++i)
    if (bits[i / 64] >> (i % 64) & 1) {
      const auto sent = reader.value<SentValue>();
      IsosurfaceTracer::PlaceValue& value = to.values[asked[i]];
      if (value.cell < 0 || sent.key < value.cell)
        value = {sent.key, sent.value};
    }
}

void SharedFrame::set_central_normals(NearTile& near, const Differences& found) const {
  if (found.values.empty())
    return;
  constexpr auto places = std::size_t(IsosurfaceTracer::places_about);
  const IsosurfaceTracer& surfaces = *surfaces_->isosurfaces();
  std::size_t next = 0;
  for_each_central_hit(surfaces, rays_of(near), [&](SurfaceHit& hit, const Ray& ray, double half) {
    const std::span<const IsosurfaceTracer::PlaceValue, places> values(&found.values[next], places);
    surfaces_->set_gradient(hit, ray, surfaces.central_gradient(hit.surface, half, values));
    next += places;
  });
}

} // namespace insitu::render
