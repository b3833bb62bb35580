#pragma once

#include <cmath>
#include <cstdint>

#include "amr/leaf_map.h"
#include "query/sampler.h"

namespace insitu::query {

/// Finds the leaves of an adaptive mesh that own points (`nearest` reconstruction). Remembers the
/// last brick of leaves, since neighbours mostly lie in one.
class LeafFinder {
public:
  explicit LeafFinder(const amr::LeafMap& leaves) : leaves_(&leaves), lattice_(leaves.lattice()) {
    for (int a = 0; a < 3; ++a)
      per_unit_[a] = 1.0 / lattice_.spacing[a];
  }

  static constexpr bool finds_all = true;

  /// The lowest closed leaf that holds p; none outside, and for points that are not finite.
  Location operator()(const math::Vec3d& p, Reason& reason) {
    reason = Reason::certified;
    if (const Location at = inside(p))
      return at;
    const amr::LeafMap::Leaf leaf = leaves_->lowest(p);
    if (!leaf) {
      reason = Reason::outside;
      return {};
    }
    take(leaf.cell);
    if (const Location at = inside(p))
      return at;
    Location found{std::int64_t(leaf.id), {}};
    int faces = 0;
    for (int a = 0; a < 3; ++a) {
      const double low = lattice_.place(a, leaf.cell.depth, 2 * leaf.cell.index[a]);
      const double high = lattice_.place(a, leaf.cell.depth, 2 * leaf.cell.index[a] + 2);
      found.parametric[a] = (p[a] - low) / (high - low);
      faces += p[a] == low || p[a] == high;
    }
    constexpr Reason why[] = {Reason::certified, Reason::on_face, Reason::on_edge,
                              Reason::on_vertex};
    reason = why[faces];
    return found;
  }

private:
  using Store = amr::BrickStore;

  void take(const mesh::AmrCell& cell) {
    const std::uint32_t brick = leaves_->store().find(cell.depth, Store::key_of(cell.index));
    entries_ = leaves_->store().entries(brick);
    const double scale = double(std::int64_t(1) << cell.depth);
    for (int a = 0; a < 3; ++a) {
      start_[a] = lattice_.place(a, cell.depth, 2 * (cell.index[a] & ~std::int64_t(7)));
      steps_a_unit_[a] = per_unit_[a] * scale;
      // Some units in the last place of the coordinates, in steps.
      rounding_[a] = 0x1p-49 * (std::fabs(start_[a]) * steps_a_unit_[a] + 16.0);
    }
  }

  Location inside(const math::Vec3d& p) const {
    if (!entries_)
      return {};
    Location found;
    int entry = 0;
    bool sure = true;
    for (int a = 0; a < 3; ++a) {
      const double steps = (p[a] - start_[a]) * steps_a_unit_[a];
      if (!(steps > 0.0 && steps < Store::side))
        return {};
      const int i = int(steps);
      const double part = steps - i;
      sure &= part > rounding_[a] && part < 1.0 - rounding_[a];
      entry |= i << (3 * a);
      found.parametric[a] = part;
    }
    if (!sure || !Store::is_leaf(entries_[entry]))
      return {};
    found.cell = entries_[entry];
    return found;
  }

  const amr::LeafMap* leaves_;
  mesh::Lattice lattice_;
  double per_unit_[3]; ///< cells of depth 0
  // Of the last brick:
  const std::uint32_t* entries_ = nullptr;
  double start_[3], steps_a_unit_[3], rounding_[3];
};

} // namespace insitu::query
