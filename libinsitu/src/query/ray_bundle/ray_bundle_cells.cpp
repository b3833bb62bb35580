#include <algorithm>
#include <bit>

#include "query/ray_bundle/ray_bundle_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/ray_bundle/ray_bundle_cells.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "query/ray_bundle/ray_bundle_claims_simd.h"
#include "query/ray_bundle/ray_bundle_starts_simd.h"

HWY_BEFORE_NAMESPACE();
namespace insitu::query::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
/// The groups that cell i's extent meets: a bit each, and which samples of theirs.
HWY_INLINE std::uint64_t groups_met(const LinearMaps& maps, int i, const BundleSlab& slab,
                                    std::int32_t* first, std::int32_t* last) {
  const Floats d;
  const hn::Rebind<std::int32_t, Floats> di;
  std::uint64_t bits = 0;
  for (std::size_t g = 0; g < std::size_t(slab.groups); g += hn::MaxLanes(d)) {
    const GroupSamples samples = samples_of_groups(slab, g, maps.lower, maps.upper, i);
    hn::StoreU(hn::ConvertTo(di, samples.first), di, first + g);
    hn::StoreU(hn::ConvertTo(di, samples.last), di, last + g);
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(d, samples.any, bytes);
    bits |= (std::uint64_t(bytes[0]) | std::uint64_t(bytes[1]) << 8) << g;
  }
  return bits;
}

/// A block's cells and the samples that they may hold.
template <Shape shape, bool with_pieces>
class BlockClaims {
public:
  BlockClaims(Shape exact_shape, const cells::CellBlock& block, const std::int32_t* pieces,
              BundleSlab& slab, BundleLists& lists, const BundleClaims& to)
      : shape_(exact_shape), block_(block), pieces_(pieces), slab_(slab), lists_(lists), to_(to) {
    linear_maps(exact_shape, block, slab, maps_);
    if (shape == Shape::hexahedron)
      set_hexahedra(exact_shape, block, hexahedra_);
  }

  HWY_INLINE void claim_all() {
    lists_.found.count = parts_ = 0;
    for (int i = 0; i < block_.count; ++i)
      find_in_cell(i);
    claim_found();
  }

private:
  /// Touches what cell i may hold, and lists what is not claimed.
  HWY_INLINE void find_in_cell(int i) {
    std::int32_t from[bundle_groups], to[bundle_groups];
    std::uint64_t met = groups_met(maps_, i, slab_, from, to);
    if (!met)
      return;
    begin_part(i);
    const Floats d;
    FloatVec affine[12];
    for (int a = 0; a < 12; ++a)
      affine[a] = hn::Set(d, maps_.affine[a][i]);
    for (; met; met &= met - 1) {
      const int g = std::countr_zero(met);
      std::uint32_t wanted =
          slab_.wanted[g] & (~std::uint32_t(0) >> (31 - to[g])) & (~std::uint32_t(0) << from[g]);
      for (; wanted; wanted &= wanted - 1) {
        find_in_group(i, g, std::countr_zero(wanted), affine);
        if (lists_.found.count > CellSamples::size) {
          claim_found();
          begin_part(i);
        }
      }
    }
  }

