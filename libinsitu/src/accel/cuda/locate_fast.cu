#include "accel/cuda/fast_map.cuh"
#include "accel/cuda/launch.h"
#include "accel/cuda/traverse.cuh"

namespace insitu::accel::cuda {

namespace {

constexpr int block = 128;

/// Writes the answer if the cell holds the point, or whatever it does.
template <Shape S>
__device__ inline bool answer_from(const LocateArguments& a, std::uint32_t i, std::uint32_t flat,
                                   const Vec3d& p, bool always) {
  const CellPlace at = place_of<S>(a, flat);
  return for_shape<S>(at, [&]<Shape Of>() {
    const Gathered<Of> cell(at);
    const FastMap map = fast_map(cell, p);
    if (!always && !(map.margin >= fast_margin))
      return false;
    write_answer(a.out, i, flat, at, cell, cells::Reason::certified,
                 {double(map.r.x), double(map.r.y), double(map.r.z)});
    return true;
  });
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
  bool found = false;
  if constexpr (from_candidates) {
    const std::uint32_t candidate = a.candidates[i];
    found = candidate != none;
    if (found && a.out.needs_map) {
      answer_from<S>(a, i, candidate, p, true);
    } else if (found) {
      write_owner(a.out, i, candidate, cells::Reason::certified);
      write_cell_values(a.out, i, place_of<S>(a, candidate));
    }
  } else {
    Traversal traversal(a.tree, p);
    while (!traversal.finished() && !found) {
      CandidateList list;
      traversal.run(list);
      unsigned tried = 0;
      for (int k; !found && (k = deepest(list, tried)) >= 0;) {
        tried |= 1u << k;
        found = answer_from<S>(a, i, list.cell[k], p, false);
      }
    }
  }
  if (!found)
    write_outside(a.out, i);
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
