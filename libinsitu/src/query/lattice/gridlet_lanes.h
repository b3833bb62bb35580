#pragma once

#include <cstdint>

#include "mesh/gridlet.h"
#include "query/location.h"

/// Points in gridlets and values there, a register full at a time; compiled per SIMD target and
/// dispatched at run time. What comes out has the bits of GridletFinder and GridletValues, one by
/// one.
namespace insitu::query {

/// A gridlet, for points strictly inside of its cells; lengths in cells.
struct GridletBox {
  double start[3], steps_a_unit[3]; ///< its lower corner; cells
  double least[3], most[3];         ///< of a place's distance from it, and least from its faces
  std::int64_t first_cell = -1;     ///< -1: no gridlet
  const std::uint64_t* full = nullptr;
  bool all_full = false; ///< all its cells are
};

/// The first points, of n, that lie strictly in a full cell, up to one that may not; returns how
/// many. Up to 3 locations behind these are overwritten, but none behind n.
std::size_t cells_ahead(const GridletBox& box, const math::Vec3d* points, std::size_t n,
                        Location* at);

/// The values of a field at the first locations, of n, up to one that lies in no gridlet; returns
/// how many. end: of the gridlets' cells. values: one a vertex, one after the other.
std::size_t values_ahead(const mesh::Gridlet* gridlets, std::int64_t end, const double* values,
                         const Location* at, std::size_t n, double* to);
std::size_t values_ahead(const mesh::Gridlet* gridlets, std::int64_t end, const float* values,
                         const Location* at, std::size_t n, double* to);

} // namespace insitu::query
