#include "render/path/path_bounds.h"

#include <algorithm>
#include <cmath>

#include "cells/kernels/kernels.h"

namespace insitu::render {

namespace {

using math::Vec3d;

constexpr double rounding = 1e-12; // of magnitudes; some thousand roundings

Bounds operator+(const Bounds& a, const Bounds& b) {
  return {a.low + b.low, a.high + b.high};
}
Bounds operator-(const Bounds& a, const Bounds& b) {
  return {a.low - b.high, a.high - b.low};
}
Bounds operator*(const Bounds& a, const Bounds& b) {
  const double p = a.low * b.low, q = a.low * b.high, r = a.high * b.low, s = a.high * b.high;
  return {std::min(std::min(p, q), std::min(r, s)), std::max(std::max(p, q), std::max(r, s))};
}

Bounds widened(const Bounds& a) {
  const double by = rounding * std::max(std::fabs(a.low), std::fabs(a.high));
  return {a.low - by, a.high + by};
}

Bounds widened(const Bounds& a, double by) {
  return {a.low - by, a.high + by};
}

double largest(const Bounds& a) {
  return std::max(std::fabs(a.low), std::fabs(a.high));
}

/// The determinant of three rows, and what its terms may lose by rounding.
Bounds determinant(const Bounds (&a)[3], const Bounds (&b)[3], const Bounds (&c)[3]) {
  const Bounds m[3] = {b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2],
                       b[0] * c[1] - b[1] * c[0]};
  double size = 0;
  for (int k = 0; k < 3; ++k)
    size += largest(a[k]) * (largest(b[(k + 1) % 3]) * largest(c[(k + 2) % 3]) +
                             largest(b[(k + 2) % 3]) * largest(c[(k + 1) % 3]));
  return widened(a[0] * m[0] + a[1] * m[1] + a[2] * m[2], rounding * size);
}

} // namespace

PathBounds::PathBounds(const mesh::CellVertices& cell, const cells::RaySpace& space)
    : shape_(cell.shape), count_(cell.count) {
  for (int k = 0; k < 8; ++k)
    cells::shape_functions(shape_, Vec3d{double(k & 1), double(k >> 1 & 1), double(k >> 2)},
                           weights_[k]);
  double q[3][8];
  for (int v = 0; v < count_; ++v) {
    const Vec3d p = space(cell.x[v]);
    for (int a = 0; a < 3; ++a)
      q[a][v] = p[a];
  }
  spread(q[0], x_);
  spread(q[1], y_);
  spread(q[2], z_);
}

void PathBounds::spread(const double* at_vertices, Corners& out) const {
  for (int k = 0; k < 8; ++k) {
    out[k] = at_vertices[0]; // relative to it, so that a constant field stays one
    for (int v = 1; v < count_; ++v)
      out[k] += weights_[k][v] * (at_vertices[v] - at_vertices[0]);
  }
}

void PathBounds::set_values(const double* values, double level) {
  double relative[8];
  for (int v = 0; v < count_; ++v)
    relative[v] = values[v] - level;
  spread(relative, f_);
}

Bounds PathBounds::range(const Corners& f, const Box& box) const {
  Bounds all{HUGE_VAL, -HUGE_VAL};
  double size = 0;
  for (int k = 0; k < 8; ++k) {
    const double r = k & 1 ? box.high.x : box.low.x, s = k & 2 ? box.high.y : box.low.y,
                 t = k & 4 ? box.high.z : box.low.z;
    const double f00 = f[0] + r * (f[1] - f[0]), f10 = f[2] + r * (f[3] - f[2]),
                 f01 = f[4] + r * (f[5] - f[4]), f11 = f[6] + r * (f[7] - f[6]);
    const double f0 = f00 + s * (f10 - f00), f1 = f01 + s * (f11 - f01);
    const double value = f0 + t * (f1 - f0);
    all = {std::min(all.low, value), std::max(all.high, value)};
    size = std::max(size, std::fabs(f[k]));
  }
  return widened(all, rounding * size);
}

