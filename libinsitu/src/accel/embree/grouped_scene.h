#pragma once

#include <cstdint>
#include <vector>

#include "accel/embree/device.h"
#include "accel/rays/ray_rules.h"
#include "core/parallel.h"

namespace insitu::accel::embree {

/// Primitives in groups, each with a hierarchy of its own below one over the groups, so that a
/// build needs scratch for a group and not for all; made for refits.
class GroupedScene {
public:
  explicit GroupedScene(const Device& device) : device_(device) {}
  ~GroupedScene() { clear(); }
  GroupedScene(const GroupedScene&) = delete;
  GroupedScene& operator=(const GroupedScene&) = delete;

  /// make(begin, end): a geometry of those primitives, whose only reference the scene takes.
  using Make = core::FunctionRef<RTCGeometry(std::int64_t begin, std::int64_t end)>;
  /// Builds anew over n primitives, `group` of them a geometry at most. Throws core::Error.
  void build(std::int64_t n, std::int64_t group, const core::Threads& threads, Make make);

  /// changed(geometry): tells what changed of it. Throws core::Error.
  void refit(const core::Threads& threads, core::FunctionRef<void(RTCGeometry)> changed);
  void clear();

  RTCScene handle() const { return scene_; }
  std::int64_t groups() const { return std::int64_t(geometries_.size()); }
  /// The number of a hit's primitive.
  std::int64_t primitive(const RTCHit& hit) const {
    return std::int64_t(hit.geomID) * group_ + hit.primID;
  }

private:
  void commit(const core::Threads& threads, const char* what);

  const Device& device_;
  RTCScene scene_ = nullptr;
  std::int64_t group_ = 1;
  std::vector<RTCGeometry> geometries_; ///< the scene's
};

/// The closest hit; no geometry's for points that are not finite or beyond any mesh.
RTCHit trace(const GroupedScene& scene, const PointRay& ray);

} // namespace insitu::accel::embree
