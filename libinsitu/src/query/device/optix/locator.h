#pragma once

#include <memory>

#include "query/device/device_locator.h"

namespace insitu::query {

/// A ray method on the device's ray tracing units. group: primitives a bottom structure holds at
/// most; more than a mesh has: one level. Throws INSITU_ERROR_UNSUPPORTED with why_no_optix().
std::unique_ptr<DeviceLocator> make_optix_locator(accel::Method method, core::Memory& memory,
                                                  std::int64_t group = std::int64_t(1) << 20);

/// Empty if OptiX can be used here, else why not.
std::string why_no_optix();

} // namespace insitu::query
