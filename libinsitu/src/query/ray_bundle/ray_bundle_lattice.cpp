#include <algorithm>
#include <bit>
#include <cmath>
#include <type_traits>
#include <utility>

#include "query/ray_bundle/ray_bundle_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/ray_bundle/ray_bundle_lattice.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "query/lattice/number_pairs_simd.h"
#include "query/ray_bundle/ray_bundle_linear_simd.h"

HWY_BEFORE_NAMESPACE();
namespace insitu::query::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Real = simd::PackTag;
using Long = hn::RebindToSigned<Real>;
using Int = hn::Rebind<std::int32_t, Real>; // as many lanes
using Reals = hn::Vec<Real>;
using RealMask = hn::Mask<Real>;
constexpr int real_lanes = int(hn::MaxLanes(Real()));

HWY_INLINE unsigned bits_of(RealMask m) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(Real(), m, bytes);
  return bytes[0];
}

/// A whole number from 0 on, far below 2^52.
HWY_INLINE hn::Vec<Long> whole(Reals a) {
  const Reals shift = hn::Set(Real(), 0x1p52);
  return hn::Xor(hn::BitCast(Long(), hn::Add(a, shift)), hn::BitCast(Long(), shift));
}

/// Where some samples lie along an axis: the cell's number and the place in it, if that is sure.
struct AlongAxis {
  Reals cell, part;
  RealMask sure, near; ///< near: in one or very near
};

HWY_INLINE AlongAxis in_even_cells(const LatticeCells& cells, int a, Reals p) {
  const Real d;
  const Reals least = hn::Set(d, cells.least[a]), most = hn::Set(d, cells.most[a]);
  const Reals begin = hn::Set(d, cells.begin[a]);
  // To the bit as GridletFinder::inside.
  const Reals place =
      hn::Mul(hn::Sub(p, hn::Set(d, cells.start[a])), hn::Set(d, cells.steps_a_unit[a]));
  const Reals cell = hn::Floor(place), part = hn::Sub(place, cell);
  AlongAxis at;
  at.cell = hn::Sub(cell, begin);
  at.part = part;
  at.near = hn::And(hn::Ge(place, hn::Sub(begin, least)),
                    hn::Le(place, hn::Add(most, hn::Add(least, least))));
  at.sure = hn::And(hn::And(hn::Gt(place, hn::Add(begin, least)), hn::Lt(place, most)),
                    hn::And(hn::Gt(part, least), hn::Lt(part, hn::Sub(hn::Set(d, 1.0), least))));
  return at;
}

/// A cell between two planes for each lane.
struct Cursor {
  Reals cell, low, high;
};

/// Moves the cursor from where it was to where p is, or to the nearest cell.
HWY_INLINE AlongAxis between_planes(const LatticeCells& cells, int a, Reals p, Cursor& at) {
  const Real d;
  const Reals one = hn::Set(d, 1.0), last = hn::Set(d, double(cells.plane_count[a] - 2));
  for (;;) {
    const RealMask down = hn::And(hn::Lt(p, at.low), hn::Gt(at.cell, hn::Zero(d)));
    const RealMask up = hn::And(hn::Gt(p, at.high), hn::Lt(at.cell, last));
    if (hn::AllFalse(d, hn::Or(down, up)))
      break;
    const Reals above = hn::Add(at.cell, one), below = hn::Sub(at.cell, one);
    const Reals next =
        hn::IfThenElse(up, hn::Add(above, one), hn::IfThenElse(down, below, at.cell));
    const Reals plane = hn::GatherIndex(d, cells.planes[a], whole(next));
    const Reals low = hn::IfThenElse(up, at.high, hn::IfThenElse(down, plane, at.low));
    at.high = hn::IfThenElse(up, plane, hn::IfThenElse(down, at.low, at.high));
    at.low = low;
    at.cell = hn::IfThenElse(up, above, hn::IfThenElse(down, below, at.cell));
  }
  return {at.cell, hn::Div(hn::Sub(p, at.low), hn::Sub(at.high, at.low)),
          hn::And(hn::Lt(at.low, p), hn::Lt(p, at.high)),
          hn::And(hn::Le(at.low, p), hn::Le(p, at.high))};
}

/// The samples of a bundle in some cells.
template <bool even, class T>
class LatticeClaims {
public:
  LatticeClaims(const LatticeCells& cells, const LatticeNumbers& numbers, BundleSlab& slab,
                const BundleClaims& to, AnswerPlaces answer)
      : cells_(cells), numbers_(numbers), slab_(slab), to_(to), answer_(answer) {
    if constexpr (!std::is_void_v<T>) {
      row_ = numbers.next[1] / std::int64_t(sizeof(T));
      layer_ = numbers.next[2] / std::int64_t(sizeof(T));
    }
  }

