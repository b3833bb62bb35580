#include "query/lattice/leaf_lanes.h"

#include <bit>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/lattice/leaf_lanes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace insitu::query::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using RealTag = hn::CappedTag<double, 8>;
using LongTag = hn::RebindToSigned<RealTag>;
using IntTag = hn::Rebind<std::int32_t, RealTag>; // as many lanes, half as wide
using UintTag = hn::RebindToUnsigned<IntTag>;
using Reals = hn::Vec<RealTag>;
using Ints = hn::Vec<IntTag>;
using Uints = hn::Vec<UintTag>;
using RealMask = hn::Mask<RealTag>;
constexpr std::size_t lanes = hn::MaxLanes(RealTag());
constexpr double side = amr::BrickStore::side;

HWY_INLINE RealMask between(Reals low, Reals a, Reals high) {
  return hn::And(hn::Gt(a, low), hn::Lt(a, high));
}
template <class Tag>
HWY_INLINE unsigned bits_of(Tag tag, hn::Mask<Tag> m) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(tag, m, bytes);
  return bytes[0];
}
/// a where kept, else b.
HWY_INLINE Uints chosen(RealMask kept, Uints a, Uints b) {
  // Through doubles, which have as many lanes.
  const RealTag d;
  const hn::RebindToUnsigned<LongTag> dl;
  const auto wide = hn::IfThenElse(kept, hn::BitCast(d, hn::PromoteTo(dl, a)),
                                   hn::BitCast(d, hn::PromoteTo(dl, b)));
  return hn::TruncateTo(UintTag(), hn::BitCast(dl, wide));
}
/// Of eight numbers, those at the indices.
HWY_INLINE Ints of_eight(const std::int32_t* numbers, Ints index) {
  const IntTag di;
  if constexpr (lanes == 8)
    return hn::TableLookupLanes(hn::Load(di, numbers), hn::IndicesFromVec(di, index));
  else
    return hn::GatherIndex(di, numbers, index);
}

/// The numbers of each lane's brick. The bricks have one depth and, if they are several, one order.
struct LaneBricks {
  Reals start[3], rounding[3], first_half[3];
  Uints first; ///< ids

  explicit LaneBricks(const BrickBox& box) : first(hn::Set(UintTag(), box.first)) {
    const RealTag d;
    for (int a = 0; a < 3; ++a) {
      start[a] = hn::Set(d, box.start[a]);
      rounding[a] = hn::Set(d, box.rounding[a]);
      first_half[a] = hn::Set(d, double(box.first_half[a]));
    }
  }
  /// For the lanes that are not kept.
  HWY_INLINE void take(const BrickBox& box, RealMask kept) {
    const LaneBricks to(box);
    for (int a = 0; a < 3; ++a) {
      start[a] = hn::IfThenElse(kept, start[a], to.start[a]);
      rounding[a] = hn::IfThenElse(kept, rounding[a], to.rounding[a]);
      first_half[a] = hn::IfThenElse(kept, first_half[a], to.first_half[a]);
    }
    first = chosen(kept, first, to.first);
  }
};

/// Where points lie in their bricks, in leaves, and in which of these.
struct LanePlaces {
  Reals place[3], lowest[3];
  Reals on[3]; ///< 1 on the face between the lowest leaf and the next
  RealMask sure;
  unsigned some_on = 0; ///< a bit an axis
  bool all_clear = true;

