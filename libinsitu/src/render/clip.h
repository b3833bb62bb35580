#pragma once

#include <optional>
#include <vector>

#include "math/vec.h"
#include "render/camera/camera.h"

namespace insitu::render {

/// A stretch of a ray.
struct Stretch {
  double from = 0, to = 0;
};

/// Cuts part of the scene away. plane: `vector` is its normal, on whose side things go; box: from
/// `point` to `vector`; sphere: around `point`.
struct Clip {
  enum class Kind { plane, box, sphere };
  Kind kind = Kind::plane;
  math::Vec3d point, vector{0, 0, 1};
  double radius = 0;
  bool keep_inside = true; ///< of a box or a sphere; false: its inside goes
};

/// The part of a ray's line, before its origin too, that lies in a box; none if it passes it by.
/// The direction's components may be 0 and the origin anywhere.
std::optional<Stretch> stretch_in_box(const Ray& ray, const math::Vec3d& low,
                                      const math::Vec3d& high);

/// What stays of a ray within [near, far], in ascending order; all of it without clips, and what
/// every single one keeps with several. The direction's components may be 0 and the origin
/// anywhere; far may be infinite. Stretches of no length are left out. Exact to the rounding of the
/// crossings.
void clip_ray(const std::vector<Clip>& clips, const Ray& ray, double near, double far,
              std::vector<Stretch>& stays);

/// The corners of a convex part of a box, low to high, that holds all of it that clips leave: its
/// meet with all half-spaces, with boxes that are kept inside, and with the boxes around spheres
/// that are. Boxes and spheres that are cut out make it no smaller. Empty where nothing is left.
std::vector<math::Vec3d> clipped_corners(const std::vector<Clip>& clips, const math::Vec3d& low,
                                         const math::Vec3d& high);

/// Whether the distance lies in one of them.
inline bool stays_at(const std::vector<Stretch>& stays, double t) {
  for (const Stretch& s : stays)
    if (s.from <= t && t <= s.to)
      return true;
  return false;
}

} // namespace insitu::render