  HWY_INLINE int claim_all() {
    const Floats d;
    for (std::size_t g = 0; g < std::size_t(slab_.groups); g += hn::MaxLanes(d)) {
      const GroupSamples samples = samples_of_groups(slab_, g, cells_.lower, cells_.upper, 0);
      if (hn::AllFalse(d, samples.any))
        continue;
      float first[bundle_lanes], last[bundle_lanes];
      hn::StoreU(samples.first, d, first);
      hn::StoreU(samples.last, d, last);
      std::uint8_t bytes[8] = {};
      hn::StoreMaskBits(d, samples.any, bytes);
      for (unsigned met = bytes[0] | unsigned(bytes[1]) << 8; met; met &= met - 1) {
        const int i = std::countr_zero(met);
        const std::uint32_t wanted = slab_.wanted[g + std::size_t(i)] &
                                     (~std::uint32_t(0) >> (31 - int(last[i]))) &
                                     (~std::uint32_t(0) << int(first[i]));
        if (!wanted)
          continue;
        for (int s = 0; s < bundle_lanes; s += real_lanes)
          claim_along(int(g + std::size_t(i)) * bundle_lanes + s, wanted);
      }
    }
    return count_;
  }

private:
  /// The numbers k of samples that the rays of a register, from slot s on, may have in the box.
  HWY_INLINE std::uint32_t met(const Reals* origin, int s) const {
    const Real d;
    Reals from = hn::Set(d, -HUGE_VAL), to = hn::Set(d, HUGE_VAL);
    for (int a = 0; a < 3; ++a) {
      const Reals per_unit = hn::Load(d, to_.rays->inverse[a] + s);
      const Reals low = hn::Mul(hn::Sub(hn::Set(d, cells_.low[a]), origin[a]), per_unit);
      const Reals high = hn::Mul(hn::Sub(hn::Set(d, cells_.high[a]), origin[a]), per_unit);
      from = hn::Max(hn::Min(low, high), from);
      to = hn::Min(hn::Max(low, high), to);
    }
    const RealMask meets = hn::Le(from, to);
    if (hn::AllFalse(d, meets))
      return 0;
    const double per_step = 1.0 / to_.step;
    const auto index = [&](Reals t) HWY_ATTR {
      return hn::Sub(hn::Mul(t, hn::Set(d, per_step)), hn::Set(d, to_.first + 0.5));
    };
    const Reals none = hn::Set(d, HUGE_VAL);
    const double first = hn::GetLane(hn::MinOfLanes(d, hn::IfThenElse(meets, index(from), none)));
    const double last =
        hn::GetLane(hn::MaxOfLanes(d, hn::IfThenElse(meets, index(to), hn::Neg(none))));
    const double slack = 1e-3 + 0x1p-45 * to_.first;
    const double end = double(bundle_depth - 1);
    if (!(first - slack < end + 1.0) || !(last + slack > 0.0))
      return 0;
    const int begin = first - slack > 0.0 ? int(std::fmin(std::ceil(first - slack), end)) : 0;
    const int behind = last + slack < end ? int(last + slack) : bundle_depth - 1;
    return (~std::uint32_t(0) << begin) & (~std::uint32_t(0) >> (bundle_depth - 1 - behind));
  }

  /// The samples of rays from slot s on, a register full.
  HWY_INLINE void claim_along(int s, std::uint32_t wanted) {
    const Real d;
    const Int di;
    Reals origin[3], direction[3];
    for (int a = 0; a < 3; ++a) {
      direction[a] = hn::Load(d, to_.rays->direction[a] + s);
      origin[a] = to_.one_origin ? hn::Set(d, to_.rays->origin[a][0])
                                 : hn::Load(d, to_.rays->origin[a] + s);
    }
    wanted &= met(origin, s);
    Cursor cursor[3];
    bool begun = false;
    for (; wanted; wanted &= wanted - 1) {
      const int k = std::countr_zero(wanted);
      const auto state = hn::Load(di, slab_.state[k] + s);
      const auto open =
          hn::And(hn::Gt(state, hn::Set(di, unwanted)), hn::Lt(state, hn::Set(di, claimed)));
      std::uint8_t bytes[8] = {};
      hn::StoreMaskBits(di, open, bytes);
      if (bytes[0] == 0)
        continue;
      // To the bit where RayBundleLocator::point() puts them.
      const Reals along = hn::Set(d, ((to_.first + double(k)) + 0.5) * to_.step);
      AlongAxis at[3];
      for (int a = 0; a < 3; ++a) {
        const Reals p = hn::Add(origin[a], hn::Mul(along, direction[a]));
        if constexpr (even) {
          at[a] = in_even_cells(cells_, a, p);
        } else {
          if (!begun)
            cursor[a] = cursor_at(a, hn::GetLane(p));
          at[a] = between_planes(cells_, a, p, cursor[a]);
        }
      }
      begun = true;
      const unsigned near =
          bytes[0] & bits_of(hn::And(at[0].near, hn::And(at[1].near, at[2].near)));
      if (near)
        claim_at(k, s, state, near, at);
    }
  }

