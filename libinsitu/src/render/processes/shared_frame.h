#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "core/for_each.h"
#include "render/pixel_average.h"
#include "render/processes/frame_part.h"
#include "render/processes/shared_light.h"
#include "render/processes/shared_normals.h"
#include "render/processes/shared_paths.h"
#include "render/processes/shared_tiles.h"
#include "render/processes/shared_volume.h"
#include "render/processes/tile_data.h"
#include "render/processes/tile_mail.h"
#include "render/surface/surfaces.h"

namespace insitu::render {

/// A frame of several processes while it is drawn: its tiles, group by group. Calls are collective
/// and throw AgreedError, but for the constructor.
class SharedFrame {
public:
  /// What the processes find out beforehand about a layer. Collective.
  struct Known {
    Known(const FramePart& part, const FrameLayer& layer, const core::Threads& threads);
    VolumeStructures volume;
    std::unique_ptr<Majorants> path_majorants; ///< if the volume is path traced
    /// If rays of light are sent, normals are central differences, or paths are traced.
    std::optional<CellBoxes> where;

  private:
    void know_volume(const FramePart& part, const FrameLayer& layer);
    std::unique_ptr<Majorants> majorants_;
    std::optional<Macrocells> macrocells_; ///< of the whole mesh, with a tolerance
  };

  /// All must outlive it, by layer; path tracing in the settings knows the majorants. Not
  /// collective; throws core::Error.
  SharedFrame(std::span<const FramePart> parts, std::span<const FrameLayer> layers,
              std::span<const std::optional<Known>> known, const core::Threads& threads);

  /// Draws from now on this sample of each pixel of a frame that has several. Not collective.
  void set_sample(const PixelAverage::Sample& sample);
  /// Draws into the images of the root.
  void draw(FrameImages& images);
  /// What was done here, so far. Not collective.
  void add_to(FrameStatistics& statistics) const;
  PathCounts path_counts() const { return paths_ ? paths_->counts() : PathCounts{}; }

private:
  /// What this process has of one of the frame's meshes.
  struct Layer {
    Layer(const FramePart& part_, const FrameLayer& from)
        : part(part_), sampler(from.sampler), settings(from.settings) {}
    const FramePart& part;
    const query::Sampler sampler;
    const FrameSettings& settings;
    std::optional<Surfaces> surfaces;
    std::optional<SharedNormals> normals; ///< if they are central differences
    std::optional<SharedVolume> volume;
    // Of the group that is being drawn; vectors keep their memory.
    std::vector<NearTile> near;
    std::vector<OwnTile> alone; ///< own tiles for this volume, of a frame that has several
    SharedTiles tiles;
  };

  void begin_surfaces(std::span<const FrameLayer> layers);
  void begin_light(std::span<const std::optional<Known>> known);
  void begin_volumes(std::span<const FrameLayer> layers,
                     std::span<const std::optional<Known>> known);
  void begin_paths(std::span<const FrameLayer> layers, std::span<const std::optional<Known>> known);
  std::int64_t tiles_a_group() const;
  void begin(const FrameTile& tile, std::vector<RayState>& rays) const;
  void begin_group();
  void begin_group(Layer& layer);
  template <class Work>
  void for_tiles(std::size_t count, Work&& work) const {
    core::for_each(threads_, count, work);
  }
  const FrameTile& tile_of(std::uint32_t slot) const { return (*group_)[slot]; }
  /// This process's, with all hits, which become pixels.
  std::span<OwnTile> own_tiles() { return {own_.data(), own_count_}; }
  std::span<RayState> rays_of(OwnTile& tile) const {
    return {tile.rays.data(), tile_of(tile.slot).rays()};
  }

  void find_hits();
  void find_own_hits(Layer& layer, NearTile& near);
  TileParcel take_own_hits(std::size_t layer, NearTile& near);
  void read_own_hits(const TileParcel& parcel);
  void order(OwnTile& tile);
  void light_hits();
  bool hits_send_rays() const { return first_surfaces_ && first_surfaces_->light_shader(); }
  void finish(FrameImages& images);
  void complete(std::size_t own);
  TileParcel finish(std::size_t own);
  bool adds_up() const;
  void write_pixel(std::size_t own, std::size_t ray, ByteWriter& to) const;
  void read_pixel(ByteReader& from, std::size_t at, float* pixel) const;
  void find_solvers_cells();
  std::vector<std::byte> ask_solvers_cells(OwnTile& tile) const;
  std::vector<std::byte> answer_solvers_cells(const NearTile& near, ByteReader asked) const;
  static void take_solvers_cells(OwnTile& tile, ByteReader answer);

  void trace_paths();
  void march();
  void count(const VolumeCounts& counts);

  const FramePart& part_; ///< the first layer's: of all, but for cells
  const FrameSettings& settings_;
  const core::Threads& threads_;
  RayGenerator rays_;
  std::uint64_t sample_ = 0; ///< of each pixel
  TileMail mail_;
  std::deque<Layer> layers_;
  std::size_t first_surfaced_ = 0; ///< the first layer with surfaces
  const Surfaces* first_surfaces_ = nullptr;
  std::vector<const Surfaces*> surfaces_; ///< by layer; null: the layer has none
  std::size_t volumes_ = 0;          ///< that are marched
  std::int32_t volume_layer_ = 0;    ///< the last one's
  std::optional<SharedLight> light_; ///< if hits or samples may send rays, or paths meet surfaces
  std::optional<PathTracer> tracer_;
  std::optional<SharedPaths> paths_;
  std::vector<std::vector<FrameTile>> groups_;
  // Of the group that is being drawn; vectors keep their memory.
  const std::vector<FrameTile>* group_ = nullptr;
  std::vector<OwnTile> own_;
  std::size_t own_count_ = 0;
  std::mutex mutex_;
  VolumeCounts volume_counts_;   ///< under the mutex
  SurfaceCounts surface_counts_; ///< under the mutex
  std::int64_t hits_ = 0;        ///< under the mutex
};

} // namespace insitu::render
