#include "query/ray_bundle/ray_bundle_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/ray_bundle/ray_bundle_invert.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "cells/kernels/pack_pair_simd.h"

HWY_BEFORE_NAMESPACE();
namespace insitu::query::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
namespace simd = cells::HWY_NAMESPACE;
using simd::Pack;
using PackVec = simd::Vec3<Pack>;

/// The cells of a pack's samples: the columns that they are in, and the lanes before each but the
/// first.
struct LaneCells {
  int count = 0;
  unsigned cell[8];
  simd::PackMask before[8];

  /// Idle lanes are in the last one's.
  HWY_INLINE LaneCells(const BundleSamples& s, int i, int end) {
    const simd::PackTag d;
    const int lanes = int(hn::Lanes(d)), n = end - i < lanes ? end - i : lanes;
    for (int k = 0; k < n; ++k)
      if (k == 0 || s.cell[i + k] != s.cell[i + k - 1]) {
        cell[count] = s.cell[i + k];
        before[count++].m = hn::FirstN(d, std::size_t(k));
      }
  }

  /// A number a cell, value(cell), in the lanes.
  template <class Value>
  HWY_INLINE Pack spread(const Value& value) const {
    Pack all(value(cell[0]));
    for (int k = 1; k < count; ++k)
      all = select(before[k], all, Pack(value(cell[k])));
    return all;
  }
};

constexpr unsigned size = cells::CellBlock::size;

/// The cells, values and points of a pack's samples from i on; values may be null.
template <int vertices, class Put>
HWY_INLINE void load_samples(const cells::CellBlock* blocks, const ValueBlock* values, int i,
                             int end, const BundleSamples& s, const Put& put, PackVec& p, Pack* f) {
  const LaneCells cells(s, i, end);
  for (int v = 0; v < vertices; ++v) {
    const auto coordinate = [&](int a) HWY_ATTR {
      return cells.spread([&](unsigned c)
                              HWY_ATTR { return blocks[c / size].vertex[v][a][c % size]; });
    };
    put(v, PackVec{coordinate(0), coordinate(1), coordinate(2)});
  }
  if (values)
    for (int v = 0; v < vertices; ++v)
      f[v] =
          cells.spread([&](unsigned c) HWY_ATTR { return values[c / size].vertex[v][c % size]; });
  const simd::PackTag d;
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
  hn::StoreU(simd::weighted_mean(vertices, weight, f).v, d, s.value + i);
}

/// values may be null.
void invert_samples(mesh::Shape shape, const cells::CellBlock* blocks, const ValueBlock* values,
                    int begin, int end, BundleSamples& s) {
  simd::with_inverse(shape, [&](auto vertices, const auto& map) HWY_ATTR {
    Pack f[2][vertices()];
    simd::invert_range<vertices()>(
        map, begin, end,
        [&]<class Put>(int k, int i, const Put& put, PackVec& p)
            HWY_ATTR { load_samples<vertices()>(blocks, values, i, end, s, put, p, f[k]); },
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
