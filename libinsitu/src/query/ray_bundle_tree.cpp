#include <algorithm>
#include <bit>
#include <cmath>

#include "query/ray_bundle_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/ray_bundle_tree.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace insitu::query::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Nodes and cells' boxes against the slab

using Floats8 = hn::CappedTag<float, 8>;

/// The slab in the tree's local frame: its axes, and the place and half extent along each.
struct SlabBox {
  float axis[3][3], middle[3], half[3];
};

/// Rounded so that no box that meets the slab is lost.
SlabBox slab_box(const accel::Tree& tree, const BundleSlab& slab) {
  SlabBox b;
  const math::Vec3d at = slab.middle - tree.origin();
  const math::Vec3d low = tree.bounds_min() - tree.origin(),
                    high = tree.bounds_max() - tree.origin();
  double largest = 0;
  for (int a = 0; a < 3; ++a)
    largest = std::max({largest, std::fabs(low[a]), std::fabs(high[a]), std::fabs(at[a])});
  for (int a = 0; a < 3; ++a) {
    for (int c = 0; c < 3; ++c)
      b.axis[a][c] = float(slab.axes[a][c]);
    b.middle[a] = float(dot(slab.axes[a], at) + 0.5 * (double(slab.lower[a]) + slab.upper[a]));
    b.half[a] = float(0.5 * (double(slab.upper[a]) - slab.lower[a]) + slab.rounding +
                      0x1p-19 * (largest + slab.reach));
  }
  return b;
}

/// Bit c: child c's box meets the slab.
HWY_INLINE unsigned children_met(const accel::Node& node, const SlabBox& slab) {
  const Floats8 d;
  const hn::Rebind<std::int32_t, Floats8> di;
  const hn::Rebind<std::uint8_t, Floats8> db;
  unsigned bits = 0;
  for (std::size_t c = 0; c < 8; c += hn::MaxLanes(d)) {
    hn::Vec<Floats8> centre[3], half[3];
    for (int a = 0; a < 3; ++a) {
      const auto base = hn::Set(d, node.lower[a]), scale = hn::Set(d, 0.5f * node.scale(a));
      const auto lo = hn::PromoteTo(di, hn::LoadU(db, node.child_lower[a] + c));
      const auto hi = hn::PromoteTo(di, hn::LoadU(db, node.child_upper[a] + c));
      centre[a] = hn::MulAdd(scale, hn::ConvertTo(d, hn::Add(lo, hi)), base);
      half[a] = hn::Mul(scale, hn::ConvertTo(d, hn::Sub(hi, lo)));
    }
    auto met = hn::Eq(centre[0], centre[0]);
    for (int a = 0; a < 3; ++a) {
      auto off = hn::Set(d, -slab.middle[a]), reach = hn::Set(d, slab.half[a]);
      for (int b = 0; b < 3; ++b) {
        const auto n = hn::Set(d, slab.axis[a][b]);
        off = hn::MulAdd(n, centre[b], off);
        reach = hn::MulAdd(hn::Abs(n), half[b], reach);
      }
      met = hn::And(met, hn::Le(hn::Abs(off), reach));
    }
    std::uint8_t byte[8] = {};
    hn::StoreMaskBits(d, met, byte);
    bits |= unsigned(byte[0]) << c;
  }
  return bits;
}

bool find_cells_target(const accel::Tree& tree, const BundleSlab& slab, std::uint32_t least,
                       std::size_t most, std::vector<std::uint32_t>& slots, std::size_t& count) {
  const SlabBox box = slab_box(tree, slab);
  if (slots.size() < most + 64)
    slots.resize(most + 64);
  count = 0;
  std::uint32_t stack[64 * 8];
  int size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const accel::Node& node = tree.nodes()[stack[--size]];
    for (unsigned met = children_met(node, box); met; met &= met - 1) {
      const int c = std::countr_zero(met);
      if (!node.meta[c])
        continue;
      if (node.is_inner(c)) {
        stack[size++] = node.child_node(c);
        __builtin_prefetch(&tree.nodes()[stack[size - 1]]);
        continue;
      }
      for (int k = 0; k < node.child_cell_count(c); ++k) {
        slots[count] = node.child_cells(c) + std::uint32_t(k);
        count += tree.cells()[slots[count]] >= least;
      }
    }
    if (count > most)
      return false;
  }
  return true;
}

} // namespace insitu::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace insitu::query {

HWY_EXPORT(find_cells_target);

bool find_cells(const accel::Tree& tree, const BundleSlab& slab, std::uint32_t least,
                std::size_t most, std::vector<std::uint32_t>& slots, std::size_t& count) {
  return HWY_DYNAMIC_DISPATCH(find_cells_target)(tree, slab, least, most, slots, count);
}

} // namespace insitu::query
#endif
