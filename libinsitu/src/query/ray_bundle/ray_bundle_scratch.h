#pragma once

#include <cstdint>
#include <vector>

#include "query/ray_bundle/ray_bundle.h"

/// What RayBundleLocator's parts share.
namespace insitu::query {

constexpr int first_shape = int(mesh::Shape::tetrahedron), shape_count = 5;

/// A stretch's cells of one shape.
struct ShapeCells {
  std::vector<std::int64_t> cells;
  std::vector<std::int32_t> ranks; ///< their pieces, -1 of odd cells; if RayBundleLocator::ranked_

  void clear() {
    cells.clear();
    ranks.clear();
  }
};

/// Of one thread, kept for its life: some hundred kilobytes.
struct RayBundleScratch {
  BundleSlab slab;
  BundleLists lists;
  // By slot: a group's rays are neighbours.
  BundleRays rays;
  math::Vec3d mean_origin, mean_direction;
  double far; ///< no origin's coordinate is larger
  alignas(64) std::uint32_t wanted[bundle_rays];
  std::uint16_t slot[bundle_rays];
  std::int32_t answer[bundle_rays]; ///< by slot, where the ray's answers begin
  std::vector<std::uint32_t> found; ///< of the stretch's cells, their places in the tree
  std::vector<double> planes[3];    ///< of a rectilinear block, those about the stretch
  // Of some cells of one shape.
  cells::CellBlock block;
  ValueBlock values;
  ShapeCells by_shape[shape_count];
  // Samples that are left.
  std::int32_t unclaimed[(bundle_depth + 1) * bundle_lanes]; ///< of a group
  std::vector<std::uint16_t> rest;
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

inline math::Vec3d RayBundleLocator::point(int place) const {
  const int slot = slot_of(place);
  return s_.rays.origin_of(slot) +
         ((double(first_ + index_of(place)) + 0.5) * step_) * s_.rays.direction_of(slot);
}

} // namespace insitu::query
