#include "query/lattice/gridlet_lanes.h"

#include "query/lattice/gridlet_strides.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/lattice/gridlet_lanes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "query/lattice/number_pairs_simd.h"

HWY_BEFORE_NAMESPACE();
namespace insitu::query::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
// A register holds one number: nothing to gain.
std::size_t cells_ahead_target(const GridletBox&, const math::Vec3d*, std::size_t, Location*) {
  return 0;
}
template <class T>
std::size_t values_ahead_of(const mesh::Gridlet*, std::int64_t, const T*, const Location*,
                            std::size_t, double*) {
  return 0;
}
#else

constexpr int lanes = HWY_MAX_BYTES >= 32 ? 4 : 2;
using RealTag = hn::FixedTag<double, lanes>;
using LongTag = hn::RebindToSigned<RealTag>;
using IntTag = hn::Rebind<std::int32_t, RealTag>;
using Reals = hn::Vec<RealTag>;
using RealMask = hn::Mask<RealTag>;

static_assert(sizeof(Location) == 4 * sizeof(double));

HWY_INLINE unsigned bits_of(RealMask m) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(RealTag(), m, bytes);
  return bytes[0];
}
HWY_INLINE RealMask between(Reals low, Reals a, Reals high) {
  return hn::And(hn::Gt(a, low), hn::Lt(a, high));
}

std::size_t cells_ahead_target(const GridletBox& box, const math::Vec3d* points, std::size_t n,
                               Location* at) {
  const RealTag d;
  const LongTag dl;
  const IntTag di;
  const Reals side = hn::Set(d, mesh::Gridlet::side), one = hn::Set(d, 1.0);
  const auto first = hn::Set(dl, box.first_cell);
  std::size_t done = 0;
  for (; done + lanes <= n; done += lanes) { // as GridletFinder::inside
    Reals p[3], part[3];
    hn::LoadInterleaved3(d, &points[done].x, p[0], p[1], p[2]);
    Reals index = hn::Zero(d);
    RealMask sure = hn::Eq(index, index);
    for (int a = 2; a >= 0; --a) {
      const Reals least = hn::Set(d, box.least[a]);
      const Reals place =
          hn::Mul(hn::Sub(p[a], hn::Set(d, box.start[a])), hn::Set(d, box.steps_a_unit[a]));
      const Reals low = hn::Trunc(place);
      part[a] = hn::Sub(place, low);
      sure = hn::And(sure, hn::And(between(least, place, hn::Set(d, box.most[a])),
                                   between(least, part[a], hn::Sub(one, least))));
      index = hn::Add(hn::Mul(index, side), low);
    }
    unsigned found = bits_of(sure);
    if ((found & 1) == 0)
      break;
    const auto cell = hn::PromoteTo(dl, hn::DemoteTo(di, hn::IfThenElseZero(sure, index)));
    if (!box.all_full) {
      alignas(32) std::int64_t local[lanes];
      hn::Store(cell, dl, local);
      unsigned full = 0;
      for (int k = 0; k < lanes; ++k)
        full |= unsigned((box.full[local[k] >> 6] >> (local[k] & 63)) & 1) << k;
      found &= full;
    }
    hn::StoreInterleaved4(hn::BitCast(d, hn::Or(cell, first)), part[0], part[1], part[2], d,
                          reinterpret_cast<double*>(at + done));
    if (found != (1u << lanes) - 1)
      return done + std::size_t(hwy::Num0BitsBelowLS1Bit_Nonzero32(~found));
  }
  return done;
}

/// As GridletValues, from the pairs of numbers along i: pairs(j, k, first, second).
template <class Pairs>
HWY_INLINE Reals value_of(Pairs&& pairs, Reals i1, Reals j1, Reals k1) {
  const RealTag d;
  const Reals one = hn::Set(d, 1.0);
  const Reals i0 = hn::Sub(one, i1), j0 = hn::Sub(one, j1), k0 = hn::Sub(one, k1);
  const auto along_i = [&](bool j, bool k) HWY_ATTR {
    Reals first, second;
    pairs(j, k, first, second);
    return hn::Add(hn::Mul(i0, first), hn::Mul(i1, second));
  };
  const auto along_j = [&](bool k) HWY_ATTR {
    const Reals f = along_i(false, k);
    return hn::Add(hn::Mul(j0, f), hn::Mul(j1, along_i(true, k)));
  };
  const Reals f = along_j(false);
  return hn::Add(hn::Mul(k0, f), hn::Mul(k1, along_j(true)));
}