  /// Sample k of the rays of group g.
  HWY_INLINE void find_in_group(int i, int g, int k, const FloatVec* affine) {
    const Floats d;
    const hn::Rebind<std::int32_t, Floats> di;
    constexpr int lanes = int(hn::MaxLanes(d));
    const bool is_odd = with_pieces && pieces_[i] < 0;
    const auto least = hn::Set(d, is_odd ? -unsound_slack : -maps_.slack[i]);
    const auto end_state = hn::Set(di, is_odd ? untouched : claimed);
    const auto steps = hn::Set(d, float(k));
    CellSamples& found = lists_.found;
    for (int s = g * bundle_lanes; s < (g + 1) * bundle_lanes; s += lanes) {
      const auto at = [&](int a) HWY_ATTR {
        return hn::MulAdd(steps, hn::Load(d, slab_.along[a] + s), hn::Load(d, slab_.base[a] + s));
      };
      const auto x = at(0), y = at(1), z = at(2);
      const auto linear = [&](int a) HWY_ATTR {
        const FloatVec* row = affine + 4 * a;
        return hn::MulAdd(row[0], x, hn::MulAdd(row[1], y, hn::MulAdd(row[2], z, row[3])));
      };
      const auto r = linear(0), u = linear(1), t = linear(2);
      std::int32_t* const state = slab_.state[k] + s;
      const auto before = hn::Load(di, state);
      const auto holds = hn::And(hn::RebindMask(di, hn::Ge(likelihood<shape>(r, u, t), least)),
                                 hn::Gt(before, hn::Set(di, unwanted)));
      if (hn::AllFalse(di, holds))
        continue;
      hn::Store(hn::IfThenElse(holds, hn::Max(before, hn::Set(di, touched)), before), di, state);
      if constexpr (with_pieces) {
        std::int32_t* const lowest = slab_.piece[k] + s;
        const auto was = hn::Load(di, lowest);
        hn::Store(hn::IfThenElse(holds, hn::Min(was, hn::Set(di, pieces_[i])), was), di, lowest);
      }
      const auto open = hn::And(holds, hn::Lt(before, end_state));
      if (hn::AllFalse(di, open))
        continue;
      const int n = found.count;
      const Packer packed(hn::RebindMask(d, open));
      if (shape == Shape::hexahedron) {
        packed.store(r, found.start[0] + n);
        packed.store(u, found.start[1] + n);
        packed.store(t, found.start[2] + n);
      }
      packed.store(hn::Iota(di, std::int32_t(k * bundle_rays + s)), found.place + n);
      found.count += int(hn::CountTrue(di, open));
    }
  }

  HWY_INLINE void begin_part(int i) {
    cell_[parts_] = i;
    begin_[parts_++] = lists_.found.count;
  }

  /// Claims what the cells are proven to hold of the listed samples, and empties the list.
  HWY_INLINE void claim_found() {
    begin_[parts_] = lists_.found.count;
    if constexpr (shape == Shape::hexahedron) {
      CellSamples& likely = lists_.likely;
      likely.count = 0;
      for (int p = 0; p < parts_; ++p) {
        const int begin = begin_[p];
        begin_[p] = likely.count;
        settle_starts(maps_, cell_[p], lists_.found, begin, begin_[p + 1], likely);
      }
      begin_[parts_] = likely.count;
      for (int p = 0; p < parts_; ++p)
        claim_in_hexahedron(shape_, block_, hexahedra_, cell_[p], likely, begin_[p], begin_[p + 1],
                            slab_, to_);
    } else {
      for (int p = 0; p < parts_; ++p)
        claim_in_any<shape>(block_, cell_[p], lists_.found, begin_[p], begin_[p + 1], slab_, to_);
    }
    lists_.found.count = parts_ = 0;
  }

  const Shape shape_;
  const cells::CellBlock& block_;
  const std::int32_t* const pieces_;
  BundleSlab& slab_;
  BundleLists& lists_;
  const BundleClaims& to_;
  LinearMaps maps_;
  HexahedronMaps hexahedra_; ///< of hexahedra
  // The list's parts, one a cell.
  int parts_ = 0;
  int cell_[cells::CellBlock::size + 1], begin_[cells::CellBlock::size + 2];
};

template <bool with_pieces>
HWY_INLINE void claim_any(Shape shape, const cells::CellBlock& block, const std::int32_t* pieces,
                          BundleSlab& slab, BundleLists& lists, const BundleClaims& to) {
  const auto claim = [&]<Shape s>() HWY_ATTR {
    BlockClaims<s, with_pieces>(shape, block, pieces, slab, lists, to).claim_all();
  };
  switch (shape) {
  case Shape::tetrahedron:
    return claim.template operator()<Shape::tetrahedron>();
  case Shape::wedge:
    return claim.template operator()<Shape::wedge>();
  case Shape::pyramid:
    return claim.template operator()<Shape::pyramid>();
  default:
    return claim.template operator()<Shape::hexahedron>();
  }
}

