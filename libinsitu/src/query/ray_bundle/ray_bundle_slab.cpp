#include <cmath>

#include "query/ray_bundle/ray_bundle_scratch.h"

/// The frame of a bundle's samples.
namespace insitu::query {

using math::Vec3d;

namespace {

Vec3d normalized(const Vec3d& v) {
  return v / std::sqrt(dot(v, v));
}

} // namespace

/// A frame along the rays about the stretch's middle, whatever of it is wanted, so that what floats
/// make of a sample does not hang on others. False if there is none.
bool RayBundleLocator::set_slab() {
  BundleSlab& slab = s_.slab;
  slab.middle = s_.mean_origin + ((double(first_) + 0.5 * depth_) * step_) * s_.mean_direction;
  slab.axes[2] = normalized(s_.mean_direction);
  // Along a row of pixels, so that boxes of groups are tight.
  Vec3d across = point(place_of(0, s_.slot[row_ - 1])) - point(place_of(0, s_.slot[0]));
  if (!(dot(across, across) > 0.0) && rays_ > 1)
    across = point(place_of(0, s_.slot[rays_ - 1])) - point(place_of(0, s_.slot[0]));
  slab.axes[0] = across - dot(across, slab.axes[2]) * slab.axes[2];
  if (!(dot(across, across) > 0.0) ||
      !(dot(slab.axes[0], slab.axes[0]) > 1e-12 * dot(across, across))) {
    const Vec3d& w = slab.axes[2];
    slab.axes[0] = std::fabs(w.x) < 0.6 ? cross(w, Vec3d{1, 0, 0}) : cross(w, Vec3d{0, 1, 0});
  }
  slab.axes[0] = normalized(slab.axes[0]);
  slab.axes[1] = cross(slab.axes[2], slab.axes[0]);
  slab.depth = depth_;
  slab.groups = groups_;
  // Of a sample's own coordinates, and of the sums that lead to them.
  slab.rounding = 0x1p-48 * (s_.far + std::fabs((double(first_) + depth_) * step_));
  const double sound = dot(slab.axes[0], slab.axes[0]) + dot(slab.axes[2], slab.axes[2]) +
                       dot(slab.middle, slab.middle) + slab.rounding;
  if (!std::isfinite(sound))
    return false;
  place_rays(claims(), groups_ * bundle_lanes, slab);
  bound_groups(s_.wanted, slab);
  return std::isfinite(slab.reach) && slab.reach < 1e30f;
}

} // namespace insitu::query
