#include "advect/lane_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "advect/lane_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "cells/kernels_simd.h"

HWY_BEFORE_NAMESPACE();
namespace insitu::advect::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
namespace simd = cells::HWY_NAMESPACE;
using simd::Pack;
using PackVec = simd::Vec3<Pack>;

constexpr int most_lanes = 8;

/// Column l is from(l), an array of vectors; idle lanes repeat the last one's.
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

/// map(x, p): the inverse of one shape.
template <int vertices, class Map>
HWY_INLINE void invert_shape(mesh::Shape shape, const LaneQuery* queries, int count, int steps,
                             LaneAnswer* answers, const Map& map) {
  const simd::PackTag d;
  const int lanes = int(hn::Lanes(d));
  for (int i = 0; i < count; i += lanes) {
    const LaneQuery* const q = queries + i;
    const int n = count - i < lanes ? count - i : lanes;
    PackVec x[vertices], p[1];
    gather<vertices>(
        lanes, n, [q](int l) HWY_ATTR { return q[l].vertices; }, x);
    gather<1>(
        lanes, n, [q](int l) HWY_ATTR { return &q[l].point; }, p);
    const auto found = map(x, p[0]);
    PackVec v{Pack(0.0), Pack(0.0), Pack(0.0)};
    if (q->velocity) {
      Pack weight[8];
      simd::shape_functions(shape, found.r, weight);
      const auto sum = [&weight](const PackVec* u) HWY_ATTR {
        PackVec s = weight[0] * u[0];
        for (int k = 1; k < vertices; ++k)
          s += weight[k] * u[k];
        return s;
      };
      for (int step = 0; step < steps; ++step) {
        PackVec u[vertices];
        gather<vertices>(
            lanes, n, [q, step](int l) HWY_ATTR { return q[l].velocity[step]; }, u);
        const PackVec at_step = sum(u);
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
      answers[i + l] = {{out[0][l], out[1][l], out[2][l]},
                        out[3][l],
                        out[4][l],
                        ((converged >> l) & 1U) != 0,
                        {out[5][l], out[6][l], out[7][l]}};
  }
}

void invert_all(mesh::Shape shape, const LaneQuery* queries, int n, int steps,
                LaneAnswer* answers) {
  using mesh::Shape;
  switch (shape) {
  case Shape::tetrahedron:
    return invert_shape<4>(shape, queries, n, steps, answers,
                           [](const PackVec* x, const PackVec& p)
                               HWY_ATTR { return simd::inverse_tetrahedron(x, p); });
  case Shape::pyramid:
    return invert_shape<5>(shape, queries, n, steps, answers,
                           [](const PackVec* x, const PackVec& p)
                               HWY_ATTR { return simd::inverse_pyramid(x, p); });
  case Shape::wedge:
    return invert_shape<6>(shape, queries, n, steps, answers,
                           [](const PackVec* x, const PackVec& p)
                               HWY_ATTR { return simd::inverse_wedge(x, p); });
  default:
    return invert_shape<8>(shape, queries, n, steps, answers,
                           [shape](const PackVec* x, const PackVec& p)
                               HWY_ATTR { return simd::inverse_hexahedron(shape, x, p); });
  }
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
