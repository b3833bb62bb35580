#include "accel/cuda/answer.cuh"
#include "accel/cuda/fast_cell.h"
#include "accel/cuda/launch.h"
#include "accel/cuda/traverse.cuh"

namespace insitu::accel::cuda {

namespace {

constexpr int block = 128;

template <Shape S>
__device__ inline FastMap fast_map(const mesh::CellVertices& cell, const Vec3d& p) {
  math::Vec3f x[8];
  constexpr int most = S == Shape::none ? 8 : mesh::vertex_count(S);
#pragma unroll
  for (int v = 0; v < most; ++v)
    if (S != Shape::none || v < cell.count) {
      const Vec3d d = cell.x[v] - p;
      x[v] = {float(d.x), float(d.y), float(d.z)};
    }
  return fast_inverse(S == Shape::none ? cell.shape : S, x);
}

/// The deepest candidate that is left, or -1.
__device__ inline int deepest(const CandidateList& list, unsigned tried) {
  int next = -1;
  for (int k = 0; k < list.count; ++k)
    if (!((tried >> k) & 1u) && (next < 0 || list.depth[k] > list.depth[next]))
      next = k;
  return next;
}

template <bool from_candidates, Shape S>
__global__ void __launch_bounds__(block) fast_kernel(const __grid_constant__ LocateArguments a) {
  const std::int64_t thread = global_thread();
  if (thread >= a.count)
    return;
  const auto i = std::uint32_t(thread);
  const Vec3d p = point_of(a, i);
  mesh::CellVertices cell;
  FastMap at{};
  std::uint32_t found = none;
  if constexpr (from_candidates) {
    found = a.candidates[i];
    if (found != none) {
      if (a.out.needs_map) {
        gather_cell<S>(a, found, cell);
        at = fast_map<S>(cell, p);
      } else {
        cell.piece = a.mesh.piece_count == 1 ? 0 : a.mesh.piece_of(found);
      }
    }
  } else {
    Traversal traversal(a.tree, p);
    while (!traversal.finished() && found == none) {
      CandidateList list;
      traversal.run(list);
      unsigned tried = 0;
      for (int k; found == none && (k = deepest(list, tried)) >= 0;) {
        tried |= 1u << k;
        gather_cell<S>(a, list.cell[k], cell);
        at = fast_map<S>(cell, p);
        if (at.margin >= fast_margin)
          found = list.cell[k];
      }
    }
  }
  if (found == none)
    return write_outside(a.out, i);
  write_answer(a, i, found, cell, cells::Reason::certified,
               {double(at.r.x), double(at.r.y), double(at.r.z)});
}

} // namespace

void launch_locate_fast(const LocateArguments& a, cudaStream_t stream) {
  if (a.count == 0)
    return;
  with_shape(a.shape, [&]<Shape S>() {
    const auto launch = [&](auto kernel) {
      kernel<<<blocks_for(a.count, block), block, 0, stream>>>(a);
    };
    a.candidates ? launch(fast_kernel<true, S>) : launch(fast_kernel<false, S>);
  });
  check_launch("locating points");
}

} // namespace insitu::accel::cuda
