#pragma once

#include <cstdint>

#include "amr/dual/corner_map.h"
#include "query/lattice/gridlet_places.h"

namespace insitu::query {

/// Where the cells of an adaptive mesh's dual lie: its gridlets, then its stitching cells by the
/// corners of leaves.
struct DualPlaces {
  const GridletPlaces* gridlets;
  const amr::CornerMap* corners;
  /// A bit a gridlet, and then a bit a stitching cell: whether it may answer; null: all may.
  const std::uint64_t* shown = nullptr;
};

} // namespace insitu::query
