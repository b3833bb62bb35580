#pragma once

#include <vector>

#include "device/device_mesh.h"
#include "query/device/device_locator.h"

namespace insitu::query::on_device {

/// A query as locators answer it, in flat ids, and what the caller sees of it: ids within pieces,
/// from the caller's base, pieces, found or not.
class CallerIds {
public:
  CallerIds(const device::DeviceMesh& mesh, const DeviceQuery& asked);
  ~CallerIds();
  CallerIds(const CallerIds&) = delete;
  CallerIds& operator=(const CallerIds&) = delete;

  const DeviceQuery& flat() const { return flat_; }
  /// Once that is answered, or queued.
  void finish();

private:
  const device::DeviceMesh& mesh_;
  const DeviceQuery& asked_;
  DeviceQuery flat_;
  bool changes_ = false;
  std::int64_t* on_device_ = nullptr; ///< flat ids that the caller does not ask for
  std::vector<std::int64_t> on_host_;
};

} // namespace insitu::query::on_device
