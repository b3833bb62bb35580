#pragma once

#include "advect/integrate/integration.h"

/// Steps that end at the faces of cells, of Integration; included by integration.h alone.
namespace insitu::advect {

template <class M, VelocityField F, class Visit>
bool Integration<M, F, Visit>::confine() {
  // A field may change its coordinates between steps (over a pole); a rate goes along.
  if constexpr (requires { velocity_.settle(p_.x, k1_); })
    velocity_.settle(p_.x, k1_);
  if constexpr (CellwiseField<F>) {
    if (!s_.face_aware || closing_in_ > 0 || free_steps_ > 0) {
      release();
    } else if ((!confined_ && velocity_.confine(p_.x, direction_ * k1_, time())) ||
               (confined_ && entered_)) {
      const bool begins = !confined_;
      confined_ = true;
      entered_ = false;
      if constexpr (requires { velocity_.is_answered(); })
        if (begins && velocity_.is_answered())
          return false;
      ++work_.evaluations;
      return true;
    }
  }
  return false;
}

template <class M, VelocityField F, class Visit>
void Integration<M, F, Visit>::confined(Sampled sampled, const Vec3d& v) {
  if (sampled == Sampled::inside) {
    k1_ = v;
    velocity_.accepted();
  } else {
    release();
  }
}

/// Goes on with whatever cells hold the points.
template <class M, VelocityField F, class Visit>
void Integration<M, F, Visit>::release() {
  if constexpr (CellwiseField<F>) {
    if (!confined_)
      return;
    confined_ = entered_ = false;
    velocity_.release();
  }
}

template <class M, VelocityField F, class Visit>
bool Integration<M, F, Visit>::finish() {
  const bool was_confined = confined_;
  bool stays = false;
  if constexpr (requires { velocity_.stays_in_own(p_.x, p_.time); })
    stays = was_confined && velocity_.stays_in_own(p_.x, p_.time);
  release();
  return was_confined && !stays;
}

/// The first theta in [low, high] at which the path comes to the face of its cell, out of which it
/// is at `high`, by `outside` (negative), the point asked last; negative if it is not in the cell
/// before. As the field knows, or regula falsi with halved ends.
template <class M, VelocityField F, class Visit>
double Integration<M, F, Visit>::way_to_face(const DenseStep& path, double low, double high,
                                             double outside) {
  const auto depth = [&](double theta) {
    return velocity_.depth(path.at(theta), path.start() + theta * path.step());
  };
  if constexpr (requires { velocity_.face_on(path, low, high); })
    if (const double theta = velocity_.face_on(path, low, high); theta >= 0.0)
      return theta;
  double inside = low > 0.0 ? depth(low) : 0.0; // mostly it comes in at 0
  // Where the path comes in, on a face, rounding may say inside: that is not the face it comes to.
  for (int i = 0; i < 20 && !(inside > control::on_face); ++i) {
    const double middle = 0.5 * (low + high), at = depth(middle);
    if (at > control::on_face) {
      low = middle;
      inside = at;
    } else {
      high = middle;
      outside = at;
    }
  }
  if (!(inside > control::on_face))
    return -1.0;
  int side = 0;
  for (int i = 0; i < 60 && high - low > 1e-14 * high; ++i) {
    double theta = (low * outside - high * inside) / (outside - inside);
    if (!(theta > low && theta < high))
      theta = 0.5 * (low + high);
    const double at = depth(theta);
    if (std::abs(at) < 0.1 * control::on_face)
      return theta;
    if (at > 0.0) {
      low = theta;
      inside = at;
      outside *= side == 1 ? 0.5 : 1.0;
      side = 1;
    } else {
      high = theta;
      outside = at;
      inside *= side == -1 ? 0.5 : 1.0;
      side = -1;
    }
  }
  return 0.5 * (low + high);
}

/// A step that ends near a face, in the cell, may have been out of it in between: h becomes the way
/// to the face.
template <class M, VelocityField F, class Visit>
bool Integration<M, F, Visit>::cuts_corner(const Trial& trial) {
  Bracket& bracket = bracket_;
  double& h = h_;
  if (velocity_.last_depth() > 0.25)
    return false;
  const DenseStep path = path_of(trial);
  if constexpr (requires { velocity_.is_inside_before(path); })
    if (velocity_.is_inside_before(path))
      return false;
  for (const double theta : {0.25, 0.5, 0.75}) {
    const double depth = velocity_.depth(path.at(theta), time() + theta * direction_ * h);
    if (depth >= -control::on_face)
      continue;
    const double face = way_to_face(path, 0.0, theta, depth);
    if (face < 0.0 || cells_crossed(face * h * k1_, extent_) < 1e-12)
      return false;
    bracket.inside = 0.0;
    bracket.outside = theta * h;
    ++bracket.landings;
    h *= face;
    return true;
  }
  return false;
}

/// Whether land() has yet to cut the trial short, to its way to the face.
template <class M, VelocityField F, class Visit>
bool Integration<M, F, Visit>::is_beyond_face() {
  if constexpr (CellwiseField<F>)
    return confined_ && bracket_.landings < control::most_landings &&
           velocity_.last_depth() < -control::on_face;
  else
    return false;
}

/// Where a step that could be accepted ends: within the cell; on its face, beyond which the next
/// cell is then the particle's; or too far, when h becomes the way to the face.
template <class M, VelocityField F, class Visit>
typename Integration<M, F, Visit>::Landing Integration<M, F, Visit>::land(Trial& trial) {
  Bracket& bracket = bracket_;
  double& h = h_;
  const double depth = velocity_.last_depth();
  const bool aimed = bracket.landings > 0;
  if (depth > (aimed ? control::on_face : 0.0)) {
    bracket.inside = std::max(bracket.inside, h);
    if (bracket.landings >= control::most_landings)
      return Landing::inside;
    if (!aimed)
      return cuts_corner(trial) ? Landing::again : Landing::inside;
  } else if (depth < -control::on_face) {
    bracket.outside = std::min(bracket.outside, h);
    if (bracket.landings >= control::most_landings && depth < -1e-6) {
      h *= 0.5;
      ++bracket.landings;
      return bracket.landings < 64 ? Landing::again : idle_face() ? Landing::idle : Landing::again;
    }
  }
  if (std::abs(depth) > control::on_face && bracket.landings < control::most_landings) {
    if (M::quintic && depth < 0.0 && relative_error_ <= control::along_extension)
      return land_along(trial);
    const DenseStep path = path_of(trial);
    const double low = std::min(bracket.inside / h, 1.0);
    double high = 1.0, outside = depth;
    if (depth > 0.0) {
      high = std::min(bracket.outside / h, 2.0);
      outside = velocity_.depth(path.at(high), time() + high * direction_ * h);
    }
    const double theta = outside < 0.0 ? way_to_face(path, low, high, outside) : high;
    ++bracket.landings;
    if (theta < 0.0 || cells_crossed(theta * h * k1_, extent_) < 1e-12)
      return idle_face() ? Landing::idle : Landing::again;
    h *= theta;
    return Landing::again;
  }
  return Landing::at_face;
}

/// The trial, out of its cell, becomes its own way to the face.
template <class M, VelocityField F, class Visit>
typename Integration<M, F, Visit>::Landing Integration<M, F, Visit>::land_along(Trial& trial) {
  const DenseStep path = path_of(trial);
  const double theta =
      way_to_face(path, std::min(bracket_.inside / h_, 1.0), 1.0, velocity_.last_depth());
  ++bracket_.landings;
  if (theta < 0.0 || cells_crossed(theta * h_ * k1_, extent_) < 1e-12)
    return idle_face() ? Landing::idle : Landing::again;
  landed_ = path.until(theta);
  h_ *= theta;
  trial.x = landed_->at(1.0);
  trial.v = landed_->rate(1.0) / landed_->step();
  chord_ = measure(velocity_, p_.x, trial.x - p_.x);
  return Landing::at_face;
}

/// The step ends on a face of its cell: the particle is confined to the next cell, whatever it is.
template <class M, VelocityField F, class Visit>
typename Integration<M, F, Visit>::Verdict Integration<M, F, Visit>::enter(Crossed crossed,
                                                                           Trial& trial) {
  if (crossed == Crossed::into_next) {
    idle_faces_ = cells_crossed(trial.x - p_.x, extent_) < 1e-9 ? idle_faces_ + 1 : 0;
    if (idle_faces_ > control::most_idle_faces) {
      idle_faces_ = 0;
      free_steps_ = 1;
    }
    entered_ = true;
    accept(trial);
    return Verdict::done;
  }
  release();
  landed_.reset();
  if (crossed == Crossed::to_boundary) {
    closing_in_ = 2;
    h_ *= 1.0 - 2.0 * control::on_face;
  } else {
    free_steps_ = 1;
  }
  ++work_.rejected;
  return another();
}

/// The particle is on a face and goes out of this cell at once. False: no cell is entered.
template <class M, VelocityField F, class Visit>
bool Integration<M, F, Visit>::idle_face() {
  const Crossed crossed = ++idle_faces_ > control::most_idle_faces
                              ? Crossed::nowhere
                              : velocity_.cross(p_.x, direction_ * k1_, time());
  if (crossed == Crossed::into_next) {
    entered_ = true;
    return true;
  }
  if (crossed == Crossed::nowhere) {
    idle_faces_ = 0;
    free_steps_ = 1;
  }
  release();
  return false;
}

} // namespace insitu::advect
