#pragma once

#include <vector>

#include "math/vec.h"
#include "render/camera.h"

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

/// What stays of a ray within [near, far], in ascending order; all of it without clips. Exact to
/// the rounding of the crossings.
void clip_ray(const std::vector<Clip>& clips, const Ray& ray, double near, double far,
              std::vector<Stretch>& stays);

} // namespace insitu::render
