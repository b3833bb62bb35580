#include "accel/camera_rays/packet_boxes.h"

#include <algorithm>
#include <bit>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/camera_rays/packet_boxes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace insitu::accel::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, RayPacket::most>;

unsigned packet_target(const Node& node, unsigned among, const RayPacket& p, unsigned rays,
                       std::uint32_t met[8], float near[8]) {
  const Floats d;
  constexpr int lanes = int(hn::MaxLanes(d));
  constexpr unsigned all = unsigned((std::uint64_t(1) << lanes) - 1);
  unsigned bits = 0;
  for (; among; among &= among - 1) {
    const int c = std::countr_zero(among);
    const Box box = node.child_box(c);
    float low[3], high[3];
    for (int a = 0; a < 3; ++a) {
      // The rounding of faces and of differences to origins, in floats.
      const float slack =
          p.slack[a] + 0x1p-22f * (std::fabs(box.lower[a]) + std::fabs(box.upper[a]));
      low[a] = box.lower[a] - slack;
      high[a] = box.upper[a] + slack;
    }
    std::uint32_t of_child = 0;
    float nearest = HUGE_VALF;
    for (int i = 0; i < RayPacket::most; i += lanes) {
      if (!(rays >> i & all))
        continue;
      auto from = hn::Zero(d), to = hn::Load(d, p.t_max + i);
      for (int a = 0; a < 3; ++a) {
        const auto origin = hn::Load(d, p.origin[a] + i), inverse = hn::Load(d, p.inverse[a] + i);
        const auto s = hn::Mul(hn::Sub(hn::Set(d, low[a]), origin), inverse);
        const auto t = hn::Mul(hn::Sub(hn::Set(d, high[a]), origin), inverse);
        from = hn::Max(from, hn::Min(s, t));
        to = hn::Min(to, hn::Max(s, t));
      }
      const auto meets = hn::Le(from, hn::Mul(to, hn::Set(d, 1 + 0x1p-20f)));
      std::uint8_t byte[8] = {};
      hn::StoreMaskBits(d, meets, byte);
      const unsigned mask = (unsigned(byte[0]) | unsigned(byte[1]) << 8) & all & (rays >> i);
      if (mask) {
        of_child |= mask << i;
        const auto first = hn::IfThenElse(meets, from, hn::Set(d, HUGE_VALF));
        nearest = std::min(nearest, hn::GetLane(hn::MinOfLanes(d, first)));
      }
    }
    if (of_child) {
      bits |= 1u << c;
      met[c] = of_child;
      near[c] = nearest;
    }
  }
  return bits;
}

} // namespace insitu::accel::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace insitu::accel {

HWY_EXPORT(packet_target);

namespace {

/// A component of a direction below this counts as this, so that no inverse is infinite: over a
/// way of the tree's size, a ray strays from where it goes by less than its least slack.
constexpr float least_direction = 1e-20f;

} // namespace

RayPacket::RayPacket(const math::Vec3d& corner, float largest)
    : corner_(corner), least_slack_(1e-18f * largest) {
  for (int i = 0; i < most; ++i) {
    for (int a = 0; a < 3; ++a) {
      origin[a][i] = 0;
      inverse[a][i] = 1;
    }
    t_max[i] = -1;
  }
  for (float& s : slack)
    s = least_slack_;
}

void RayPacket::set(int i, const math::Vec3d& at, const math::Vec3d& direction, double to) {
  for (int a = 0; a < 3; ++a) {
    origin[a][i] = float(at[a] - corner_[a]);
    slack[a] = std::max(slack[a], least_slack_ + 0x1p-22f * std::fabs(origin[a][i]) +
                                      float(0x1p-48 * std::fabs(at[a])));
    const float d = float(direction[a]);
    inverse[a][i] = 1 / std::copysign(std::max(std::fabs(d), least_direction), d);
  }
  open |= 1u << i;
  end_at(i, to);
}

void RayPacket::end_at(int i, double to) {
  t_max[i] = round_up(std::min(to, 0x1p126));
  if (to < 0)
    open &= ~(1u << i);
}

unsigned children_along_packet(const Node& node, unsigned among, const RayPacket& packet,
                               unsigned rays, std::uint32_t met[8], float near[8]) {
  return HWY_DYNAMIC_DISPATCH(packet_target)(node, among, packet, rays, met, near);
}

} // namespace insitu::accel
#endif
