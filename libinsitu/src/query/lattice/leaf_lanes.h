#pragma once

#include <cmath>
#include <cstdint>

#include "amr/leaves/leaf_map.h"
#include "query/location.h"

/// Points that follow each other in an adaptive mesh's leaves of one depth, a register full at a
/// time; compiled per SIMD target and dispatched at run time. What is found has the bits of
/// LeafFinder, one by one.
namespace insitu::query {

/// A brick of leaves, which have its depth or lie elsewhere.
struct BrickBox {
  explicit BrickBox(const amr::LeafMap& of) : leaves(&of), lattice(of.lattice()) {
    for (int a = 0; a < 3; ++a)
      per_unit[a] = 1.0 / lattice.spacing[a];
  }

  /// Takes the brick of a depth whose leaf holds p, as far as rounding tells; else as take().
  bool take_at(int at_depth, const math::Vec3d& p, std::uint32_t& found) {
    std::int64_t index[3];
    for (int a = 0; a < 3; ++a) {
      const double steps = (p[a] - lattice.origin[a]) * steps_of(a, at_depth);
      found = amr::BrickStore::nothing;
      if (!(std::fabs(steps) < double(2 * mesh::Lattice::largest_index)))
        return false;
      index[a] = std::int64_t(steps);
      index[a] -= steps < double(index[a]);
    }
    return take(at_depth, index, found);
  }

  /// Takes the brick of the leaf at an index of a depth. False, and nothing changes, where there is
  /// none; found: what is there instead, refined(_in_part) or nothing.
  bool take(int at_depth, const std::int64_t* index, std::uint32_t& found) {
    using Store = amr::BrickStore;
    const std::int64_t corner[3] = {first_half_of(index[0]), first_half_of(index[1]),
                                    first_half_of(index[2])};
    const bool same = entries && depth == at_depth && corner[0] == first_half[0] &&
                      corner[1] == first_half[1] && corner[2] == first_half[2];
    if (same && order)
      return true;
    found = Store::nothing;
    const Store& store = leaves->store();
    const std::uint32_t brick = store.find(at_depth, Store::key_of(index));
    if (brick == amr::BrickTable::none)
      return false;
    std::uint32_t first_id = 0;
    const amr::BrickNumbering::Order* const its = leaves->numbering().order_of(brick, first_id);
    if (!its) { // else all are leaves
      found = store.entries(brick)[Store::entry_of(index)];
      if (!Store::is_leaf(found))
        return false;
    }
    if (same)
      return true;
    order = its;
    first = first_id;
    entries = store.entries(brick);
    depth = at_depth;
    for (int a = 0; a < 3; ++a) {
      first_half[a] = corner[a];
      start[a] = lattice.place(a, depth, first_half[a]);
      steps_a_unit[a] = steps_of(a, depth);
      // Some units in the last place of the coordinates, in steps.
      rounding[a] = 0x1p-49 * (std::fabs(start[a]) * steps_a_unit[a] + 16.0);
    }
    return true;
  }

  /// Cells of a depth in a unit.
  double steps_of(int axis, int at_depth) const {
    return per_unit[axis] * double(std::int64_t(1) << lattice.halvings(axis, at_depth));
  }

  static std::int64_t first_half_of(std::int64_t index) {
    return 2 * (index & ~std::int64_t(amr::BrickStore::side - 1));
  }

  /// The entry of the brick's cell i, j, k.
  std::uint32_t entry(int i, int j, int k) const {
    return order ? order->id(first, i, j, k) : entries[i | j << 3 | k << 6];
  }

  const amr::LeafMap* leaves;
  mesh::Lattice lattice;
  double per_unit[3]; ///< cells of depth 0
  int depth = 0;
  double start[3], steps_a_unit[3];                  ///< its lower corner; leaves
  double rounding[3];                                ///< of a place in it, in leaves
  std::int64_t first_half[3] = {0, 0, 0};            ///< of its start; see mesh::Lattice::place
  const std::uint32_t* entries = nullptr;            ///< null: no brick
  const amr::BrickNumbering::Order* order = nullptr; ///< or null
  std::uint32_t first = 0;                           ///< with an order: its first id
};

/// The first points, of n, up to one that may lie in no leaf of the box's depth; returns how many.
/// box: about the last point before, and afterwards about the last one. others: of the same leaves,
/// for use, kept from call to call. Up to 7 answers behind these are overwritten, but none behind
/// n.
std::size_t leaves_ahead(BrickBox& box, BrickBox (&others)[2], const math::Vec3d* points,
                         std::size_t n, Location* at, Reason* reasons);

} // namespace insitu::query
