#include "lanes.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "numerics/exact/lanes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "cells/kernels/kernels_simd.h"

HWY_BEFORE_NAMESPACE();
namespace insitu::test::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
namespace simd = cells::HWY_NAMESPACE;
using simd::Pack;
using PackVec = simd::Vec3<Pack>;

HWY_INLINE PackVec load_vector(const double (&rows)[3][LaneBlock::size], int i) {
  const simd::PackTag d;
  return {Pack(hn::Load(d, rows[0] + i)), Pack(hn::Load(d, rows[1] + i)),
          Pack(hn::Load(d, rows[2] + i))};
}

void filter_target(mesh::Shape shape, const LaneBlock& block, cells::FilterResult* out) {
  const simd::PackTag d;
  const int lanes = int(hn::Lanes(d));
  for (int i = 0; i < block.count; i += lanes) {
    PackVec x[8];
    for (int v = 0; v < mesh::vertex_count(shape); ++v)
      x[v] = load_vector(block.vertex[v], i);
    simd::PackMask inside, outside;
    simd::filter(shape, x, load_vector(block.point, i), inside, outside);
    std::uint8_t in[8] = {}, not_in[8] = {};
    hn::StoreMaskBits(d, inside.m, in);
    hn::StoreMaskBits(d, outside.m, not_in);
    for (int k = 0; k < lanes; ++k)
      out[i + k] = in[0] >> k & 1       ? cells::FilterResult::inside
                   : not_in[0] >> k & 1 ? cells::FilterResult::outside
                                        : cells::FilterResult::undecided;
  }
}

void invert_target(mesh::Shape shape, const LaneBlock& block, cells::InverseMap<double>* out) {
  const simd::PackTag d;
  const int lanes = int(hn::Lanes(d));
  for (int i = 0; i < block.count; i += lanes) {
    PackVec x[8];
    for (int v = 0; v < mesh::vertex_count(shape); ++v)
      x[v] = load_vector(block.vertex[v], i);
    const auto map = simd::inverse_map(shape, x, load_vector(block.point, i));
    alignas(64) double row[6][8];
    hn::Store(map.r.x.v, d, row[0]);
    hn::Store(map.r.y.v, d, row[1]);
    hn::Store(map.r.z.v, d, row[2]);
    hn::Store(map.margin.v, d, row[3]);
    hn::Store(simd::select(map.converged, Pack(1.0), Pack(0.0)).v, d, row[4]);
    hn::Store(map.error.v, d, row[5]);
    for (int k = 0; k < lanes; ++k)
      out[i + k] = {{row[0][k], row[1][k], row[2][k]}, row[3][k], row[4][k] != 0.0, row[5][k]};
  }
}

} // namespace insitu::test::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace insitu::test {

HWY_EXPORT(filter_target);
HWY_EXPORT(invert_target);

void filter_lanes(mesh::Shape shape, const LaneBlock& block, cells::FilterResult* out) {
  HWY_DYNAMIC_DISPATCH(filter_target)(shape, block, out);
}
void invert_lanes(mesh::Shape shape, const LaneBlock& block, cells::InverseMap<double>* out) {
  HWY_DYNAMIC_DISPATCH(invert_target)(shape, block, out);
}

} // namespace insitu::test
#endif
