#include <algorithm>

#include "render/processes/shared_volume.h"

/// The volume of a frame of several processes where each composites the samples in its own cells.
namespace insitu::render {

/// All composite samples of the group's rays, and owners blend what comes of that.
void SharedVolume::composite(std::int64_t first) {
  std::vector<TileParcel> parcels;
  part_.world.agree_after([&] {
    parcels = from_near(&NearTile::open, [&](std::span<RayState> rays, auto lattice, int width,
                                             std::size_t first_ray, auto& open,
                                             VolumeCounts& counts, ByteWriter& writer) {
      thread_local VolumeMarcher::Runs runs; // for the thread's life
      runs.runs.clear();
      runs.pieces.clear();
      volume_.composite(rays, lattice, width, first, depth_, part_.own_cells, open, runs, counts);
      write_runs(runs, first_ray, first, form_, writer);
    });
  });
  const std::vector<TileParcel> received = mail_.exchange(std::move(parcels));
  part_.world.agree_after([&] {
    for_tiles(tiles_.own.size(), [&](std::size_t i) { blend(tiles_.own[i], received, first); });
  });
}

namespace {

/// Whether the code of one process may end the ray, which had gathered so much of so many hits
/// before these runs, sooner than they do, and an image of 8 bits tell: what is behind adds a
/// thousandth at most, which is less than one of 255 steps of a channel that is not dark, and up to
/// three where sRGB has them close together.
bool may_end_sooner(const RayState& ray, float alpha, std::size_t hits, const SentRuns& runs,
                    const SentRuns::Sent& first, const RunForm& form) {
  constexpr float dark = 0.025f, slack = 2e-5f;
  const Color& c = ray.color;
  if (!(ray.alpha > saturated - slack) || std::min({c.r, c.g, c.b}) > dark)
    return false;
  // A piece with nothing before it that is saturated has ended where the whole ray does.
  const bool is_first = !(alpha > 0) && !form.is_preintegrated && first.pieces > 0 &&
                        runs.pieces(first)[0].hits == hits;
  return !is_first || !(runs.pieces(first)[0].alpha >= saturated);
}

} // namespace

/// Blends the runs on a tile's rays. Where two processes have the same sample, on a face between
/// their cells or in cells that overlap, the lowest cell has to be found.
void SharedVolume::blend(OwnTile& tile, std::span<const TileParcel> received, std::int64_t first) {
  thread_local SentRuns runs; // for the thread's life
  const std::size_t rays = tiles_.tile_of(tile.slot).rays();
  runs.clear(rays);
  tile.asked.clear();
  for (const TileParcel& parcel : received)
    if (parcel.slot == tile.slot)
      runs.add(parcel.rank, parcel.reader(), first, form_);
  runs.put_in_order();
  for (std::size_t r = 0; r < rays; ++r) {
    RayState& ray = tile.rays[r];
    const std::span<const SentRuns::Sent> of_ray = runs.of(r);
    if (of_ray.empty() || ray.is_saturated())
      continue;
    if (SentRuns::overlap(of_ray)) {
      tile.asked.push_back(std::uint16_t(r));
      continue;
    }
    const Color color = ray.color;
    const float alpha = ray.alpha;
    const std::size_t next_hit = ray.next_hit;
    tile.progress->keep(r);
    for (const SentRuns::Sent& run : of_ray)
      if (!ray.is_saturated())
        volume_.gather(ray, *tile.progress, r, run, runs.pieces(run));
    if (may_end_sooner(ray, alpha, next_hit, runs, of_ray[0], form_)) {
      ray.color = color;
      ray.alpha = alpha;
      ray.next_hit = next_hit;
      tile.progress->put_back(r);
      tile.asked.push_back(std::uint16_t(r));
      continue;
    }
    note_saturated(tile, r);
  }
}

/// Whether some owner has to ask for cells.
bool SharedVolume::are_asked() const {
  std::int64_t asked = 0;
  for (std::size_t i = 0; i < tiles_.own.size(); ++i)
    asked += std::int64_t(tiles_.own[i].asked.size());
  part_.world.reduce(std::span(&asked, 1), parallel::Reduction::sum);
  return asked > 0;
}

/// All claim the round's samples, with cells, of rays of which owners have not been told enough.
void SharedVolume::claim_asked(std::int64_t first) {
  std::vector<TileParcel> parcels;
  part_.world.agree_after([&] {
    for (std::size_t i = 0; i < tiles_.own.size(); ++i)
      for (const int source : tiles_.own[i].sources)
        if (!tiles_.own[i].asked.empty())
          parcels.push_back({source, tiles_.own[i].slot, parallel::bytes_of(tiles_.own[i].asked)});
  });
  const std::vector<TileParcel> received = mail_.exchange(std::move(parcels));
  part_.world.agree_after([&] {
    for (const TileParcel& parcel : received)
      begin_asked(tiles_.near_of(parcel.slot), parcel.reader(), first);
  });
  for (std::int64_t from = first; from < first + depth_; from += claimed_)
    claim({from, &NearTile::asked});
  part_.world.agree_after([&] { // what was hidden here may be seen after all
    for (std::size_t i = 0; i < tiles_.near.size(); ++i)
      for (std::size_t p = 0; p < tiles_.near[i].open.size(); ++p) {
        std::vector<std::uint16_t>&open = tiles_.near[i].open[p], &asked = tiles_.near[i].asked[p];
        open.insert(open.end(), asked.begin(), asked.end());
        std::sort(open.begin(), open.end());
        open.erase(std::unique(open.begin(), open.end()), open.end());
        asked.clear();
      }
  });
}

void SharedVolume::begin_asked(NearTile& near, ByteReader from, std::int64_t first) const {
  const std::vector<FrameTile::Part> parts = tiles_.tile_of(near.slot).parts();
  while (!from.at_end()) {
    const std::size_t r = from.value<std::uint16_t>();
    const auto part = std::find_if(parts.begin(), parts.end(), [&](const FrameTile::Part& p) {
      return r < p.first_ray + p.rays();
    });
    RayState& ray = near.rays[r];
    ray.next = std::max(ray.first, first);
    if (ray.next < ray.end)
      near.asked[std::size_t(part - parts.begin())].push_back(std::uint16_t(r - part->first_ray));
  }
}

} // namespace insitu::render
