#include "mesh/folds.h"

#include <algorithm>
#include <cmath>

namespace insitu::mesh {

namespace {

using math::Vec3d;

/// Bernstein coefficients of degree two along each of `axes` axes (three numbers an axis).
struct Patch {
  double value[27];
};

enum class Sign { kept, changes, unknown };

/// The determinant's range as far as one patch tells. `sign` times the determinant should be
/// positive; corners are values that it takes.
Sign look(const Patch& p, int axes, double sign, double tolerance) {
  const int count = axes == 3 ? 27 : axes == 2 ? 9 : 3;
  double least = HUGE_VAL;
  for (int i = 0; i < count; ++i)
    least = std::min(least, sign * p.value[i]);
  if (least >= -tolerance)
    return Sign::kept;
  for (int corner = 0; corner < 1 << axes; ++corner) {
    const int at = (corner & 1) * 2 + (corner >> 1 & 1) * 6 + (corner >> 2 & 1) * 18;
    if (sign * p.value[at] < -tolerance)
      return Sign::changes;
  }
  return Sign::unknown;
}

/// de Casteljau's halves along the axis whose coefficients are `stride` apart.
void split(const Patch& p, int count, int stride, Patch& low, Patch& high) {
  for (int i = 0; i < count; ++i) {
    if (i / stride % 3 != 0)
      continue;
    const double a = p.value[i], b = p.value[i + stride], c = p.value[i + 2 * stride];
    const double ab = 0.5 * (a + b), bc = 0.5 * (b + c), middle = 0.5 * (ab + bc);
    low.value[i] = a;
    low.value[i + stride] = ab;
    low.value[i + 2 * stride] = high.value[i] = middle;
    high.value[i + stride] = bc;
    high.value[i + 2 * stride] = c;
  }
}

/// Halves along one axis after the other. Where that many levels leave it open, it does change.
bool changes(const Patch& p, int axes, double sign, double tolerance, int level) {
  const Sign found = look(p, axes, sign, tolerance);
  if (found != Sign::unknown || level == 5 * axes)
    return found != Sign::kept;
  constexpr int strides[] = {1, 3, 9};
  Patch low, high;
  split(p, axes == 3 ? 27 : axes == 2 ? 9 : 3, strides[level % axes], low, high);
  return changes(low, axes, sign, tolerance, level + 1) ||
         changes(high, axes, sign, tolerance, level + 1);
}

double triple(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  return dot(a, cross(b, c));
}

/// a: the edges along r at (s, t) = (0, 0), (1, 0), (0, 1), (1, 1); b along s at (r, t), c along t
/// at (r, s) likewise.
Patch hexahedron_determinant(const Vec3d* a, const Vec3d* b, const Vec3d* c) {
  Patch p{};
  for (int bc = 0; bc < 16; ++bc) {
    const int bi = bc & 1, bk = bc >> 1 & 1, ci = bc >> 2 & 1, cj = bc >> 3;
    const Vec3d normal = cross(b[bi + 2 * bk], c[ci + 2 * cj]);
    for (int aj = 0; aj < 2; ++aj)
      for (int ak = 0; ak < 2; ++ak)
        p.value[(bi + ci) + 3 * (aj + cj) + 9 * (ak + bk)] += dot(a[aj + 2 * ak], normal);
  }
  // r (1 - r) is half of the middle polynomial, 2 r (1 - r).
  for (int i = 0; i < 27; ++i)
    p.value[i] *=
        (i % 3 == 1 ? 0.5 : 1.0) * (i / 3 % 3 == 1 ? 0.5 : 1.0) * (i / 9 == 1 ? 0.5 : 1.0);
  return p;
}

bool hexahedron_changes(const Vec3d* x, int swap, double tolerance) {
  // By i + 2 j + 4 k; hexahedra turn, voxels count.
  const Vec3d v[8] = {x[0], x[1], x[3 - swap], x[2 + swap], x[4], x[5], x[7 - swap], x[6 + swap]};
  const Vec3d a[4] = {v[1] - v[0], v[3] - v[2], v[5] - v[4], v[7] - v[6]};
  const Vec3d b[4] = {v[2] - v[0], v[3] - v[1], v[6] - v[4], v[7] - v[5]};
  const Vec3d c[4] = {v[4] - v[0], v[5] - v[1], v[6] - v[2], v[7] - v[3]};
  const Patch p = hexahedron_determinant(a, b, c);
  double sum = 0.0;
  for (const double value : p.value)
    sum += value;
  return changes(p, 3, sum < 0.0 ? -1.0 : 1.0, tolerance, 0);
}

bool wedge_changes(const Vec3d* x, double tolerance) {
  const Vec3d a[2] = {x[1] - x[0], x[4] - x[3]}, b[2] = {x[2] - x[0], x[5] - x[3]};
  Patch upright[3]; // over t, at the corners of the triangle, between which it is linear
  double sum = 0.0;
  for (int k = 0; k < 3; ++k) {
    const Vec3d c = x[k + 3] - x[k];
    upright[k].value[0] = triple(a[0], b[0], c);
    upright[k].value[1] = 0.5 * (triple(a[0], b[1], c) + triple(a[1], b[0], c));
    upright[k].value[2] = triple(a[1], b[1], c);
    sum += upright[k].value[0] + upright[k].value[1] + upright[k].value[2];
  }
  for (const Patch& p : upright)
    if (changes(p, 1, sum < 0.0 ? -1.0 : 1.0, tolerance, 0))
      return true;
  return false;
}

bool pyramid_changes(const Vec3d* x, double tolerance) {
  double least = HUGE_VAL, greatest = -HUGE_VAL;
  for (int k = 0; k < 4; ++k) {
    const Vec3d &corner = x[k], &next = x[(k + 1) % 4], &previous = x[(k + 3) % 4];
    const double d = triple(next - corner, previous - corner, x[4] - corner);
    least = std::min(least, d);
    greatest = std::max(greatest, d);
  }
  return least < -tolerance && greatest > tolerance;
}

} // namespace

bool jacobian_changes_sign(Shape shape, const Vec3d* x) {
  Vec3d low = x[0], high = x[0];
  for (int v = 1; v < vertex_count(shape); ++v)
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], x[v][axis]);
      high[axis] = std::max(high[axis], x[v][axis]);
    }
  // A triple product of edges errs by at most 48 roundings of the box's volume (contain_filter.h),
  // the sums above and the subdivision by less than 200.
  const Vec3d size = high - low;
  const double tolerance = 256 * 0x1p-53 * (size.x * size.y * size.z);
  switch (shape) {
  case Shape::hexahedron:
    return hexahedron_changes(x, 0, tolerance);
  case Shape::voxel:
    return hexahedron_changes(x, 1, tolerance);
  case Shape::wedge:
    return wedge_changes(x, tolerance);
  case Shape::pyramid:
    return pyramid_changes(x, tolerance);
  default:
    return false;
  }
}

} // namespace insitu::mesh
