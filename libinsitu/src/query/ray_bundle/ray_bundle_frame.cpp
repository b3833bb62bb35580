#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "query/ray_bundle/ray_bundle_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/ray_bundle/ray_bundle_frame.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "query/ray_bundle/ray_bundle_linear_simd.h"

HWY_BEFORE_NAMESPACE();
namespace insitu::query::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// The first sample of each ray, and the way to the next, along the slab's axes; the reach is the
/// largest coordinate there is.
void place_rays_target(const BundleClaims& to, int rays, BundleSlab& slab) {
  const simd::PackTag d;
  const hn::Rebind<float, simd::PackTag> df;
  const Pack along = Pack((to.first + 0.5) * to.step), step(to.step);
  const Pack last = Pack(double(slab.depth - 1));
  Pack reach(0.0);
  for (int s = 0; s < rays; s += int(hn::MaxLanes(d))) {
    const auto column = [&](const double(&of)[3][bundle_rays]) HWY_ATTR {
      return PackVec{simd::load_pack(of[0] + s), simd::load_pack(of[1] + s),
                     simd::load_pack(of[2] + s)};
    };
    const PackVec direction = column(to.rays->direction);
    const PackVec middle{Pack(slab.middle.x), Pack(slab.middle.y), Pack(slab.middle.z)};
    const PackVec from = (column(to.rays->origin) + along * direction) - middle;
    const PackVec way = step * direction;
    for (int a = 0; a < 3; ++a) {
      const PackVec axis{Pack(slab.axes[a].x), Pack(slab.axes[a].y), Pack(slab.axes[a].z)};
      const Pack base = dot(axis, from), next = dot(axis, way);
      hn::Store(hn::DemoteTo(df, base.v), df, slab.base[a] + s);
      hn::Store(hn::DemoteTo(df, next.v), df, slab.along[a] + s);
      reach = larger(larger(absolute(base), absolute(base + last * next)), reach);
    }
  }
  slab.reach = float(hn::GetLane(hn::MaxOfLanes(d, reach.v))) * (1.0f + 0x1p-20f);
}

/// The number of the lowest and the highest bit of each lane; of 0 lowest > highest.
template <class D>
HWY_INLINE void bit_range(D d, hn::Vec<hn::Rebind<std::int32_t, D>> bits, hn::Vec<D>& lowest,
                          hn::Vec<D>& highest) {
  const hn::Rebind<std::int32_t, D> di;
  const auto zero = hn::Zero(di);
  const auto log2_of = [&](hn::Vec<hn::Rebind<std::int32_t, D>> one) HWY_ATTR {
    const auto exponent = hn::ShiftRight<23>(hn::BitCast(di, hn::Abs(hn::ConvertTo(d, one))));
    return hn::ConvertTo(d, hn::Sub(exponent, hn::Set(di, 127)));
  };
  const auto none = hn::RebindMask(d, hn::Eq(bits, zero));
  const auto top = hn::RebindMask(d, hn::Lt(bits, zero)); // bit 31
  lowest = hn::IfThenElse(none, hn::Set(d, 32.0f), log2_of(hn::And(bits, hn::Sub(zero, bits))));
  // Without the bit below the highest one, so that rounding does not reach the next power.
  const auto rest = hn::AndNot(hn::ShiftRight<1>(bits), bits);
  highest = hn::IfThenElse(top, hn::Set(d, 31.0f), log2_of(rest));
  highest = hn::IfThenElse(none, hn::Set(d, -1.0f), highest);
}

/// A group's bounds over its wanted samples, and over whatever is wanted in a lane.
struct GroupBounds {
  FloatVec lower[3], upper[3], first_w, last_w, least_step, most_step;
};