  /// As LeafFinder::in_last_brick; sure: which lie inside.
  HWY_INLINE void find(const LaneBricks& bricks, const BrickBox& box, const Reals* p) {
    const RealTag d;
    sure = hn::Eq(p[0], p[0]);
    for (int a = 0; a < 3; ++a) {
      place[a] = hn::Mul(hn::Sub(p[a], bricks.start[a]), hn::Set(d, box.steps_a_unit[a]));
      sure = hn::And(sure, between(hn::Zero(d), place[a], hn::Set(d, side)));
    }
  }
  /// As LeafFinder::in_last_brick and near_faces; sure: those whose leaves all lie in the brick.
  HWY_INLINE void find_leaves(const LaneBricks& bricks, const BrickBox& box, const Reals* p) {
    const RealTag d;
    const Reals zero = hn::Zero(d), one = hn::Set(d, 1.0);
    for (int a = 0; a < 3; ++a) {
      lowest[a] = hn::Trunc(place[a]);
      on[a] = zero;
      const RealMask clear = between(bricks.rounding[a], hn::Sub(place[a], lowest[a]),
                                     hn::Sub(one, bricks.rounding[a]));
      if (hn::AllTrue(d, clear))
        continue;
      all_clear = false;
      const Reals nearest = hn::Trunc(hn::Add(place[a], hn::Set(d, 0.5)));
      const Reals halves = hn::Add(bricks.first_half[a], hn::Add(nearest, nearest));
      const double half = box.lattice.half_width(a, box.depth);
      const Reals face =
          hn::Add(hn::Set(d, box.lattice.origin[a]), hn::Mul(hn::Set(d, half), halves));
      const Reals low = hn::Sub(nearest, hn::IfThenElseZero(hn::Le(p[a], face), one));
      lowest[a] = hn::IfThenElse(clear, lowest[a], low);
      on[a] = hn::IfThenZeroElse(clear, hn::IfThenElseZero(hn::Eq(p[a], face), one));
      const Reals last = hn::Add(lowest[a], on[a]);
      sure = hn::And(sure, hn::And(hn::Ge(lowest[a], zero), hn::Lt(last, hn::Set(d, side))));
      some_on |= unsigned(!hn::AllFalse(d, hn::Eq(on[a], one))) << a;
    }
  }
};

/// The lowest id of the leaves that hold each point, and in which of two along each axis (0, 1). By
/// a brick's entries; which lanes have leaves only.
HWY_INLINE unsigned by_entries(const BrickBox& box, const LanePlaces& at, Uints& id, Ints* beyond) {
  const IntTag di;
  const UintTag du;
  const auto entry_at = [&](Ints i) HWY_ATTR {
    return hn::BitCast(du,
                       hn::GatherIndex(di, reinterpret_cast<const std::int32_t*>(box.entries), i));
  };
  Ints index = hn::Zero(di), step[3];
  for (int a = 0; a < 3; ++a) {
    const Ints lowest = hn::DemoteTo(di, hn::IfThenElseZero(at.sure, at.lowest[a]));
    index = hn::Add(index, hn::ShiftLeftSame(lowest, 3 * a));
    step[a] = hn::DemoteTo(di, hn::IfThenElseZero(at.sure, at.on[a]));
    beyond[a] = hn::Zero(di);
  }
  id = entry_at(index);
  Uints highest = id; // what is no leaf has the highest numbers
  for (unsigned c = 1; c < 8 && at.some_on != 0; ++c) {
    if ((c & ~at.some_on) != 0)
      continue;
    Ints there = index, to[3];
    for (int a = 0; a < 3; ++a) {
      to[a] = (c >> a) & 1 ? step[a] : hn::Zero(di);
      there = hn::Add(there, hn::ShiftLeftSame(to[a], 3 * a));
    }
    const Uints entry = entry_at(there);
    const auto lower = hn::RebindMask(di, hn::Lt(entry, id));
    highest = hn::Max(highest, entry);
    id = hn::Min(id, entry);
    for (int a = 0; a < 3; ++a)
      beyond[a] = hn::IfThenElse(lower, to[a], beyond[a]);
  }
  return bits_of(du, hn::Lt(highest, hn::Set(du, amr::BrickStore::refined_in_part)));
}

/// The same by an order of ids: the lowest sum is that of the lowest offsets.
HWY_INLINE void by_order(const BrickBox& box, const LaneBricks& bricks, const LanePlaces& at,
                         Uints& id, Ints* beyond) {
  const IntTag di;
  const UintTag du;
  id = bricks.first;
  for (int a = 0; a < 3; ++a) {
    const std::int32_t* const offsets = box.order->offsets[a];
    const Ints lowest = hn::DemoteTo(di, hn::IfThenElseZero(at.sure, at.lowest[a]));
    Ints offset = of_eight(offsets, lowest);
    beyond[a] = hn::Zero(di);
    if ((at.some_on >> a) & 1) {
      const Ints step = hn::DemoteTo(di, hn::IfThenElseZero(at.sure, at.on[a]));
      const Ints next = of_eight(offsets, hn::Add(lowest, step));
      beyond[a] = hn::IfThenElseZero(hn::Lt(next, offset), step);
      offset = hn::Min(next, offset);
    }
    id = hn::Add(id, hn::BitCast(du, offset));
  }
}

