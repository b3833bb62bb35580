#include <algorithm>
#include <cmath>

#include "render/surface/cell_roots.h"

namespace insitu::render {

namespace {

constexpr double agreement = 1.0 / 64; // of a cubic with the field, of the values' spread
constexpr int most_halvings = 6;

bool above(double f) {
  return f >= 0.0;
}

/// A cubic on [0, 1] in Bernstein form.
struct Cubic {
  double c0, c1, c2, c3;
  double at(double u) const {
    const double w = 1 - u;
    return w * w * (w * c0 + 3 * u * c1) + u * u * (3 * w * c2 + u * c3);
  }
  /// Extrema strictly inside, ascending; returns how many.
  int extrema(double (&u)[2]) const {
    // The derivative, over 3: d0 (1-u)^2 + 2 d1 u (1-u) + d2 u^2.
    const double d0 = c1 - c0, d1 = c2 - c1, d2 = c3 - c2;
    const double a = d0 - 2 * d1 + d2, b = d1 - d0; // a u^2 + 2 b u + d0
    const double discriminant = b * b - a * d0;
    if (!(discriminant > 0))
      return 0;
    const double s = -(b + std::copysign(std::sqrt(discriminant), b));
    int n = 0;
    for (const double root : {s != 0 ? d0 / s : -1.0, a != 0 ? s / a : -1.0})
      if (root > 0 && root < 1)
        u[n++] = root;
    if (n == 2 && u[0] > u[1])
      std::swap(u[0], u[1]);
    return n;
  }
};

} // namespace

bool CellRoots::track(const Point& a, const Point& b, int depth) {
  if (is_linear(a, b))
    return report_linear(a, b);
  const double h = b.t - a.t;
  const double secant = (b.f - a.f) / h;
  const double slope_a = std::isfinite(a.slope) ? a.slope : secant;
  const double slope_b = std::isfinite(b.slope) ? b.slope : secant;
  const Cubic cubic{a.f, a.f + h * slope_a / 3, b.f - h * slope_b / 3, b.f};
  const double low = std::min({cubic.c0, cubic.c1, cubic.c2, cubic.c3});
  const double high = std::max({cubic.c0, cubic.c1, cubic.c2, cubic.c3});
  const double slack = agreement * span_;
  if (low > span_ / 4 || high < -span_ / 4)
    return true; // far away, even for a cubic that is badly off
  const Point m = evaluate(a.t + 0.5 * h);
  const double error = std::fabs(m.f - cubic.at(0.5));
  if (error > slack && depth < most_halvings)
    return track(a, m, depth + 1) && track(m, b, depth + 1);
  return search_cubic(a, m, error) && search_cubic(m, b, error);
}

bool CellRoots::search_cubic(const Point& a, const Point& b, double error) {
  const double h = b.t - a.t;
  const double secant = (b.f - a.f) / h;
  const double slope_a = std::isfinite(a.slope) ? a.slope : secant;
  const double slope_b = std::isfinite(b.slope) ? b.slope : secant;
  const Cubic cubic{a.f, a.f + h * slope_a / 3, b.f - h * slope_b / 3, b.f};
  double u[2];
  const int extrema = cubic.extrema(u);
  Point from = a;
  for (int k = 0; k < extrema; ++k) {
    const double predicted = cubic.at(u[k]);
    const bool other_side = above(predicted) != above(from.f);
    // Half the interval leaves a sixteenth of the error; twice that is doubted.
    if (!other_side && std::fabs(predicted) > error / 8 + 1e-12 * span_)
      continue;
    const Point p = evaluate(a.t + u[k] * h);
    if (above(p.f) == above(from.f))
      continue;
    if (!bracket(from, p))
      return false;
    from = p;
  }
  return above(from.f) == above(b.f) || bracket(from, b);
}

} // namespace insitu::render
