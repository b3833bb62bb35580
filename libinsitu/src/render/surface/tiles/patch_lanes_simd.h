// What solvers of patches share, once per Highway target. Include after hwy/foreach_target.h, like
// any per-target header of Highway.
#if defined(INSITU_RENDER_PATCH_LANES_SIMD_H) == defined(HWY_TARGET_TOGGLE)
#ifdef INSITU_RENDER_PATCH_LANES_SIMD_H
#undef INSITU_RENDER_PATCH_LANES_SIMD_H
#else
#define INSITU_RENDER_PATCH_LANES_SIMD_H
#endif

#include <hwy/highway.h>

#include "render/surface/tiles/patches.h"

HWY_BEFORE_NAMESPACE();
namespace insitu::render::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Nearer to a face of the cell than this, in parametric coordinates, the search by the ray
/// decides.
constexpr double face_slack = 1e-8;
/// A step of Newton's method in double from less than this leaves no error that counts.
constexpr double small_step = 1e-5;
/// How far iterates may leave the cube.
constexpr double reach = 1e-2;

using Floats = hn::CappedTag<float, 16>;
using Doubles = hn::CappedTag<double, 8>;

/// A vector of numbers with operators; products and sums may fuse. Friends need HWY_ATTR: GCC
/// instantiates those of a class template without the target of the place, and where they are not
/// inlined (-O0) they would be called by another convention than theirs.
template <class D>
struct Lanes {
  using Real = hn::TFromD<D>;
  hn::Vec<D> v;

  Lanes() = default;
  HWY_INLINE explicit Lanes(hn::Vec<D> a) : v(a) {}
  HWY_INLINE explicit Lanes(Real a) : v(hn::Set(D(), a)) {}
  HWY_INLINE HWY_ATTR friend Lanes operator+(Lanes a, Lanes b) { return Lanes(hn::Add(a.v, b.v)); }
  HWY_INLINE HWY_ATTR friend Lanes operator-(Lanes a, Lanes b) { return Lanes(hn::Sub(a.v, b.v)); }
  HWY_INLINE HWY_ATTR friend Lanes operator*(Lanes a, Lanes b) { return Lanes(hn::Mul(a.v, b.v)); }
  HWY_INLINE HWY_ATTR friend Lanes operator/(Lanes a, Lanes b) { return Lanes(hn::Div(a.v, b.v)); }
  HWY_INLINE HWY_ATTR friend Lanes least(Lanes a, Lanes b) { return Lanes(hn::Min(a.v, b.v)); }
  HWY_INLINE HWY_ATTR friend Lanes greatest(Lanes a, Lanes b) { return Lanes(hn::Max(a.v, b.v)); }
  HWY_INLINE HWY_ATTR friend Lanes size(Lanes a) { return Lanes(hn::Abs(a.v)); }
  /// a b + c and c - a b.
  HWY_INLINE HWY_ATTR friend Lanes mul_add(Lanes a, Lanes b, Lanes c) {
    return Lanes(hn::MulAdd(a.v, b.v, c.v));
  }
  HWY_INLINE HWY_ATTR friend Lanes sub_mul(Lanes c, Lanes a, Lanes b) {
    return Lanes(hn::NegMulAdd(a.v, b.v, c.v));
  }
  HWY_INLINE Lanes within(Real low, Real high) const {
    return least(greatest(*this, Lanes(low)), Lanes(high));
  }
};

/// A trilinear function of parametric coordinates and its derivatives; k(n): the coefficients of 1,
/// r, s, u, rs, su, ru, rsu, of which a linear one has four.
template <bool linear, class Coefficient, class L>
HWY_INLINE L evaluate(const Coefficient& k, const L (&r)[3], L (&slope)[3]) {
  if constexpr (linear) {
    for (int a = 0; a < 3; ++a)
      slope[a] = k(a + 1);
    return mul_add(k(3), r[2], mul_add(k(2), r[1], mul_add(k(1), r[0], k(0))));
  }
  const L a = mul_add(k(4), r[0], k(2)), b = mul_add(k(7), r[0], k(5));
  const L p = mul_add(r[1], a, mul_add(k(1), r[0], k(0)));
  const L q = mul_add(r[1], b, mul_add(k(6), r[0], k(3)));
  slope[0] = mul_add(r[2], mul_add(k(7), r[1], k(6)), mul_add(k(4), r[1], k(1)));
  slope[1] = mul_add(r[2], b, a);
  slope[2] = q;
  return mul_add(r[2], q, p);
}

/// A trilinear function of parametric coordinates; a linear one where `linear`.
template <class D, bool linear>
struct Trilinear {
  using L = Lanes<D>;
  typename L::Real k[8];

  HWY_INLINE void load(const double (&rows)[8][Patches::most], int p) {
    for (int n = 0; n < 8; ++n)
      k[n] = typename L::Real(rows[n][p]);
  }
  HWY_INLINE L at(const L (&r)[3]) const {
    if constexpr (linear)
      return mul_add(L(k[3]), r[2], mul_add(L(k[2]), r[1], mul_add(L(k[1]), r[0], L(k[0]))));
    const L a = mul_add(L(k[4]), r[0], L(k[2])), b = mul_add(L(k[7]), r[0], L(k[5]));
    const L p = mul_add(r[1], a, mul_add(L(k[1]), r[0], L(k[0])));
    const L q = mul_add(r[1], b, mul_add(L(k[6]), r[0], L(k[3])));
    return mul_add(r[2], q, p);
  }
  HWY_INLINE L at(const L (&r)[3], L (&slope)[3]) const {
    return evaluate<linear>([&](int n) HWY_ATTR { return L(k[n]); }, r, slope);
  }
};

/// Solves slope out = g: cross products of rows are the columns of the inverse, times the
/// determinant.
template <class L>
HWY_INLINE void newton_step(const L (&slope)[3][3], const L (&g)[3], L (&out)[3]) {
  L c[3][3];
  for (int a = 0; a < 3; ++a) {
    const L(&m)[3] = slope[(a + 1) % 3], (&n)[3] = slope[(a + 2) % 3];
    for (int b = 0; b < 3; ++b)
      c[a][b] = sub_mul(m[(b + 1) % 3] * n[(b + 2) % 3], m[(b + 2) % 3], n[(b + 1) % 3]);
  }
  const L determinant =
      mul_add(slope[0][0], c[0][0], mul_add(slope[0][1], c[0][1], slope[0][2] * c[0][2]));
  const L inverse = L(typename L::Real(1)) / determinant;
  for (int b = 0; b < 3; ++b)
    out[b] = mul_add(g[0], c[0][b], mul_add(g[1], c[1][b], g[2] * c[2][b])) * inverse;
}

/// How far a point is within the unit cube, at the least; below 0 outside.
template <class L>
HWY_INLINE L cube_margin(const L (&r)[3]) {
  const L one(typename L::Real(1));
  return least(least(least(r[0], one - r[0]), least(r[1], one - r[1])), least(r[2], one - r[2]));
}

/// The same for the slanted face of the cell, of which the patch is a part.
template <class L, PatchDomain domain>
HWY_INLINE L slant_margin(const L (&r)[3], const L (&lower)[3], L side) {
  const L rest = L(typename L::Real(1)) - mul_add(side, r[0] + r[1], lower[0] + lower[1]);
  return domain == PatchDomain::simplex ? rest - mul_add(side, r[2], lower[2]) : rest;
}

} // namespace insitu::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
