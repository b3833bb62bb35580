#pragma once

#include "accel/camera_rays/frustum.h"
#include "accel/tree/node.h"

namespace insitu::accel {

/// A ray origin + t direction beside boxes of a tree, whose frame begins at `corner`.
struct BoxRay {
  double origin[3], direction[3];
  double inverse[3]; ///< may be infinite
  double slack[3];   ///< what the origin's rounding in the tree's frame may make of a face

  BoxRay(const math::Vec3d& o, const math::Vec3d& d, const math::Vec3d& corner) {
    for (int a = 0; a < 3; ++a) {
      origin[a] = o[a] - corner[a];
      direction[a] = d[a];
      inverse[a] = 1.0 / d[a];
      slack[a] = std::fabs(origin[a]) * 0x1p-48;
    }
  }
};

/// Bit c: child c is among `among`, bits too, and the ray meets its box for t in [t_min, t_max],
/// from near[c] on. Boxes are widened by the rounding of the test. What is no child's is not to be
/// among them. Runs on the widest vectors that the processor has.
unsigned children_along_ray(const Node& node, unsigned among, const BoxRay& ray, double t_min,
                            double t_max, double near[8]);

/// A frustum beside boxes of a tree, whose frame begins at `corner`: linear functions that are not
/// negative within, and the depth.
struct BoxFrustum {
  struct Function {
    math::Vec3d normal;
    double offset; ///< dot(normal, p) + offset
  };
  Function sides[4], depth;

  BoxFrustum(const Frustum& frustum, const math::Vec3d& corner) {
    const math::Vec3d eye = frustum.eye - corner;
    for (std::size_t s = 0; s < 4; ++s) {
      const Frustum::Side& side = frustum.sides[s];
      sides[s] = {side.normal, side.shift - dot(side.normal, eye)};
    }
    depth = {frustum.forward, -dot(frustum.forward, eye)};
  }
};

/// Returns bit c if child c of the node is among `among`, bits too, and its box may reach into the
/// frustum. depth[c] becomes the least depth in that box. Boxes are widened by the rounding of the
/// test. `among` must name children that exist.
unsigned children_in_frustum(const Node& node, unsigned among, const BoxFrustum& frustum,
                             double depth[8]);

} // namespace insitu::accel
