// The proof that cells hold a bundle's samples, once per Highway target. Include after
// hwy/foreach_target.h, like any per-target header of Highway.
#if defined(INSITU_QUERY_RAY_BUNDLE_CLAIMS_SIMD_H) == defined(HWY_TARGET_TOGGLE)
#ifdef INSITU_QUERY_RAY_BUNDLE_CLAIMS_SIMD_H
#undef INSITU_QUERY_RAY_BUNDLE_CLAIMS_SIMD_H
#else
#define INSITU_QUERY_RAY_BUNDLE_CLAIMS_SIMD_H
#endif

#include <algorithm>
#include <bit>
#include <cmath>
#include <hwy/highway.h>

#include "query/ray_bundle/ray_bundle_linear_simd.h"

HWY_BEFORE_NAMESPACE();
namespace insitu::query::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// The maps of up to 64 hexahedra, in columns.
struct HexahedronMaps {
  static constexpr int size = cells::CellBlock::size;
  alignas(64) double map[21][size]; ///< of TrilinearMap, vector by vector
  alignas(64) double scale[3][size];
};

HWY_INLINE void set_hexahedra(Shape shape, const cells::CellBlock& block, HexahedronMaps& out) {
  const simd::PackTag d;
  for (int i = 0; i < block.count; i += int(hn::Lanes(d))) {
    PackVec x[8];
    for (int v = 0; v < 8; ++v)
      x[v] = {simd::load_pack(block.vertex[v][0] + i), simd::load_pack(block.vertex[v][1] + i),
              simd::load_pack(block.vertex[v][2] + i)};
    const auto m = simd::trilinear_map(shape, x);
    const PackVec* const of[7] = {&m.er, &m.es, &m.et, &m.crs, &m.crt, &m.cst, &m.crst};
    PackVec scale = simd::absolute_of(m.er);
    for (int k = 0; k < 7; ++k) {
      hn::Store(of[k]->x.v, d, out.map[3 * k] + i);
      hn::Store(of[k]->y.v, d, out.map[3 * k + 1] + i);
      hn::Store(of[k]->z.v, d, out.map[3 * k + 2] + i);
      if (k > 0)
        scale += simd::absolute_of(*of[k]);
    }
    hn::Store(scale.x.v, d, out.scale[0] + i);
    hn::Store(scale.y.v, d, out.scale[1] + i);
    hn::Store(scale.z.v, d, out.scale[2] + i);
  }
}

/// A pack's samples, to the bit where RayBundleLocator::point() puts them.
HWY_INLINE PackVec points_of(const BundleClaims& to, const std::int32_t* place) {
  const simd::PackTag d;
  const hn::Rebind<std::int32_t, simd::PackTag> di;
  const hn::Rebind<std::int64_t, simd::PackTag> dl;
  const auto at = hn::LoadU(di, place);
  const auto slot = hn::And(at, hn::Set(di, bundle_rays - 1));
  const auto k = hn::PromoteTo(d, hn::ShiftRight<bundle_rays_log2>(at));
  const auto along =
      hn::Mul(hn::Add(hn::Add(hn::Set(d, to.first), k), hn::Set(d, 0.5)), hn::Set(d, to.step));
  const auto index = hn::PromoteTo(dl, slot);
  const auto coordinate = [&](int a) HWY_ATTR {
    const double* const from = to.rays->origin[a];
    const auto begin = to.one_origin ? hn::Set(d, *from) : hn::GatherIndex(d, from, index);
    return Pack(hn::Add(begin, hn::Mul(along, hn::GatherIndex(d, to.rays->direction[a], index))));
  };
  return {coordinate(0), coordinate(1), coordinate(2)};
}

/// A step of Newton's method from where the root is near already; where that is not certified, the
/// whole of it. A lane's answer does not hang on the other lanes.
HWY_INLINE simd::InverseMap<Pack> invert_near(const simd::TrilinearMap<Pack>& map, const PackVec& f,
                                              const PackVec& scale, const simd::PackMask& idle,
                                              const PackVec& start) {
  simd::InverseMap<Pack> out;
  PackVec x, a, b, c;
  map(start, x, a, b, c);
  const auto n = simd::newton_step(a, b, c, f - x);
  const Pack size = simd::largest_of(n.step);
  out.r = start + n.step;
  out.error = simd::error_of_step(size < Pack(1e-5), start, n, size, Pack(0.0), scale, false);
  const simd::PackMask near = out.error < Pack(HUGE_VAL);
  if (!simd::all_of(near | idle)) {
    PackVec r{Pack(0.5), Pack(0.5), Pack(0.5)};
    Pack error;
    out.converged = simd::newton(map, f, scale, false, r, error);
    out.r = {select(near, out.r.x, r.x), select(near, out.r.y, r.y), select(near, out.r.z, r.z)};
    out.error = select(near, out.error, error);
  }
  const Pack one(1.0);
  const auto slack = [&](const Pack& u) HWY_ATTR { return smaller(u, one - u); };
  out.margin = smaller(slack(out.r.x), smaller(slack(out.r.y), slack(out.r.z)));
  return out;
}

