#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

#include "core/for_each.h"
#include "render/processes/frame_part.h"
#include "render/processes/run_data.h"
#include "render/processes/shared_light.h"
#include "render/processes/shared_tiles.h"
#include "render/processes/tile_data.h"
#include "render/processes/tile_mail.h"

namespace insitu::render {

/// The volume of one mesh in a frame of several processes: owners of tiles gather it, in rounds of
/// samples by depth. Calls are collective and throw AgreedError, but for the constructor.
class SharedVolume {
public:
  /// What the frame has besides the volume.
  struct Beside {
    bool has_surfaces = false;              ///< of whatever mesh
    const SceneSurfaces* shadows = nullptr; ///< those that cast shadows on the volume
    SharedLight* light = nullptr;           ///< by which they do
    std::size_t light_first = 0;            ///< the layer whose shadows come first
    bool is_exact = true;                   ///< or composited where the cells are
  };
  /// All must outlive it. Not collective; throws core::Error.
  SharedVolume(const FramePart& part, const query::Sampler& sampler, const FrameSettings& settings,
               const VolumeStructures& structures, const Beside& beside, TileMail& mail,
               const core::Threads& threads);

  const VolumeMarcher& marcher() const { return volume_; }
  /// Bytes of a ray's samples that are on their way at a time, at most.
  std::int64_t bytes_a_ray() const;
  /// Gathers the volume along the rays of own tiles, and those of their hits that lie before the
  /// last sample of each. Rays that keep stretches have one hit, if any, which may end them, and
  /// gather none.
  void march(const SharedTiles& tiles);

  /// What was done here, so far. Not collective.
  const VolumeCounts& counts() const { return counts_; }

private:
  using Rays = std::vector<std::vector<std::uint16_t>> NearTile::*;

  template <class Work>
  void for_tiles(std::size_t count, Work&& work) const {
    core::for_each(threads_, count, work);
  }
  void tell_ends();
  void start(NearTile& near) const;
  void march_thin();
  std::int64_t next_round(std::int64_t round) const;
  /// A round of claims, or of those on thin rays.
  struct Round {
    std::int64_t first = 0;
    Rays rays = &NearTile::open;
    bool with_cells = true;
    bool is_thin = false;
  };
  void claim(const Round& round);
  template <class Work>
  std::vector<TileParcel> from_near(Rays rays, Work&& work);
  void gather(std::vector<TileParcel> parcels, const Round& round);
  void gather_by_rays_of_light(std::span<const TileParcel> received, const Round& round);
  using LitSamples = std::vector<std::uint32_t>; ///< by ray: a bit a sample
  void take_points(const OwnTile& tile, ClaimReader ahead, const Round& round,
                   SharedLight::Batch& batch, LitSamples& lit) const;
  ClaimReader claims_of(const OwnTile& tile, std::span<const TileParcel> received,
                        const Round& round) const;
  std::optional<SurfacePoint> lit_point(const OwnTile& tile, const ClaimReader& claimed,
                                        int sample) const;
  void take(OwnTile& tile, const ClaimReader& claimed, const Round& round);
  static void note_saturated(OwnTile& tile, std::size_t ray);
  void composite(std::int64_t first);
  void blend(OwnTile& tile, std::span<const TileParcel> received, std::int64_t first);
  bool are_asked() const;
  void claim_asked(std::int64_t first);
  void begin_asked(NearTile& near, ByteReader from, std::int64_t first) const;
  std::int64_t tell_saturated(std::int64_t round);
  void stop_saturated(NearTile& near, ByteReader from) const;
  void count(const VolumeCounts& counts);

  const FramePart& part_;
  TileMail& mail_;
  const core::Threads& threads_;
  const Beside beside_;
  VolumeMarcher volume_;
  bool composites_ = false;               ///< where the cells are
  int claimed_ = ClaimReader::most_depth; ///< samples of a ray that are claimed at once
  int depth_ = claimed_;                  ///< samples of a ray in a round
  bool tells_cells_ = false;              ///< which claimed samples are in
  RunForm form_;
  SharedTiles tiles_; ///< of the group that is being drawn
  std::mutex mutex_;
  VolumeCounts counts_; ///< under the mutex
};

/// What is written of the near tiles for their owners, parcels without a byte left out:
/// work(rays, lattice, width, first_ray, which, counts, writer) for the parts of a tile of which
/// some rays are to be looked at, `which` of them. Within an agreement.
template <class Work>
std::vector<TileParcel> SharedVolume::from_near(Rays rays, Work&& work) {
  std::vector<TileParcel> parcels(tiles_.near.size());
  for_tiles(tiles_.near.size(), [&](std::size_t i) {
    thread_local ByteWriter writer; // for the thread's life
    writer.clear();
    VolumeCounts counts;
    NearTile& near = tiles_.near[i];
    const FrameTile& tile = tiles_.tile_of(near.slot);
    const std::vector<FrameTile::Part> parts = tile.parts();
    for (std::size_t p = 0; p < parts.size(); ++p) {
      const FrameTile::Part& part = parts[p];
      if (std::vector<std::uint16_t>& which = (near.*rays)[p]; !which.empty())
        work(std::span(&near.rays[part.first_ray], part.rays()),
             std::span<const query::LatticeRay>(&near.lattice[part.first_ray], part.rays()),
             part.x1 - part.x0, part.first_ray, which, counts, writer);
    }
    count(counts);
    parcels[i] = {tile.owner, near.slot, writer.bytes(sizeof near.slot)};
  });
  std::erase_if(parcels, [](const TileParcel& p) { return p.bytes.empty(); });
  return parcels;
}

} // namespace insitu::render
