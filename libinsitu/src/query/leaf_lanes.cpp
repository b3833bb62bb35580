#include "query/leaf_lanes.h"

#include "amr/brick_store.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/leaf_lanes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace insitu::query::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using RealTag = hn::CappedTag<double, 8>;
using LongTag = hn::RebindToSigned<RealTag>;
using IntTag = hn::Rebind<std::int32_t, RealTag>; // as many lanes, half as wide
using Reals = hn::Vec<RealTag>;
using Ints = hn::Vec<IntTag>;
using RealMask = hn::Mask<RealTag>;

HWY_INLINE Reals real(Ints a) {
  return hn::PromoteTo(RealTag(), a);
}
HWY_INLINE RealMask between(Reals low, Reals a, Reals high) {
  return hn::And(hn::Gt(a, low), hn::Lt(a, high));
}
HWY_INLINE unsigned bits_of(RealMask m) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(RealTag(), m, bytes);
  return bytes[0];
}
HWY_INLINE void store(hn::Vec<LongTag> cell, const Reals* r, Location* to) {
  static_assert(sizeof(Location) == 4 * sizeof(double));
  hn::StoreInterleaved4(hn::BitCast(RealTag(), cell), r[0], r[1], r[2], RealTag(),
                        reinterpret_cast<double*>(to));
}

std::size_t leaves_ahead_target(const BrickBox& box, const math::Vec3d* points, std::size_t n,
                                Location* at, Reason* reasons) {
  constexpr double side = amr::BrickStore::side;
  const RealTag d;
  const IntTag di;
  const LongTag dl;
  const hn::RebindToUnsigned<IntTag> du;
  const Reals zero = hn::Zero(d), one = hn::Set(d, 1.0);
  const std::size_t lanes = hn::Lanes(d);
  const auto entry_at = [&](Ints index) HWY_ATTR {
    return hn::GatherIndex(di, reinterpret_cast<const std::int32_t*>(box.entries), index);
  };
  std::size_t done = 0;
  for (; done + lanes <= n; done += lanes) {
    Reals p[3], place[3], lowest[3], on[3]; // on: 1 on a face
    hn::LoadInterleaved3(d, &points[done].x, p[0], p[1], p[2]);
    RealMask sure = hn::Eq(p[0], p[0]);
    unsigned some_on = 0; // a bit an axis
    bool all_clear = true;
    for (int a = 0; a < 3; ++a) { // as LeafFinder::in_last_brick and near_faces
      place[a] = hn::Mul(hn::Sub(p[a], hn::Set(d, box.start[a])), hn::Set(d, box.steps_a_unit[a]));
      sure = hn::And(sure, between(zero, place[a], hn::Set(d, side)));
      lowest[a] = hn::Trunc(place[a]);
      on[a] = zero;
      const RealMask clear = between(hn::Set(d, box.rounding[a]), hn::Sub(place[a], lowest[a]),
                                     hn::Set(d, 1.0 - box.rounding[a]));
      if (hn::AllTrue(d, clear))
        continue;
      all_clear = false;
      const Reals nearest = hn::Trunc(hn::Add(place[a], hn::Set(d, 0.5)));
      const Reals halves =
          hn::Add(hn::Set(d, double(box.first_half[a])), hn::Add(nearest, nearest));
      const double half = box.lattice.spacing[a] * mesh::Lattice::power(box.depth + 1);
      const Reals face =
          hn::Add(hn::Set(d, box.lattice.origin[a]), hn::Mul(hn::Set(d, half), halves));
      const Reals low = hn::Sub(nearest, hn::IfThenElseZero(hn::Le(p[a], face), one));
      lowest[a] = hn::IfThenElse(clear, lowest[a], low);
      on[a] = hn::IfThenZeroElse(clear, hn::IfThenElseZero(hn::Eq(p[a], face), one));
      const Reals last = hn::Add(lowest[a], on[a]);
      sure = hn::And(sure, hn::And(hn::Ge(lowest[a], zero), hn::Lt(last, hn::Set(d, side))));
      some_on |= unsigned(!hn::AllFalse(d, hn::Eq(on[a], one))) << a;
    }
    if (!(bits_of(sure) & 1))
      break;
    Ints index = hn::Zero(di), step[3];
    for (int a = 0; a < 3; ++a) {
      const Reals i = hn::IfThenElseZero(sure, lowest[a]);
      index = hn::Add(index, hn::ShiftLeftSame(hn::DemoteTo(di, i), 3 * a));
      step[a] = hn::DemoteTo(di, hn::IfThenElseZero(sure, on[a]));
    }
    // The lowest id of the leaves there, and in which of two along each axis. What is no leaf has
    // the highest numbers.
    auto id = hn::BitCast(du, entry_at(index)), highest = id;
    Ints beyond[3] = {hn::Zero(di), hn::Zero(di), hn::Zero(di)};
    for (unsigned c = 1; c < 8 && some_on != 0; ++c) {
      if ((c & ~some_on) != 0)
        continue;
      Ints there = index, to[3];
      for (int a = 0; a < 3; ++a) {
        to[a] = (c >> a) & 1 ? step[a] : hn::Zero(di);
        there = hn::Add(there, hn::ShiftLeftSame(to[a], 3 * a));
      }
      const auto entry = hn::BitCast(du, entry_at(there));
      const auto lower = hn::RebindMask(di, hn::Lt(entry, id));
      highest = hn::Max(highest, entry);
      id = hn::Min(id, entry);
      for (int a = 0; a < 3; ++a)
        beyond[a] = hn::IfThenElse(lower, to[a], beyond[a]);
    }
    alignas(64) std::uint32_t tops[8];
    hn::Store(highest, du, tops);
    Reals r[3], faces = zero;
    for (int a = 0; a < 3; ++a) {
      const Reals up = real(beyond[a]);
      r[a] = hn::Sub(place[a], hn::Add(lowest[a], up));
      if (!all_clear) {
        r[a] = hn::Min(hn::Max(r[a], zero), one);
        r[a] = hn::IfThenElse(hn::Eq(on[a], one), hn::Sub(one, up), r[a]);
        faces = hn::Add(faces, on[a]);
      }
    }
    store(hn::BitCast(dl, hn::PromoteTo(hn::RebindToUnsigned<LongTag>(), id)), r, at + done);
    alignas(64) double on_faces[8];
    hn::Store(faces, d, on_faces);
    constexpr Reason why[] = {Reason::certified, Reason::on_face, Reason::on_edge,
                              Reason::on_vertex};
    const unsigned found = bits_of(sure);
    for (std::size_t k = 0; k < lanes; ++k) {
      if (!((found >> k) & 1) || !amr::BrickStore::is_leaf(tops[k]))
        return done + k;
      reasons[done + k] = why[int(on_faces[k])];
    }
  }
  return done;
}

} // namespace insitu::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace insitu::query {

HWY_EXPORT(leaves_ahead_target);

std::size_t leaves_ahead(const BrickBox& box, const math::Vec3d* points, std::size_t n,
                         Location* at, Reason* reasons) {
  return HWY_DYNAMIC_DISPATCH(leaves_ahead_target)(box, points, n, at, reasons);
}

} // namespace insitu::query
#endif
