#include "sedov_taylor.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

// L. I. Sedov, Similarity and Dimensional Methods in Mechanics (1959), chapter IV; L. D. Landau
// and E. M. Lifshitz, Fluid Mechanics, section 106; for the quantities and their known values,
// J. R. Kamm and F. X. Timmes, On Efficient Generation of Numerically Robust Sedov Solutions,
// LA-UR-07-2849 (2007).
//
// With l = r / R, velocity R' l V, density D and pressure R'^2 P (in units of the density ahead)
// and R R'' / R'^2 = -3/2, the Euler equations are, with s = ln l,
//   continuity  (1 - V) d ln D = dV + 3 V ds
//   entropy     (1 - V) (d ln P - gamma d ln D) = -3 ds
// and the energy inside any l is constant in time, which gives the squared sound speed over
// (R' l)^2 as z = gamma (gamma - 1) (1 - V) V^2 / (2 (gamma V - 1)), P = D l^2 z / gamma.
// Eliminating D and P leaves ds/dV as a function of V alone. V falls from 2 / (gamma + 1) at the
// shock to 1 / gamma at the centre; in w = ln(gamma V - 1) every derivative is smooth, so s and ln
// D are two quadratures in w. Nothing here is special at gamma = 2, where the closed form has 0/0.

namespace sedov {

SedovTaylor::SedovTaylor(double gamma, double energy, double density)
    : gamma_(gamma), energy_(energy), density_(density) {
  if (!(gamma > 1.0 && gamma < 7.0))
    throw std::invalid_argument("Sedov-Taylor: 1 < gamma < 7 expected, " + std::to_string(gamma) +
                                " given");
  if (!(energy > 0.0 && density > 0.0))
    throw std::invalid_argument("Sedov-Taylor: the energy and the density must be positive");

  struct Rates { // d / dw
    double log_radius, log_density, speed;
  };
  const auto speed = [=](double w) { return (1.0 + std::exp(w)) / gamma; };
  const auto rates = [=](double w) -> Rates {
    const double y = std::exp(w), v = speed(w), dv = y / gamma;
    const double ds = (y * (2.0 * (1.0 - v) / v - gamma) - gamma * (1.0 - v)) /
                      (gamma * ((3.0 * gamma - 1.0) * v - 5.0));
    return {ds, (dv + 3.0 * v * ds) / (1.0 - v), dv};
  };
  const auto log_pressure = [=](double w, double s, double d) {
    const double v = speed(w);
    return d + 2.0 * s + std::log(0.5 * (gamma - 1.0) * (1.0 - v) * v * v) - w;
  };
  const auto energy_rate = [=](double w, double s, double d, double ds) { // l^2 (...) dl/dw
    const double l = std::exp(s), u = speed(w) * l;
    return l * l * l * ds *
           (0.5 * std::exp(d) * u * u + std::exp(log_pressure(w, s, d)) / (gamma - 1.0));
  };
  const auto simpson = [](double h, double first, double middle, double last) {
    return h / 6.0 * (first + 4.0 * middle + last);
  };

  // Inwards to l = innermost, where s is linear in w; Simpson's rule over each step.
  constexpr int steps = 8000;
  constexpr double innermost = 1e-4;
  const double first = std::log((gamma - 1.0) / (gamma + 1.0));
  const double core_slope = (gamma - 1.0) / (2.0 * gamma + 1.0); // ds/dw at the centre
  const double step = std::log(innermost) / core_slope / steps;
  double s = 0.0, d = std::log((gamma + 1.0) / (gamma - 1.0)), integral = 0.0;
  for (int i = 0;; ++i) {
    const double w = first + i * step, v = speed(w);
    const Rates r0 = rates(w);
    const double pressure_rate =
        r0.log_density + 2.0 * r0.log_radius - 1.0 + r0.speed * (2.0 / v - 1.0 / (1.0 - v));
    profile_.push_back({s, d, log_pressure(w, s, d), v, r0.log_density / r0.log_radius,
                        pressure_rate / r0.log_radius, r0.speed / r0.log_radius});
    if (i == steps)
      break;
    // The middle values by the same rule on the step's first half.
    const Rates r1 = rates(w + 0.25 * step), r2 = rates(w + 0.5 * step), r4 = rates(w + step);
    const double s2 = s + simpson(0.5 * step, r0.log_radius, r1.log_radius, r2.log_radius);
    const double d2 = d + simpson(0.5 * step, r0.log_density, r1.log_density, r2.log_density);
    const double s4 = s + simpson(step, r0.log_radius, r2.log_radius, r4.log_radius);
    const double d4 = d + simpson(step, r0.log_density, r2.log_density, r4.log_density);
    integral -= simpson(step, energy_rate(w, s, d, r0.log_radius),
                        energy_rate(w + 0.5 * step, s2, d2, r2.log_radius),
                        energy_rate(w + step, s4, d4, r4.log_radius));
    s = s4;
    d = d4;
  }
  // The core inside is empty and of uniform pressure.
  integral += std::exp(3.0 * s + profile_.back().log_pressure) / (3.0 * (gamma - 1.0));
  // energy = 4 pi density R'^2 R^3 integral, and R' = 2 R / (5 t).
  alpha_ = 16.0 * std::numbers::pi / 25.0 * integral;
}

double SedovTaylor::shock_radius(double time) const {
  return std::pow(energy_ * time * time / (alpha_ * density_), 0.2);
}

double SedovTaylor::shock_time(double radius) const {
  return std::sqrt(alpha_ * density_ * std::pow(radius, 5.0) / energy_);
}

SedovTaylor::State SedovTaylor::at(double radius, double time) const {
  const double shock = shock_radius(time), shock_speed = 0.4 * shock / time;
  if (radius > shock)
    return {density_, 0.0, 0.0};
  const double s = std::log(radius / shock);
  double density = 0.0, pressure = std::exp(profile_.back().log_pressure), speed = 1.0 / gamma_;
  if (s >= profile_.back().log_radius) { // else in the core
    const auto b =
        std::lower_bound(profile_.begin() + 1, profile_.end() - 1, s,
                         [](const Entry& entry, double at) { return entry.log_radius > at; });
    const auto a = b - 1;
    const double h = b->log_radius - a->log_radius, t = (s - a->log_radius) / h, r = 1.0 - t;
    const auto hermite = [&](double Entry::*value, double Entry::*slope) { // cubic
      return r * r * ((1.0 + 2.0 * t) * (*a).*value + t * h * (*a).*slope) +
             t * t * ((1.0 + 2.0 * r) * (*b).*value - r * h * (*b).*slope);
    };
    density = std::exp(hermite(&Entry::log_density, &Entry::density_slope));
    pressure = std::exp(hermite(&Entry::log_pressure, &Entry::pressure_slope));
    speed = hermite(&Entry::speed, &Entry::speed_slope);
  }
  return {density_ * density, density_ * shock_speed * shock_speed * pressure,
          shock_speed * speed * radius / shock};
}

} // namespace sedov
