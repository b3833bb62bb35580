#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "accel/faces/mesh_faces.h"
#include "accel/ray_locator.h"
#include "accel/tree/tree.h"
#include "core/log.h"
#include "query/batch/tree_locator.h"
#include "query/device/device_locator.h"
#include "query/locator_choice.h"

namespace insitu::query {

/// The structures of a mesh's locator beside the tree on the host: faces, a ray method, a device.
class Locators {
public:
  explicit Locators(core::Memory& memory) : memory_(&memory), faces_(memory) {}

  /// Takes effect at the next commit.
  void choose(const LocatorChoice& choice) {
    pending_ = pending_ || choice != choice_;
    choice_ = choice;
  }
  const LocatorChoice& choice() const { return choice_; }
  /// Whether the next commit has structures to make, whatever changed.
  bool pending() const { return pending_; }
  const LocatorPick& pick() const { return pick_; }

  /// Decides what the next commit makes; throws as pick_locator.
  void decide(bool on_device, const std::string& mesh_name, const core::Log& log);
  /// Finds faces anew, if rays ask for them or for knowing overlaps; before commit().
  void make_faces(HostView host, const core::Threads& threads);
  /// Brings the structures up to date. what: INSITU_CHANGED_*, and rebuild_due. Throws
  /// core::Error; then there are none.
  void commit(const mesh::Mesh& mesh, HostView host, std::uint32_t what,
              const core::Threads& threads);

  /// Null unless these answer.
  const accel::RayLocator* rays() const { return rays_.get(); }
  const DeviceLocator* device() const { return device_.get(); }
  /// How points find their cells by these structures; valid until the next commit.
  const PointLocator& point_locator() const {
    const PointLocator& by_tree = TreeLocator::plain();
    return chosen_ ? *chosen_ : by_tree;
  }
  /// Made for methods that use faces, and to find out whether cells overlap; empty else.
  const accel::MeshFaces& faces() const { return faces_; }

  /// How often structures beside the host's tree were made and refitted, since the mesh was made.
  struct Upkeep {
    std::int64_t builds = 0, refits = 0;
  };
  const Upkeep& upkeep() const { return upkeep_; }
  /// Counts of this mesh, since it was made.
  RayCounts& ray_counts() const { return ray_counts_; }
  void note(const DeviceCounts& counts) const;
  /// tree: of the host, which counts where it stands.
  insitu_locator_info info(const accel::Tree& tree) const;

private:
  core::Memory* memory_;
  LocatorChoice choice_;
  LocatorPick pick_;
  bool pending_ = true;
  std::string said_; ///< the last fallback that was logged
  accel::MeshFaces faces_;
  std::unique_ptr<accel::RayLocator> rays_;
  std::unique_ptr<DeviceLocator> device_;
  std::unique_ptr<PointLocator> chosen_; ///< by rays or a device; null: by the tree
  Upkeep upkeep_;
  mutable RayCounts ray_counts_;
  mutable std::atomic<std::int64_t> settled_on_host_{0};
};

} // namespace insitu::query
