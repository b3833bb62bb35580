#include "accel/embree/device.h"

#include <string>

#include "core/simd_target.h"
#include "core/status.h"

namespace insitu::accel::embree {

namespace {

const char* error_name(RTCError error) {
  switch (error) {
  case RTC_ERROR_OUT_OF_MEMORY:
    return "out of memory";
  case RTC_ERROR_UNSUPPORTED_CPU:
    return "unsupported processor";
  case RTC_ERROR_INVALID_ARGUMENT:
    return "invalid argument";
  case RTC_ERROR_INVALID_OPERATION:
    return "invalid operation";
  case RTC_ERROR_CANCELLED:
    return "cancelled";
  default:
    return "unknown error";
  }
}

} // namespace

bool Device::count(void* device, ssize_t bytes, bool) {
  auto& d = *static_cast<Device*>(device);
  d.memory_.add(INSITU_MEMORY_EMBREE, std::int64_t(bytes));
  const std::int64_t now = d.bytes_.fetch_add(std::int64_t(bytes)) + std::int64_t(bytes);
  std::int64_t peak = d.peak_;
  while (now > peak && !d.peak_.compare_exchange_weak(peak, now)) {
  }
  return true;
}

Device::Device(core::Memory& memory) : memory_(memory), device_(rtcNewDevice(core::simd_target().embree)) {
  if (!device_)
    throw core::Error(INSITU_ERROR_INTERNAL,
                      std::string("Embree: no device: ") + error_name(rtcGetDeviceError(nullptr)));
  rtcSetDeviceMemoryMonitorFunction(device_, count, this);
}

Device::~Device() {
  rtcReleaseDevice(device_);
}

void Device::check(const char* what) const {
  const RTCError error = rtcGetDeviceError(device_);
  if (error != RTC_ERROR_NONE)
    throw core::Error(error == RTC_ERROR_OUT_OF_MEMORY ? INSITU_ERROR_MEMORY
                                                       : INSITU_ERROR_INTERNAL,
                      std::string("Embree, ") + what + ": " + error_name(error));
}

} // namespace insitu::accel::embree
