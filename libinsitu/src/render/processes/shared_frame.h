#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "core/for_each.h"
#include "render/pixel_average.h"
#include "render/processes/frame_part.h"
#include "render/processes/frame_tiles.h"
#include "render/processes/run_data.h"
#include "render/processes/shared_light.h"
#include "render/processes/shared_normals.h"
#include "render/processes/shared_paths.h"
#include "render/processes/tile_data.h"
#include "render/processes/tile_mail.h"
#include "render/surface/surfaces.h"

namespace insitu::render {

/// A frame of several processes while it is drawn: its tiles, group by group. Calls are collective
/// and throw AgreedError, but for the constructor.
class SharedFrame {
public:
  /// What the processes find out beforehand. Collective.
  struct Known {
    Known(const FramePart& part, const query::Sampler& sampler, const FrameSettings& settings,
          Structures& structures, const core::Threads& threads);
    VolumeStructures volume;
    std::unique_ptr<Majorants> path_majorants; ///< if the volume is path traced
    /// If rays of light are sent, normals are central differences, or paths are traced.
    std::optional<CellBoxes> where;

  private:
    void know_volume(const FramePart& part, const query::Sampler& sampler,
                     const FrameSettings& settings, Structures& structures);
    std::unique_ptr<Majorants> majorants_;
    std::optional<Macrocells> macrocells_; ///< of the whole mesh, with a tolerance
  };

  /// All must outlive it; path tracing in the settings knows the majorants. Not collective; throws
  /// core::Error.
  SharedFrame(const FramePart& part, const query::Sampler& sampler, const FrameSettings& settings,
              const Known& known, Structures& structures, const core::Threads& threads);

  /// Draws from now on this sample of each pixel of a frame that has several. Not collective.
  void set_sample(const PixelAverage::Sample& sample);
  /// Draws into the images of the root.
  void draw(FrameImages& images);
  /// What was done here, so far. Not collective.
  void add_to(FrameStatistics& statistics) const;
  PathCounts path_counts() const { return paths_ ? paths_->counts() : PathCounts{}; }

private:
  /// A tile's rays at the process that owns it.
  struct OwnTile {
    std::uint32_t slot = 0;               ///< in the group
    std::vector<RayState> rays;           ///< of the tile, and maybe some more
    std::vector<std::int32_t> end;        ///< rounds that a ray takes part in end here
    std::vector<int> sources;             ///< processes whose cells may be seen in the tile
    std::vector<std::uint64_t> saturated; ///< a bit a ray
    bool has_news = false;                ///< sources do not know yet which rays are
    std::vector<std::uint16_t> asked;     ///< rays of which runs do not tell enough
    std::optional<VolumeMarcher::Progress> progress;
  };
  /// A tile's rays where this process's cells may be seen in it.
  struct NearTile {
    std::uint32_t slot = 0;
    std::vector<RayState> rays;                    ///< of the tile, and maybe some more
    std::vector<query::LatticeRay> lattice;        ///< the same
    std::vector<std::vector<std::uint16_t>> open;  ///< by part: rays that have not ended
    std::vector<std::vector<std::uint16_t>> asked; ///< by part: rays that are claimed after all
  };
  using Rays = std::vector<std::vector<std::uint16_t>> NearTile::*;

  std::int64_t tiles_a_group() const;
  void begin_paths(const Known& known, bool meet_surfaces, Structures& structures);
  void begin(const FrameTile& tile, std::vector<RayState>& rays) const;
  void begin_group();
  template <class Work>
  void for_tiles(std::size_t count, Work&& work) const {
    core::for_each(threads_, count, work);
  }
  const FrameTile& tile_of(std::uint32_t slot) const { return (*group_)[slot]; }
  std::span<RayState> rays_of(OwnTile& tile) const {
    return {tile.rays.data(), tile_of(tile.slot).rays()};
  }
  std::span<RayState> rays_of(NearTile& tile) const {
    return {tile.rays.data(), tile_of(tile.slot).rays()};
  }
  OwnTile& own_of(std::uint32_t slot);
  NearTile& near_of(std::uint32_t slot);

  void find_hits();
  void find_own_hits(NearTile& near);
  TileParcel take_own_hits(NearTile& near);
  void order(OwnTile& tile);
  void light_hits();
  bool hits_send_rays() const { return surfaces_ && surfaces_->light_shader(); }
  void finish(FrameImages& images);
  void complete(OwnTile& tile) const;
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
  const query::Sampler sampler_;
  const FrameSettings& settings_;
  const core::Threads& threads_;
  RayGenerator rays_;
  std::uint64_t sample_ = 0; ///< of each pixel
  std::optional<VolumeMarcher> volume_;
  std::optional<Surfaces> surfaces_;
  bool composites_ = false;               ///< where the cells are
  int claimed_ = ClaimReader::most_depth; ///< samples of a ray that are claimed at once
  int depth_ = claimed_;                  ///< samples of a ray in a round
  bool tells_cells_ = false;              ///< which claimed samples are in
  RunForm form_;
  std::vector<std::vector<FrameTile>> groups_;
  TileMail mail_;
  std::optional<SharedNormals> normals_; ///< if they are central differences
  std::optional<SharedLight> light_;     ///< if hits or samples send rays, or paths meet surfaces
  std::optional<PathTracer> tracer_;
  std::optional<SharedPaths> paths_;
  // Of the group that is being drawn; vectors keep their memory.
  const std::vector<FrameTile>* group_ = nullptr;
  std::vector<OwnTile> own_;
  std::vector<NearTile> near_;
  std::size_t own_count_ = 0, near_count_ = 0;
  std::mutex mutex_;
  VolumeCounts volume_counts_;   ///< under the mutex
  SurfaceCounts surface_counts_; ///< under the mutex
  std::int64_t hits_ = 0;        ///< under the mutex
};

/// What is written of the near tiles for their owners, parcels without a byte left out:
/// work(rays, lattice, width, first_ray, which, counts, writer) for the parts of a tile of which
/// some rays are to be looked at, `which` of them. Within an agreement.
template <class Work>
std::vector<TileParcel> SharedFrame::from_near(Rays rays, Work&& work) {
  std::vector<TileParcel> parcels(near_count_);
  for_tiles(near_count_, [&](std::size_t i) {
    thread_local ByteWriter writer; // for the thread's life
    writer.clear();
    VolumeCounts counts;
    NearTile& near = near_[i];
    const FrameTile& tile = tile_of(near.slot);
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
