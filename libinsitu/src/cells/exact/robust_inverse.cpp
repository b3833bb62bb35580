#include "cells/exact/robust_inverse.h"

#include <algorithm>
#include <cmath>

#include "cells/kernels/kernels.h"

namespace insitu::cells {

namespace {

using math::Vec3d;

/// The nearest point of the reference cell, axis by axis (simplices: scaled back to the slanted
/// face).
Vec3d clamp_to_reference(Shape shape, Vec3d r) {
  for (int a = 0; a < 3; ++a)
    r[a] = std::clamp(r[a], 0.0, 1.0);
  const double sum = shape == Shape::tetrahedron ? r.x + r.y + r.z
                     : shape == Shape::wedge     ? r.x + r.y
                                                 : 0.0;
  if (sum > 1.0) {
    r.x /= sum;
    r.y /= sum;
    if (shape == Shape::tetrahedron)
      r.z /= sum;
  }
  return r;
}

struct Attempt {
  Vec3d r;
  double residual;
};

/// Levenberg-Marquardt, projected: solves (J^T J + mu I) d = J^T f and keeps steps that help.
Attempt descend(Shape shape, const Vec3d* x, const Vec3d& p, Vec3d r) {
  const auto misfit = [&](const Vec3d& q) { return p - map_to_physical(shape, x, q); };
  Vec3d f = misfit(r);
  double residual = dot(f, f), damping = 1e-3;
  for (int i = 0; i < 100 && residual > 0.0; ++i) {
    Vec3d j[3];
    jacobian(shape, x, r, j);
    double m[3][3], g[3];
    double trace = 0.0;
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b)
        m[a][b] = dot(j[a], j[b]);
      g[a] = dot(j[a], f);
      trace += m[a][a];
    }
    if (trace == 0.0)
      break;
    for (int a = 0; a < 3; ++a)
      m[a][a] += damping * trace;
    const Vec3d c0{m[0][0], m[1][0], m[2][0]}, c1{m[0][1], m[1][1], m[2][1]},
        c2{m[0][2], m[1][2], m[2][2]}, h{g[0], g[1], g[2]};
    const Vec3d bc = cross(c1, c2);
    const double det = dot(c0, bc);
    if (det == 0.0) {
      damping = std::max(damping * 10.0, 1e-12);
      continue;
    }
    const Vec3d step{dot(h, bc) / det, dot(h, cross(c2, c0)) / det, dot(h, cross(c0, c1)) / det};
    const Vec3d next = clamp_to_reference(shape, r + step);
    const Vec3d next_f = misfit(next);
    const double next_residual = dot(next_f, next_f);
    if (next_residual < residual) {
      r = next;
      f = next_f;
      residual = next_residual;
      damping *= 0.1;
    } else {
      damping = std::max(damping, 1e-12) * 10.0;
      if (damping > 1e6)
        break;
    }
  }
  return {r, residual};
}

} // namespace

math::Vec3d robust_inverse(Shape shape, const Vec3d* x, const Vec3d& p) {
  constexpr double starts[3] = {0.5, 0.1, 0.9};
  Attempt best{{0.5, 0.5, 0.5}, HUGE_VAL};
  double size = 0.0;
  for (int v = 1; v < vertex_count(shape); ++v)
    size = std::max(size, dot(x[v] - x[0], x[v] - x[0]));
  for (int k = 0; k < 27; ++k) {
    const Vec3d start =
        clamp_to_reference(shape, {starts[k % 3], starts[k / 3 % 3], starts[k / 9]});
    const Attempt attempt = descend(shape, x, p, start);
    if (attempt.residual < best.residual)
      best = attempt;
    if (best.residual <= size * 1e-28)
      break;
  }
  return best.r;
}

} // namespace insitu::cells
