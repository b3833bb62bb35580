#pragma once

#include <cstdint>
#include <vector>

#include "query/ray_bundle/ray_bundle.h"

/// What RayBundleLocator's parts share.
namespace insitu::query {

/// Of one thread, kept for its life: some hundred kilobytes, and the vertices of a stretch's cells.
struct RayBundleScratch {
  BundleSlab slab;
  BundleSamples samples;
  // By slot: a group's rays are neighbours.
  math::Vec3d origin[bundle_rays], direction[bundle_rays];
  std::uint32_t wanted[bundle_rays];
  std::uint16_t ray[bundle_rays], slot[bundle_rays];
  // The stretch's cells, shape by shape.
  std::vector<std::uint32_t> found; ///< their places in the tree
  std::vector<std::int64_t> cells;
  std::vector<std::int32_t> ranks; ///< their pieces, -1 of odd cells; if RayBundleLocator::ranked_
  std::vector<cells::CellBlock> blocks;
  std::vector<ValueBlock> values;
  struct Run {
    mesh::Shape shape;
    int begin, end;
  };
  std::vector<Run> runs;
  // Samples in the order of their cells, and those that are left.
  std::vector<std::uint32_t> count;
  std::vector<std::uint16_t> open, sorted, rest;
  std::vector<math::Vec3d> points;
  std::vector<Location> answers;
  std::int64_t by_reason[reason_count];
};

// A sample by its number along the ray, k, and its ray's slot.
constexpr int place_of(int k, int slot) {
  return k * bundle_rays + slot;
}
constexpr int slot_of(int place) {
  return place % bundle_rays;
}
constexpr int index_of(int place) {
  return place / bundle_rays;
}
constexpr int cell_of_key(std::int32_t key) {
  return key & 0xffff;
}

inline math::Vec3d RayBundleLocator::point(int place) const {
  const int slot = slot_of(place);
  return s_.origin[slot] + ((double(first_ + index_of(place)) + 0.5) * step_) * s_.direction[slot];
}

} // namespace insitu::query
