#include "core/memory.h"

#include <cstdlib>
#include <iterator>
#include <string>

#if defined(__linux__)
#include <sys/mman.h>
#endif

#include "core/status.h"

namespace insitu::core {

const char* purpose_name(insitu_purpose purpose) {
  static constexpr const char* names[] = {
      "tree",       "build",        "ranges",          "earlier_step",   "query", "tracers",
      "frames",     "converted",    "embree",          "device",         "amr",   "gathered_fields",
      "geocentric", "chart_copies", "face_neighbours", "blanked_fields", "halo",  "polyhedra",
      "flat",       "held_steps"};
  static_assert(std::size(names) == INSITU_MEMORY_COUNT);
  return purpose >= 0 && purpose < INSITU_MEMORY_COUNT ? names[purpose] : "unknown";
}

void Memory::add(insitu_purpose purpose, std::int64_t bytes) {
  by_purpose_[purpose].fetch_add(bytes, std::memory_order_relaxed);
  const std::int64_t now = total_.fetch_add(bytes, std::memory_order_relaxed) + bytes;
  std::int64_t peak = peak_.load(std::memory_order_relaxed);
  while (now > peak && !peak_.compare_exchange_weak(peak, now, std::memory_order_relaxed)) {
  }
}

void* allocate_bytes(std::size_t bytes) {
  constexpr std::size_t huge_page = std::size_t(2) << 20;
  const std::size_t alignment = bytes >= 2 * huge_page ? huge_page : 64;
  const std::size_t rounded = (bytes + alignment - 1) / alignment * alignment;
  void* p = rounded < bytes ? nullptr : std::aligned_alloc(alignment, rounded);
  if (!p)
    throw Error(INSITU_ERROR_MEMORY,
                "out of memory: " + std::to_string(bytes) + " bytes asked for");
#if defined(__linux__) && defined(MADV_HUGEPAGE)
  if (alignment == huge_page)
    (void)madvise(p, rounded, MADV_HUGEPAGE); // a wish; failure costs only time
#endif
  return p;
}

void free_bytes(void* p) noexcept {
  std::free(p);
}

} // namespace insitu::core
