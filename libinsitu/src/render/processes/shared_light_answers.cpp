#include "render/processes/shared_light_data.h"
#include "render/surface/tiles/isosurface_rays.h"

/// What rays of light of others meet in this process's cells.
namespace insitu::render {

namespace {

/// The points of a parcel.
struct Received {
  std::vector<SurfacePoint> points;
  std::vector<SecondaryStart> starts;

  explicit Received(const TileParcel& asked) {
    for (ByteReader reader = asked.reader(); !reader.at_end();) {
      const auto sent = reader.value<SentPoint>();
      points.push_back({sent.position, sent.normal, {}, sent.clearance, sent.seed});
      starts.push_back({sent.cell, sent.surface, sent.normal, sent.clearance});
    }
  }
};

} // namespace

std::vector<std::byte> SharedLight::answer(const Shader& shader, const TileParcel& asked) {
  const Received received(asked);
  SurfaceCounts counts, sent;
  const Rays rays(
      shader, received.points.size(),
      [&](std::size_t i) -> const SurfacePoint& { return received.points[i]; }, sent);
  ByteWriter writer;
  write_met(layer_of(asked.slot), rays, received.starts, counts, writer);
  count(counts);
  return writer.bytes();
}

void SharedLight::write_met(std::size_t layer, const Rays& rays,
                            std::span<const SecondaryStart> starts, SurfaceCounts& counts,
                            ByteWriter& to) const {
  const Layer& of = layers_[layer];
  thread_local std::vector<Stretch> stays[RayCells::most]; // these two for the thread's life
  thread_local std::vector<SurfaceHit> hits[RayCells::most];
  struct Where {
    std::uint32_t count = 0, first = 0;
  };
  std::vector<Where> met(rays.all.size());
  std::vector<SentMeeting> found;
  LightRay light[RayCells::most];
  for (const std::vector<std::uint32_t>& stream : rays.streams)
    for (std::size_t first = 0; first < stream.size(); first += RayCells::most) {
      const std::size_t count = std::min<std::size_t>(RayCells::most, stream.size() - first);
      for (std::size_t i = 0; i < count; ++i) {
        const Rays::One& one = rays.all[stream[first + i]];
        light[i] = {one.ray, &stays[i], starts.empty() ? nullptr : &starts[one.point]};
        clip_ray(of.settings->clips, one.ray, 0, one.t_max, stays[i]);
      }
      const unsigned ended = of.surfaces->collect(std::span(light, count), hits, counts);
      for (std::size_t i = 0; i < count; ++i) {
        Where& at = met[stream[first + i]];
        at.first = std::uint32_t(found.size());
        at.count = ended >> i & 1 ? ray_ends : std::uint32_t(hits[i].size());
        if (at.count != ray_ends)
          for (const SurfaceHit& hit : hits[i])
            found.emplace_back(hit, of.part->key(hit.cell));
      }
    }
  std::vector<std::uint64_t> bits(words_of(met.size()));
  for (std::size_t r = 0; r < met.size(); ++r)
    bits[r / 64] |= std::uint64_t(met[r].count > 0) << (r % 64);
  to.array(std::span<const std::uint64_t>(bits));
  for (const Where& at : met)
    if (at.count > 0) {
      to.value(at.count);
      if (at.count != ray_ends)
        to.array(std::span<const SentMeeting>(found).subspan(at.first, at.count));
    }
}

/// The samples of a volume that show here, of the rays that are open: how many, and these.
std::vector<std::byte> SharedLight::answer_shadow(const Shader& shader, const TileParcel& asked,
                                                  ByteReader open) {
  const Layer& of = layers_[layer_of(asked.slot)];
  const VolumeShadow& shadow = *of.surfaces->volume_shadow();
  const Received received(asked);
  SurfaceCounts counts, sent;
  const Rays rays(
      shader, received.points.size(),
      [&](std::size_t i) -> const SurfacePoint& { return received.points[i]; }, sent);
  const auto bits = open.array<std::uint64_t>(words_of(rays.all.size()));
  ByteWriter writer;
  std::vector<VolumeShadow::Claim> claims;
  for (std::size_t r = 0; r < rays.all.size(); ++r) {
    if (!(bits[r / 64] >> (r % 64) & 1))
      continue;
    claims.clear();
    shadow.claim(rays.all[r].ray, rays.all[r].t_max, of.part->own_cells, claims,
                 counts.shadow_samples);
    writer.value(std::uint32_t(claims.size()));
    for (const VolumeShadow::Claim& claim : claims)
      writer.value(
          SentShadowSample{of.part->key(claim.cell), std::int32_t(claim.index), claim.opacity});
  }
  count(counts);
  return writer.bytes();
}

} // namespace insitu::render