  /// The cell of a place along an axis, or the one nearest to it.
  HWY_INLINE Cursor cursor_at(int a, double p) const {
    const Real d;
    const double* const planes = cells_.planes[a];
    const std::int64_t n = cells_.plane_count[a];
    const std::int64_t above = std::upper_bound(planes, planes + n, p) - planes;
    const std::int64_t cell = std::clamp<std::int64_t>(above - 1, 0, n - 2);
    return {hn::Set(d, double(cell)), hn::Set(d, planes[cell]), hn::Set(d, planes[cell + 1])};
  }

  /// What of samples k, those of the bits, is sure to be in a cell that is there.
  HWY_INLINE void claim_at(int k, int s, hn::Vec<Int> state, unsigned near, const AlongAxis* at) {
    const Real d;
    const Long dl;
    const RealMask sure = hn::And(at[0].sure, hn::And(at[1].sure, at[2].sure));
    const unsigned in_cells = near & bits_of(sure);
    Reals index[3]; // of the others 0
    for (int a = 0; a < 3; ++a)
      index[a] = hn::IfThenElseZero(sure, at[a].cell);
    const auto sum_of = [&](const std::int64_t* steps) HWY_ATTR {
      const auto times = [&](int a)
                             HWY_ATTR { return hn::Mul(index[a], hn::Set(d, double(steps[a]))); };
      return hn::Add(hn::Add(times(0), times(1)), times(2));
    };
    alignas(64) std::int64_t cell[real_lanes];
    hn::Store(hn::Add(whole(sum_of(cells_.next)), hn::Set(dl, cells_.first_cell)), dl, cell);
    const unsigned there = in_cells & existing(cell, in_cells);
    set_states_of(k, s, state, near & ~in_cells, there);
    if (!there)
      return;
    count_ += std::popcount(there);
    const PackVec r{simd::Pack(at[0].part), simd::Pack(at[1].part), simd::Pack(at[2].part)};
    if constexpr (std::is_void_v<T>) {
      give(k, s, cell, there, r);
    } else {
      alignas(64) ValueSample value[real_lanes];
      static_assert(sizeof(ValueSample) == 2 * sizeof(double));
      hn::StoreInterleaved2(hn::BitCast(d, hn::Load(dl, cell)),
                            value_of(sum_of(numbers_.next), r).v, d,
                            reinterpret_cast<double*>(value));
      if (to_.locations)
        store_locations(k, s, cell, there, r);
      for (unsigned bits = there; bits; bits &= bits - 1) {
        const int lane = std::countr_zero(bits);
        to_.samples[to_.answer[s + lane] + k] = value[lane];
      }
    }
  }

  /// Of the lanes of the bits, those whose cells exist.
  HWY_INLINE unsigned existing(const std::int64_t* cell, unsigned bits) const {
    if (!cells_.full && !cells_.blanked)
      return bits;
    unsigned there = 0;
    for (unsigned rest = bits; rest; rest &= rest - 1) {
      const int lane = std::countr_zero(rest);
      const std::int64_t local = cell[lane] - cells_.first_of_piece;
      const bool is_there = cells_.full ? (cells_.full[local >> 6] >> (local & 63) & 1) != 0
                                        : cells_.blanked->exists(local);
      there |= unsigned(is_there) << lane;
    }
    return there;
  }