void bound_groups_target(const std::uint32_t* wanted, BundleSlab& slab) {
  const Floats d;
  const hn::Rebind<std::int32_t, Floats> di;
  constexpr float none = std::numeric_limits<float>::infinity();
  const auto most = hn::Set(d, none), least = hn::Set(d, -none);
  const float slack = 0x1p-20f * slab.reach; // the roundings of base + k along
  for (int a = 0; a < 3; ++a) {
    slab.lower[a] = none;
    slab.upper[a] = -none;
  }
  for (int g = 0; g < bundle_groups; ++g) {
    slab.wanted[g] = 0;
    for (int a = 0; a < 2; ++a) {
      slab.group_lower[a][g] = none;
      slab.group_upper[a][g] = -none;
    }
    slab.first_w[g] = slab.last_w[g] = slab.first_per_w[g] = slab.last_per_w[g] = 0.0f;
    slab.index_rounding[g] = float(bundle_depth); // all indices, where rays do not go along
    if (g >= slab.groups)
      continue;
    GroupBounds b{{most, most, most}, {least, least, least}, most, least, most, least};
    for (int s = g * bundle_lanes; s < (g + 1) * bundle_lanes; s += int(hn::MaxLanes(d))) {
      const auto bits = hn::Load(di, reinterpret_cast<const std::int32_t*>(wanted) + s);
      const auto any = hn::RebindMask(d, hn::Ne(bits, hn::Zero(di)));
      if (hn::AllFalse(d, any))
        continue;
      FloatVec first, last;
      bit_range(d, bits, first, last);
      for (int a = 0; a < 3; ++a) {
        const auto base = hn::Load(d, slab.base[a] + s), along = hn::Load(d, slab.along[a] + s);
        const auto p = hn::Add(base, hn::Mul(first, along)),
                   q = hn::Add(base, hn::Mul(last, along));
        b.lower[a] = hn::Min(b.lower[a], hn::IfThenElse(any, hn::Min(p, q), most));
        b.upper[a] = hn::Max(b.upper[a], hn::IfThenElse(any, hn::Max(p, q), least));
        if (a < 2)
          continue;
        b.first_w = hn::Min(b.first_w, hn::IfThenElse(any, base, most));
        b.last_w = hn::Max(b.last_w, hn::IfThenElse(any, base, least));
        b.least_step = hn::Min(b.least_step, hn::IfThenElse(any, along, most));
        b.most_step = hn::Max(b.most_step, hn::IfThenElse(any, along, least));
      }
    }
    for (int s = g * bundle_lanes; s < (g + 1) * bundle_lanes; ++s)
      slab.wanted[g] |= wanted[s];
    if (!slab.wanted[g])
      continue;
    const auto min_of = [&](FloatVec v) HWY_ATTR { return hn::GetLane(hn::MinOfLanes(d, v)); };
    const auto max_of = [&](FloatVec v) HWY_ATTR { return hn::GetLane(hn::MaxOfLanes(d, v)); };
    for (int a = 0; a < 3; ++a) {
      const float low = min_of(b.lower[a]) - slack, high = max_of(b.upper[a]) + slack;
      slab.lower[a] = std::min(slab.lower[a], low);
      slab.upper[a] = std::max(slab.upper[a], high);
      if (a < 2) {
        slab.group_lower[a][g] = low;
        slab.group_upper[a][g] = high;
      }
    }
    const float least_step = min_of(b.least_step), most_step = max_of(b.most_step);
    if (!(least_step > 0.0f))
      continue;
    slab.first_w[g] = min_of(b.first_w);
    slab.last_w[g] = max_of(b.last_w);
    slab.first_per_w[g] = 1.0f / most_step;
    slab.last_per_w[g] = 1.0f / least_step;
    slab.index_rounding[g] =
        1e-3f + (0x1p-19f * slab.reach + float(slab.rounding)) * slab.last_per_w[g];
  }
}

} // namespace insitu::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace insitu::query {

HWY_EXPORT(place_rays_target);
HWY_EXPORT(bound_groups_target);

void place_rays(const BundleClaims& to, int rays, BundleSlab& slab) {
  HWY_DYNAMIC_DISPATCH(place_rays_target)(to, rays, slab);
}

void bound_groups(const std::uint32_t* wanted, BundleSlab& slab) {
  HWY_DYNAMIC_DISPATCH(bound_groups_target)(wanted, slab);
}

} // namespace insitu::query
#endif
