#pragma once

#include "core/memory.h"

// The one place that knows which Embree is installed; both offer what is used here under the same
// names.
#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace insitu::accel::embree {

/// An Embree device whose memory is counted; one a tree. Throws core::Error.
class Device {
public:
  explicit Device(core::Memory& memory);
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  RTCDevice handle() const { return device_; }
  /// Throws the device's pending error, if any; `what` says what was being done.
  void check(const char* what) const;

private:
  RTCDevice device_;
};

} // namespace insitu::accel::embree