HWY_INLINE void store_answers(const LanePlaces& places, Uints id, const Ints* beyond, Location* at,
                              Reason* reasons) {
  const RealTag d;
  const IntTag di;
  const hn::Rebind<std::uint8_t, RealTag> db;
  const Reals zero = hn::Zero(d), one = hn::Set(d, 1.0);
  Reals r[3], faces = zero;
  for (int a = 0; a < 3; ++a) {
    const Reals up = hn::PromoteTo(d, beyond[a]);
    r[a] = hn::Sub(places.place[a], hn::Add(places.lowest[a], up));
    if (!places.all_clear) {
      r[a] = hn::Min(hn::Max(r[a], zero), one);
      r[a] = hn::IfThenElse(hn::Eq(places.on[a], one), hn::Sub(one, up), r[a]);
      faces = hn::Add(faces, places.on[a]);
    }
  }
  static_assert(sizeof(Location) == 4 * sizeof(double));
  const auto cell = hn::PromoteTo(hn::RebindToUnsigned<LongTag>(), id);
  hn::StoreInterleaved4(hn::BitCast(d, cell), r[0], r[1], r[2], d, reinterpret_cast<double*>(at));
  alignas(16) static constexpr Reason why[16] = {Reason::certified, Reason::on_face,
                                                 Reason::on_edge, Reason::on_vertex};
  const auto reason_of = hn::Load(db, reinterpret_cast<const std::uint8_t*>(why));
  hn::StoreU(hn::TableLookupBytes(reason_of, hn::DemoteTo(db, hn::DemoteTo(di, faces))), db,
             reinterpret_cast<std::uint8_t*>(reasons));
}

std::size_t leaves_ahead_target(BrickBox& box, BrickBox (&others)[2], const math::Vec3d* points,
                                std::size_t n, Location* at, Reason* reasons) {
  const RealTag d;
  if constexpr (lanes < 4) // one by one is as fast
    return 0;
  constexpr unsigned all = (1u << lanes) - 1;
  std::uint32_t entry;
  std::size_t done = 0, prefix = lanes;
  // A register's bricks are found from its own points, not from the ones before: nothing waits.
  for (; prefix == lanes && done + lanes <= n; done += prefix) {
    const math::Vec3d* const from = points + done;
    if (box.order && !box.take_at(box.depth, from[0], entry))
      break;
    Reals p[3];
    hn::LoadInterleaved3(d, &from->x, p[0], p[1], p[2]);
    LaneBricks bricks(box);
    LanePlaces places;
    places.find(bricks, box, p);
    unsigned in = bits_of(d, places.sure);
    if (box.order)
      for (int b = 0; b < 2 && in != all; ++b) {
        // The last point's, then that of the first one elsewhere.
        const std::size_t lane = b == 0 ? lanes - 1 : std::size_t(std::countr_one(in));
        BrickBox& other = others[b];
        if (!other.take_at(box.depth, from[lane], entry) || other.order != box.order)
          continue;
        bricks.take(other, places.sure);
        places.find(bricks, box, p);
        in = bits_of(d, places.sure);
      }
    if (!(in & 1))
      break;
    places.find_leaves(bricks, box, p);
    Uints id;
    Ints beyond[3];
    unsigned found = all;
    if (box.order)
      by_order(box, bricks, places, id, beyond);
    else
      found = by_entries(box, places, id, beyond);
    store_answers(places, id, beyond, at + done, reasons + done);
    found &= bits_of(d, places.sure);
    prefix = found == all ? lanes : std::size_t(std::countr_one(found));
  }
  return done;
}

} // namespace insitu::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace insitu::query {

HWY_EXPORT(leaves_ahead_target);

std::size_t leaves_ahead(BrickBox& box, BrickBox (&others)[2], const math::Vec3d* points,
                         std::size_t n, Location* at, Reason* reasons) {
  return HWY_DYNAMIC_DISPATCH(leaves_ahead_target)(box, others, points, n, at, reasons);
}

} // namespace insitu::query
#endif
