#pragma once

#include "advect/integrate/integration.h"

/// Where particles leave, of Integration; included by integration.h alone.
namespace insitu::advect {

/// Whether a way in coordinates and time is as short as an exit is told by.
template <class M, VelocityField F, class Visit>
bool Integration<M, F, Visit>::is_close(const Vec3d& way, double time) const {
  return is_close(way, time, closely_ ? 4.0 * epsilon : s_.exit_tolerance);
}
template <class M, VelocityField F, class Visit>
bool Integration<M, F, Visit>::is_close(const Vec3d& way, double time, double tolerance) const {
  // Far from the origin coordinates may be coarser than the tolerance.
  const double coarse = 8.0 * epsilon * cells_crossed(p_.x, {1.0, 1.0, 1.0});
  // Time counts too: a moving mesh can leave a particle that is at rest.
  return (cells_crossed(way, extent_) <= tolerance ||
          cells_crossed(way, {1.0, 1.0, 1.0}) <= coarse) &&
         (span_ == infinity || time <= tolerance * span_);
}

/// Whether a step is so short that only therefore it ends beyond the mesh by no more than rounding:
/// many of these would go with a wall that moves, or never come to an end. However long the step
/// takes, it is so if a good part of its way goes beyond, and that is more than the place's
/// rounding.
template <class M, VelocityField F, class Visit>
bool Integration<M, F, Visit>::creeps(const Trial& trial) {
  if ((closing_in_ == 0 && span_ == infinity) || confined_)
    return false;
  constexpr double good_part = 1.0 / 64.0;
  const Vec3d way = trial.x - p_.x;
  // What counts as rounding beside the mesh is coarser than what tells an exit.
  if (!is_close(way, 0.0, s_.exit_tolerance) && !is_close(0.25 * way, 0.0, 0.0))
    return false;
  const Vec3d back = kept_inside(trial.x) - trial.x;
  const double noise = 4.0 * epsilon * length_of(p_.x);
  return !(back == Vec3d{}) && (is_close(way, h_, s_.exit_tolerance) ||
                                length_of(back) > std::max(good_part * length_of(way), noise));
}

/// A stage of the trial was not inside. False: `factor` of the step may be; else it ends.
template <class M, VelocityField F, class Visit>
bool Integration<M, F, Visit>::give_up(const Trial& trial, double& factor) {
  const bool left = trial.sampled == Sampled::outside;
  closing_in_ = 2;
  ending_ = left ? INSITU_END_LEFT : INSITU_END_NOT_FINITE;
  if constexpr (requires { velocity_.way_out(p_.x, p_.x, h_); }) {
    // The part of the step, straight on, that stays inside, but for what the path may be curved. It
    // is tried once a step; then halves.
    const Vec3d straight = (direction_ * h_) * k1_;
    if (left && factor == 1.0 && !closely_ && std::isfinite(cells_crossed(straight, extent_))) {
      const double part = velocity_.way_out(p_.x, p_.x + straight, time());
      if (part >= 0.0 && is_close(part * straight, part * h_) && exit(p_.x + straight, h_))
        return true;
      if (part > 0.0 && part < 1.0) {
        const double curved = std::clamp(0.1 * part * cells_crossed(straight, extent_), 1e-4, 0.1);
        factor = (1.0 - curved) * part;
        return false;
      }
    }
  }
  factor = 0.5;
  const Vec3d moved = trial.x - p_.x;
  if (!is_close(moved, h_) && 0.5 * h_ != 0.0)
    return false;
  if constexpr (ExitingField<F>)
    if (left) {
      const double dt = speed_ > 0.0 ? std::min(measure(velocity_, p_.x, moved) / speed_, h_) : h_;
      if (!exit(trial.x, dt) && !closely_) {
        closely_ = true;
        return false;
      }
    }
  return true;
}

/// Places the particle where the way to b, which takes dt, leaves the domain, if it does.
template <class M, VelocityField F, class Visit>
bool Integration<M, F, Visit>::exit(const Vec3d& b, double dt) {
  if constexpr (ExitingField<F>) {
    if (const auto exit = velocity_.leave(p_.x, b, time(), direction_ * dt)) {
      p_.length += measure(velocity_, p_.x, exit->inside - p_.x);
      p_.time = time() + direction_ * exit->t * dt;
      p_.x = exit->inside;
      p_.exit_face = exit->face;
      p_.exit_normal = exit->normal;
      return true;
    }
  }
  return false;
}

} // namespace insitu::advect
