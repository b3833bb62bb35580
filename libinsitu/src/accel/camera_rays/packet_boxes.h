#pragma once

#include <cstdint>

#include "accel/tree/node.h"
#include "math/vec.h"

namespace insitu::accel {

/// Up to 16 rays origin + t direction, t from 0 on, that pass a tree together; a ray a lane. In
/// floats, in the frame of the tree, whose boxes are widened by what that rounds.
struct RayPacket {
  static constexpr int most = 16;
  alignas(64) float origin[3][most], inverse[3][most];
  alignas(64) float t_max[most]; ///< rounded up
  float slack[3] = {};           ///< what rounding may make of an origin
  unsigned open = 0;             ///< bit i: ray i still looks for something

  /// No rays; `corner` is where the tree's frame begins, `largest` no less than any coordinate in
  /// it.
  RayPacket(const math::Vec3d& corner, float largest);
  /// Makes this ray number i. The direction has length 1.
  void set(int i, const math::Vec3d& at, const math::Vec3d& direction, double to);
  /// What lies behind `to` counts no more.
  void end_at(int i, double to);

private:
  math::Vec3d corner_;
  float least_slack_;
};

/// For children c of a node that are among `among`, bits too: the rays of `rays`, a bit each, that
/// may meet the box of child c go into met[c], and the least t where one does into near[c]. Returns
/// the children that any of them meets. `among` must name children that exist.
unsigned children_along_packet(const Node& node, unsigned among, const RayPacket& packet,
                               unsigned rays, std::uint32_t met[8], float near[8]);

} // namespace insitu::accel
