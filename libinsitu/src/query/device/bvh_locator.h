#pragma once

#include <memory>

#include "query/device/device_locator.h"

namespace insitu::query {

/// The `bvh` method on a CUDA device.
std::unique_ptr<DeviceLocator> make_bvh_locator(core::Memory& memory);

} // namespace insitu::query
