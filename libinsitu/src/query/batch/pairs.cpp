#include "query/batch/pairs.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/batch/pairs.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "cells/kernels/pack_pair_simd.h"

HWY_BEFORE_NAMESPACE();
namespace insitu::query::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
namespace simd = cells::HWY_NAMESPACE;
using simd::Pack;
using PackVec = simd::Vec3<Pack>;

template <class Put>
HWY_INLINE void load_pairs(const PairBlock& block, int i, int vertices, const Put& put,
                           PackVec& p) {
  for (int v = 0; v < vertices; ++v)
    put(v, PackVec{simd::load_pack(block.cells.vertex[v][0] + i),
                   simd::load_pack(block.cells.vertex[v][1] + i),
                   simd::load_pack(block.cells.vertex[v][2] + i)});
  p = {simd::load_pack(block.point[0] + i), simd::load_pack(block.point[1] + i),
       simd::load_pack(block.point[2] + i)};
}

/// What an inverse map found for the pairs of a pack, from i on.
HWY_INLINE void store_found(const simd::InverseMap<Pack>& found, int i, PairBlock& block) {
  const simd::PackTag d;
  hn::Store(found.r.x.v, d, block.parametric[0] + i);
  hn::Store(found.r.y.v, d, block.parametric[1] + i);
  hn::Store(found.r.z.v, d, block.parametric[2] + i);
  hn::Store(found.margin.v, d, block.margin + i);
  hn::Store(found.error.v, d, block.error + i);
  block.converged |= std::uint64_t(simd::lane_bits(found.converged)) << i;
  block.certified |= std::uint64_t(simd::lane_bits(found.margin > found.error)) << i;
  const simd::PackMask on_boundary = simd::is_on_boundary(found.margin, found.error);
  block.on_boundary |= std::uint64_t(simd::lane_bits(on_boundary)) << i;
}

void invert_target(mesh::Shape shape, PairBlock& block) {
  block.converged = block.certified = block.on_boundary = 0;
  simd::with_inverse(shape, [&](auto vertices, const auto& map) HWY_ATTR {
    simd::invert_range<vertices()>(
        map, 0, block.cells.count,
        [&]<class Put>(int, int i, const Put& put, PackVec& p)
            HWY_ATTR { load_pairs(block, i, vertices(), put, p); },
        [&](int, int i, const simd::InverseMap<Pack>& found)
            HWY_ATTR { store_found(found, i, block); });
  });
  // The last pack's idle lanes may repeat a point that was proven.
  block.converged &= block.cells.all();
  block.certified &= block.cells.all();
  block.on_boundary &= block.cells.all();
}

void contain_target(mesh::Shape shape, PairBlock& block) {
  const int lanes = int(hn::Lanes(simd::PackTag())), vertices = mesh::vertex_count(shape);
  block.inside = block.outside = 0;
  for (int i = 0; i < block.cells.count; i += lanes) {
    PackVec x[8], p;
    load_pairs(block, i, vertices, simd::PutWhole{x}, p);
    simd::PackMask inside, outside;
    simd::filter(shape, x, p, inside, outside);
    block.inside |= std::uint64_t(simd::lane_bits(inside)) << i;
    block.outside |= std::uint64_t(simd::lane_bits(outside)) << i;
  }
}

} // namespace insitu::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace insitu::query {

HWY_EXPORT(invert_target);
HWY_EXPORT(contain_target);

namespace {

void fill_up(mesh::Shape shape, PairBlock& block) {
  block.cells.fill_up(shape);
  for (int i = block.cells.count; i % 8 != 0; ++i)
    for (int a = 0; a < 3; ++a)
      block.point[a][i] = block.point[a][0];
}

} // namespace

void invert(mesh::Shape shape, PairBlock& block) {
  fill_up(shape, block);
  HWY_DYNAMIC_DISPATCH(invert_target)(shape, block);
}

void contain(mesh::Shape shape, PairBlock& block) {
  fill_up(shape, block);
  HWY_DYNAMIC_DISPATCH(contain_target)(shape, block);
}

} // namespace insitu::query
#endif
