#include "advect/lanes/lane_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "advect/lanes/lane_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "cells/kernels/pack_pair_simd.h"

HWY_BEFORE_NAMESPACE();
namespace insitu::advect::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
namespace simd = cells::HWY_NAMESPACE;
using simd::Pack;
using PackVec = simd::Vec3<Pack>;

constexpr int most_lanes = 8;

/// Lane l of to[v] is vector v of from(l); idle lanes repeat the last one's.
template <int count, class From>
HWY_INLINE void gather(int lanes, int n, const From& from, PackVec* to) {
  alignas(64) double row[3 * count][most_lanes];
  for (int l = 0; l < lanes; ++l) {
    const math::Vec3d* column = from(l < n ? l : n - 1);
    for (int v = 0; v < count; ++v) {
      row[3 * v][l] = column[v].x;
      row[3 * v + 1][l] = column[v].y;
      row[3 * v + 2][l] = column[v].z;
    }
  }
  for (int v = 0; v < count; ++v)
    to[v] = {simd::load_pack(row[3 * v]), simd::load_pack(row[3 * v + 1]),
             simd::load_pack(row[3 * v + 2])};
}

#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX2
using Row = hn::Vec<simd::PackTag>;

#if HWY_TARGET <= HWY_AVX3
constexpr int row_lanes = 8;

/// Blocks of two lanes: block k of to[m] is block m of from[k].
HWY_INLINE void transpose_blocks(const Row* from, Row* to) {
  const simd::PackTag d;
  Row even[2], odd[2];
  for (int k = 0; k < 2; ++k) {
    const Row a = from[2 * k], b = from[2 * k + 1];
    even[k] = hn::OddEvenBlocks(hn::SwapAdjacentBlocks(b), a);
    odd[k] = hn::OddEvenBlocks(b, hn::SwapAdjacentBlocks(a));
  }
  to[0] = hn::ConcatLowerLower(d, even[1], even[0]);
  to[1] = hn::ConcatLowerLower(d, odd[1], odd[0]);
  to[2] = hn::ConcatUpperUpper(d, even[1], even[0]);
  to[3] = hn::ConcatUpperUpper(d, odd[1], odd[0]);
}
#else
constexpr int row_lanes = 4;

HWY_INLINE void transpose_blocks(const Row* from, Row* to) {
  const simd::PackTag d;
  to[0] = hn::ConcatLowerLower(d, from[1], from[0]);
  to[1] = hn::ConcatUpperUpper(d, from[1], from[0]);
}
#endif

/// Lane l of to[m] is lane m of from[l].
HWY_INLINE void transpose(const Row* from, Row* to) {
  constexpr int half = row_lanes / 2;
  const simd::PackTag d;
  Row lower[half], upper[half], even[half], odd[half];
  for (int k = 0; k < half; ++k) {
    lower[k] = hn::InterleaveLower(d, from[2 * k], from[2 * k + 1]);
    upper[k] = hn::InterleaveUpper(d, from[2 * k], from[2 * k + 1]);
  }
  transpose_blocks(lower, even);
  transpose_blocks(upper, odd);
  for (int k = 0; k < half; ++k) {
    to[2 * k] = even[k];
    to[2 * k + 1] = odd[k];
  }
}

/// gather() of a cell's vertices, or of what there is at them: room for eight.
template <int count, class From>
HWY_INLINE void gather_cells(int, int n, const From& from, PackVec* to) {
  constexpr int blocks = (3 * count + row_lanes - 1) / row_lanes;
  static_assert(blocks * row_lanes <= 24);
  const simd::PackTag d;
  const double* column[row_lanes];
  for (int l = 0; l < row_lanes; ++l)
    column[l] = &from(l < n ? l : n - 1)->x;
  Row rows[blocks * row_lanes];
  for (int b = 0; b < blocks; ++b) {
    Row given[row_lanes];
    for (int l = 0; l < row_lanes; ++l)
      given[l] = hn::LoadU(d, column[l] + b * row_lanes);
    transpose(given, rows + b * row_lanes);
  }
  for (int v = 0; v < count; ++v)
    to[v] = {Pack(rows[3 * v]), Pack(rows[3 * v + 1]), Pack(rows[3 * v + 2])};
}
#else
template <int count, class From>
HWY_INLINE void gather_cells(int lanes, int n, const From& from, PackVec* to) {
  gather<count>(lanes, n, from, to);
}
#endif

