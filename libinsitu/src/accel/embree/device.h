#pragma once

#include <atomic>
#include <cstdint>

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

  /// Bytes that it holds, and the most since reset_peak().
  std::int64_t bytes() const { return bytes_; }
  std::int64_t peak_bytes() const { return peak_; }
  void reset_peak() { peak_ = bytes_.load(); }

private:
  static bool count(void* device, ssize_t bytes, bool);

  core::Memory& memory_;
  std::atomic<std::int64_t> bytes_{0}, peak_{0};
  RTCDevice device_;
};

/// rtcIntersect1 as both releases have it. Rays in a direction each share little: packets of 4, 8
/// and 16 take 0.94 to 0.97 of the time a ray with AVX-512, in random order and in a sorted one,
/// rtcOccluded16 0.91 to 0.94 of rtcOccluded1's (tests/unit/bench/ray_packets_bench.cpp): too
/// little for a second way to trace.
inline void intersect(RTCScene scene, RTCRayHit& ray) {
#if RTC_VERSION_MAJOR >= 4
  rtcIntersect1(scene, &ray, nullptr);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, &ray);
#endif
}

} // namespace insitu::accel::embree
