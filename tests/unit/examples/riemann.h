#pragma once

#include <array>
#include <cmath>

/// The exact solution of Riemann's problem for an ideal gas at rest on both sides of x = 0:
/// density, velocity, pressure at x / t. As in E. Toro, Riemann Solvers, chapter 4; no vacuum.
class Riemann {
public:
  struct State {
    double density, velocity, pressure;
  };
  Riemann(State left, State right, double gamma) : left_(left), right_(right), g_(gamma) {
    double low = 0.0, high = 100.0 * std::fmax(left.pressure, right.pressure);
    for (int i = 0; i < 200; ++i) { // what both waves do to the velocity, together, falls to 0
      p_ = 0.5 * (low + high);
      (change(left_) + change(right_) + right_.velocity - left_.velocity < 0.0 ? low : high) = p_;
    }
    u_ = 0.5 * (left_.velocity + right_.velocity + change(right_) - change(left_));
  }

  State at(double s) const {
    if (s < u_)
      return side(left_, s);
    State mirrored = side({right_.density, -right_.velocity, right_.pressure}, -s, -u_);
    mirrored.velocity = -mirrored.velocity;
    return mirrored;
  }

private:
  double sound(const State& w) const { return std::sqrt(g_ * w.pressure / w.density); }
  /// Of the velocity, over the wave between w and the contact's pressure.
  double change(const State& w) const {
    if (p_ > w.pressure)
      return (p_ - w.pressure) * std::sqrt(2.0 / ((g_ + 1.0) * w.density) /
                                           (p_ + (g_ - 1.0) / (g_ + 1.0) * w.pressure));
    return 2.0 * sound(w) / (g_ - 1.0) * (std::pow(p_ / w.pressure, (g_ - 1.0) / (2.0 * g_)) - 1.0);
  }
  State side(const State& w, double s) const { return side(w, s, u_); }
  /// Left of the contact.
  State side(const State& w, double s, double u) const {
    const double c = sound(w), ratio = p_ / w.pressure, k = (g_ - 1.0) / (g_ + 1.0);
    if (p_ > w.pressure) {
      const double shock =
          w.velocity - c * std::sqrt((g_ + 1.0) / (2.0 * g_) * ratio + (g_ - 1.0) / (2.0 * g_));
      return s < shock ? w : State{w.density * (ratio + k) / (k * ratio + 1.0), u, p_};
    }
    const double c_star = c * std::pow(ratio, (g_ - 1.0) / (2.0 * g_));
    if (s < w.velocity - c)
      return w;
    if (s > u - c_star)
      return {w.density * std::pow(ratio, 1.0 / g_), u, p_};
    const double f = 2.0 / (g_ + 1.0) + k / c * (w.velocity - s);
    return {w.density * std::pow(f, 2.0 / (g_ - 1.0)),
            2.0 / (g_ + 1.0) * (c + 0.5 * (g_ - 1.0) * w.velocity + s),
            w.pressure * std::pow(f, 2.0 * g_ / (g_ - 1.0))};
  }

  State left_, right_;
  double g_, p_ = 0.0, u_ = 0.0;
};
