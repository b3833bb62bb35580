#include "mesh/cell_signs.h"

#include <cmath>

// Three x86 targets are enough: each one more costs compile time and gains little here.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mesh/cell_signs.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace insitu::mesh::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<double, 8>;
using Lanes = hn::Vec<Tag>;
using Mask = hn::Mask<Tag>;

struct Lanes3 {
  Lanes x, y, z;
};
HWY_INLINE Lanes3 minus(const Lanes3& a, const Lanes3& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE Lanes dot(const Lanes3& a, const Lanes3& b) {
  return hn::MulAdd(a.z, b.z, hn::MulAdd(a.y, b.y, hn::Mul(a.x, b.x)));
}
HWY_INLINE Lanes3 cross(const Lanes3& a, const Lanes3& b) {
  return {hn::NegMulAdd(a.z, b.y, hn::Mul(a.y, b.z)), hn::NegMulAdd(a.x, b.z, hn::Mul(a.z, b.x)),
          hn::NegMulAdd(a.y, b.x, hn::Mul(a.x, b.y))};
}

/// What is known of a pack of cells.
struct Found {
  Mask positive, negative;
  Lanes least, greatest; ///< coefficients of the Jacobian

  HWY_INLINE Found()
      : positive(none()), negative(none()), least(hn::Set(Tag(), HUGE_VAL)),
        greatest(hn::Set(Tag(), -HUGE_VAL)) {}
  static HWY_INLINE Mask none() { return hn::Lt(hn::Zero(Tag()), hn::Zero(Tag())); }
  HWY_INLINE void coefficient(Lanes value) {
    least = hn::Min(least, value);
    greatest = hn::Max(greatest, value);
  }
  /// A corner's volume, where the edges' squared lengths multiply to `edges`: cells may be needles
  /// or sheets, so zero to rounding is meant against the edges.
  HWY_INLINE void corner(Lanes volume, Lanes edges) {
    const Lanes zero = hn::Zero(Tag());
    const Mask known = hn::Gt(hn::Mul(volume, volume), hn::Mul(hn::Set(Tag(), 1e-28), edges));
    positive = hn::Or(positive, hn::And(known, hn::Gt(volume, zero)));
    negative = hn::Or(negative, hn::And(known, hn::Lt(volume, zero)));
  }
};

/// The Bernstein coefficients of folds.cpp.
HWY_INLINE void hexahedron(const Lanes3* x, int swap, Found& f) {
  const Lanes3 v[8] = {x[0], x[1], x[3 - swap], x[2 + swap], x[4], x[5], x[7 - swap], x[6 + swap]};
  Lanes3 a[4], b[4], c[4];
  Lanes squared_a[4], squared_b[4], squared_c[4];
  for (int k = 0; k < 4; ++k) {
    const int low = k & 1, high = k >> 1;
    a[k] = minus(v[2 * low + 4 * high + 1], v[2 * low + 4 * high]);
    b[k] = minus(v[low + 4 * high + 2], v[low + 4 * high]);
    c[k] = minus(v[low + 2 * high + 4], v[low + 2 * high]);
    squared_a[k] = dot(a[k], a[k]);
    squared_b[k] = dot(b[k], b[k]);
    squared_c[k] = dot(c[k], c[k]);
  }
  Lanes value[27];
  for (Lanes& l : value)
    l = hn::Zero(Tag());
  for (int bc = 0; bc < 16; ++bc) {
    const int bi = bc & 1, bk = bc >> 1 & 1, ci = bc >> 2 & 1, cj = bc >> 3;
    const Lanes3 normal = cross(b[bi + 2 * bk], c[ci + 2 * cj]);
    for (int aj = 0; aj < 2; ++aj)
      for (int ak = 0; ak < 2; ++ak) {
        Lanes& at = value[(bi + ci) + 3 * (aj + cj) + 9 * (ak + bk)];
        at = hn::Add(at, dot(a[aj + 2 * ak], normal));
      }
  }
  for (int i = 0; i < 27; ++i) {
    const int r = i % 3, s = i / 3 % 3, t = i / 9;
    const double weight = (r == 1 ? 0.5 : 1.0) * (s == 1 ? 0.5 : 1.0) * (t == 1 ? 0.5 : 1.0);
    f.coefficient(hn::Mul(value[i], hn::Set(Tag(), weight)));
    if (r != 1 && s != 1 && t != 1)
      f.corner(value[i], hn::Mul(squared_a[(s + 2 * t) / 2],
                                 hn::Mul(squared_b[(r + 2 * t) / 2], squared_c[(r + 2 * s) / 2])));
  }
}

HWY_INLINE void wedge(const Lanes3* x, Found& f) {
  const Lanes3 a[2] = {minus(x[1], x[0]), minus(x[4], x[3])};
  const Lanes3 b[2] = {minus(x[2], x[0]), minus(x[5], x[3])};
  const Lanes half = hn::Set(Tag(), 0.5);
  // Turned: triangle 0 1 2 faces away.
  const Lanes3 low = cross(b[0], a[0]), high = cross(b[1], a[1]);
  const Lanes3 one = cross(b[1], a[0]), other = cross(b[0], a[1]);
  const Lanes low_edges = hn::Mul(dot(a[0], a[0]), dot(b[0], b[0])),
              high_edges = hn::Mul(dot(a[1], a[1]), dot(b[1], b[1]));
  for (int k = 0; k < 3; ++k) {
    const Lanes3 c = minus(x[k + 3], x[k]);
    const Lanes squared = dot(c, c), bottom = dot(low, c), top = dot(high, c);
    f.corner(bottom, hn::Mul(low_edges, squared));
    f.corner(top, hn::Mul(high_edges, squared));
    f.coefficient(bottom);
    f.coefficient(top);
    f.coefficient(hn::Mul(half, hn::Add(dot(one, c), dot(other, c))));
  }
}

HWY_INLINE void pyramid(const Lanes3* x, Found& f) {
  for (int k = 0; k < 4; ++k) {
    const Lanes3 a = minus(x[(k + 1) % 4], x[k]), b = minus(x[(k + 3) % 4], x[k]),
                 c = minus(x[4], x[k]);
    const Lanes volume = dot(cross(a, b), c);
    f.corner(volume, hn::Mul(dot(a, a), hn::Mul(dot(b, b), dot(c, c))));
    f.coefficient(volume);
  }
}

HWY_INLINE void tetrahedron(const Lanes3* x, Found& f) {
  const Lanes3 a = minus(x[1], x[0]), b = minus(x[2], x[0]), c = minus(x[3], x[0]);
  const Lanes volume = dot(cross(a, b), c);
  f.corner(volume, hn::Mul(dot(a, a), hn::Mul(dot(b, b), dot(c, c))));
  f.coefficient(volume);
}

HWY_INLINE std::uint64_t bits_of(const Mask& mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(Tag(), mask, bytes);
  return bytes[0];
}

template <Shape S>
void look(const CellBlock& block, CellSigns& out) {
  const Tag d;
  const int lanes = int(hn::Lanes(d));
  constexpr int n = vertex_count(S);
  for (int i = 0; i < block.count; i += lanes) {
    Lanes3 x[n];
    for (int v = 0; v < n; ++v)
      x[v] = {hn::Load(d, block.vertex[v][0] + i), hn::Load(d, block.vertex[v][1] + i),
              hn::Load(d, block.vertex[v][2] + i)};
    Found f;
    if constexpr (S == Shape::tetrahedron)
      tetrahedron(x, f);
    else if constexpr (S == Shape::pyramid)
      pyramid(x, f);
    else if constexpr (S == Shape::wedge)
      wedge(x, f);
    else
      hexahedron(x, S == Shape::voxel ? 1 : 0, f);
    Lanes3 low = x[0], high = x[0];
    Mask coincident = Found::none();
    for (int v = 1; v < n; ++v) {
      low = {hn::Min(low.x, x[v].x), hn::Min(low.y, x[v].y), hn::Min(low.z, x[v].z)};
      high = {hn::Max(high.x, x[v].x), hn::Max(high.y, x[v].y), hn::Max(high.z, x[v].z)};
      for (int w = 0; w < v; ++w)
        coincident =
            hn::Or(coincident, hn::And(hn::Eq(x[v].x, x[w].x),
                                       hn::And(hn::Eq(x[v].y, x[w].y), hn::Eq(x[v].z, x[w].z))));
    }
    const Lanes3 size = minus(high, low);
    const Lanes tolerance = // of folds.cpp
        hn::Mul(hn::Set(d, 256 * 0x1p-53), hn::Mul(size.x, hn::Mul(size.y, size.z)));
    const Mask kept = hn::Or(hn::Ge(f.least, hn::Neg(tolerance)), hn::Le(f.greatest, tolerance));
    out.positive |= bits_of(f.positive) << i;
    out.negative |= bits_of(f.negative) << i;
    out.coincident |= bits_of(coincident) << i;
    out.unsure |= bits_of(hn::Not(kept)) << i;
  }
}

void cell_signs_target(Shape shape, const CellBlock& block, CellSigns& out) {
  switch (shape) {
  case Shape::tetrahedron:
    return look<Shape::tetrahedron>(block, out);
  case Shape::voxel:
    return look<Shape::voxel>(block, out);
  case Shape::hexahedron:
    return look<Shape::hexahedron>(block, out);
  case Shape::wedge:
    return look<Shape::wedge>(block, out);
  case Shape::pyramid:
    return look<Shape::pyramid>(block, out);
  case Shape::none:
    break;
  }
}

} // namespace insitu::mesh::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace insitu::mesh {

HWY_EXPORT(cell_signs_target);

CellSigns cell_signs(Shape shape, CellBlock& block) {
  // The last pack's idle lanes repeat the first cell.
  for (int i = block.count; i % 8 != 0; ++i)
    for (int v = 0; v < vertex_count(shape); ++v)
      for (int a = 0; a < 3; ++a)
        block.vertex[v][a][i] = block.vertex[v][a][0];
  CellSigns out;
  HWY_DYNAMIC_DISPATCH(cell_signs_target)(shape, block, out);
  const std::uint64_t all = block.count == 64 ? ~0ull : (1ull << block.count) - 1;
  return {out.positive & all, out.negative & all, out.coincident & all, out.unsure & all};
}

} // namespace insitu::mesh
#endif
