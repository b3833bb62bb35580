#pragma once

#include <vector>

#include "accel/embree/grouped_scene.h"
#include "accel/ray_locator.h"
#include "accel/tree/node.h"

namespace insitu::accel::embree {

/// user_geometry: cells are Embree's user primitives, with a vanishing ray. The mesh must outlive
/// this.
class CellRays final : public RayLocator {
public:
  CellRays(core::Memory& memory, std::int64_t group);

  void build(const mesh::MeshView& mesh, const MeshFaces* faces,
             const core::Threads& threads) override;
  void refit(const mesh::MeshView& mesh, const core::Threads& threads) override;
  void find(std::span<const math::Vec3d> points, std::span<std::int64_t> cells,
            std::span<std::int64_t> beyond) const override;
  RayLocatorReport report() const override;

private:
  /// What the callbacks know of their geometry.
  struct Group {
    const CellRays* rays;
    std::size_t first;
  };
  void set_boxes(const mesh::MeshView& mesh, const core::Threads& threads);
  static void bound(const RTCBoundsFunctionArguments* args);
  static void intersect(const RTCIntersectFunctionNArguments* args);

  std::int64_t group_;
  const mesh::MeshView* mesh_ = nullptr;
  math::Vec3d origin_;
  core::Buffer<std::uint32_t> cells_; ///< flat ids of the primitives
  core::Buffer<Box> boxes_;           ///< of the primitives, while Embree builds
  std::int64_t peak_boxes_ = 0;
  std::vector<Group> groups_;
  Device device_;
  GroupedScene scene_{device_};
};

} // namespace insitu::accel::embree
