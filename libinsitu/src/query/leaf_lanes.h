#pragma once

#include <cstdint>

#include "mesh/lattice.h"
#include "query/sampler.h"

/// Points that follow each other within one brick of an adaptive mesh's leaves, a register full at
/// a time; compiled per SIMD target and dispatched at run time. What is found has the bits of
/// LeafFinder, one by one.
namespace insitu::query {

/// A brick of leaves, which have its depth or lie elsewhere.
struct BrickBox {
  mesh::Lattice lattice;
  int depth = 0;
  double start[3], steps_a_unit[3];       ///< its lower corner; leaves
  double rounding[3];                     ///< of a place in it, in leaves
  std::int64_t first_half[3] = {0, 0, 0}; ///< of its start; see mesh::Lattice::place
  const std::uint32_t* entries = nullptr; ///< null: no brick
};

/// The first points, of n, up to one that may lie in leaves that are not the brick's; returns how
/// many. Up to 7 answers behind these are overwritten, but none behind n.
std::size_t leaves_ahead(const BrickBox& box, const math::Vec3d* points, std::size_t n,
                         Location* at, Reason* reasons);

} // namespace insitu::query