  HWY_INLINE void set_states_of(int k, int s, hn::Vec<Int> state, unsigned near, unsigned there) {
    const Int di;
    const std::uint8_t near_bytes[8] = {std::uint8_t(near)}, there_bytes[8] = {std::uint8_t(there)};
    const auto is_near = hn::LoadMaskBits(di, near_bytes),
               is_there = hn::LoadMaskBits(di, there_bytes);
    const auto next = hn::IfThenElse(is_near, hn::Set(di, touched), state);
    hn::Store(hn::IfThenElse(is_there, hn::Set(di, claimed), next), di, slab_.state[k] + s);
  }

  /// The weighted mean of eight numbers each, `offset` bytes from those of the first cell.
  HWY_INLINE simd::Pack value_of(Reals offset, const PackVec& r) const
      requires(!std::is_void_v<T>) {
    alignas(64) std::int64_t from[real_lanes];
    hn::Store(whole(offset), Long(), from);
    simd::Pack number[8], weight[8];
    const T* at[real_lanes];
    for (int lane = 0; lane < real_lanes; ++lane)
      at[lane] = reinterpret_cast<const T*>(numbers_.first + from[lane]);
    load_pairs(Real(), at, 0, number[0].v, number[1].v);
    load_pairs(Real(), at, row_, number[2].v, number[3].v);
    load_pairs(Real(), at, layer_, number[4].v, number[5].v);
    load_pairs(Real(), at, row_ + layer_, number[6].v, number[7].v);
    if (cells_.shape == Shape::hexahedron) { // turns where voxels count on
      std::swap(number[2], number[3]);
      std::swap(number[6], number[7]);
    }
    simd::shape_functions(cells_.shape, r, weight);
    return simd::weighted_mean(8, weight, number);
  }

  HWY_INLINE void store_locations(int k, int s, const std::int64_t* cell, unsigned there,
                                  const PackVec& r) {
    alignas(64) double part[3][real_lanes];
    hn::Store(r.x.v, Real(), part[0]);
    hn::Store(r.y.v, Real(), part[1]);
    hn::Store(r.z.v, Real(), part[2]);
    for (unsigned bits = there; bits; bits &= bits - 1) {
      const int lane = std::countr_zero(bits);
      to_.locations[to_.answer[s + lane] + k] = {cell[lane],
                                                 {part[0][lane], part[1][lane], part[2][lane]}};
    }
  }

  HWY_INLINE void give(int k, int s, const std::int64_t* cell, unsigned there, const PackVec& r) {
    alignas(64) double part[3][real_lanes];
    hn::Store(r.x.v, Real(), part[0]);
    hn::Store(r.y.v, Real(), part[1]);
    hn::Store(r.z.v, Real(), part[2]);
    std::uint16_t place[real_lanes];
    Location at[real_lanes];
    std::size_t n = 0;
    for (unsigned bits = there; bits; bits &= bits - 1) {
      const int lane = std::countr_zero(bits);
      place[n] = std::uint16_t(k * bundle_rays + s + lane);
      at[n++] = {cell[lane], {part[0][lane], part[1][lane], part[2][lane]}};
    }
    answer_({place, n}, {at, n});
  }

  const LatticeCells& cells_;
  const LatticeNumbers& numbers_;
  BundleSlab& slab_;
  const BundleClaims& to_;
  AnswerPlaces answer_;
  std::int64_t row_ = 0, layer_ = 0; ///< in numbers
  int count_ = 0;
};

template <bool even>
HWY_INLINE int claim_lattice_of(const LatticeCells& cells, const LatticeNumbers& numbers,
                                BundleSlab& slab, const BundleClaims& to, AnswerPlaces answer) {
  if (!numbers.first)
    return LatticeClaims<even, void>(cells, numbers, slab, to, answer).claim_all();
  if (numbers.is_float32)
    return LatticeClaims<even, float>(cells, numbers, slab, to, answer).claim_all();
  return LatticeClaims<even, double>(cells, numbers, slab, to, answer).claim_all();
}

int claim_lattice_target(const LatticeCells& cells, const LatticeNumbers& numbers, BundleSlab& slab,
                         const BundleClaims& to, AnswerPlaces answer) {
  return cells.planes[0] ? claim_lattice_of<false>(cells, numbers, slab, to, answer)
                         : claim_lattice_of<true>(cells, numbers, slab, to, answer);
}

} // namespace insitu::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace insitu::query {

HWY_EXPORT(claim_lattice_target);

int claim_lattice(const LatticeCells& cells, const LatticeNumbers& numbers, BundleSlab& slab,
                  const BundleClaims& to, AnswerPlaces answer) {
  return HWY_DYNAMIC_DISPATCH(claim_lattice_target)(cells, numbers, slab, to, answer);
}

} // namespace insitu::query
#endif
