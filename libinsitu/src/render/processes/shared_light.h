#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "render/processes/cell_boxes.h"
#include "render/processes/frame_part.h"
#include "render/processes/tile_mail.h"
#include "render/surface/surfaces.h"

namespace insitu::render {

/// A point that is lit: where its rays start, and the cell of that place, if it is on a surface.
struct LightPoint {
  SurfacePoint at;
  std::int32_t surface = -1, process = -1; ///< see SurfaceHit
  std::int64_t process_cell = -1;
};

/// Bytes of a point of light on its way, of a hit of a ray, and of a sample of a volume's shadow.
constexpr std::int64_t bytes_a_light_point = 80, bytes_a_light_hit = 40, bytes_a_shadow_sample = 16;

/// Rays of light in a frame of several processes. A point goes to the processes whose cells its
/// rays may meet, which make the same rays of it and tell what they meet in their own cells; the
/// process that asked puts that in order, mesh by mesh.
class SharedLight {
public:
  /// What rays meet of one of the frame's meshes.
  struct Layer {
    const FramePart* part;
    const FrameSettings* settings;
    const Surfaces* surfaces; ///< null: nothing
    const CellBoxes* where;
  };
  /// All must outlive it. layers: at least one.
  SharedLight(std::vector<Layer> layers, TileMail& mail, const core::Threads& threads);

  /// Points of a tile that this process owns, and what comes through their rays: point by point, in
  /// the order of Shader::send().
  struct Batch {
    std::uint32_t slot = 0;
    std::vector<LightPoint> points;
    std::vector<double> open;
  };
  /// Of a tile about so many rays at a time: a megabyte and a half.
  static constexpr std::size_t rays_at_once = std::size_t(1) << 15;
  /// Follows the rays that the shader sends, through surfaces, and through those volumes too that
  /// cast a shadow. What comes through the mesh of the layer `first` counts first, and surface and
  /// cell of points are of that mesh. Collective; at most a batch a tile.
  void ask(std::size_t first, const Shader& shader, bool with_volumes, std::span<Batch> batches);

  /// Hits of a tile that this process owns, which are to be lit.
  struct Seen {
    std::uint32_t slot = 0;
    std::vector<Surfaces::Seen> hits;
  };
  /// Lights those of a layer by the rays that its surfaces' shader sends. Collective; at most one a
  /// tile.
  void light(std::size_t layer, std::span<const Seen> tiles);

  // What rays meet of a layer, for those who send them with something else.

  struct Rays;
  using Met = std::vector<std::pair<std::uint32_t, SurfaceHit>>; ///< by ray
  /// Writes what rays meet in this process's cells: a bit for each that meets something, and of
  /// those how many hits, and these. starts: of the points of the rays, or empty.
  void write_met(std::size_t layer, const Rays& rays, std::span<const SecondaryStart> starts,
                 SurfaceCounts& counts, ByteWriter& to) const;
  /// Adds what a process has written of the rays of these points: rays that are not open, and hits.
  static void read_met(ByteReader& from, const Rays& rays, std::span<const std::uint32_t> points,
                       std::vector<double>& open, Met& met);
  /// What comes past the hits of all processes, and bodies.
  void pass(std::size_t layer, const Rays& rays, Met& met, std::vector<double>& open) const;

  /// What was done here, so far. Not collective.
  const SurfaceCounts& counts() const { return counts_; }

private:
  struct Asked;
  struct Question;
  void begin(std::size_t first, const Shader& shader, Question& question,
             std::vector<TileParcel>& parcels);
  void ask_shadows(const Shader& shader, std::span<Question> questions,
                   std::span<const TileParcel> points, std::vector<TileParcel> parcels);
  void open_shadows(const Question& question, std::vector<TileParcel>& parcels) const;
  void take_points(std::size_t layer, const Seen& seen, std::size_t next, Batch& batch);
  void follow(Question& question, std::span<const TileParcel> answers) const;
  void darken(Question& question, std::size_t layer, std::span<const double> asked,
              std::span<const TileParcel> answers) const;
  std::vector<std::byte> answer(const Shader& shader, const TileParcel& asked);
  std::vector<std::byte> answer_shadow(const Shader& shader, const TileParcel& asked,
                                       ByteReader open);
  void count(const SurfaceCounts& counts);
  /// Parcels are about a tile and a layer.
  std::uint32_t slot_of(std::uint32_t tile, std::size_t layer) const {
    return tile * std::uint32_t(layers_.size()) + std::uint32_t(layer);
  }
  std::size_t layer_of(std::uint32_t slot) const { return slot % layers_.size(); }
  /// visit(layer) for those with surfaces: `first`, then the others in order.
  template <class Visit>
  void for_each_layer(std::size_t first, Visit&& visit) const {
    if (layers_[first].surfaces)
      visit(first);
    for (std::size_t l = 0; l < layers_.size(); ++l)
      if (l != first && layers_[l].surfaces)
        visit(l);
  }

  const std::vector<Layer> layers_;
  parallel::World& world_;
  TileMail& mail_;
  const core::Threads& threads_;
  std::mutex mutex_;
  SurfaceCounts counts_; ///< under the mutex
};

} // namespace insitu::render