void PathBounds::derivatives(const Corners& f, const Box& box, Bounds (&d)[3]) const {
  for (int axis = 0; axis < 3; ++axis) {
    const int step = 1 << axis, b = (axis + 1) % 3, c = (axis + 2) % 3;
    const int sb = 1 << b, sc = 1 << c;
    const double e00 = f[step] - f[0], e10 = f[step + sb] - f[sb], e01 = f[step + sc] - f[sc],
                 e11 = f[step + sb + sc] - f[sb + sc];
    d[axis] = {HUGE_VAL, -HUGE_VAL};
    for (int k = 0; k < 4; ++k) {
      const double u = k & 1 ? box.high[b] : box.low[b], v = k & 2 ? box.high[c] : box.low[c];
      const double e0 = e00 + u * (e10 - e00), e1 = e01 + u * (e11 - e01);
      const double e = e0 + v * (e1 - e0);
      d[axis] = {std::min(d[axis].low, e), std::max(d[axis].high, e)};
    }
    d[axis] = widened(d[axis]);
  }
}

/// Bounds of the path's direction in parametric space; false where the cell may fold.
bool PathBounds::path_rates(const Box& box, const Bounds (&dx)[3], const Bounds (&dy)[3],
                            Bounds (&rates)[3]) const {
  Bounds dz[3];
  derivatives(z_, box, dz);
  const Bounds det = determinant(dx, dy, dz);
  if (det.has_zero() || !std::isfinite(det.low) || !std::isfinite(det.high))
    return false;
  const Bounds inverse{1 / det.high, 1 / det.low};
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    const Bounds p = dx[b] * dy[c], q = dx[c] * dy[b];
    rates[a] = widened(p - q, rounding * (largest(p) + largest(q))) * inverse;
  }
  return true;
}

PathBounds::Known PathBounds::operator()(const Vec3d& from, const Vec3d& to, double length) const {
  Known known;
  Box hull;
  for (int a = 0; a < 3; ++a) {
    hull.low[a] = std::min(from[a], to[a]);
    hull.high[a] = std::max(from[a], to[a]);
  }
  // A trial box that is wider than the ends' by as much as the cell's curvature may bend the path:
  // first little, as in cells that are nearly parallelepipeds.
  Bounds dx[3], dy[3], rates[3];
  const auto direct = [&](const Box& box) {
    derivatives(x_, box, dx);
    derivatives(y_, box, dy);
    return path_rates(box, dx, dy, rates);
  };
  Box box;
  double widths[3] = {};
  for (int a = 0; a < 3; ++a)
    widths[a] = hull.high[a] - hull.low[a];
  const double widest = std::max({widths[0], widths[1], widths[2]});
  constexpr double wider[] = {0.05, 0.3};
  for (const double part : wider) {
    for (int a = 0; a < 3; ++a) {
      const double by = part * (0.5 * widths[a] + 0.5 * widest) + 1e-9;
      box.low[a] = hull.low[a] - by;
      box.high[a] = hull.high[a] + by;
    }
    if (!direct(box))
      return known;
    // The path from `from` forwards and from `to` backwards is in both.
    Box reached;
    bool inside = true;
    for (int a = 0; a < 3; ++a) {
      const double low = length * std::min(rates[a].low, 0.0),
                   high = length * std::max(rates[a].high, 0.0);
      inside &= from[a] + low > box.low[a] && from[a] + high < box.high[a];
      reached.low[a] = std::max(from[a] + low, to[a] - high) - 1e-11;
      reached.high[a] = std::min(from[a] + high, to[a] - low) + 1e-11;
      reached.low[a] = std::max(box.low[a], std::min(reached.low[a], hull.low[a]));
      reached.high[a] = std::min(box.high[a], std::max(reached.high[a], hull.high[a]));
    }
    if (!inside)
      continue;
    known.path = true;
    known.field = range(f_, reached);
    derivatives(x_, reached, dx);
    derivatives(y_, reached, dy);
    Bounds df[3];
    derivatives(f_, reached, df);
    known.monotone = !determinant(dx, dy, df).has_zero();
    return known;
  }
  return known;
}

} // namespace insitu::render
