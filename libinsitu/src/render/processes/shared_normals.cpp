#include "render/processes/shared_normals.h"

#include <utility>

#include "core/for_each.h"
#include "query/chart_image.h"
#include "render/processes/place_values.h"

namespace insitu::render {

namespace {

struct SentPlace {
  math::Vec3d at;
  std::int32_t surface;
  std::int32_t none = 0;
};
static_assert(sizeof(SentPlace) == std::size_t(bytes_a_place_about));

constexpr auto places_a_hit = std::size_t(IsosurfaceTracer::places_about);

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

/// The places about the hits of some rays.
struct SharedNormals::Group {
  std::vector<PlaceValue> values;                ///< place by place, hit by hit; cells are keys
  std::vector<std::vector<std::uint32_t>> asked; ///< by process: of these places
  std::vector<ByteWriter> questions;             ///< by process
};

/// In slices of groups, as memory allows. Parcels are about groups of the process that asks.
void SharedNormals::find(std::size_t groups,
                         core::FunctionRef<std::span<RayState>(std::size_t)> rays) const {
  for (std::size_t begin = 0, end = 0;; begin = end) {
    std::vector<Group> of;
    std::vector<TileParcel> parcels;
    part_.world.agree_after([&] {
      std::size_t bytes = 0;
      for (; end < groups && bytes < part_.most_bytes; ++end)
        for (const RayState& ray : rays(end))
          bytes += ray.hits.size() * places_a_hit * sizeof(SentPlace);
      of.resize(end - begin);
      core::for_each(threads_, of.size(),
                     [&](std::size_t i) { of[i] = places_about(rays(begin + i)); });
      for (std::size_t i = 0; i < of.size(); ++i)
        for (std::size_t p = 0; p < of[i].questions.size(); ++p)
          if (ByteWriter& question = of[i].questions[p]; !question.empty())
            parcels.push_back({int(p), std::uint32_t(i), std::exchange(question, {}).bytes()});
    });
    const std::vector<TileParcel> asked = mail_.exchange(std::exchange(parcels, {}));
    part_.world.agree_after([&] {
      parcels.resize(asked.size());
      core::for_each(threads_, asked.size(), [&](std::size_t q) {
        parcels[q] = {asked[q].rank, asked[q].slot, answer(asked[q].reader())};
      });
    });
    const std::vector<TileParcel> answers = mail_.exchange(std::move(parcels));
    part_.world.agree_after([&] {
      for (const TileParcel& answer : answers)
        take(answer, of[answer.slot]);
      core::for_each(threads_, of.size(),
                     [&](std::size_t i) { set_gradients(rays(begin + i), of[i]); });
    });
    std::int64_t left = std::int64_t(groups - end);
    part_.world.reduce(std::span(&left, 1), parallel::Reduction::greatest);
    if (left == 0)
      return;
  }
}

/// What this process's own cells hold of the places, and what others are asked of them.
SharedNormals::Group SharedNormals::places_about(std::span<RayState> rays) const {
  Group found;
  const IsosurfaceTracer* const surfaces = surfaces_.isosurfaces();
  if (!surfaces)
    return found;
  const auto processes = std::size_t(part_.world.size());
  found.asked.resize(processes);
  found.questions.resize(processes);
  const query::ChartImage* const chart = sampler_.chart();
  for_each_central_hit(*surfaces, rays, [&](const SurfaceHit& hit, const Ray& ray, double half) {
    const math::Vec3d p = ray.origin + hit.t * ray.direction;
    for (int i = 0; i < IsosurfaceTracer::places_about; ++i) {
      const SentPlace place{IsosurfaceTracer::place_about(p, half, i), hit.surface};
      const math::Vec3d image = chart ? (*chart)(place.at) : place.at;
      for (std::size_t other = 0; other < processes; ++other)
        if (int(other) != part_.world.rank() && where_.may_hold(int(other), image)) {
          found.asked[other].push_back(std::uint32_t(found.values.size()));
          found.questions[other].value(place);
        }
      found.values.push_back(own_value(hit.surface, place.at, hit.cell));
    }
  });
  return found;
}

/// Of a place that an own cell holds, with that cell's key.
PlaceValue SharedNormals::own_value(std::int32_t surface, const math::Vec3d& place,
                                    std::int64_t hint) const {
  PlaceValue found = surfaces_.isosurfaces()->value_at(surface, place, hint);
  found.cell = part_.own_key(sampler_.mesh(), found.cell);
  return found;
}

std::vector<std::byte> SharedNormals::answer(ByteReader asked) const {
  std::vector<PlaceValue> found;
  while (!asked.at_end()) {
    const auto place = asked.value<SentPlace>();
    found.push_back(own_value(place.surface, place.at, -1));
  }
  ByteWriter writer;
  write_values(found, writer);
  return writer.bytes();
}

void SharedNormals::take(const TileParcel& answer, Group& to) {
  ByteReader reader = answer.reader();
  read_values(reader, to.asked[std::size_t(answer.rank)],
              [&](std::uint32_t i) -> PlaceValue& { return to.values[i]; });
}

void SharedNormals::set_gradients(std::span<RayState> rays, const Group& found) const {
  if (found.values.empty())
    return;
  const IsosurfaceTracer& surfaces = *surfaces_.isosurfaces();
  std::size_t next = 0;
  for_each_central_hit(surfaces, rays, [&](SurfaceHit& hit, const Ray& ray, double half) {
    const std::span<const PlaceValue, places_a_hit> values(&found.values[next], places_a_hit);
    surfaces_.set_gradient(hit, ray, surfaces.central_gradient(hit.surface, half, values));
    next += places_a_hit;
  });
}

} // namespace insitu::render
