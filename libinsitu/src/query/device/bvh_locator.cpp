#include "query/device/bvh_locator.h"

#include "accel/cuda/device_tree.h"
#include "core/status.h"
#include "core/timer.h"
#include "device/device_mesh.h"
#include "query/device/caller_ids.h"
#include "query/device/locate.h"

namespace insitu::query {

namespace {

class BvhLocator final : public DeviceLocator {
public:
  explicit BvhLocator(core::Memory& memory) : mesh_(memory), tree_(memory), workspace_(memory) {}

  void commit(const mesh::Mesh& mesh, HostView, std::uint32_t what, const accel::MeshFaces*,
              const core::Threads& threads) override {
    threads_ = &threads;
    // Queries and tracers that were queued still read what changes; the solver may still write it.
    device::wait_for_all("waiting for the device");
    const bool rebuild = (what & (INSITU_CHANGED_TOPOLOGY | rebuild_due)) != 0;
    built_ = built_ && !rebuild && !(what & INSITU_CHANGED_GEOMETRY);
    mesh_.commit(mesh, what, stream_.get());
    report_.tree_seconds = 0.0;
    if (!built_) {
      const core::Timer timer;
      if (rebuild)
        tree_.build(mesh_, stream_.get());
      else
        tree_.refit(mesh_, stream_.get());
      report_.tree_seconds = timer.seconds();
      if (rebuild) {
        report_.peak_bytes = bytes();
        report_.tree_peak_bytes = tree_.bytes() + tree_.scratch_bytes();
      }
      built_ = true;
    }
    // Scratch is worth keeping only while rebuilds come often.
    constexpr int patience = 4;
    commits_since_build_ = rebuild ? 0 : commits_since_build_ + 1;
    if (commits_since_build_ == patience)
      tree_.release_scratch();
  }

  DeviceCounts locate(const DeviceQuery& query) const override {
    require_built();
    on_device::CallerIds ids(mesh_, query);
    const DeviceCounts counts =
        on_device::locate_points(mesh_, &tree_, workspace_, *threads_, ids.flat(), nullptr);
    ids.finish();
    return counts;
  }

  void use_structures(core::FunctionRef<void(const DeviceStructures&)> use) const override {
    require_built();
    use({mesh_, tree_});
  }

  DeviceReport report() const override {
    DeviceReport report = report_;
    report.bytes = bytes();
    report.bytes_copied = mesh_.bytes_copied();
    report.primitives = tree_.cell_count();
    report.tree_bytes = tree_.bytes();
    return report;
  }

private:
  void require_built() const {
    if (!built_)
      throw core::Error(INSITU_ERROR_ORDER, "the mesh is not committed on the device");
  }
  std::int64_t bytes() const {
    return mesh_.bytes() + tree_.bytes() + tree_.scratch_bytes() + workspace_.device_bytes();
  }

  device::Stream stream_;
  device::DeviceMesh mesh_;
  accel::cuda::DeviceTree tree_;
  mutable on_device::Workspace workspace_;
  const core::Threads* threads_ = nullptr; ///< of the last commit: the session's
  bool built_ = false;
  int commits_since_build_ = 0;
  DeviceReport report_;
};

} // namespace

std::unique_ptr<DeviceLocator> make_bvh_locator(core::Memory& memory) {
  return std::make_unique<BvhLocator>(memory);
}

} // namespace insitu::query
