#include "accel/camera_rays/frustum.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/camera_rays/frustum.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace insitu::accel::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

unsigned frustum_target(const Node& node, unsigned among, const Frustum& frustum, double depth[8]) {
  using Doubles = hn::CappedTag<double, 8>;
  const Doubles d;
  const hn::Rebind<float, Doubles> df;
  const hn::Rebind<std::int32_t, Doubles> di;
  const hn::Rebind<std::uint8_t, Doubles> db;
  constexpr int lanes = int(hn::MaxLanes(d));
  unsigned bits = 0;
  for (int i = 0; i < 8; i += lanes) {
    hn::Vec<Doubles> low[3], high[3];
    for (int a = 0; a < 3; ++a) {
      const auto face = [&](const std::uint8_t* steps) HWY_ATTR {
        const auto at = hn::ConvertTo(df, hn::PromoteTo(di, hn::LoadU(db, steps + i)));
        return hn::PromoteTo(
            d, hn::Add(hn::Set(df, node.lower[a]), hn::Mul(hn::Set(df, node.scale(a)), at)));
      };
      low[a] = face(node.child_lower[a]);
      high[a] = face(node.child_upper[a]);
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
    auto meets = hn::Ge(reach(frustum.forward, frustum.depth_offset), zero);
    for (const Frustum::Side& side : frustum.sides)
      meets = hn::And(meets, hn::Ge(reach(side.normal, side.offset), zero));
    hn::StoreU(hn::Neg(reach(-frustum.forward, -frustum.depth_offset)), d, depth + i);
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

HWY_EXPORT(frustum_target);

unsigned children_in_frustum(const Node& node, unsigned among, const Frustum& frustum,
                             double depth[8]) {
  return HWY_DYNAMIC_DISPATCH(frustum_target)(node, among, frustum, depth);
}

} // namespace insitu::accel
#endif
