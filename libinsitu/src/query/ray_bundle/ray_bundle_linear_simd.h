// Linear stand-ins for the inverse maps of a bundle's cells, once per Highway target. Include after
// hwy/foreach_target.h, like any per-target header of Highway.
#if defined(INSITU_QUERY_RAY_BUNDLE_LINEAR_SIMD_H) == defined(HWY_TARGET_TOGGLE)
#ifdef INSITU_QUERY_RAY_BUNDLE_LINEAR_SIMD_H
#undef INSITU_QUERY_RAY_BUNDLE_LINEAR_SIMD_H
#else
#define INSITU_QUERY_RAY_BUNDLE_LINEAR_SIMD_H
#endif

#include <hwy/highway.h>

#include "cells/kernels/kernels_simd.h"
#include "query/ray_bundle/ray_bundle_groups_simd.h"

HWY_BEFORE_NAMESPACE();
namespace insitu::query::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
namespace simd = cells::HWY_NAMESPACE;
using mesh::Shape;
using simd::Pack;
using PackVec = simd::Vec3<Pack>;

/// The map of a reference cell's coordinates about an anchor: x = anchor + J (r - at) + rest, the
/// rest at most the sum of these vectors' lengths in any norm, component by component.
struct Linear {
  PackVec anchor, j[3];
  double at[3];    ///< what the coordinates are at the anchor
  double range[3]; ///< how far r goes from `at` in the cell
  PackVec rest[4];
  int rests;
};

HWY_INLINE PackVec times(double s, const PackVec& v) {
  return Pack(s) * v;
}

HWY_INLINE Linear linear_of(Shape shape, const PackVec* x) {
  Linear m;
  m.rests = 0;
  for (int a = 0; a < 3; ++a) {
    m.at[a] = 0.0;
    m.range[a] = 1.0;
  }
  if (shape == Shape::tetrahedron) {
    m.anchor = x[0];
    for (int a = 0; a < 3; ++a)
      m.j[a] = x[1 + a] - x[0];
  } else if (shape == Shape::wedge) { // r s-triangle at t = 1/2, products taken at r = s = 1/3
    const PackVec e1 = x[1] - x[0], e2 = x[2] - x[0], e3 = x[3] - x[0];
    const PackVec crt = (x[4] - x[0]) - e1 - e3, cst = (x[5] - x[0]) - e2 - e3;
    m.j[0] = e1 + times(0.5, crt);
    m.j[1] = e2 + times(0.5, cst);
    m.j[2] = e3 + times(1.0 / 3.0, crt + cst);
    m.anchor = x[0] + times(0.5, e3); // at r = s = 0, t = 1/2
    m.range[2] = 0.5;
    m.rest[0] = times(1.0 / 3.0, crt); // |r - 1/3| |t - 1/2|
    m.rest[1] = times(1.0 / 3.0, cst);
    m.rests = 2;
  } else if (shape ==
             Shape::pyramid) { // in u, v, w about the apex; u v / w near (u + v) / 2 - w / 4
    const PackVec b = x[1] - x[0], c = x[3] - x[0], e = (x[2] - x[0]) - b - c;
    m.anchor = x[4];
    m.j[0] = b + times(0.5, e);
    m.j[1] = c + times(0.5, e);
    m.j[2] = (x[0] - x[4]) - times(0.25, e);
    m.rest[0] = times(0.25, e);
    m.rests = 1;
  } else { // about the middle
    const int swap = shape == Shape::voxel ? 1 : 0;
    const PackVec &p2 = x[2 + swap], &p3 = x[3 - swap], &p6 = x[6 + swap], &p7 = x[7 - swap];
    // Sums and differences along r, then s, then t.
    const PackVec s01 = x[0] + x[1], s32 = p3 + p2, s45 = x[4] + x[5], s76 = p7 + p6;
    const PackVec d01 = x[1] - x[0], d32 = p2 - p3, d45 = x[5] - x[4], d76 = p6 - p7;
    const PackVec ss0 = s01 + s32, ss1 = s45 + s76, ds0 = d01 + d32, ds1 = d45 + d76;
    const PackVec sd0 = s32 - s01, sd1 = s76 - s45, dd0 = d32 - d01, dd1 = d76 - d45;
    m.anchor = times(0.125, ss0 + ss1);
    m.j[0] = times(0.25, ds0 + ds1);
    m.j[1] = times(0.25, sd0 + sd1);
    m.j[2] = times(0.25, ss1 - ss0);
    for (int a = 0; a < 3; ++a)
      m.range[a] = 0.5;
    m.rest[0] = times(0.125, dd0 + dd1); // 1/2 of it, times 1/4
    m.rest[1] = times(0.125, ds1 - ds0);
    m.rest[2] = times(0.125, sd1 - sd0);
    m.rest[3] = times(0.125, dd1 - dd0); // times 1/8
    m.rests = 4;
  }
  return m;
}

