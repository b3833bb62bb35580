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
  /// What paths meet of one of the frame's meshes.
  struct Layer {
    const FramePart* part;
    const CellBoxes* where;
    const Medium* medium;         ///< null: none
    const Surfaces* surfaces;     ///< null: none
    const SharedNormals* normals; ///< null: the surfaces have none that are central differences
  };
  /// All must outlive it. layers: those with a medium in the order of the tracer's media. light:
  /// null if no layer has surfaces; those of the layer `first` count first.
  SharedPaths(std::vector<Layer> layers, std::size_t first, const FrameSettings& settings,
              const PathTracer& tracer, SharedLight* light, TileMail& mail,
              const core::Threads& threads);

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
    std::vector<Asked> asked;        ///< by layer and process
    std::vector<RayState> wall_rays; ///< of walls, and maybe some more
  };

  std::int64_t collect(Batch& batch) const;
  void ask(Batch& batch, std::vector<TileParcel>& parcels) const;
  using WallRays = std::vector<RayState>;
  void ask(Batch& batch, std::size_t layer, int process, std::vector<TileParcel>& parcels) const;
  WallRays find_walls(const TileParcel& asked) const;
  std::vector<std::byte> answer(const TileParcel& asked, const WallRays& walls) const;
  static void answer_values(const Layer& layer, ByteReader& from, std::size_t count,
                            ByteWriter& to);
  void begin_answers(Batch& batch) const;
  void take(Batch& batch, std::span<const TileParcel> answers) const;
  void take_walls(Batch& batch) const;
  void light_walls();
  void light_walls(std::size_t layer);
  /// Parcels are about a tile and a layer.
  std::uint32_t slot_of(std::uint32_t tile, std::size_t layer) const {
    return tile * std::uint32_t(layers_.size()) + std::uint32_t(layer);
  }
  std::size_t layer_of(std::uint32_t slot) const { return slot % layers_.size(); }
  Asked& asked_of(Batch& batch, std::size_t layer, int process) const {
    return batch.asked[layer * std::size_t(world_.size()) + std::size_t(process)];
  }

  const std::vector<Layer> layers_;
  const std::size_t first_;
  std::vector<const Medium*> media_;      ///< those of the layers
  std::vector<const Surfaces*> surfaces_; ///< by layer
  parallel::World& world_;
  const FrameSettings& settings_;
  const PathTracer& tracer_;
  SharedLight* light_;
  TileMail& mail_;
  const core::Threads& threads_;
  std::vector<Batch> batches_; ///< of tiles; vectors keep their memory
  std::size_t count_ = 0;      ///< of them are in use
  PathCounts counts_;
};

} // namespace insitu::render
