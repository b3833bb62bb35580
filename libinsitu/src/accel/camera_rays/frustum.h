#pragma once

#include <array>
#include <cmath>

#include "accel/tree/node.h"
#include "math/vec.h"

namespace insitu::accel {

/// The part of space that a rectangle of an image shows, behind the eye left out. A point p lies in
/// it where dot(normal, p) + offset >= 0 for every side. Its depth is
/// dot(forward, p) + depth_offset.
struct Frustum {
  struct Side {
    math::Vec3d normal;
    double offset = 0;
  };
  std::array<Side, 4> sides;
  math::Vec3d forward;
  double depth_offset = 0;

  /// Returns the frustum in a frame of reference that begins at `corner`.
  Frustum from(const math::Vec3d& corner) const {
    Frustum moved = *this;
    for (Side& side : moved.sides)
      side.offset += dot(side.normal, corner);
    moved.depth_offset += dot(forward, corner);
    return moved;
  }

  /// Whether a box may reach into the frustum. Sets depth to the least depth in the box.
  bool may_meet(const math::Vec3d& low, const math::Vec3d& high, double& depth) const {
    bool meets = true;
    for (const Side& side : sides)
      meets = meets && reach(side.normal, side.offset, high, low) >= 0.0;
    double greatest = reach(forward, depth_offset, high, low);
    depth = -reach(-forward, -depth_offset, high, low);
    return meets && greatest >= 0.0;
  }

private:
  /// The greatest value of dot(normal, p) + offset in a box, with what rounding may hide.
  static double reach(const math::Vec3d& normal, double offset, const math::Vec3d& high,
                      const math::Vec3d& low) {
    double sum = offset, size = std::fabs(offset);
    for (int a = 0; a < 3; ++a) {
      const double term = normal[a] * (normal[a] > 0 ? high[a] : low[a]);
      sum += term;
      size += std::fabs(term);
    }
    return sum + 0x1p-48 * size;
  }
};

/// Returns bit c if child c of the node is among `among`, bits too, and its box may reach into the
/// frustum, which is in the tree's frame of reference. depth[c] becomes the least depth in that
/// box. Boxes are widened by the rounding of the test. `among` must name children that exist.
unsigned children_in_frustum(const Node& node, unsigned among, const Frustum& frustum,
                             double depth[8]);

} // namespace insitu::accel