/// Writes down the samples that cell i, the block's, is proven to hold. f: the vertices' values in
/// it, or null.
template <int vertices>
HWY_INLINE void claim_proven(Shape shape, const simd::InverseMap<Pack>& found, const Pack* f, int i,
                             const std::int32_t* place, unsigned lanes, BundleSlab& slab,
                             const BundleClaims& to) {
  const simd::PackTag d;
  unsigned bits = simd::lane_bits(found.margin > found.error) & lanes;
  if (!bits)
    return;
  alignas(64) double value[8], r[3][8];
  if (f) {
    Pack weight[8];
    simd::shape_functions(shape, found.r, weight);
    hn::Store(simd::weighted_mean(vertices, weight, f).v, d, value);
  }
  if (to.locations) {
    hn::Store(found.r.x.v, d, r[0]);
    hn::Store(found.r.y.v, d, r[1]);
    hn::Store(found.r.z.v, d, r[2]);
  }
  const std::int64_t cell = to.cells[i];
  std::int32_t* const state = slab.state[0];
  for (; bits; bits &= bits - 1) {
    const int k = std::countr_zero(bits);
    const int at = to.answer[place[k] % bundle_rays] + place[k] / bundle_rays;
    state[place[k]] = claimed;
    if (to.locations)
      to.locations[at] = {cell, {r[0][k], r[1][k], r[2][k]}};
    if (to.samples)
      to.samples[at] = {cell, f ? value[k] : to.values->vertex[0][i]};
  }
}

/// Claims those of samples [begin, end) that cell i is proven to hold.
template <int vertices, class Inverse>
HWY_INLINE void claim_in_cell(Shape shape, int i, const CellSamples& likely, int begin, int end,
                              BundleSlab& slab, const BundleClaims& to, const Inverse& inverse) {
  const int lanes = int(hn::Lanes(simd::PackTag()));
  Pack f[8];
  if (to.values_at_vertices)
    for (int v = 0; v < vertices; ++v)
      f[v] = Pack(to.values->vertex[v][i]);
  for (int n = begin; n < end; n += lanes) {
    const unsigned use = (1u << std::min(lanes, end - n)) - 1;
    const PackVec p = points_of(to, likely.place + n);
    claim_proven<vertices>(shape, inverse(p, n, use), to.values_at_vertices ? f : nullptr, i,
                           likely.place + n, use, slab, to);
  }
}

/// Claims samples [begin, end), which hexahedron i is likely to hold.
HWY_INLINE void claim_in_hexahedron(Shape shape, const cells::CellBlock& block,
                                    const HexahedronMaps& maps, int i, const CellSamples& likely,
                                    int begin, int end, BundleSlab& slab, const BundleClaims& to) {
  const simd::PackTag d;
  const hn::Rebind<float, simd::PackTag> df;
  const auto vector = [&](int k) HWY_ATTR {
    return PackVec{Pack(maps.map[3 * k][i]), Pack(maps.map[3 * k + 1][i]),
                   Pack(maps.map[3 * k + 2][i])};
  };
  const PackVec x0{Pack(block.vertex[0][0][i]), Pack(block.vertex[0][1][i]),
                   Pack(block.vertex[0][2][i])};
  const PackVec scale{Pack(maps.scale[0][i]), Pack(maps.scale[1][i]), Pack(maps.scale[2][i])};
  claim_in_cell<8>(
      shape, i, likely, begin, end, slab, to, [&](const PackVec& p, int n, unsigned use) HWY_ATTR {
        const auto start = [&](int a) HWY_ATTR {
          return Pack(hn::PromoteTo(d, hn::LoadU(df, likely.start[a] + n)));
        };
        const simd::TrilinearMap<Pack> map{vector(0), vector(1), vector(2), vector(3),
                                           vector(4), vector(5), vector(6)};
        const simd::PackMask idle = {hn::Not(hn::FirstN(d, std::size_t(std::bit_width(use))))};
        return invert_near(map, p - x0, scale, idle, {start(0), start(1), start(2)});
      });
}

/// Of another shape.
template <Shape shape>
HWY_INLINE void claim_in_any(const cells::CellBlock& block, int i, const CellSamples& likely,
                             int begin, int end, BundleSlab& slab, const BundleClaims& to) {
  constexpr int vertices = mesh::vertex_count(shape);
  PackVec x[vertices];
  for (int v = 0; v < vertices; ++v)
    x[v] = {Pack(block.vertex[v][0][i]), Pack(block.vertex[v][1][i]), Pack(block.vertex[v][2][i])};
  claim_in_cell<vertices>(shape, i, likely, begin, end, slab, to,
                          [&](const PackVec& p, int, unsigned)
                              HWY_ATTR { return simd::inverse_map(shape, x, p); });
}

} // namespace insitu::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
