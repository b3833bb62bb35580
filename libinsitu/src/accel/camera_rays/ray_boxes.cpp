#include "accel/camera_rays/ray_boxes.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/camera_rays/ray_boxes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace insitu::accel::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

unsigned children_target(const Node& node, unsigned among, const BoxRay& ray, double t_min,
                         double t_max, double near[8]) {
  using Doubles = hn::CappedTag<double, 8>;
  const Doubles d;
  const hn::Rebind<float, Doubles> df;
  const hn::Rebind<std::int32_t, Doubles> di;
  const hn::Rebind<std::uint8_t, Doubles> db;
  constexpr int lanes = int(hn::MaxLanes(d));
  unsigned bits = 0;
  for (int i = 0; i < 8; i += lanes) {
    auto from = hn::Set(d, t_min), to = hn::Set(d, t_max);
    auto misses = hn::Lt(to, from);
    for (int a = 0; a < 3; ++a) {
      const auto face = [&](const std::uint8_t* steps) HWY_ATTR {
        const auto at = hn::ConvertTo(df, hn::PromoteTo(di, hn::LoadU(db, steps + i)));
        const auto x = hn::Add(hn::Set(df, node.lower[a]), hn::Mul(hn::Set(df, node.scale(a)), at));
        return hn::PromoteTo(d, x);
      };
      const auto origin = hn::Set(d, ray.origin[a]), slack = hn::Set(d, ray.slack[a]);
      const auto low = hn::Sub(hn::Sub(face(node.child_lower[a]), slack), origin);
      const auto high = hn::Sub(hn::Add(face(node.child_upper[a]), slack), origin);
      if (ray.direction[a] == 0.0) {
        const auto zero = hn::Zero(d);
        misses = hn::Or(misses, hn::Or(hn::Gt(low, zero), hn::Lt(high, zero)));
        continue;
      }
      // By the direction's sign, not by size: 0 times an infinite inverse is NaN, which the
      // comparisons below pass over.
      const auto inverse = hn::Set(d, ray.inverse[a]), rounding = hn::Set(d, 0x1p-50);
      const bool up = ray.direction[a] > 0.0;
      auto enters = hn::Mul(up ? low : high, inverse), leaves = hn::Mul(up ? high : low, inverse);
      enters = hn::Sub(enters, hn::Mul(hn::Abs(enters), rounding));
      leaves = hn::Add(leaves, hn::Mul(hn::Abs(leaves), rounding));
      from = hn::IfThenElse(hn::Gt(enters, from), enters, from);
      to = hn::IfThenElse(hn::Lt(leaves, to), leaves, to);
    }
    misses = hn::Or(misses, hn::Lt(to, from));
    hn::StoreU(from, d, near + i);
    std::uint8_t byte[8] = {};
    hn::StoreMaskBits(d, misses, byte);
    bits |= (~unsigned(byte[0]) & ((1u << lanes) - 1)) << i;
  }
  return bits & among;
}

} // namespace insitu::accel::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace insitu::accel {

HWY_EXPORT(children_target);

unsigned children_along_ray(const Node& node, unsigned among, const BoxRay& ray, double t_min,
                            double t_max, double near[8]) {
  return HWY_DYNAMIC_DISPATCH(children_target)(node, among, ray, t_min, t_max, near);
}

} // namespace insitu::accel
#endif