/// The slack of cells whose linear stand-in says nothing.
constexpr float unsound_slack = 1e3f;

/// What is needed of up to 64 cells: a linear stand-in for the inverse map, as far as it may be
/// off, and the cell's extent along the slab's axes.
struct LinearMaps {
  static constexpr int size = cells::CellBlock::size;
  /// Coordinate a of the reference cell is affine[4 a + 3] + sum over b of affine[4 a + b] x[b].
  alignas(64) float affine[12][size];
  alignas(64) float slack[size]; ///< added to the likelihood of what the cell holds, it is >= 0
  alignas(64) float lower[3][size], upper[3][size];
  /// Of hexahedra, whose coordinates r, s, t are about the middle here: what the stand-in neglects
  /// of coordinate a is bends[a] r s + bends[3 + a] r t + bends[6 + a] s t + bends[9 + a] r s t, up
  /// to `rounding`.
  alignas(64) float bends[12][size];
  alignas(64) float rounding[size];
};

/// The linear stand-ins of a block's cells. With A any matrix near J's inverse, r - at = A (x -
/// anchor) - (A J - 1) (r - at) - A rest: the last two, and roundings, are the slack.
HWY_INLINE void linear_maps(Shape shape, const cells::CellBlock& block, const BundleSlab& slab,
                            LinearMaps& out) {
  const simd::PackTag d;
  const hn::Rebind<float, simd::PackTag> df;
  const int lanes = int(hn::Lanes(d)), vertices = mesh::vertex_count(shape);
  const bool is_hexahedron = vertices == 8;
  const double reach = double(slab.reach);
  for (int i = 0; i < block.count; i += lanes) {
    PackVec x[8];
    PackVec low, high;
    for (int v = 0; v < vertices; ++v) { // into the slab's frame
      const PackVec p{simd::load_pack(block.vertex[v][0] + i) - Pack(slab.middle.x),
                      simd::load_pack(block.vertex[v][1] + i) - Pack(slab.middle.y),
                      simd::load_pack(block.vertex[v][2] + i) - Pack(slab.middle.z)};
      const auto along = [&](const math::Vec3d& axis) HWY_ATTR {
        return dot(PackVec{Pack(axis.x), Pack(axis.y), Pack(axis.z)}, p);
      };
      x[v] = {along(slab.axes[0]), along(slab.axes[1]), along(slab.axes[2])};
      low = v == 0
                ? x[v]
                : PackVec{smaller(low.x, x[v].x), smaller(low.y, x[v].y), smaller(low.z, x[v].z)};
      high = v == 0
                 ? x[v]
                 : PackVec{larger(high.x, x[v].x), larger(high.y, x[v].y), larger(high.z, x[v].z)};
    }
    const auto store = [&](const Pack& p, float* row)
                           HWY_ATTR { hn::StoreU(hn::DemoteTo(df, p.v), df, row + i); };
    const auto store_bound = [&](const Pack& p, double sign, float* row) HWY_ATTR {
      store(p + Pack(sign) * (Pack(slab.rounding + 0x1p-20 * reach) + Pack(0x1p-20) * absolute(p)),
            row);
    };
    store_bound(low.x, -1.0, out.lower[0]);
    store_bound(low.y, -1.0, out.lower[1]);
    store_bound(low.z, -1.0, out.lower[2]);
    store_bound(high.x, 1.0, out.upper[0]);
    store_bound(high.y, 1.0, out.upper[1]);
    store_bound(high.z, 1.0, out.upper[2]);
    const Linear m = linear_of(shape, x);
    const PackVec bc = cross(m.j[1], m.j[2]), ca = cross(m.j[2], m.j[0]),
                  ab = cross(m.j[0], m.j[1]);
    const Pack inverse = Pack(1.0) / dot(m.j[0], bc);
    const PackVec rows[3] = {inverse * bc, inverse * ca, inverse * ab};
    const auto rounded = [&](const Pack& p)
                             HWY_ATTR { return Pack(hn::PromoteTo(d, hn::DemoteTo(df, p.v))); };
    Pack slack[3], rounding[3], constant[3];
    PackVec kept[3];
    for (int a = 0; a < 3; ++a) {
      const PackVec r{rounded(rows[a].x), rounded(rows[a].y), rounded(rows[a].z)};
      kept[a] = r;
      constant[a] = Pack(m.at[a]) - dot(r, m.anchor);
      const Pack sum = absolute(r.x) + absolute(r.y) + absolute(r.z);
      slack[a] = rounding[a] =
          sum * Pack(slab.rounding + 0x1p-19 * reach) + Pack(0x1p-20) * absolute(constant[a]);
      for (int b = 0; b < 3; ++b)
        slack[a] =
            slack[a] + Pack(m.range[b]) * absolute(dot(r, m.j[b]) - Pack(a == b ? 1.0 : 0.0));
      for (int k = 0; k < m.rests; ++k)
        slack[a] = slack[a] + absolute(dot(r, m.rest[k]));
    }
    // Of the likelihoods below, each takes at most so many coordinates.
    const Pack all = is_hexahedron ? larger(slack[0], larger(slack[1], slack[2]))
                                   : slack[0] + slack[1] + slack[2];
    // No inverse to speak of: then the cell is looked at last, but for all samples about it.
    const auto sound = all < Pack(1e3);
    const Pack zero(0.0);
    for (int a = 0; a < 3; ++a) {
      store(select(sound, kept[a].x, zero), out.affine[4 * a]);
      store(select(sound, kept[a].y, zero), out.affine[4 * a + 1]);
      store(select(sound, kept[a].z, zero), out.affine[4 * a + 2]);
      store(select(sound, constant[a], Pack(is_hexahedron ? 1.49 : -0.99)), out.affine[4 * a + 3]);
    }
    store(select(sound, all + Pack(1e-6), Pack(unsound_slack)), out.slack);
    if (is_hexahedron) {
      store(larger(rounding[0], larger(rounding[1], rounding[2])), out.rounding);
      for (int k = 0; k < 4; ++k)
        for (int a = 0; a < 3; ++a)
          store(Pack(k < 3 ? 4.0 : 8.0) * dot(kept[a], m.rest[k]), out.bends[3 * k + a]);
    }
  }
}

/// How deep in the reference cell linear coordinates lie: the smallest slack of its inequalities.
template <Shape shape>
HWY_INLINE FloatVec likelihood(const FloatVec& r, const FloatVec& s, const FloatVec& t) {
  const Floats d;
  const auto one = hn::Set(d, 1.0f), half = hn::Set(d, 0.5f);
  if constexpr (shape == Shape::hexahedron)
    return hn::Sub(half, hn::Max(hn::Abs(r), hn::Max(hn::Abs(s), hn::Abs(t))));
  if constexpr (shape == Shape::tetrahedron)
    return hn::Min(hn::Min(r, s), hn::Min(t, hn::Sub(hn::Sub(one, r), hn::Add(s, t))));
  if constexpr (shape == Shape::wedge)
    return hn::Min(hn::Min(r, s), hn::Min(hn::Sub(one, hn::Add(r, s)), hn::Sub(half, hn::Abs(t))));
  return hn::Min(hn::Min(hn::Min(r, hn::Sub(t, r)), hn::Min(s, hn::Sub(t, s))), hn::Sub(one, t));
}

} // namespace insitu::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