template <class T>
std::size_t values_ahead_of(const mesh::Gridlet* gridlets, std::int64_t end, const T* values,
                            const Location* at, std::size_t n, double* to) {
  constexpr int bits = mesh::Gridlet::cell_bits, bits_an_axis = bits / 3;
  const RealTag d;
  const LongTag dl;
  const hn::Repartition<std::int32_t, LongTag> di;
  const auto low_bits = hn::Set(dl, mesh::Gridlet::side - 1);
  GridletStrides strides(gridlets, 1);
  std::size_t done = 0;
  for (; done + lanes <= n; done += lanes) {
    Reals cell_bits, i1, j1, k1;
    hn::LoadInterleaved4(d, reinterpret_cast<const double*>(at + done), cell_bits, i1, j1, k1);
    const auto cell = hn::BitCast(dl, cell_bits);
    const std::int64_t gridlet = at[done].cell >> bits;
    const T* low[lanes];
    Reals value;
    if (hn::AllTrue(dl, hn::Eq(hn::ShiftRight<bits>(cell), hn::Set(dl, gridlet)))) {
      if (std::uint64_t(at[done].cell) >= std::uint64_t(end))
        break;
      const T* const numbers = values + strides.lower(gridlet << bits);
      const std::int64_t row = strides.row(), layer = strides.layer();
      const auto times = [&](hn::Vec<LongTag> few, std::int64_t length) HWY_ATTR {
        return hn::MulEven(hn::BitCast(di, few), hn::Set(di, std::int32_t(length)));
      };
      const auto i = hn::And(cell, low_bits);
      const auto j = hn::And(hn::ShiftRight<bits_an_axis>(cell), low_bits);
      const auto k = hn::And(hn::ShiftRight<2 * bits_an_axis>(cell), low_bits);
      alignas(32) std::int64_t vertex[lanes];
      hn::Store(hn::Add(i, hn::Add(times(j, row), times(k, layer))), dl, vertex);
      for (int lane = 0; lane < lanes; ++lane)
        low[lane] = numbers + vertex[lane];
      value = value_of(
          [&](bool up_j, bool up_k, Reals& first, Reals& second) HWY_ATTR {
            load_pairs(d, low, (up_j ? row : 0) + (up_k ? layer : 0), first, second);
          },
          i1, j1, k1);
    } else {
      const T *row[lanes], *layer[lanes], *last[lanes];
      bool in_gridlets = true;
      for (int lane = 0; lane < lanes; ++lane)
        in_gridlets &= std::uint64_t(at[done + std::size_t(lane)].cell) < std::uint64_t(end);
      if (!in_gridlets)
        break;
      for (int lane = 0; lane < lanes; ++lane) {
        low[lane] = values + strides.lower(at[done + std::size_t(lane)].cell);
        row[lane] = low[lane] + strides.row();
        layer[lane] = low[lane] + strides.layer();
        last[lane] = layer[lane] + strides.row();
      }
      value = value_of(
          [&](bool up_j, bool up_k, Reals& first, Reals& second) HWY_ATTR {
            load_pairs(d, up_k ? up_j ? last : layer : up_j ? row : low, 0, first, second);
          },
          i1, j1, k1);
    }
    hn::StoreU(value, d, to + done);
  }
  return done;
}

#endif

std::size_t values_of_doubles(const mesh::Gridlet* gridlets, std::int64_t end, const double* values,
                              const Location* at, std::size_t n, double* to) {
  return values_ahead_of(gridlets, end, values, at, n, to);
}
std::size_t values_of_floats(const mesh::Gridlet* gridlets, std::int64_t end, const float* values,
                             const Location* at, std::size_t n, double* to) {
  return values_ahead_of(gridlets, end, values, at, n, to);
}

} // namespace insitu::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace insitu::query {

HWY_EXPORT(cells_ahead_target);
HWY_EXPORT(values_of_doubles);
HWY_EXPORT(values_of_floats);

std::size_t cells_ahead(const GridletBox& box, const math::Vec3d* points, std::size_t n,
                        Location* at) {
  return HWY_DYNAMIC_DISPATCH(cells_ahead_target)(box, points, n, at);
}
std::size_t values_ahead(const mesh::Gridlet* gridlets, std::int64_t end, const double* values,
                         const Location* at, std::size_t n, double* to) {
  return HWY_DYNAMIC_DISPATCH(values_of_doubles)(gridlets, end, values, at, n, to);
}
std::size_t values_ahead(const mesh::Gridlet* gridlets, std::int64_t end, const float* values,
                         const Location* at, std::size_t n, double* to) {
  return HWY_DYNAMIC_DISPATCH(values_of_floats)(gridlets, end, values, at, n, to);
}

} // namespace insitu::query
#endif
