#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "advect/integrate/settings.h"
#include "mesh/view.h"
#include "query/sampler.h"

/// Fields between two committed steps. At commit n the steps ..., n - 1, n are known and no later
/// one: everything here looks back.
namespace insitu::advect {

/// A field at the steps before the current one, as far as they are known, on the same cells.
struct EarlierSteps {
  /// Of the step before alone; null: nothing is known.
  EarlierSteps(const mesh::FieldView* last = nullptr) : fields(last, last ? 1 : 0) {}
  EarlierSteps(std::span<const mesh::FieldView> fields_, std::span<const double> before_)
      : fields(fields_), before(before_) {}

  std::span<const mesh::FieldView> fields; ///< the latest first: of the interval's beginning
  std::span<const double> before;          ///< the times of fields[1], fields[2], ...
};

/// The times of the last steps, and how much of each of them there is in a field at a time between
/// the last two.
///
/// Slopes are those of the parabola through three steps at uneven distances (Fornberg, Generation
/// of Finite Difference Formulas on Arbitrarily Spaced Grids, Math. Comp. 51, 1988, the case of
/// three points); between the ends, the cubic of Hermite (de Boor, A Practical Guide to Splines,
/// chapter IV). With three steps known, both slopes are of one parabola, and the cubic is it.
class StepTimes {
public:
  /// The interval from t0 to t1, and the times of the steps before t0, the last one first: earlier
  /// times, or later ones where t1 < t0.
  StepTimes(double t0, double t1, std::span<const double> before = {}) : t0_(t0), t1_(t1) {
    // A step that comes close after another one tells the slope badly: to rounding of the values,
    // times the ratio of the intervals.
    double later = t0;
    const double way = t1 < t0 ? -1.0 : 1.0;
    for (const double t : before.first(std::min<std::size_t>(before.size(), most_steps - 2))) {
      if (!(way * (later - t) >= least_ratio * std::abs(t1 - t0)) || later == t)
        break;
      (known_ == 2 ? h1_ : h2_) = later - t;
      later = t;
      ++known_;
    }
  }

  double begin() const { return t0_; }
  double end() const { return t1_; }
  double interval() const { return t1_ - t0_; }

  /// How much of the current step there is in the straight line.
  double alpha(double t) const {
    return t1_ != t0_ ? std::clamp((t - t0_) / (t1_ - t0_), 0.0, 1.0) : 1.0;
  }

  /// Of so many steps of a field, the current one included, those that serve: 1, the current one
  /// alone, to 4.
  int usable(std::size_t steps) const {
    return t1_ != t0_ ? int(std::min<std::size_t>(steps, std::size_t(known_))) : 1;
  }

  /// The weights of the last `steps` steps at time t, the current one's first. At t0 and t1 they
  /// are those of the step there, to the bit. steps: 2 to usable().
  void weights(double t, int steps, double* w) const {
    const double s = alpha(t), rest = 1.0 - s;
    combine(steps, (1.0 + 2.0 * s) * rest * rest, s * rest * rest, s * s * (3.0 - 2.0 * s),
            -s * s * rest, s, rest, w);
  }
  /// Their derivatives with time.
  void rates(double t, int steps, double* w) const {
    const double s = alpha(t), rest = 1.0 - s;
    combine(steps, -6.0 * s * rest, rest * (1.0 - 3.0 * s), 6.0 * s * rest, s * (3.0 * s - 2.0),
            1.0, -1.0, w);
    for (int k = 0; k < steps; ++k)
      w[k] /= interval();
  }

private:
  static constexpr double least_ratio = 1e-3;

  /// h00, h10, h01, h11: Hermite's basis (or its derivative); now, then: the straight line's.
  void combine(int steps, double h00, double h10, double h01, double h11, double now, double then,
               double* w) const {
    if (steps == 2) {
      w[0] = now;
      w[1] = then;
      return;
    }
    // Divided differences: d[0] of the last interval, d[1] and d[2] of those before. Slopes are
    // sums of them; end: at t1, begin: at t0.
    const double h = interval();
    const double end[2] = {(2.0 * h + h1_) / (h + h1_), -h / (h + h1_)};
    double begin[3] = {h1_ / (h + h1_), h / (h + h1_), 0.0};
    if (steps == 4) {
      begin[0] = 0.0;
      begin[1] = (2.0 * h1_ + h2_) / (h1_ + h2_);
      begin[2] = -h1_ / (h1_ + h2_);
    }
    const double d0 = h10 * begin[0] + h11 * end[0];
    const double d1 = (h10 * begin[1] + h11 * end[1]) * (h / h1_);
    w[0] = h01 + d0;
    w[1] = h00 - d0 + d1;
    w[2] = -d1;
    if (steps == 4) {
      const double d2 = h10 * begin[2] * (h / h2_);
      w[2] += d2;
      w[3] = -d2;
    }
  }

  double t0_, t1_;
  double h1_ = 0.0, h2_ = 0.0; ///< the intervals before, of the same sign
  int known_ = 2;              ///< steps
};

/// A field of the current step and, as far as they are known, of the steps before, the latest
/// first, all on the same cells.
struct FieldInTime {
  mesh::FieldView now;
  std::vector<mesh::FieldView> earlier;

  /// Component values at a place, on the straight line in time. At most three components.
  void blended(const query::Sampler& sampler, const query::Location& at, double alpha,
               double* out) const {
    sampler.interpolate(now, at, out);
    if (earlier.empty() || alpha == 1.0)
      return;
    double then[3];
    sampler.interpolate(earlier[0], at, then);
    for (int c = 0; c < now.components; ++c)
      out[c] = (1.0 - alpha) * then[c] + alpha * out[c];
  }

  /// The same, interpolated through all the steps there are.
  void value(const query::Sampler& sampler, const query::Location& at, const StepTimes& times,
             double t, double* out) const {
    const int steps = times.usable(1 + earlier.size());
    if (steps <= 2)
      return blended(sampler, at, times.alpha(t), out);
    double w[most_steps], u[3];
    times.weights(t, steps, w);
    sampler.interpolate(now, at, out);
    for (int c = 0; c < now.components; ++c)
      out[c] *= w[0];
    for (int k = 1; k < steps; ++k) {
      sampler.interpolate(earlier[std::size_t(k - 1)], at, u);
      for (int c = 0; c < now.components; ++c)
        out[c] += w[k] * u[c];
    }
  }
};

} // namespace insitu::advect
