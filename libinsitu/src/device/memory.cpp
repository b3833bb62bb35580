#include "device/memory.h"

#include <string>

#include "core/status.h"
#include "device/check.h"

namespace insitu::device {

namespace {

[[noreturn]] void refuse_memory(const std::string& what) {
  std::size_t free = 0, total = 0;
  (void)cudaMemGetInfo(&free, &total);
  throw core::Error(INSITU_ERROR_MEMORY, "CUDA, " + what + ": out of memory; " +
                                             std::to_string(free) + " of the device's " +
                                             std::to_string(total) + " bytes are free");
}

} // namespace

void check(cudaError_t status, const char* what) {
  if (status == cudaSuccess)
    return;
  (void)cudaGetLastError(); // or the next check of a launch would find it again
  if (status == cudaErrorMemoryAllocation)
    refuse_memory(what);
  throw core::Error(INSITU_ERROR_UNSUPPORTED, std::string("CUDA, ") + what + ": " +
                                                  cudaGetErrorString(status) + " (" +
                                                  std::to_string(int(status)) + ")");
}

void* allocate(std::size_t bytes) {
  void* p = nullptr;
  const cudaError_t status = cudaMalloc(&p, bytes);
  if (status == cudaErrorMemoryAllocation) {
    (void)cudaGetLastError();
    refuse_memory(std::to_string(bytes) + " bytes asked for on the device");
  }
  check(status, "allocating memory on the device");
  return p;
}

void free(void* p) noexcept {
  (void)cudaFree(p);
}

void* allocate_pinned(std::size_t bytes) {
  void* p = nullptr;
  const cudaError_t status = cudaMallocHost(&p, bytes);
  if (status == cudaErrorMemoryAllocation) {
    (void)cudaGetLastError();
    refuse_memory(std::to_string(bytes) + " bytes asked for as pinned memory");
  }
  check(status, "allocating pinned memory");
  return p;
}

void free_pinned(void* p) noexcept {
  (void)cudaFreeHost(p);
}

void* allocate_on(StreamHandle stream, std::size_t bytes, const char* what) {
  void* p = nullptr;
  check(cudaMallocAsync(&p, bytes, stream), what);
  return p;
}

void free_on(StreamHandle stream, void* p) noexcept {
  (void)cudaFreeAsync(p, stream);
}

void copy_to_device(void* to, const void* from, std::size_t bytes, StreamHandle stream,
                    const char* what) {
  check(cudaMemcpyAsync(to, from, bytes, cudaMemcpyHostToDevice, stream), what);
}

void copy_to_host(void* to, const void* from, std::size_t bytes, StreamHandle stream,
                  const char* what) {
  check(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToHost, stream), what);
}

void fill(void* p, int byte, std::size_t bytes, StreamHandle stream, const char* what) {
  check(cudaMemsetAsync(p, byte, bytes, stream), what);
}

void wait(StreamHandle stream, const char* what) {
  check(cudaStreamSynchronize(stream), what);
}

void wait_for_all(const char* what) {
  check(cudaDeviceSynchronize(), what);
}

Stream::Stream() {
  check(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "making a stream");
}

Stream::~Stream() {
  (void)cudaStreamDestroy(stream_);
}

} // namespace insitu::device
