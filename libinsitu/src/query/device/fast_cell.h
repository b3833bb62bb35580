#pragma once

#include <cmath>

#include "math/hd.h"
#include "math/number.h"
#include "math/vec.h"
#include "mesh/shape.h"

/// Point in cell in float, for `fast` (Morrical 2020, section 4): Cramer's rule for tetrahedra,
/// Newton's method for the other shapes. Nothing is proven.
namespace insitu::query::on_device {

struct FastMap {
  math::Vec3f r;
  float margin; ///< slack of the reference cell's inequalities; NaN where nothing was found
};

/// A cell whose margin is at least this much below zero does not hold the point: half of what float
/// leaves uncertain, so that few points fall between two cells.
constexpr float fast_margin = -2e-6f;

namespace detail {

using math::Vec3f;

/// Solves a r + b s + c t = f.
INSITU_HD inline Vec3f solve(const Vec3f& a, const Vec3f& b, const Vec3f& c, const Vec3f& f) {
  const Vec3f bc = cross(b, c), ca = cross(c, a), ab = cross(a, b);
  const float inverse = 1.0f / dot(a, bc);
  return {dot(f, bc) * inverse, dot(f, ca) * inverse, dot(f, ab) * inverse};
}

INSITU_HD inline float least(float a, float b) {
  return a < b ? a : b;
}
INSITU_HD inline float slack(float u) {
  return least(u, 1.0f - u);
}

/// map(q, x, a, b, c): the place at q and the three derivatives. False once q is far out, and
/// where it still moves in the end: beside such cells, not in them.
template <class Map>
INSITU_HD inline bool newton_float(const Map& map, const Vec3f& p, Vec3f& q) {
  float size = 1.0f;
  for (int i = 0; i < 8; ++i) {
    Vec3f x, a, b, c;
    map(q, x, a, b, c);
    const Vec3f d = solve(a, b, c, p - x);
    q += d;
    size = fmaxf(fabsf(d.x), fmaxf(fabsf(d.y), fabsf(d.z)));
    if (!(fabsf(q.x) < 3.0f && fabsf(q.y) < 3.0f && fabsf(q.z) < 3.0f))
      return false; // and NaN
    if (size < 2e-4f)
      return true; // the next step would be its square
  }
  return size < 1e-2f;
}

} // namespace detail

/// x: the vertices relative to the point, in VTK's order.
INSITU_HD inline FastMap fast_inverse(mesh::Shape shape, const math::Vec3f* x) {
  using detail::least;
  using detail::slack;
  using math::Vec3f;
  using mesh::Shape;
  if (shape == Shape::tetrahedron) {
    const Vec3f r = detail::solve(x[1] - x[0], x[2] - x[0], x[3] - x[0], -x[0]);
    const float last = 1.0f - r.x - r.y - r.z;
    const bool sound = r.x - r.x + (r.y - r.y) + (r.z - r.z) == 0.0f;
    return {r, sound ? least(least(r.x, r.y), least(r.z, last)) : NAN};
  }
  if (shape == Shape::wedge) {
    const Vec3f e1 = x[1] - x[0], e2 = x[2] - x[0], e3 = x[3] - x[0];
    const Vec3f crt = (x[4] - x[0]) - e1 - e3, cst = (x[5] - x[0]) - e2 - e3;
    Vec3f q{1.0f / 3.0f, 1.0f / 3.0f, 0.5f};
    const bool found = detail::newton_float(
        [&](const Vec3f& r, Vec3f& v, Vec3f& a, Vec3f& b, Vec3f& c) {
          a = e1 + r.z * crt;
          b = e2 + r.z * cst;
          c = e3 + r.x * crt + r.y * cst;
          v = r.x * a + r.y * b + r.z * e3;
        },
        -x[0], q);
    return {q, found ? least(least(q.x, q.y), least(1.0f - q.x - q.y, slack(q.z))) : NAN};
  }
  if (shape == Shape::pyramid) { // u = (1-t) r, v = (1-t) s, w = 1-t: cells/kernels/inverse_map.inl
    const Vec3f ea = x[0] - x[4], eb = x[1] - x[0], ec = x[3] - x[0];
    const Vec3f ed = (x[2] - x[0]) - eb - ec;
    Vec3f q{0.25f, 0.25f, 0.5f};
    const bool found = detail::newton_float(
        [&](const Vec3f& u, Vec3f& v, Vec3f& a, Vec3f& b, Vec3f& c) {
          const float w = fabsf(u.z) < 1e-6f ? 1e6f : 1.0f / u.z;
          const float r = u.x * w, s = u.y * w;
          a = eb + s * ed;
          b = ec + r * ed;
          c = ea - (r * s) * ed;
          v = u.x * eb + u.y * ec + u.z * ea + (u.x * s) * ed;
        },
        -x[4], q);
    const float w = fabsf(q.z) < 1e-6f ? 1.0f : q.z;
    const bool apex = fabsf(q.z) < 1e-6f;
    return {{apex ? 0.5f : q.x / w, apex ? 0.5f : q.y / w, 1.0f - q.z},
            found ? least(least(least(q.x, q.z - q.x), least(q.y, q.z - q.y)), slack(q.z)) : NAN};
  }
  const bool voxel = shape == Shape::voxel;
  const Vec3f e1 = x[1] - x[0], e2 = (voxel ? x[3] : x[2]) - x[0],
              e3 = (voxel ? x[2] : x[3]) - x[0], e4 = x[4] - x[0], e5 = x[5] - x[0],
              e6 = (voxel ? x[7] : x[6]) - x[0], e7 = (voxel ? x[6] : x[7]) - x[0];
  const Vec3f crs = e2 - e1 - e3, crt = e5 - e1 - e4, cst = e7 - e3 - e4;
  const Vec3f crst = e6 - e2 - (e5 - e1) - (e7 - e3) + e4;
  Vec3f q{0.5f, 0.5f, 0.5f};
  const bool found = detail::newton_float(
      [&](const Vec3f& r, Vec3f& v, Vec3f& a, Vec3f& b, Vec3f& c) {
        const Vec3f rs = crs + r.z * crst;
        a = e1 + r.y * rs + r.z * crt;
        b = e3 + r.x * rs + r.z * cst;
        c = e4 + r.x * (crt + r.y * crst) + r.y * cst;
        v = r.x * a + r.y * (e3 + r.z * cst) + r.z * e4;
      },
      -x[0], q);
  return {q, found ? least(slack(q.x), least(slack(q.y), slack(q.z))) : NAN};
}

} // namespace insitu::query::on_device
