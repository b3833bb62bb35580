#pragma once

#include <functional>

#include "query/batch/tree_locator.h"
#include "query/device/device_locator.h"

namespace insitu::query {

/// Whole calls at the current step are answered on a device; single points, batches within a
/// thread and times between two steps by the tree.
class DeviceCalls final : public TreeLocator {
public:
  /// note: told what each slice of a call counted.
  using Note = std::function<void(const DeviceCounts& counts)>;
  DeviceCalls(const DeviceLocator& device, Note note) : device_(device), note_(std::move(note)) {}
  bool visit(const core::Threads& threads, std::span<const math::Vec3d> points,
             const LocateOptions& options, LocateCounts* counts, PutAnswers put) const override;

private:
  const DeviceLocator& device_;
  Note note_;
};

} // namespace insitu::query