void claim_target(Shape shape, const cells::CellBlock& block, BundleSlab& slab, BundleLists& lists,
                  const BundleClaims& to) {
  claim_any<false>(shape, block, nullptr, slab, lists, to);
}
void claim_with_pieces_target(Shape shape, const cells::CellBlock& block,
                              const std::int32_t* pieces, BundleSlab& slab, BundleLists& lists,
                              const BundleClaims& to) {
  claim_any<true>(shape, block, pieces, slab, lists, to);
}

void set_states_target(const std::uint32_t* wanted, BundleSlab& slab) {
  const hn::CappedTag<std::int32_t, bundle_lanes> d;
  for (int s = 0; s < slab.groups * bundle_lanes; s += int(hn::MaxLanes(d))) {
    auto bits = hn::Load(d, reinterpret_cast<const std::int32_t*>(wanted) + s);
    for (int k = 0; k < slab.depth; ++k) {
      const auto is_wanted = hn::TestBit(bits, hn::Set(d, 1));
      hn::Store(hn::IfThenElse(is_wanted, hn::Set(d, untouched), hn::Set(d, unwanted)), d,
                slab.state[k] + s);
      bits = hn::ShiftRight<1>(bits);
    }
  }
}

void clear_claimed_target(const BundleSlab& slab, std::uint32_t* wanted) {
  const hn::CappedTag<std::int32_t, bundle_lanes> d;
  for (int s = 0; s < slab.groups * bundle_lanes; s += int(hn::MaxLanes(d))) {
    std::int32_t* const bits = reinterpret_cast<std::int32_t*>(wanted) + s;
    auto gone = hn::Zero(d);
    for (int k = slab.depth; k-- > 0;) {
      const auto is_claimed =
          hn::Eq(hn::Load(d, slab.state[k] + s), hn::Set(d, std::int32_t(claimed)));
      gone = hn::Or(hn::ShiftLeft<1>(gone), hn::IfThenElseZero(is_claimed, hn::Set(d, 1)));
    }
    hn::Store(hn::AndNot(gone, hn::Load(d, bits)), d, bits);
  }
}

int find_unclaimed_target(int group, const BundleSlab& slab, std::int32_t* places) {
  const hn::CappedTag<std::int32_t, bundle_lanes> d;
  int count = 0;
  for (std::uint32_t rest = slab.wanted[group]; rest; rest &= rest - 1) {
    const int k = std::countr_zero(rest);
    for (int s = group * bundle_lanes; s < (group + 1) * bundle_lanes; s += int(hn::MaxLanes(d))) {
      const auto state = hn::Load(d, slab.state[k] + s);
      const auto open =
          hn::And(hn::Gt(state, hn::Set(d, unwanted)), hn::Lt(state, hn::Set(d, claimed)));
      if (hn::AllFalse(d, open))
        continue;
      const Packer packed(hn::RebindMask(Floats(), open));
      packed.store(hn::Iota(d, std::int32_t(k * bundle_rays + s)), places + count);
      count += int(hn::CountTrue(d, open));
    }
  }
  return count;
}

} // namespace insitu::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace insitu::query {

HWY_EXPORT(claim_target);
HWY_EXPORT(claim_with_pieces_target);
HWY_EXPORT(set_states_target);
HWY_EXPORT(clear_claimed_target);
HWY_EXPORT(find_unclaimed_target);

void claim_cells(mesh::Shape shape, const cells::CellBlock& block, const std::int32_t* pieces,
                 BundleSlab& slab, BundleLists& lists, const BundleClaims& to) {
  if (pieces)
    HWY_DYNAMIC_DISPATCH(claim_with_pieces_target)(shape, block, pieces, slab, lists, to);
  else
    HWY_DYNAMIC_DISPATCH(claim_target)(shape, block, slab, lists, to);
}

void set_states(const std::uint32_t* wanted, BundleSlab& slab) {
  HWY_DYNAMIC_DISPATCH(set_states_target)(wanted, slab);
}

void clear_claimed(const BundleSlab& slab, std::uint32_t* wanted) {
  HWY_DYNAMIC_DISPATCH(clear_claimed_target)(slab, wanted);
}

int find_unclaimed(int group, const BundleSlab& slab, std::int32_t* places) {
  return HWY_DYNAMIC_DISPATCH(find_unclaimed_target)(group, slab, places);
}

} // namespace insitu::query
#endif
