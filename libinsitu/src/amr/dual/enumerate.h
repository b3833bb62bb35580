#pragma once

#include <span>
#include <vector>

#include "amr/dual/corner_map.h"
#include "amr/dual/dual_cells.h"
#include "amr/dual/reentrant.h"
#include "amr/dual/virtual_leaves.h"
#include "mesh/gridlet.h"

namespace insitu::amr {

/// A corner around which depths differ by more than one: its cell may fold.
struct SteepCorner {
  SteepCorner(const Corner& corner, bool folds);
  std::int64_t index[3];
  std::int8_t depth;
  std::uint8_t octants = 0; ///< those whose leaf lies two depths above or more
  bool folded;
};

/// Which of a dual mesh's cells a stitching cell is, whoever makes it: the cells of a depth's
/// bricks come one brick after the other, those of a brick by corners, and those of a corner by
/// numbers.
struct CellPlace {
  std::int32_t corner[3];
  std::uint8_t depth;
  std::uint8_t
      at_end; ///< a bit an axis: the corner is the last one of the brick, not the next's first
  std::uint8_t number;  ///< of the cells at the corner
  std::uint8_t is_cube; ///< a gridlet's, where there are none; then corner is its lowest leaf
  bool operator==(const CellPlace&) const = default;

  std::int32_t brick(int axis) const { return (corner[axis] >> 3) - (at_end >> axis & 1); }
};

/// What some bricks of a map make of the dual mesh.
struct DualPart {
  std::vector<mesh::Gridlet> gridlets; ///< `first` counts from the part's own
  std::vector<std::uint64_t> full;     ///< 8 words a gridlet
  std::vector<std::uint32_t> leaves;   ///< vertices of gridlets
  std::vector<DualCell> cells;
  std::vector<CornerCell> at_corners; ///< most of them
  std::vector<CellPlace> places;      ///< of cells, if they are asked for
  std::vector<MeanVertex> means;      ///< vertices of cells
  std::vector<SteepCorner> steep;
  std::int64_t cubes = 0, empty = 0;
  std::int64_t folded = 0; ///< cells
};

/// Which leaves are real and which corners count.
struct Real {
  std::int64_t end = 0;  ///< leaves with ids from here on are virtual
  std::int64_t near = 0; ///< corners of leaves from here on alone do not count, others' do
  const VirtualLeaves* made = nullptr; ///< the virtual ones, if there are any
  bool with_places = false;            ///< of cells
  /// A bit for each leaf from `near` on: not all that lies around it is known. Null: there are
  /// none.
  const std::uint64_t* outermost = nullptr;

  Real(std::int64_t real) : end(real), near(real) {}

  bool counts(const Corner& corner) const {
    return near >= end || touches(corner, [&](std::int64_t leaf) { return leaf < near; });
  }
  /// Whether all leaves around a corner that does not count are known.
  bool knows(const Corner& corner) const {
    return touches(corner, [&](std::int64_t leaf) {
      return (outermost[(leaf - near) >> 6] >> ((leaf - near) & 63) & 1) == 0;
    });
  }

private:
  template <class F>
  bool touches(const Corner& corner, F&& f) const {
    for (int o = 0; o < 8; ++o)
      if (corner.inside >> o & 1) {
        const std::uint32_t id = corner.id[o];
        if (f(std::int64_t(id < end ? id : made->leaves[std::size_t(id - end)].real_id)))
          return true;
      }
    return false;
  }
};

/// The dual mesh of some bricks. Virtual leaves lie in stitching
/// cells only. Looks for folds where depths differ by more than one and where virtual leaves are.
/// only_unfolded: a part with folds gets no cells and no gridlets, just its steep corners.
void enumerate(const BrickStore& store, const mesh::Lattice& lattice,
               std::span<const std::uint32_t> bricks, const Real& real, bool only_unfolded,
               DualPart& part);

} // namespace insitu::amr
