#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

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
  slab.reach = 0.0f;
  for (int r = 0; r < rays_; ++r)
    for (const int k : {0, depth_ - 1}) {
      const Vec3d p = point(place_of(k, s_.slot[r])) - slab.middle;
      for (int a = 0; a < 3; ++a)
        slab.reach = std::max(slab.reach, std::fabs(float(dot(slab.axes[a], p))));
    }
  slab.reach *= 1.0f + 0x1p-20f;
  set_groups();
  return std::isfinite(slab.reach) && slab.reach < 1e30f;
}

/// The samples in the slab's frame.
void RayBundleLocator::set_groups() {
  BundleSlab& slab = s_.slab;
  constexpr float none = std::numeric_limits<float>::infinity();
  for (int a = 0; a < 3; ++a) {
    slab.lower[a] = none;
    slab.upper[a] = -none;
  }
  for (int g = 0; g < bundle_groups; ++g) {
    slab.wanted[g] = 0;
    for (int a = 0; a < 2; ++a) {
      slab.group_lower[a][g] = none;
      slab.group_upper[a][g] = -none;
    }
    float least_w = none, most_w = -none, least_step = none, most_step = -none;
    for (int slot = g * bundle_lanes; slot < (g + 1) * bundle_lanes; ++slot) {
      const std::uint32_t wanted = g < groups_ ? s_.wanted[slot] : 0u;
      for (int a = 0; a < 3; ++a)
        slab.base[a][slot] = slab.along[a][slot] = 0.0f;
      if (!wanted)
        continue;
      slab.wanted[g] |= wanted;
      const Vec3d from = point(place_of(0, slot)) - slab.middle,
                  step = step_ * s_.rays.direction_of(slot);
      const int first = std::countr_zero(wanted), last = 31 - std::countl_zero(wanted);
      for (int a = 0; a < 3; ++a) {
        const float base = float(dot(slab.axes[a], from)), along = float(dot(slab.axes[a], step));
        slab.base[a][slot] = base;
        slab.along[a][slot] = along;
        const float p = base + float(first) * along, q = base + float(last) * along;
        const float lower = std::min(p, q), upper = std::max(p, q);
        slab.lower[a] = std::min(slab.lower[a], lower);
        slab.upper[a] = std::max(slab.upper[a], upper);
        if (a < 2) {
          slab.group_lower[a][g] = std::min(slab.group_lower[a][g], lower);
          slab.group_upper[a][g] = std::max(slab.group_upper[a][g], upper);
        } else {
          least_w = std::min(least_w, base);
          most_w = std::max(most_w, base);
          least_step = std::min(least_step, along);
          most_step = std::max(most_step, along);
        }
      }
    }
    slab.first_w[g] = least_w;
    slab.last_w[g] = most_w;
    slab.first_per_w[g] = 1.0f / most_step;
    slab.last_per_w[g] = 1.0f / least_step;
    slab.index_rounding[g] = 0.0f;                 // see below
    if (!slab.wanted[g] || !(least_step > 0.0f)) { // all indices, where rays do not go along
      slab.first_w[g] = slab.last_w[g] = slab.first_per_w[g] = slab.last_per_w[g] = 0.0f;
      slab.index_rounding[g] = float(bundle_depth);
    }
  }
  for (int g = 0; g < groups_; ++g)
    if (slab.index_rounding[g] == 0.0f)
      slab.index_rounding[g] =
          1e-3f + (0x1p-19f * slab.reach + float(slab.rounding)) * slab.last_per_w[g];
  // The roundings of base + k along.
  for (int a = 0; a < 3; ++a) {
    slab.lower[a] -= 0x1p-20f * slab.reach;
    slab.upper[a] += 0x1p-20f * slab.reach;
  }
  for (int g = 0; g < groups_; ++g)
    for (int a = 0; a < 2; ++a) {
      slab.group_lower[a][g] -= 0x1p-20f * slab.reach;
      slab.group_upper[a][g] += 0x1p-20f * slab.reach;
    }
}

} // namespace insitu::query