/// What an inverse map found, and the velocity there, of n lanes.
template <int vertices>
HWY_INLINE void answer(mesh::Shape shape, const LaneQuery* q, int n, int steps,
                       const simd::InverseMap<Pack>& found, LaneAnswer* answers) {
  const simd::PackTag d;
  const int lanes = int(hn::Lanes(d));
  PackVec v{Pack(0.0), Pack(0.0), Pack(0.0)};
  if (q->velocity) {
    Pack weight[8];
    simd::shape_functions(shape, found.r, weight);
    for (int step = 0; step < steps; ++step) {
      PackVec u[vertices];
      gather_cells<vertices>(
          lanes, n, [q, step](int l) HWY_ATTR { return q[l].velocity[step]; }, u);
      PackVec at_step = weight[0] * u[0];
      for (int k = 1; k < vertices; ++k)
        at_step += weight[k] * u[k];
      if (steps == 1) {
        v = at_step;
        break;
      }
      alignas(64) double row[most_lanes];
      for (int l = 0; l < lanes; ++l)
        row[l] = q[l < n ? l : n - 1].weights[step];
      const PackVec part = simd::load_pack(row) * at_step;
      v = step == 0 ? part : v + part;
    }
  }
  alignas(64) double out[8][most_lanes];
  const Pack rows[] = {found.r.x, found.r.y, found.r.z, found.margin, found.error, v.x, v.y, v.z};
  for (int k = 0; k < 8; ++k)
    hn::Store(rows[k].v, d, out[k]);
  const unsigned converged = simd::lane_bits(found.converged);
  for (int l = 0; l < n; ++l)
    answers[l] = {{out[0][l], out[1][l], out[2][l]},
                  out[3][l],
                  out[4][l],
                  ((converged >> l) & 1U) != 0,
                  {out[5][l], out[6][l], out[7][l]}};
}

void invert_all(mesh::Shape shape, const LaneQuery* queries, int count, int steps,
                LaneAnswer* answers) {
  const int lanes = int(hn::Lanes(simd::PackTag()));
  simd::with_inverse(shape, [&](auto vertices, const auto& map) HWY_ATTR {
    const auto in_pack = [&](int i) HWY_ATTR { return count - i < lanes ? count - i : lanes; };
    simd::invert_range<vertices()>(
        map, 0, count,
        [&]<class Put>(int, int i, const Put& put, PackVec& p) HWY_ATTR {
          const LaneQuery* const q = queries + i;
          PackVec x[vertices()];
          gather_cells<vertices()>(
              lanes, in_pack(i), [q](int l) HWY_ATTR { return q[l].vertices; }, x);
          for (int v = 0; v < vertices(); ++v)
            put(v, x[v]);
          gather<1>(
              lanes, in_pack(i), [q](int l) HWY_ATTR { return &q[l].point; }, &p);
        },
        [&](int, int i, const simd::InverseMap<Pack>& found) HWY_ATTR {
          answer<vertices()>(shape, queries + i, in_pack(i), steps, found, answers + i);
        });
  });
}

} // namespace insitu::advect::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace insitu::advect {

HWY_EXPORT(invert_all);

void invert_lanes(mesh::Shape shape, const LaneQuery* queries, int n, int steps,
                  LaneAnswer* answers) {
  HWY_DYNAMIC_DISPATCH(invert_all)(shape, queries, n, steps, answers);
}

} // namespace insitu::advect
#endif
