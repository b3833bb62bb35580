#include <algorithm>
#include <bit>
#include <cmath>

#include "query/ray_bundle/ray_bundle_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/ray_bundle/ray_bundle_tree.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "query/ray_bundle/ray_bundle_groups_simd.h"

HWY_BEFORE_NAMESPACE();
namespace insitu::query::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Nodes and cells' boxes against the slab

using Floats8 = hn::CappedTag<float, 8>;

/// The slab in the tree's local frame: coordinate a of its own is axis[a] times the place, less
/// at[a], up to `rounding`.
struct SlabBox {
  float axis[3][3], at[3], rounding;
};

/// Rounded so that no box that meets a sample is lost.
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
    b.at[a] = float(dot(slab.axes[a], at));
  }
  b.rounding = float(slab.rounding + 0x1p-19 * (largest + slab.reach));
  return b;
}

/// Extents of a node's children along the slab's axes.
struct ChildExtents {
  alignas(32) float lower[3][8], upper[3][8];
};

/// Bit c: child c's box meets the slab.
HWY_INLINE unsigned children_met(const accel::Node& node, const BundleSlab& slab,
                                 const SlabBox& box, ChildExtents& out) {
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
      auto off = hn::Set(d, -box.at[a]), reach = hn::Set(d, box.rounding);
      for (int b = 0; b < 3; ++b) {
        const auto n = hn::Set(d, box.axis[a][b]);
        off = hn::MulAdd(n, centre[b], off);
        reach = hn::MulAdd(hn::Abs(n), half[b], reach);
      }
      const auto lower = hn::Sub(off, reach), upper = hn::Add(off, reach);
      met = hn::And(met, hn::And(hn::Le(lower, hn::Set(d, slab.upper[a])),
                                 hn::Ge(upper, hn::Set(d, slab.lower[a]))));
      hn::StoreU(lower, d, out.lower[a] + c);
      hn::StoreU(upper, d, out.upper[a] + c);
    }
    std::uint8_t byte[8] = {};
    hn::StoreMaskBits(d, met, byte);
    bits |= unsigned(byte[0]) << c;
  }
  return bits;
}

/// Whether there may be samples in child c's box.
HWY_INLINE bool holds_samples(const ChildExtents& extents, int c, const BundleSlab& slab) {
  const Floats d;
  for (std::size_t g = 0; g < std::size_t(slab.groups); g += hn::MaxLanes(d))
    if (!hn::AllFalse(d, samples_of_groups(slab, g, extents.lower, extents.upper, c).any))
      return true;
  return false;
}

bool find_cells_target(const accel::Tree& tree, const BundleSlab& slab, std::size_t most,
                       std::vector<std::uint32_t>& slots, std::size_t& count) {
  const SlabBox box = slab_box(tree, slab);
  if (slots.size() < most + 64)
    slots.resize(most + 64);
  count = 0;
  std::uint32_t stack[64 * 8];
  int size = 0;
  ChildExtents extents;
  stack[size++] = 0;
  while (size > 0) {
    const accel::Node& node = tree.nodes()[stack[--size]];
    for (unsigned met = children_met(node, slab, box, extents); met; met &= met - 1) {
      const int c = std::countr_zero(met);
      if (!node.meta[c])
        continue;
      if (node.is_inner(c)) {
        stack[size++] = node.child_node(c);
        __builtin_prefetch(&tree.nodes()[stack[size - 1]]);
        continue;
      }
      if (!holds_samples(extents, c, slab))
        continue;
      for (int k = 0; k < node.child_cell_count(c); ++k)
        slots[count++] = node.child_cells(c) + std::uint32_t(k);
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

bool find_cells(const accel::Tree& tree, const BundleSlab& slab, std::size_t most,
                std::vector<std::uint32_t>& slots, std::size_t& count) {
  return HWY_DYNAMIC_DISPATCH(find_cells_target)(tree, slab, most, slots, count);
}

} // namespace insitu::query
#endif
