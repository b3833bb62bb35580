#pragma once

#include <cstdint>

#include "mesh/lattice.h"
#include "query/sampler.h"

/// Points that follow each other within one box of an adaptive mesh's cells, a register full at a
/// time; compiled per SIMD target and dispatched at run time. What is found has the bits of
/// GridletFinder and LeafFinder, one by one.
namespace insitu::query {

/// A box of cells of one depth.
struct LatticeBox {
  double start[3], steps_a_unit[3]; ///< its lower corner; cells of its depth
  double rounding[3];               ///< of a place in it, in cells
  double size[3];                   ///< cells
};

struct GridletBox : LatticeBox {
  std::int64_t first_cell = 0;
  const std::uint64_t* full = nullptr; ///< see mesh::GridletsView, of this gridlet; null: all are
};
/// The first points, of n, up to one that is not proven to lie strictly inside of a cell; returns
/// how many. Up to 7 answers behind these are overwritten, but none behind n.
std::size_t cells_ahead(const GridletBox& box, const math::Vec3d* points, std::size_t n,
                        Location* at);

struct BrickBox : LatticeBox {
  mesh::Lattice lattice;
  int depth = 0;
  std::int64_t first_half[3] = {0, 0, 0}; ///< of its start; see mesh::Lattice::place
  const std::uint32_t* entries = nullptr; ///< null: no brick
};
/// The first points, of n, up to one that may lie in leaves that are not the brick's; otherwise the
/// same.
std::size_t leaves_ahead(const BrickBox& box, const math::Vec3d* points, std::size_t n,
                         Location* at, Reason* reasons);

/// Whether calling these is worth it: several points follow each other in the box, which so many
/// ahead tell.
inline bool stays_in(const LatticeBox& box, const math::Vec3d* points, std::size_t n) {
  constexpr std::size_t ahead = 4;
  if (n < 8)
    return false;
  bool in = true;
  for (int a = 0; a < 3; ++a) {
    const double steps = (points[ahead - 1][a] - box.start[a]) * box.steps_a_unit[a];
    in &= steps > 0.0 && steps < box.size[a];
  }
  return in;
}

} // namespace insitu::query
