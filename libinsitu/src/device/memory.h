#pragma once

#include <cstddef>

#include "device/stream.h"

/// Memory of a device, and pinned memory of the host. All functions but those that free throw
/// core::Error: INSITU_ERROR_MEMORY with the device's free and total bytes where memory runs out,
/// else INSITU_ERROR_UNSUPPORTED. what: the action that the message names.
namespace insitu::device {

void* allocate(std::size_t bytes);
void free(void* p) noexcept;
void* allocate_pinned(std::size_t bytes);
void free_pinned(void* p) noexcept;

/// Memory that is there for the work that is queued on the stream between the two calls.
void* allocate_on(StreamHandle stream, std::size_t bytes, const char* what);
void free_on(StreamHandle stream, void* p) noexcept;

/// These queue a copy on the stream. Pageable memory has been read when copy_to_device returns.
void copy_to_device(void* to, const void* from, std::size_t bytes, StreamHandle stream,
                    const char* what);
void copy_to_host(void* to, const void* from, std::size_t bytes, StreamHandle stream,
                  const char* what);
/// Queues the setting of all bytes to one value.
void fill(void* p, int byte, std::size_t bytes, StreamHandle stream, const char* what);

} // namespace insitu::device
