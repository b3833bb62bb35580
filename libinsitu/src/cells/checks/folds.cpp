#include "cells/checks/folds.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "cells/checks/cell_signs.h"
#include "cells/kernels/kernels.h"

namespace insitu::cells {

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

bool hexahedron_changes(Shape shape, const Vec3d* x, double tolerance) {
  Patch p;
  hexahedron_determinant(hexahedron_edges(x, shape == Shape::voxel ? 1 : 0), p.value);
  double sum = 0.0;
  for (const double value : p.value)
    sum += value;
  return changes(p, 3, sum < 0.0 ? -1.0 : 1.0, tolerance, 0);
}

bool wedge_changes(const Vec3d* x, double tolerance) {
  double value[3][3], sum = 0.0;
  wedge_determinant(x, value);
  for (const auto& upright : value)
    sum += upright[0] + upright[1] + upright[2];
  for (const auto& upright : value) {
    Patch p;
    std::copy_n(upright, 3, p.value);
    if (changes(p, 1, sum < 0.0 ? -1.0 : 1.0, tolerance, 0))
      return true;
  }
  return false;
}

bool pyramid_changes(const Vec3d* x, double tolerance) {
  double value[4];
  pyramid_determinant(x, value);
  const auto [least, greatest] = std::minmax_element(value, value + 4);
  return -*least > tolerance && *greatest > tolerance;
}

} // namespace

bool jacobian_changes_sign(Shape shape, const Vec3d* x) {
  const double tolerance = determinant_tolerance(vertex_count(shape), x);
  switch (shape) {
  case Shape::voxel:
  case Shape::hexahedron:
    return hexahedron_changes(shape, x, tolerance);
  case Shape::wedge:
    return wedge_changes(x, tolerance);
  case Shape::pyramid:
    return pyramid_changes(x, tolerance);
  default:
    return false;
  }
}

CellKinds kinds_of(Shape shape, CellBlock& block) {
  CellKinds kinds;
  if (block.count == 0)
    return kinds;
  const CellSigns s = cell_signs(shape, block);
  kinds.folded = s.positive & s.negative;
  for (std::uint64_t open = s.unsure & (s.positive ^ s.negative); open; open &= open - 1) {
    const int k = std::countr_zero(open);
    Vec3d x[8];
    block.get(shape, k, x);
    kinds.folded |= std::uint64_t(jacobian_changes_sign(shape, x)) << k;
  }
  kinds.inverted = s.negative & ~kinds.folded;
  kinds.flat = block.all() & ~(s.positive | s.negative);
  kinds.collapsed = s.coincident;
  return kinds;
}

} // namespace insitu::cells
