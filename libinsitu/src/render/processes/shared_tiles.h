#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "query/ray_bundle/ray_bundle.h"
#include "render/processes/frame_tiles.h"
#include "render/volume/volume.h"

/// The tiles of a group, which processes draw together.
namespace insitu::render {

/// A tile's rays at the process that owns it.
struct OwnTile {
  std::uint32_t slot = 0;     ///< in the group
  std::vector<RayState> rays; ///< of the tile, and maybe some more
  // Of a volume that is marched on these rays (SharedVolume).
  std::vector<int> sources;             ///< processes whose cells may be seen in the tile
  std::vector<std::int32_t> end;        ///< rounds that a ray takes part in end here
  std::vector<std::uint64_t> saturated; ///< a bit a ray
  bool has_news = false;                ///< sources do not know yet which rays are
  std::vector<std::uint16_t> asked;     ///< rays of which runs do not tell enough
  std::optional<VolumeMarcher::Progress> progress;
};

/// A tile's rays where this process's cells of a mesh may be seen in it.
struct NearTile {
  std::uint32_t slot = 0;
  std::vector<RayState> rays;                    ///< of the tile, and maybe some more
  std::vector<query::LatticeRay> lattice;        ///< the same
  std::vector<std::vector<std::uint16_t>> open;  ///< by part: rays that have not ended
  std::vector<std::vector<std::uint16_t>> asked; ///< by part: rays that are claimed after all
};

/// What a process has to do with a group's tiles and one mesh.
struct SharedTiles {
  const std::vector<FrameTile>* group = nullptr;
  std::span<OwnTile> own;
  std::span<NearTile> near;

  const FrameTile& tile_of(std::uint32_t slot) const { return (*group)[slot]; }
  template <class Tile>
  std::span<RayState> rays_of(Tile& tile) const {
    return {tile.rays.data(), tile_of(tile.slot).rays()};
  }
  OwnTile& own_of(std::uint32_t slot) const { return find(own, slot); }
  NearTile& near_of(std::uint32_t slot) const { return find(near, slot); }

private:
  template <class Tile>
  static Tile& find(std::span<Tile> tiles, std::uint32_t slot) {
    return *std::find_if(tiles.begin(), tiles.end(),
                         [&](const Tile& tile) { return tile.slot == slot; });
  }
};

} // namespace insitu::render
