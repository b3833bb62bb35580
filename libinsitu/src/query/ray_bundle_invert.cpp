#include "query/ray_bundle_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/ray_bundle_invert.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "cells/pack_pair_simd.h"

HWY_BEFORE_NAMESPACE();
namespace insitu::query::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
namespace simd = cells::HWY_NAMESPACE;
using simd::Pack;
using PackVec = simd::Vec3<Pack>;

/// Lanes from `from` on get the cell's vertices.
template <int vertices>
HWY_INLINE void set_cell(const cells::CellBlock* blocks, unsigned cell, int from, PackVec* x) {
  const simd::PackTag d;
  const cells::CellBlock& block = blocks[cell / cells::CellBlock::size];
  const unsigned column = cell % cells::CellBlock::size;
  if (from == 0) {
    for (int v = 0; v < vertices; ++v)
      x[v] = {Pack(block.vertex[v][0][column]), Pack(block.vertex[v][1][column]),
              Pack(block.vertex[v][2][column])};
    return;
  }
  const auto before = hn::FirstN(d, std::size_t(from));
  const auto put = [&](Pack& to, double value)
                       HWY_ATTR { to.v = hn::IfThenElse(before, to.v, hn::Set(d, value)); };
  for (int v = 0; v < vertices; ++v) {
    put(x[v].x, block.vertex[v][0][column]);
    put(x[v].y, block.vertex[v][1][column]);
    put(x[v].z, block.vertex[v][2][column]);
  }
}

/// The same with values.
template <int vertices>
HWY_INLINE void set_values(const ValueBlock* blocks, unsigned cell, int from, Pack* f) {
  const simd::PackTag d;
  const ValueBlock& block = blocks[cell / cells::CellBlock::size];
  const unsigned column = cell % cells::CellBlock::size;
  const auto before = hn::FirstN(d, std::size_t(from));
  for (int v = 0; v < vertices; ++v) {
    const auto value = hn::Set(d, block.vertex[v][column]);
    f[v].v = from == 0 ? value : hn::IfThenElse(before, f[v].v, value);
  }
}

/// The cells, values and points of a pack's samples from i on; values may be null.
template <int vertices>
HWY_INLINE void load_samples(const cells::CellBlock* blocks, const ValueBlock* values, int i,
                             int end, const BundleSamples& s, PackVec* x, PackVec& p, Pack* f) {
  const simd::PackTag d;
  const int lanes = int(hn::Lanes(d)), n = end - i < lanes ? end - i : lanes;
  int run = 0;
  for (int k = 1; k <= n; ++k) // a run a cell; idle lanes repeat the last one's
    if (k == n || s.cell[i + k] != s.cell[i + run]) {
      set_cell<vertices>(blocks, s.cell[i + run], run, x);
      if (values)
        set_values<vertices>(values, s.cell[i + run], run, f);
      run = k;
    }
  const auto at = [&](const double* row) HWY_ATTR { return Pack(hn::LoadU(d, row + i)); };
  p = {at(s.point[0]), at(s.point[1]), at(s.point[2])};
}

/// f: the vertices' values, or null.
template <int vertices>
HWY_INLINE void store_samples(mesh::Shape shape, const simd::InverseMap<Pack>& found, const Pack* f,
                              int i, BundleSamples& s) {
  const simd::PackTag d;
  hn::StoreU(found.r.x.v, d, s.parametric[0] + i);
  hn::StoreU(found.r.y.v, d, s.parametric[1] + i);
  hn::StoreU(found.r.z.v, d, s.parametric[2] + i);
  hn::StoreU(found.margin.v, d, s.margin + i);
  hn::StoreU(found.error.v, d, s.error + i);
  if (!f)
    return;
  Pack weight[8];
  simd::shape_functions(shape, found.r, weight);
  Pack sum = weight[0] * f[0];
  for (int v = 1; v < vertices; ++v)
    sum = sum + weight[v] * f[v];
  hn::StoreU(sum.v, d, s.value + i);
}

/// values may be null.
void invert_samples(mesh::Shape shape, const cells::CellBlock* blocks, const ValueBlock* values,
                    int begin, int end, BundleSamples& s) {
  simd::with_inverse(shape, [&](auto vertices, const auto& map) HWY_ATTR {
    Pack f[2][vertices()];
    simd::invert_range<vertices()>(
        map, begin, end,
        [&](int k, int i, PackVec* x, PackVec& p)
            HWY_ATTR { load_samples<vertices()>(blocks, values, i, end, s, x, p, f[k]); },
        [&](int k, int i, const simd::InverseMap<Pack>& found)
            HWY_ATTR { store_samples<vertices()>(shape, found, values ? f[k] : nullptr, i, s); });
  });
}

} // namespace insitu::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace insitu::query {

HWY_EXPORT(invert_samples);

void invert(mesh::Shape shape, const cells::CellBlock* blocks, const ValueBlock* values, int begin,
            int end, BundleSamples& samples) {
  HWY_DYNAMIC_DISPATCH(invert_samples)(shape, blocks, values, begin, end, samples);
}

} // namespace insitu::query
#endif
