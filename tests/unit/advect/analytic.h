#pragma once

#include <cmath>
#include <limits>

#include "advect/integrate/integrate.h"

namespace insitu::test {

using advect::Sampled;
using math::Vec3d;

/// A velocity given by a formula, on the box [low, high] of cells of one size.
template <class F>
struct Analytic {
  F f;
  Vec3d low{-inf, -inf, -inf};
  Vec3d high{inf, inf, inf};
  Vec3d cell{inf, inf, inf};
  static constexpr double inf = std::numeric_limits<double>::infinity();
  long asked = 0;

  Sampled operator()(const Vec3d& x, double t, Vec3d& v) {
    ++asked;
    for (int a = 0; a < 3; ++a)
      if (!(x[a] >= low[a] && x[a] <= high[a]))
        return Sampled::outside;
    v = f(x, t);
    return std::isfinite(v.x + v.y + v.z) ? Sampled::inside : Sampled::not_finite;
  }
  void accepted() {}
  Vec3d extent() const { return cell; }
};

template <class F>
Analytic<F> unbounded(F f) {
  return {f};
}

/// On the unit cube, in cells of a tenth.
template <class F>
Analytic<F> in_unit_cube(F f) {
  return {f, {0, 0, 0}, {1, 1, 1}, {0.1, 0.1, 0.1}};
}

inline Vec3d rotation(const Vec3d& x, double) {
  return {-x.y, x.x, 0.0};
}

/// A rigid rotation about z, and where it takes x.
inline Vec3d turn(const Vec3d& x) {
  return {-x.y, x.x, 0.0};
}
inline Vec3d turned(const Vec3d& x, double angle) {
  return {std::cos(angle) * x.x - std::sin(angle) * x.y,
          std::sin(angle) * x.x + std::cos(angle) * x.y, x.z};
}

/// The flow of Arnold, Beltrami and Childress with A = sqrt 3, B = sqrt 2, C = 1, the amplitude of
/// which grows with time.
inline Vec3d abc_flow(const Vec3d& x, double t) {
  const double a = std::sqrt(3.0) + 0.5 * t * std::sin(M_PI * t), b = std::sqrt(2.0), c = 1.0;
  return {a * std::sin(x.z) + c * std::cos(x.y), b * std::sin(x.x) + a * std::cos(x.z),
          c * std::sin(x.y) + b * std::cos(x.x)};
}

/// Runs integrate() and keeps what came out of it.
struct Outcome {
  advect::State p;
  advect::Work work;
  insitu_ending ending = INSITU_END_COUNT;
};

template <class F>
Outcome run(F& field, const advect::IntegratorSettings& settings, const Vec3d& seed, double to,
            double max_length = std::numeric_limits<double>::infinity(), double from = 0.0) {
  Outcome r;
  r.p.x = seed;
  r.p.time = from;
  r.ending =
      advect::integrate(field, settings, to, max_length, r.p, r.work, [](const advect::State&) {});
  return r;
}

inline double distance(const Vec3d& a, const Vec3d& b) {
  return advect::length_of(a - b);
}

} // namespace insitu::test
