// Coordinates of a bundle's samples in hexahedra, in floats, once per Highway target. Include after
// hwy/foreach_target.h, like any per-target header of Highway.
#if defined(INSITU_QUERY_RAY_BUNDLE_STARTS_SIMD_H) == defined(HWY_TARGET_TOGGLE)
#ifdef INSITU_QUERY_RAY_BUNDLE_STARTS_SIMD_H
#undef INSITU_QUERY_RAY_BUNDLE_STARTS_SIMD_H
#else
#define INSITU_QUERY_RAY_BUNDLE_STARTS_SIMD_H
#endif

#include <algorithm>
#include <hwy/highway.h>

#include "query/ray_bundle/ray_bundle_linear_simd.h"

HWY_BEFORE_NAMESPACE();
namespace insitu::query::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// A step of Newton's method for r + bends(r) = linear, in floats.
HWY_INLINE void bend_back(const FloatVec* bends, const FloatVec* linear, FloatVec* r) {
  const Floats d;
  const auto one = hn::Set(d, 1.0f);
  FloatVec j[3][3], h[3];
  for (int a = 0; a < 3; ++a) {
    const auto rs = bends[a], rt = bends[3 + a], st = bends[6 + a], rst = bends[9 + a];
    const auto by_r = hn::MulAdd(r[2], hn::MulAdd(r[1], rst, rt), hn::Mul(r[1], rs));
    h[a] = hn::Sub(hn::MulAdd(r[0], by_r, hn::Mul(hn::Mul(r[1], r[2]), st)), linear[a]);
    h[a] = hn::Add(h[a], r[a]);
    j[a][0] = by_r;
    j[a][1] = hn::MulAdd(r[2], hn::MulAdd(r[0], rst, st), hn::Mul(r[0], rs));
    j[a][2] = hn::MulAdd(r[0], hn::MulAdd(r[1], rst, rt), hn::Mul(r[1], st));
    j[a][a] = hn::Add(j[a][a], one);
  }
  // Cramer's rule, with the first column's cofactors.
  const auto minor = [&](int a, int b, int p, int q) HWY_ATTR {
    return hn::NegMulAdd(j[a][q], j[b][p], hn::Mul(j[a][p], j[b][q]));
  };
  const auto c0 = minor(1, 2, 1, 2), c1 = minor(2, 0, 1, 2), c2 = minor(0, 1, 1, 2);
  const auto scale =
      hn::Div(one, hn::MulAdd(j[0][0], c0, hn::MulAdd(j[1][0], c1, hn::Mul(j[2][0], c2))));
  const auto step = [&](const FloatVec& a, const FloatVec& b, const FloatVec& c) HWY_ATTR {
    return hn::Mul(scale, hn::MulAdd(h[0], a, hn::MulAdd(h[1], b, hn::Mul(h[2], c))));
  };
  r[0] = hn::Sub(r[0], step(c0, c1, c2));
  const auto s = step(minor(1, 2, 2, 0), minor(2, 0, 2, 0), minor(0, 1, 2, 0));
  r[2] = hn::Sub(r[2], step(minor(1, 2, 0, 1), minor(2, 0, 0, 1), minor(0, 1, 0, 1)));
  r[1] = hn::Sub(r[1], s);
}

/// Solves for the coordinates of samples [begin, end), which hexahedron i may hold, and appends to
/// `kept` those that lie within, as far as floats tell; where these tell nothing, all of them, from
/// the middle.
HWY_INLINE void settle_starts(const LinearMaps& maps, int i, const CellSamples& found, int begin,
                              int end, CellSamples& kept) {
  const Floats d;
  const hn::Rebind<std::int32_t, Floats> di;
  const auto half = hn::Set(d, 0.5f);
  const int lanes = int(hn::MaxLanes(d));
  if (!(maps.slack[i] < unsound_slack)) {
    for (int n = begin; n < end; ++n) {
      for (int a = 0; a < 3; ++a)
        kept.start[a][kept.count] = 0.5f;
      kept.place[kept.count++] = found.place[n];
    }
    return;
  }
  FloatVec bends[12];
  for (int a = 0; a < 12; ++a)
    bends[a] = hn::Set(d, maps.bends[a][i]);
  const auto most = hn::Set(d, 0.5f + 1e-4f + 4.0f * maps.rounding[i]);
  for (int n = begin; n < end; n += lanes) {
    FloatVec linear[3], r[3];
    for (int a = 0; a < 3; ++a)
      r[a] = linear[a] = hn::LoadU(d, found.start[a] + n);
    const auto rs = hn::Mul(r[0], r[1]), rt = hn::Mul(r[0], r[2]), st = hn::Mul(r[1], r[2]),
               rst = hn::Mul(rs, r[2]);
    for (int a = 0; a < 3; ++a)
      r[a] = hn::NegMulAdd(
          bends[a], rs,
          hn::NegMulAdd(bends[3 + a], rt,
                        hn::NegMulAdd(bends[6 + a], st, hn::NegMulAdd(bends[9 + a], rst, r[a]))));
    bend_back(bends, linear, r);
    bend_back(bends, linear, r);
    const auto far = hn::Max(hn::Abs(r[0]), hn::Max(hn::Abs(r[1]), hn::Abs(r[2])));
    const auto within =
        hn::And(hn::Le(far, most), hn::FirstN(d, std::size_t(std::min(lanes, end - n))));
    const std::size_t some = hn::CountTrue(d, within);
    if (some == 0)
      continue;
    const Packer packed(within);
    for (int a = 0; a < 3; ++a)
      packed.store(hn::Add(r[a], half), kept.start[a] + kept.count);
    packed.store(hn::LoadU(di, found.place + n), kept.place + kept.count);
    kept.count += int(some);
  }
}

} // namespace insitu::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
