#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "render/path/path_wave.h"
#include "render/processes/cell_boxes.h"
#include "render/processes/frame_part.h"
#include "render/processes/frame_tiles.h"
#include "render/processes/place_values.h"
#include "render/processes/shared_light.h"
#include "render/processes/shared_normals.h"
#include "render/processes/tile_mail.h"

namespace insitu::render {

/// Bytes of a place that a path asks the value of; of a ray of a path that asks for surfaces; and
/// of what stands before these in a parcel.
constexpr std::int64_t bytes_a_path_place = 24, bytes_a_path_ray = 56, bytes_a_path_head = 12;

/// The majorants of a path traced volume whose mesh is spread over processes: those of one process,
/// to the bit. Collective; throws AgreedError.
std::unique_ptr<Majorants> whole_path_majorants(const FramePart& part,
                                                const query::Sampler& sampler,
                                                const FrameSettings& settings,
                                                Structures& structures,
                                                const core::Threads& threads);

/// Paths in a frame of several processes. The process that owns a tile advances its paths, in the
/// waves of one process; what they ask goes to all processes whose cells may know, wave by wave at
/// the same time.
class SharedPaths {
public:
  /// All must outlive it. surfaces, light: null, both or neither, if paths do not meet surfaces.
  /// normals: null: these have none that are central differences.
  SharedPaths(const FramePart& part, const FrameSettings& settings, const PathTracer& tracer,
              const Surfaces* surfaces, SharedLight* light, const SharedNormals* normals,
              const CellBoxes& where, TileMail& mail, const core::Threads& threads);

  /// A tile that this process owns.
  struct Tile {
    std::uint32_t slot = 0;
    /// Rays that are traced together, see PathTracer::tile_side, with their hits in order.
    std::vector<std::span<RayState>> parts;
  };
  /// Draws the tiles' pixels. Collective.
  void trace(std::span<const Tile> tiles);

  /// The samples of a tile's ray; null where none has met the medium. Until the next trace(). Not
  /// collective.
  const PathSums::Pixel* sum(std::size_t tile, std::size_t ray) const;
  /// What was done here, so far. Not collective.
  const PathCounts& counts() const { return counts_; }

  /// Bytes that the paths of a tile take where it is owned.
  static constexpr std::size_t bytes_a_tile =
      std::size_t(FrameTile::most_rays / (PathTracer::tile_side * PathTracer::tile_side)) *
      PathWave::side_by_side * (sizeof(Path) + std::size_t(bytes_a_path_place));

private:
  /// Which of a batch's questions a process was asked.
  struct Asked {
    std::vector<std::uint32_t> values, lights, walls;
  };
  /// A tile's paths, and what they ask now.
  struct Batch {
    std::uint32_t slot = 0;
    std::vector<PathWave> waves; ///< of its parts
    std::size_t parts = 0;       ///< of them are in use
    std::vector<Path*> values, lights, walls;
    std::vector<Asked> asked;        ///< by process
    std::vector<RayState> wall_rays; ///< of walls, and maybe some more
  };

  std::int64_t collect(Batch& batch) const;
  void ask(Batch& batch, std::vector<TileParcel>& parcels) const;
  using WallRays = std::vector<RayState>;
  WallRays find_walls(const TileParcel& asked) const;
  std::vector<std::byte> answer(const TileParcel& asked, const WallRays& walls) const;
  void answer_values(ByteReader& from, std::size_t count, ByteWriter& to) const;
  void take(Batch& batch, std::span<const TileParcel> answers) const;
  void take_walls(Batch& batch) const;
  void light_walls();

  const FramePart& part_;
  const FrameSettings& settings_;
  const PathTracer& tracer_;
  const Surfaces* surfaces_;
  SharedLight* light_;
  const SharedNormals* normals_;
  const CellBoxes& where_;
  TileMail& mail_;
  const core::Threads& threads_;
  std::vector<Batch> batches_; ///< of tiles; vectors keep their memory
  std::size_t count_ = 0;      ///< of them are in use
  PathCounts counts_;
};

} // namespace insitu::render
