// The memory and the streams of a device that is the host: work is done when it is queued.
#include "device/memory.h"

#include <cstdlib>
#include <cstring>
#include <new>

namespace insitu::device {

void* allocate(std::size_t bytes) {
  // 256 bytes are CUDA's alignment; a size of 0 has an address too.
  void* p = std::aligned_alloc(256, (bytes / 256 + 1) * 256);
  if (!p)
    throw std::bad_alloc();
  return p;
}
void free(void* p) noexcept {
  std::free(p);
}
void* allocate_pinned(std::size_t bytes) {
  return allocate(bytes);
}
void free_pinned(void* p) noexcept {
  device::free(p);
}
void* allocate_on(StreamHandle, std::size_t bytes, const char*) {
  return allocate(bytes);
}
void free_on(StreamHandle, void* p) noexcept {
  device::free(p);
}

void copy_to_device(void* to, const void* from, std::size_t bytes, StreamHandle, const char*) {
  if (bytes > 0)
    std::memcpy(to, from, bytes);
}
void copy_to_host(void* to, const void* from, std::size_t bytes, StreamHandle, const char*) {
  if (bytes > 0)
    std::memcpy(to, from, bytes);
}
void fill(void* p, int byte, std::size_t bytes, StreamHandle, const char*) {
  if (bytes > 0)
    std::memset(p, byte, bytes);
}

void wait(StreamHandle, const char*) {}
void wait_for_all(const char*) {}

Stream::Stream() = default;
Stream::~Stream() = default;

} // namespace insitu::device
