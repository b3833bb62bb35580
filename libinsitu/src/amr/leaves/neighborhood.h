#pragma once

#include <cstdint>

#include "amr/leaves/brick_store.h"

namespace insitu::amr {

/// A lattice corner and what lies around it: in octant o, on the high side of axis a if bit a is
/// set, a cell of the corner's depth, covered by a leaf of this depth or a coarser one, or outside.
struct Corner {
  int depth;
  std::int64_t index[3]; ///< between cells index - 1 and index
  std::uint32_t id[8];   ///< the octant's leaf
  std::uint8_t up[8];    ///< how many depths above it lies
  std::uint8_t inside;   ///< a bit an octant
  int most_up;

  /// The octant's cell of the corner's depth, along an axis.
  std::int64_t cell(int octant, int axis) const { return index[axis] - 1 + (octant >> axis & 1); }
};

/// Fills a corner of a depth; false if no leaf of this depth touches it, or a finer one does.
bool corner_at(const BrickStore& store, int depth, const std::int64_t* index, Corner& corner);

/// A brick with the layer of entries around it, and which corners in it have leaves of its depth.
/// Coordinates in it count entries from 0 to 9; the brick's own are 1 to 8. Corner c lies between
/// entries c and c + 1.
class Neighborhood {
public:
  /// Leaves of ids below `real` may lie in gridlets; cubes have one of an id below `near`, if that
  /// is less. False if the brick holds no leaf.
  bool load(const BrickStore& store, std::int64_t brick, std::int64_t real, std::int64_t near);

  int depth() const { return depth_; }
  /// The index of entry (0, 0, 0).
  std::int64_t lower(int axis) const { return lower_[axis]; }
  std::uint32_t entry(int i, int j, int k) const { return entries_[i + side * (j + side * k)]; }

  /// A row of corners 0 to 8 along i: those with eight real leaves of the depth, a bit each.
  unsigned cubes(int j, int k) const;
  /// Those with a leaf of the depth and nothing that is refined all over, but no cubes.
  unsigned mixed(int j, int k) const;
  /// Whether this brick is the one to handle a mixed corner, the one that has its first leaf, and
  /// no finer leaf touches it; then fills `corner`.
  bool take(const BrickStore& store, int i, int j, int k, Corner& corner);

private:
  static constexpr int side = 10;
  static constexpr std::uint8_t unknown = 0xff;
  /// From a corner's lowest entry to that of an octant.
  static constexpr int offset(int octant) {
    return (octant & 1) + side * (octant >> 1 & 1) + side * side * (octant >> 2);
  }

  unsigned row_all(const std::uint16_t* rows, int j, int k) const {
    const unsigned m = rows[j + side * k] & rows[j + 1 + side * k] & rows[j + side * (k + 1)] &
                       rows[j + 1 + side * (k + 1)];
    return m & m >> 1 & 0x1ff;
  }
  unsigned row_any(const std::uint16_t* rows, int j, int k) const {
    const unsigned m = rows[j + side * k] | rows[j + 1 + side * k] | rows[j + side * (k + 1)] |
                       rows[j + 1 + side * (k + 1)];
    return (m | m >> 1) & 0x1ff;
  }

  /// Notes what covers an entry for all children of its parent: a coarser leaf covers all.
  void spread(int i, int j, int k);

  int depth_ = 0;
  std::int64_t lower_[3] = {0, 0, 0};
  std::uint32_t entries_[side * side * side];
  std::uint8_t up_[side * side * side]; ///< unknown: not yet looked for
  /// A bit an entry.
  std::uint16_t leaf_[side * side], real_[side * side], near_[side * side], refined_[side * side];
};

} // namespace insitu::amr
