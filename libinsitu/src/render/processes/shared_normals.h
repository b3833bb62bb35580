#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/processes/cell_boxes.h"
#include "render/processes/frame_part.h"
#include "render/processes/tile_mail.h"
#include "render/surface/surfaces.h"

namespace insitu::render {

/// Bytes of a place about a hit on its way.
constexpr std::int64_t bytes_a_place_about = 32;

/// Normals that are central differences, in a frame of several processes: the places about a hit
/// may be in other processes' cells. The process that found the hit asks those whose boxes hold a
/// place, and the value in the lowest cell counts.
class SharedNormals {
public:
  /// All must outlive it.
  SharedNormals(const FramePart& part, const query::Sampler& sampler, const Surfaces& surfaces,
                const CellBoxes& where, TileMail& mail, const core::Threads& threads)
      : part_(part), sampler_(sampler), surfaces_(surfaces), where_(where), mail_(mail),
        threads_(threads) {}

  /// Sets gradients and clearances of the hits of Surfaces::find_own() that have none yet. Rays are
  /// in groups, `rays` of each. Collective; throws AgreedError.
  void find(std::size_t groups, core::FunctionRef<std::span<RayState>(std::size_t)> rays) const;

private:
  struct Group;
  Group places_about(std::span<RayState> rays) const;
  PlaceValue own_value(std::int32_t surface, const math::Vec3d& place, std::int64_t hint) const;
  std::vector<std::byte> answer(ByteReader asked) const;
  static void take(const TileParcel& answer, Group& to);
  void set_gradients(std::span<RayState> rays, const Group& found) const;

  const FramePart& part_;
  const query::Sampler sampler_;
  const Surfaces& surfaces_;
  const CellBoxes& where_;
  TileMail& mail_;
  const core::Threads& threads_;
};

} // namespace insitu::render
