#pragma once

#include <memory>

#include "accel/device_locator.h"

namespace insitu::accel::cuda {

/// The `bvh` method on a CUDA device.
std::unique_ptr<DeviceLocator> make_bvh_locator(core::Memory& memory);

} // namespace insitu::accel::cuda
