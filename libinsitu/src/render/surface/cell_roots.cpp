#include "render/surface/cell_roots.h"

#include <algorithm>
#include <cmath>

#include "cells/exact/decide.h"
#include "cells/exact/robust_inverse.h"
#include "cells/kernels/kernels.h"

namespace insitu::render {

namespace {

using math::Vec3d;

constexpr int most_halvings = 20;
/// Where the path through the cell cannot be bounded: it folds or collapses there.
constexpr int most_halvings_of_folds = 6;
/// Of a stretch. A root of order two takes about two for each halving; more takes a ray that runs
/// along the surface.
constexpr int most_parts = 64;
constexpr double flat = 1e-10;           // of the values' spread: as good as on the level
constexpr double root_tolerance = 1e-11; // of the ray's length in the cell

bool above(double f) {
  return f >= 0.0;
}

bool on_edge(const cells::Crossing& c) {
  constexpr double none = 1e-9;
  return std::any_of(c.weights, c.weights + c.count, [](double w) { return w <= none; });
}

} // namespace

CellRoots::CellRoots(const mesh::CellVertices& cell, const cells::RaySpace& space, double t_near,
                     double t_far)
    : cell_(cell), space_(space), t_near_(t_near) {
  const int n = cells::face_crossings(cell, space, crossings_);
  if (n < 2 || crossings_[n - 1].t < t_near || crossings_[0].t > t_far)
    return;
  extent_ = crossings_[n - 1].t - crossings_[0].t;
  for (int k = 0; k + 1 < n; ++k) {
    const double a = crossings_[k].t, b = crossings_[k + 1].t;
    if (b < t_near || a > t_far)
      continue;
    // More than one way in and out, or an edge met twice: a stretch counts if its middle is inside.
    // So too between two edges, where a curved face may lie in between. One too short to tell does
    // no harm.
    if ((n > 2 || (on_edge(crossings_[k]) && on_edge(crossings_[k + 1]))) &&
        b - a > 1e-9 * extent_) {
      const Vec3d middle = space.ray().origin + (0.5 * (a + b)) * space.ray().direction;
      const auto map = cells::inverse_map(cell.shape, cell.x, middle);
      const bool sure = map.converged && map.margin > -1e-9; // Newton may fail in collapsed cells
      if (!sure && !cells::decide(cell.shape, cell.x, middle))
        continue;
    }
    stretch_[stretches_++] = {k, k + 1};
  }
}

void CellRoots::finish(Point& p) const {
  p.gradient = cells::gradient(cell_.shape, cell_.x, values_, p.parametric);
  p.slope = dot(p.gradient, space_.ray().direction);
}

CellRoots::Point CellRoots::at_crossing(const cells::Crossing& c) const {
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
  p.f = std::clamp((values_[0] - level_) + sum, low_ - level_, high_ - level_);
  finish(p);
  return p;
}

void CellRoots::find(const double* values, double level,
                     const core::FunctionRef<bool(const LevelHit&)>& found, RootSearch how) {
  double low = values[0], high = values[0];
  for (int v = 0; v < cell_.count; ++v) {
    if (std::isnan(values[v]))
      return;
    low = std::min(low, values[v]);
    high = std::max(high, values[v]);
  }
  if (level <= low || level > high || !std::isfinite(high - low))
    return; // all of the cell is on one side
  values_ = values;
  level_ = level;
  low_ = low;
  high_ = high;
  span_ = high - low;
  spread_ = std::max(high - level, level - low);
  bounds_are_set_ = false;
  found_ = &found;
  for (int s = 0; s < stretches_; ++s) {
    Point a = at_crossing(crossings_[stretch_[s].first]);
    const Point b = at_crossing(crossings_[stretch_[s].last]);
    if (a.t < t_near_)
      a = evaluate(t_near_);
    parts_ = 0;
    if (!(how == RootSearch::cubic   ? track(a, b, 0)
          : how == RootSearch::exact ? search(a, b, 0)
                                     : search_twice(a, b)))
      return;
  }
}

bool CellRoots::report(const Point& p) {
  return (*found_)({p.t, p.parametric, p.gradient});
}

bool CellRoots::is_linear(const Point& a, const Point& b) const {
  return cell_.shape == mesh::Shape::tetrahedron || b.t - a.t <= root_tolerance * extent_;
}

bool CellRoots::report_linear(const Point& a, const Point& b) {
  if (above(a.f) == above(b.f))
    return true;
  // In parametric coordinates too.
  const double u = a.f / (a.f - b.f);
  Point root = a;
  root.t = a.t + u * (b.t - a.t);
  root.parametric = (1 - u) * a.parametric + u * b.parametric;
  return report(root);
}

// Both ends' sides are settled; the roots strictly between follow.
bool CellRoots::search(const Point& a, const Point& b, int depth) {
  if (is_linear(a, b))
    return report_linear(a, b);
  if (!bounds_)
    bounds_.emplace(cell_, space_);
  if (!bounds_are_set_)
    bounds_->set_values(values_, level_);
  bounds_are_set_ = true;
  const PathBounds::Known known = (*bounds_)(a.parametric, b.parametric, b.t - a.t);
  const bool changes = above(a.f) != above(b.f);
  if (known.path && !changes && (known.monotone || known.field.low > 0 || known.field.high < 0))
    return true;
  const bool is_flat =
      known.path && known.field.low >= -flat * spread_ && known.field.high <= flat * spread_;
  if ((known.path && known.monotone) || is_flat || ++parts_ > most_parts ||
      depth >= (known.path ? most_halvings : most_halvings_of_folds))
    return !changes || bracket(a, b);
  const Point m = evaluate(a.t + 0.5 * (b.t - a.t));
  return search(a, m, depth + 1) && search(m, b, depth + 1);
}

bool CellRoots::search_twice(Point a, Point b) {
  if (above(a.f) == above(b.f))
    return true;
  const auto secant = [&] {
    const double t = a.t + (b.t - a.t) * (a.f / (a.f - b.f));
    return std::clamp(t, a.t, b.t);
  };
  const Point p = evaluate(secant());
  (above(p.f) == above(a.f) ? a : b) = p;
  return report(evaluate(secant()));
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
