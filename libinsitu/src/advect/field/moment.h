#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include "advect/integrate/fields.h"
#include "advect/integrate/in_time.h"
#include "math/vec.h"
#include "mesh/view.h"
#include "query/sampler.h"

namespace insitu::advect {

/// The velocity and the geometry of a mesh at one moment between two committed steps. At time t,
/// with alpha = (t - t0) / (t1 - t0) in [0, 1], vertices are at (1 - alpha) earlier + alpha current
/// coordinates, and the velocity is interpolated through the steps that are given: (1 - alpha)
/// earlier + alpha current velocity through two (TimeInterpolation says what through more). A part
/// of which there is no earlier state is taken as it is now.
class Moment {
public:
  /// What the arguments refer to must outlive the object. The moment is that of the current step
  /// until set() is called.
  Moment(const query::Sampler& sampler, const mesh::FieldView& now, const EarlierSteps& earlier,
         double t0, double t1, insitu_accuracy accuracy);

  void set(double t) {
    alpha_ = times_.alpha(t);
    if (steps_ > 2)
      times_.weights(t, steps_, weights_);
  }

  /// What set() has found, in plain data.
  struct Kept {
    double alpha, weights[most_steps];
  };
  Kept keep() const {
    Kept kept{alpha_, {}};
    std::copy_n(weights_, most_steps, kept.weights);
    return kept;
  }
  void go_on_from(const Kept& kept) {
    alpha_ = kept.alpha;
    std::copy_n(kept.weights, most_steps, weights_);
  }

  /// How much of the current step there is in the velocity through two steps.
  double alpha() const { return alpha_; }
  /// How much of the current step there is in the geometry: 1 if nothing moved.
  double geometry_alpha() const { return moves_ ? alpha_ : 1.0; }
  /// What alpha() and geometry_alpha() are at another time.
  double alpha_at(double t) const { return times_.alpha(t); }
  double geometry_alpha_at(double t) const { return moves_ ? times_.alpha(t) : 1.0; }
  /// The weights of more than two steps, the current one's first.
  const double* weights() const { return weights_; }

  const query::Sampler& sampler() const { return *sampler_; }
  const mesh::MeshView& mesh() const { return sampler_->mesh(); }
  const StepTimes& times() const { return times_; }
  insitu_accuracy accuracy() const { return accuracy_; }
  /// The steps through which the velocity is interpolated, from 1, which is the current one alone.
  int steps() const { return steps_; }
  const mesh::FieldView& field(int step) const { return fields_[step]; }
  /// Of the velocity: 3, or 2 on a flat mesh, whatever the field has.
  int components() const { return fields_[0].components; }
  bool is_by_cell() const { return fields_[0].association == INSITU_CELL; }
  /// Whether the vertices move between the steps.
  bool moves() const { return moves_; }

  query::LocateOptions options() const { return {accuracy_, geometry_alpha()}; }
  query::Location locate(const math::Vec3d& x, std::int64_t hint) const {
    return sampler_->locate(x, hint, options());
  }

  /// The velocity of the moment, from that of each step. Returns whether it is finite.
  template <class OfStep>
  Sampled blend(OfStep&& of_step, math::Vec3d& v) const {
    v = blended(of_step);
    return is_finite(v) ? Sampled::inside : Sampled::not_finite;
  }
  /// The velocity of the moment at a place, by the sampler. Returns whether it is finite.
  Sampled interpolate(const query::Location& at, math::Vec3d& v) const;

  /// The gradient of a component at a place and time, and the change with time of the velocity at
  /// a place in a cell (0 if the earlier velocity is unknown).
  math::Vec3d gradient(const query::Location& at, int component, double t) const;
  math::Vec3d rate_of_change(const query::Location& at, double t) const;

  static bool is_finite(const math::Vec3d& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
  }

private:
  template <class OfStep>
  math::Vec3d blended(OfStep& of_step) const {
    if (steps_ == 1)
      return of_step(0);
    if (steps_ == 2)
      return (1.0 - alpha_) * of_step(1) + alpha_ * of_step(0);
    math::Vec3d v = weights_[0] * of_step(0);
    for (int step = 1; step < steps_; ++step)
      v += weights_[step] * of_step(step);
    return v;
  }
  /// The velocity of a step, of the components of all steps.
  math::Vec3d at_step(const double* values, int step) const;
  std::span<const mesh::FieldView> fields() const { return {fields_, std::size_t(steps_)}; }

  const query::Sampler* sampler_;
  mesh::FieldView fields_[most_steps]; ///< at each step, the current one first
  StepTimes times_;
  int steps_; ///< of fields_, that serve
  bool moves_;
  insitu_accuracy accuracy_;
  double alpha_ = 1.0;
  double weights_[most_steps] = {}; ///< of the moment, through more than two steps
};

} // namespace insitu::advect
