#include "api/array_watch.h"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>

#include "core/status.h"

namespace insitu::api {

namespace {

constexpr std::int64_t chunk_items = 4096;

/// Mixes as SplitMix64 does (S. Vigna, https://prng.di.unimi.it/splitmix64.c).
std::uint64_t mix(std::uint64_t hash, std::uint64_t value) {
  hash = (hash ^ value) + 0x9e3779b97f4a7c15u;
  hash = (hash ^ (hash >> 30)) * 0xbf58476d1ce4e5b9u;
  hash = (hash ^ (hash >> 27)) * 0x94d049bb133111ebu;
  return hash ^ (hash >> 31);
}

/// Of the items' bytes, wherever they lie: not of what is between them.
std::uint64_t hash_of(const mesh::ExternalArray& a, std::size_t chunk) {
  const auto size = std::size_t(mesh::size_of(a.type));
  const std::int64_t begin = std::int64_t(chunk) * chunk_items;
  const std::int64_t end = std::min(begin + chunk_items, a.layout.count);
  std::uint64_t hash = 0;
  for (std::int64_t i = begin; i < end; ++i)
    for (int c = 0; c < a.components; ++c) {
      std::uint64_t value = 0;
      std::memcpy(&value, a.at(i, c), size);
      hash = mix(hash, value);
    }
  return hash;
}

} // namespace

bool is_checked() {
  if (const char* text = std::getenv("INSITU_CHECKED"); text && *text)
    return std::strcmp(text, "0") != 0;
#ifdef INSITU_CHECKED
  return true;
#else
  return false;
#endif
}

void ArrayWatch::remember(const mesh::Mesh& mesh, const core::Threads& threads) {
  arrays_.clear();
  mesh_ = mesh.name();
  adaptive_.remember(mesh, threads);
  if (mesh.is_adaptive())
    return;
  mesh.visit_arrays(
      [&](const mesh::ExternalArray& array, const std::string& name, mesh::Mesh::ArrayKind kind) {
        if (kind != mesh::Mesh::ArrayKind::field)
          arrays_.push_back({name, array, kind, {}});
      });
  for (Array& a : arrays_) {
    a.chunks.resize(std::size_t((a.array.layout.count + chunk_items - 1) / chunk_items));
    threads.parallel_for(std::int64_t(a.chunks.size()), 1, [&](std::int64_t begin, std::int64_t) {
      a.chunks[std::size_t(begin)] = hash_of(a.array, std::size_t(begin));
    });
  }
}

void ArrayWatch::refuse(const Array& a, std::size_t chunk) const {
  const std::int64_t first = std::int64_t(chunk) * chunk_items;
  const std::int64_t last = std::min(first + chunk_items, a.array.layout.count) - 1;
  throw core::Error(INSITU_ERROR_ORDER,
                    "mesh '" + mesh_ + "', " + a.name + ": items " + std::to_string(first) +
                        " to " + std::to_string(last) +
                        " are not what was committed; say what changed by insitu_mesh_changed, "
                        "then call insitu_mesh_commit");
}

void ArrayWatch::expect_unchanged(std::uint32_t said, const core::Threads& threads) const {
  if (!(said & INSITU_CHANGED_TOPOLOGY))
    adaptive_.expect_unchanged(threads);
  for (const Array& a : arrays_) {
    if (said & (a.kind == mesh::Mesh::ArrayKind::geometry
                    ? INSITU_CHANGED_GEOMETRY | INSITU_CHANGED_TOPOLOGY
                    : INSITU_CHANGED_TOPOLOGY))
      continue;
    const std::size_t none = a.chunks.size();
    std::atomic<std::size_t> first{none}; // the lowest, whatever the threads
    threads.parallel_for(std::int64_t(none), 1, [&](std::int64_t begin, std::int64_t) {
      const auto chunk = std::size_t(begin);
      std::size_t now = first.load();
      if (chunk < now && hash_of(a.array, chunk) != a.chunks[chunk])
        while (chunk < now && !first.compare_exchange_weak(now, chunk)) {
        }
    });
    if (first != none)
      refuse(a, first);
  }
}

void ArrayWatch::expect_unchanged_chunk() {
  adaptive_.expect_unchanged_chunk();
  for (Array& a : arrays_) {
    if (a.chunks.empty())
      continue;
    a.next = a.next + 1 < a.chunks.size() ? a.next + 1 : 0;
    if (hash_of(a.array, a.next) != a.chunks[a.next])
      refuse(a, a.next);
  }
}

} // namespace insitu::api
