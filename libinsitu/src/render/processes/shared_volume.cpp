#include "render/processes/shared_volume.h"

#include <algorithm>
#include <bit>
#include <limits>

/// A volume of a frame of several processes, in rounds of samples by depth.
namespace insitu::render {

namespace {

/// A bit beside a ray's number in its tile.
constexpr unsigned opaque = 1u << 15;
static_assert(FrameTile::most_rays <= opaque);

/// Rounds of composited samples are longer: what is sent of them hardly grows, and that a ray is
/// saturated is told late.
constexpr int claims_a_round = 4;

} // namespace

SharedVolume::SharedVolume(const FramePart& part, const query::Sampler& sampler,
                           const FrameSettings& settings, const VolumeStructures& structures,
                           const Beside& beside, TileMail& mail, const core::Threads& threads)
    : part_(part), mail_(mail), threads_(threads), beside_(beside),
      volume_(sampler, *settings.volume, structures, settings.lighting, !settings.clips.empty()) {
  volume_.take_part();
  if (beside.shadows)
    volume_.set_surfaces(beside.shadows);
  claimed_ = ClaimReader::most_depth / volume_.group() * volume_.group();
  composites_ = !beside.is_exact;
  depth_ = composites_ ? claims_a_round * claimed_ : claimed_;
  // Otherwise where two processes claim a sample alone.
  tells_cells_ = settings.cell || volume_.light_shader() || volume_.has_levels();
  if (composites_)
    form_ = {beside.has_surfaces, volume_.is_preintegrated(), volume_.is_lit()};
}

std::int64_t SharedVolume::bytes_a_ray() const {
  return claimed_ * (bytes_a_sample + bytes_a_change + // in any case of some rays
                     (volume_.is_lit() ? bytes_a_gradient : 0) +
                     (volume_.is_lit_by_place() ? bytes_a_place : 0) +
                     (volume_.has_levels() ? bytes_a_level : 0));
}

void SharedVolume::count(const VolumeCounts& counts) {
  const std::lock_guard lock(mutex_);
  counts_ += counts;
}

void SharedVolume::march(const SharedTiles& tiles) {
  tiles_ = tiles;
  tell_ends();
  // The first round, the last one's end, and whether there are thin rays; the latter two negative.
  std::int64_t rounds[3] = {std::numeric_limits<std::int64_t>::max(), 0, 0};
  part_.world.agree_after([&] {
    for (std::size_t i = 0; i < tiles_.own.size(); ++i) {
      OwnTile& tile = tiles_.own[i];
      const std::span<RayState> rays = tiles_.rays_of(tile);
      tile.progress.emplace(rays.size());
      tile.saturated.assign(FrameTile::most_rays / 64, 0);
      tile.has_news = false;
      tile.end.assign(rays.size(), 0);
      for (std::size_t r = 0; r < rays.size(); ++r) {
        volume_.start(rays[r]);
        if (rays[r].keeps_stretches)
          rays[r].hits.clear();
        if (rays[r].is_thin)
          rounds[2] = -1;
        if (rays[r].next >= rays[r].end)
          continue;
        tile.end[r] = std::int32_t((rays[r].end - 1) / depth_ + 1);
        rounds[0] = std::min(rounds[0], rays[r].next / depth_);
        rounds[1] = std::min(rounds[1], -std::int64_t(tile.end[r]));
      }
    }
  });
  part_.world.reduce(std::span(rounds), parallel::Reduction::least);
  if (rounds[2] < 0)
    march_thin();
  for (std::int64_t round = rounds[0]; round < -rounds[1]; round = next_round(round)) {
    if (composites_)
      composite(round * depth_);
    else
      claim({round * depth_, &NearTile::open, tells_cells_});
    if ((composites_ || !tells_cells_) && are_asked())
      claim_asked(round * depth_);
    if (round + 1 == -rounds[1] || tell_saturated(round) == 0)
      break;
  }
}

/// With a tolerance a step may be many rounds long: then the next one in which a process has
/// samples.
std::int64_t SharedVolume::next_round(std::int64_t round) const {
  if (!volume_.has_levels())
    return round + 1;
  std::int64_t next = std::numeric_limits<std::int64_t>::max();
  part_.world.agree_after([&] {
    for (std::size_t i = 0; i < tiles_.near.size(); ++i) {
      const NearTile& near = tiles_.near[i];
      const std::vector<FrameTile::Part> parts = tiles_.tile_of(near.slot).parts();
      for (std::size_t p = 0; p < parts.size(); ++p)
        for (const std::uint16_t r : near.open[p])
          next = std::min(next, near.rays[parts[p].first_ray + r].next);
    }
  });
  part_.world.reduce(std::span(&next, 1), parallel::Reduction::least);
  return std::max(round + 1, next / depth_);
}

/// Owners tell where opaque hits end rays, and where others part what is composited; all start
/// their rays.
void SharedVolume::tell_ends() {
  if (beside_.has_surfaces) {
    std::vector<TileParcel> parcels;
    part_.world.agree_after([&] {
      ByteWriter writer;
      for (std::size_t i = 0; i < tiles_.own.size(); ++i) {
        writer.clear();
        const std::span<RayState> rays = tiles_.rays_of(tiles_.own[i]);
        for (std::size_t r = 0; r < rays.size(); ++r)
          for (const SurfaceHit& hit : rays[r].hits)
            if (const bool is_end = hit.opacity >= 1; is_end || composites_) {
              writer.value(std::uint16_t(r | (is_end ? opaque : 0u)));
              writer.value(hit.t);
            }
        for (const int source : tiles_.own[i].sources)
          if (writer.size() > 0)
            parcels.push_back({source, tiles_.own[i].slot, writer.bytes()});
      }
    });
    mail_.exchange_in_turns(std::move(parcels), [&](const std::vector<TileParcel>& received) {
      for (const TileParcel& parcel : received) {
        NearTile& tile = tiles_.near_of(parcel.slot);
        for (ByteReader reader = parcel.reader(); !reader.at_end();) {
          const auto ray = reader.value<std::uint16_t>();
          SurfaceHit& hit = tile.rays[ray & (opaque - 1)].hits.emplace_back();
          hit.t = reader.value<double>();
          hit.opacity = ray & opaque ? 1 : 0;
        }
      }
    });
  }
  part_.world.agree_after(
      [&] { for_tiles(tiles_.near.size(), [&](std::size_t i) { start(tiles_.near[i]); }); });
}

void SharedVolume::start(NearTile& near) const {
  near.lattice.resize(FrameTile::most_rays);
  const std::vector<FrameTile::Part> parts = tiles_.tile_of(near.slot).parts();
  near.open.resize(parts.size());
  near.asked.resize(parts.size());
  for (std::size_t p = 0; p < parts.size(); ++p) {
    near.open[p].clear();
    near.asked[p].clear();
    for (std::size_t r = 0; r < parts[p].rays(); ++r) {
      RayState& ray = near.rays[parts[p].first_ray + r];
      near.lattice[parts[p].first_ray + r] = {ray.ray.origin, ray.ray.direction};
      volume_.start(ray);
      volume_.keep_near(ray);
      if (ray.next < ray.end)
        near.open[p].push_back(std::uint16_t(r));
    }
  }
}

void SharedVolume::march_thin() {
  std::vector<TileParcel> parcels;
  part_.world.agree_after([&] {
    parcels.resize(tiles_.near.size());
    for_tiles(tiles_.near.size(), [&](std::size_t i) {
      thread_local VolumeMarcher::Claims claims; // these two for the thread's life
      thread_local ByteWriter writer;
      VolumeCounts counts;
      volume_.claim_thin(tiles_.rays_of(tiles_.near[i]), part_.own_cells, claims, counts);
      writer.clear();
      write_claims(claims, 0, &part_.key, writer);
      parcels[i] = {tiles_.tile_of(tiles_.near[i].slot).owner, tiles_.near[i].slot, writer.bytes()};
      count(counts);
    });
    std::erase_if(parcels, [](const TileParcel& p) { return p.bytes.empty(); });
  });
  gather(std::move(parcels), {0, &NearTile::open, true, true});
}

/// All claim samples of the group's rays, and owners gather them.
void SharedVolume::claim(const Round& round) {
  std::vector<TileParcel> parcels;
  part_.world.agree_after([&] {
    parcels = from_near(round.rays, [&](std::span<RayState> rays, auto lattice, int width,
                                        std::size_t first_ray, auto& which, VolumeCounts& counts,
                                        ByteWriter& writer) {
      thread_local VolumeMarcher::Claims claims; // for the thread's life
      volume_.claim(rays, lattice, width, round.first, claimed_, part_.own_cells, which, claims,
                    counts);
      write_claims(claims, first_ray, round.with_cells ? &part_.key : nullptr, writer);
    });
  });
  gather(std::move(parcels), round);
}

/// Sends claims to the owners of their tiles, who take those of a ray together.
void SharedVolume::gather(std::vector<TileParcel> parcels, const Round& round) {
  const std::vector<TileParcel> received = mail_.exchange(std::move(parcels));
  if (volume_.light_shader())
    return gather_by_rays_of_light(received, round);
  part_.world.agree_after([&] {
    for_tiles(tiles_.own.size(), [&](std::size_t i) {
      ClaimReader claimed = claims_of(tiles_.own[i], received, round);
      tiles_.own[i].asked.clear();
      while (claimed.next()) {
        if (claimed.is_tied()) {
          if (!tiles_.own[i].rays[claimed.ray()].is_saturated())
            tiles_.own[i].asked.push_back(std::uint16_t(claimed.ray()));
          continue;
        }
        if (volume_.is_lit_by_place())
          for (std::uint32_t rest = claimed.wanted(); rest; rest &= rest - 1)
            claimed.set_light(std::countr_zero(rest),
                              volume_.light_without_rays(
                                  lit_point(tiles_.own[i], claimed, std::countr_zero(rest))));
        take(tiles_.own[i], claimed, round);
      }
    });
  });
}

ClaimReader SharedVolume::claims_of(const OwnTile& tile, std::span<const TileParcel> received,
                                    const Round& round) const {
  ClaimReader claimed(volume_, round.with_cells);
  for (const TileParcel& parcel : received)
    if (parcel.slot == tile.slot)
      claimed.add(parcel.reader());
  return claimed;
}

std::optional<SurfacePoint> SharedVolume::lit_point(const OwnTile& tile, const ClaimReader& claimed,
                                                    int sample) const {
  return VolumeMarcher::lit_point(tile.rays[claimed.ray()].ray,
                                  claimed.locations()[sample].parametric, claimed.places()[sample]);
}

void SharedVolume::take(OwnTile& tile, const ClaimReader& claimed, const Round& round) {
  const std::size_t r = claimed.ray();
  RayState& ray = tile.rays[r];
  if (round.is_thin)
    return volume_.gather_thin(ray, claimed.samples()->value,
                               volume_.is_lit() ? *claimed.locations()
                                                : query::Location{claimed.samples()->cell, {}});
  volume_.gather(ray, *tile.progress, r, round.first, claimed.wanted(), claimed.samples(),
                 claimed.locations(), claimed.levels());
  note_saturated(tile, r);
}

void SharedVolume::note_saturated(OwnTile& tile, std::size_t r) {
  if (tile.rays[r].is_saturated() && !(tile.saturated[r / 64] >> (r % 64) & 1)) {
    tile.saturated[r / 64] |= std::uint64_t(1) << (r % 64);
    tile.has_news = true;
  }
}

/// Owners tell which rays are saturated before they end. Returns how many of all rays go on.
std::int64_t SharedVolume::tell_saturated(std::int64_t round) {
  std::vector<TileParcel> parcels;
  std::int64_t left = 0;
  part_.world.agree_after([&] {
    ByteWriter writer;
    for (std::size_t i = 0; i < tiles_.own.size(); ++i) {
      OwnTile& tile = tiles_.own[i];
      for (std::size_t r = 0; r < tile.end.size(); ++r)
        left += tile.end[r] > round + 1 && !(tile.saturated[r / 64] >> (r % 64) & 1);
      if (!tile.has_news)
        continue;
      tile.has_news = false;
      writer.clear();
      for (const std::uint64_t word : tile.saturated)
        writer.value(word);
      for (const int source : tile.sources)
        parcels.push_back({source, tile.slot, writer.bytes()});
    }
  });
  part_.world.reduce(std::span(&left, 1), parallel::Reduction::sum);
  if (left == 0)
    return 0;
  const std::vector<TileParcel> received = mail_.exchange(std::move(parcels));
  part_.world.agree_after([&] {
    for (const TileParcel& parcel : received)
      stop_saturated(tiles_.near_of(parcel.slot), parcel.reader());
  });
  return left;
}

void SharedVolume::stop_saturated(NearTile& near, ByteReader from) const {
  std::uint64_t done[FrameTile::most_rays / 64];
  for (std::uint64_t& word : done)
    word = from.value<std::uint64_t>();
  const std::vector<FrameTile::Part> parts = tiles_.tile_of(near.slot).parts();
  for (std::size_t p = 0; p < parts.size(); ++p)
    std::erase_if(near.open[p], [&](std::uint16_t r) {
      const std::size_t ray = parts[p].first_ray + r;
      return done[ray / 64] >> (ray % 64) & 1;
    });
}

} // namespace insitu::render
