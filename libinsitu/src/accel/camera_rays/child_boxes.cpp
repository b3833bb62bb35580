#include "accel/camera_rays/child_boxes.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/camera_rays/child_boxes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace insitu::accel::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, 8>;

/// Faces of children across an axis, from their steps.
HWY_INLINE hn::Vec<Doubles> faces(const Node& node, int axis, const std::uint8_t* steps) {
  const Doubles d;
  const hn::Rebind<float, Doubles> df;
  const hn::Rebind<std::int32_t, Doubles> di;
  const hn::Rebind<std::uint8_t, Doubles> db;
  const auto at = hn::ConvertTo(df, hn::PromoteTo(di, hn::LoadU(db, steps)));
  const auto x = hn::Add(hn::Set(df, node.lower[axis]), hn::Mul(hn::Set(df, node.scale(axis)), at));
  return hn::PromoteTo(d, x);
}

unsigned children_target(const Node& node, unsigned among, const BoxRay& ray, double t_min,
                         double t_max, double near[8]) {
  const Doubles d;
  constexpr int lanes = int(hn::MaxLanes(d));
  unsigned bits = 0;
  for (int i = 0; i < 8; i += lanes) {
    auto from = hn::Set(d, t_min), to = hn::Set(d, t_max);
    auto misses = hn::Lt(to, from);
    for (int a = 0; a < 3; ++a) {
      const auto origin = hn::Set(d, ray.origin[a]), slack = hn::Set(d, ray.slack[a]);
      const auto low = hn::Sub(hn::Sub(faces(node, a, node.child_lower[a] + i), slack), origin);
      const auto high = hn::Sub(hn::Add(faces(node, a, node.child_upper[a] + i), slack), origin);
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

unsigned frustum_target(const Node& node, unsigned among, const BoxFrustum& frustum,
                        double depth[8]) {
  const Doubles d;
  constexpr int lanes = int(hn::MaxLanes(d));
  unsigned bits = 0;
  for (int i = 0; i < 8; i += lanes) {
    hn::Vec<Doubles> low[3], high[3];
    for (int a = 0; a < 3; ++a) {
      low[a] = faces(node, a, node.child_lower[a] + i);
      high[a] = faces(node, a, node.child_upper[a] + i);
    }
    // The greatest value of a linear function in the boxes, with what rounding may hide.
    const auto reach = [&](const math::Vec3d& normal, double offset) HWY_ATTR {
      auto sum = hn::Set(d, offset), size = hn::Set(d, std::fabs(offset));
      for (int a = 0; a < 3; ++a) {
        const auto term = hn::Mul(hn::Set(d, normal[a]), normal[a] > 0 ? high[a] : low[a]);
        sum = hn::Add(sum, term);
        size = hn::Add(size, hn::Abs(term));
      }
      return hn::MulAdd(hn::Set(d, 0x1p-48), size, sum);
    };
    const auto zero = hn::Zero(d);
    auto meets = hn::Ge(reach(frustum.depth.normal, frustum.depth.offset), zero);
    for (const BoxFrustum::Function& side : frustum.sides)
      meets = hn::And(meets, hn::Ge(reach(side.normal, side.offset), zero));
    hn::StoreU(hn::Neg(reach(-frustum.depth.normal, -frustum.depth.offset)), d, depth + i);
    std::uint8_t byte[8] = {};
    hn::StoreMaskBits(d, meets, byte);
    bits |= (unsigned(byte[0]) & ((1u << lanes) - 1)) << i;
  }
  return bits & among;
}

} // namespace insitu::accel::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace insitu::accel {

HWY_EXPORT(children_target);
HWY_EXPORT(frustum_target);

unsigned children_along_ray(const Node& node, unsigned among, const BoxRay& ray, double t_min,
                            double t_max, double near[8]) {
  return HWY_DYNAMIC_DISPATCH(children_target)(node, among, ray, t_min, t_max, near);
}

unsigned children_in_frustum(const Node& node, unsigned among, const BoxFrustum& frustum,
                             double depth[8]) {
  return HWY_DYNAMIC_DISPATCH(frustum_target)(node, among, frustum, depth);
}

} // namespace insitu::accel
#endif
