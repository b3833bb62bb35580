#include "render/cell_roots.h"

#include <algorithm>
#include <cmath>

#include "cells/decide.h"
#include "cells/kernels.h"
#include "cells/robust_inverse.h"

namespace insitu::render {

namespace {

using math::Vec3d;

constexpr double agreement = 1.0 / 64; // of a cubic with the field, of the values' spread
constexpr int most_halvings = 6;
constexpr double root_tolerance = 1e-11; // of the ray's length in the cell

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

CellRoots::CellRoots(const mesh::CellVertices& cell, const RaySpace& space, double t_near,
                     double t_far)
    : cell_(cell), space_(space), t_near_(t_near) {
  const int n = face_crossings(cell, space, crossings_);
  if (n < 2 || crossings_[n - 1].t < t_near || crossings_[0].t > t_far)
    return;
  extent_ = crossings_[n - 1].t - crossings_[0].t;
  for (int k = 0; k + 1 < n; ++k) {
    const double a = crossings_[k].t, b = crossings_[k + 1].t;
    if (b < t_near || a > t_far)
      continue;
    // More than one way in and out, or an edge met twice: a stretch counts if its middle is inside.
    // One too short to tell does no harm.
    if (n > 2 && b - a > 1e-9 * extent_) {
      const Vec3d middle = space.ray().origin + (0.5 * (a + b)) * space.ray().direction;
      const auto map = cells::inverse_map(cell.shape, cell.x, middle);
      const bool sure = map.converged && map.margin > -1e-9; // Newton may fail in collapsed cells
      if (!sure && cells::decide(cell.shape, cell.x, middle) == cells::Reason::outside)
        continue;
    }
    stretch_[stretches_++] = {k, k + 1};
  }
}

void CellRoots::finish(Point& p) const {
  p.gradient = cells::gradient(cell_.shape, cell_.x, values_, p.parametric);
  p.slope = dot(p.gradient, space_.ray().direction);
}

CellRoots::Point CellRoots::at_crossing(const Crossing& c) const {
  Point p;
  p.t = c.t;
  p.f = c.value(values_) - level_;
  p.parametric = c.parametric(cell_.shape);
  finish(p);
  return p;
}

CellRoots::Point CellRoots::evaluate(double t) {
  ++evaluations_;
  Point p;
  p.t = t;
  const Vec3d x = space_.ray().origin + t * space_.ray().direction;
  const auto map = cells::inverse_map(cell_.shape, cell_.x, x);
  p.parametric =
      map.converged && map.margin > -1e-6 ? map.r : cells::robust_inverse(cell_.shape, cell_.x, x);
  double weights[8];
  cells::shape_functions(cell_.shape, p.parametric, weights);
  // Relative to vertex 0, so that a constant field is constant to the last bit.
  double sum = 0;
  for (int v = 1; v < cell_.count; ++v)
    sum += weights[v] * (values_[v] - values_[0]);
  p.f = (values_[0] - level_) + sum;
  finish(p);
  return p;
}

void CellRoots::find(const double* values, double level,
                     const core::FunctionRef<bool(const LevelHit&)>& found) {
  double low = values[0], high = values[0];
  for (int v = 0; v < cell_.count; ++v) {
    if (std::isnan(values[v]))
      return;
    low = std::min(low, values[v]);
    high = std::max(high, values[v]);
  }
  if (level < low || level > high || !std::isfinite(high - low))
    return;
  values_ = values;
  level_ = level;
  spread_ = high - low;
  found_ = &found;
  for (int s = 0; s < stretches_; ++s) {
    Point a = at_crossing(crossings_[stretch_[s].first]);
    const Point b = at_crossing(crossings_[stretch_[s].last]);
    if (a.t < t_near_)
      a = evaluate(t_near_);
    if (!search(a, b, 0))
      return;
  }
}

bool CellRoots::report(const Point& p) {
  return (*found_)({p.t, p.parametric, p.gradient});
}

// Both ends' sides are settled; the roots strictly between follow.
bool CellRoots::search(const Point& a, const Point& b, int depth) {
  if (cell_.shape == mesh::Shape::tetrahedron || b.t - a.t <= root_tolerance * extent_) {
    if (above(a.f) == above(b.f))
      return true;
    // Linear, in parametric coordinates too.
    const double u = a.f / (a.f - b.f);
    Point root = a;
    root.t = a.t + u * (b.t - a.t);
    root.parametric = (1 - u) * a.parametric + u * b.parametric;
    return report(root);
  }
  const double h = b.t - a.t;
  const double secant = (b.f - a.f) / h;
  const double slope_a = std::isfinite(a.slope) ? a.slope : secant;
  const double slope_b = std::isfinite(b.slope) ? b.slope : secant;
  const Cubic cubic{a.f, a.f + h * slope_a / 3, b.f - h * slope_b / 3, b.f};
  const double low = std::min({cubic.c0, cubic.c1, cubic.c2, cubic.c3});
  const double high = std::max({cubic.c0, cubic.c1, cubic.c2, cubic.c3});
  const double slack = agreement * spread_;
  if (low > spread_ / 4 || high < -spread_ / 4)
    return true; // far away, even for a cubic that is badly off
  const Point m = evaluate(a.t + 0.5 * h);
  const double error = std::fabs(m.f - cubic.at(0.5));
  if (error > slack && depth < most_halvings)
    return search(a, m, depth + 1) && search(m, b, depth + 1);
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
    if (!other_side && std::fabs(predicted) > error / 8 + 1e-12 * spread_)
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

// Newton's method, kept inside a bracket that a bisection halves when it would leave.
bool CellRoots::bracket(Point a, Point b) {
  const double tolerance = root_tolerance * extent_;
  Point p = std::fabs(a.f) < std::fabs(b.f) ? a : b;
  if (p.f == 0.0)
    return report(p);
  double t = a.t + (b.t - a.t) * (a.f / (a.f - b.f));
  for (int i = 0; i < 60; ++i) {
    if (!(t > a.t && t < b.t))
      t = 0.5 * (a.t + b.t);
    if (!(t > a.t && t < b.t))
      break; // neighbouring numbers
    p = evaluate(t);
    if (p.f == 0.0)
      break;
    (above(p.f) == above(a.f) ? a : b) = p;
    const double step = p.slope != 0.0 ? -p.f / p.slope : HUGE_VAL;
    if (std::fabs(step) <= tolerance || b.t - a.t <= tolerance)
      break;
    // Every fourth step a bisection: Newton alone can creep where the slope changes a lot.
    t = i % 4 == 3 ? 0.5 * (a.t + b.t) : p.t + step;
  }
  return report(p);
}

} // namespace insitu::render
