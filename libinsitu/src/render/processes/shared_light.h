#pragma once

#include <cstdint>
#include <mutex>
#include <span>
#include <vector>

#include "query/directory.h"
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
/// process that asked puts that in order.
class SharedLight {
public:
  /// All must outlive it. where: each process's cells.
  SharedLight(const FramePart& part, const FrameSettings& settings, const Surfaces& surfaces,
              const query::Directory& where, double diagonal, TileMail& mail,
              const core::Threads& threads);

  /// Points of a tile that this process owns, and what comes through their rays: point by point, in
  /// the order of Shader::send().
  struct Batch {
    std::uint32_t slot = 0;
    std::vector<LightPoint> points;
    std::vector<double> open;
  };
  /// Follows the rays that the shader sends, through surfaces, and through the volume too if it
  /// casts a shadow. Collective; at most a batch a tile.
  void ask(const Shader& shader, const VolumeShadow* shadow, std::span<Batch> batches);

  /// What was done here, so far. Not collective.
  const SurfaceCounts& counts() const { return counts_; }

private:
  struct Rays;
  struct Asked;
  bool may_meet(int process, const Ray& ray, double t_max) const;
  void follow(Batch& batch, const Rays& rays, std::span<const TileParcel> answers,
              Asked& asked) const;
  void darken(Batch& batch, const Rays& rays, std::span<const TileParcel> answers,
              const Asked& asked) const;
  std::vector<std::byte> answer(const Shader& shader, const TileParcel& asked);
  std::vector<std::byte> answer_shadow(const Shader& shader, const VolumeShadow& shadow,
                                       const TileParcel& asked, ByteReader open);
  void count(const SurfaceCounts& counts);

  const FramePart& part_;
  const FrameSettings& settings_;
  const Surfaces& surfaces_;
  TileMail& mail_;
  const core::Threads& threads_;
  std::vector<std::vector<mesh::Box>> where_; ///< by process, widened against rounding
  std::vector<mesh::Box> all_;                ///< around these
  std::mutex mutex_;
  SurfaceCounts counts_; ///< under the mutex
};

} // namespace insitu::render
