#include "accel/cuda/answer.cuh"
#include "accel/cuda/launch.h"
#include "cells/kernels/contain_query.h"

/// What follows for points that the first kernel leaves open.
namespace insitu::accel::cuda {

namespace {

constexpr int block = 128;

template <Shape S>
__device__ inline cells::Decision decide_in_double_double(const Vec3d* x, const Vec3d& p,
                                                          bool& failed) {
  constexpr cells::FaceTable table = cells::face_table(S);
  cells::ContainQuery<math::DoubleDoublePredicates> query(table, x, p);
  const cells::ExactResult result = query.answer();
  failed = query.predicates().failed;
  return cells::decision_of(result);
}

__global__ void __launch_bounds__(block)
    decide_pairs_kernel(const __grid_constant__ LocateArguments a, std::uint32_t count) {
  const std::int64_t i = global_thread();
  if (i >= count)
    return;
  const OpenPair pair = a.lists.pairs[i];
  OpenPoint& open = a.lists.open_points[pair.open];
  if (open.point == none)
    return;
  const Vec3d p = point_of(a, open.point);
  const CellPlace at = place_of<Shape::none>(a, pair.cell);
  bool failed = false;
  const cells::Decision decision = for_shape<Shape::none>(at, [&]<Shape S>() {
    const Gathered<S> cell(at);
    return decide_in_double_double<S>(cell.x, p, failed);
  });
  if (failed)
    a.lists.left_pairs[atomicAdd(a.lists.counters + Lists::left, 1u)] = pair;
  else if (decision)
    atomicMin(&open.best, as_best(pair.cell, decision));
}

__global__ void take_decided_kernel(const __grid_constant__ LocateArguments a, std::uint32_t first,
                                    std::uint32_t count, const cells::Decision* decided) {
  const std::int64_t i = global_thread();
  if (i >= count || !decided[i])
    return;
  const OpenPair pair = a.lists.left_pairs[first + i];
  atomicMin(&a.lists.open_points[pair.open].best, as_best(pair.cell, decided[i]));
}

template <bool map>
__global__ void __launch_bounds__(block)
    finish_kernel(const __grid_constant__ LocateArguments a, std::uint32_t count) {
  const std::int64_t i = global_thread();
  if (i >= count)
    return;
  const OpenPoint o = a.lists.open_points[i];
  if (o.point == none)
    return;
  const std::uint32_t cell = o.best == no_cell ? none : std::uint32_t(o.best >> 8);
  finish<map, Shape::none>(a, o.point, cell,
                           cells::Decision::from_code(std::uint8_t(o.best & 255u)),
                           point_of(a, o.point));
}

__global__ void finish_at_kernel(const __grid_constant__ LocateArguments a, const OwnedPoint* owned,
                                 const Vec3d* parametric, std::uint32_t count) {
  const std::int64_t i = global_thread();
  if (i >= count)
    return;
  const OwnedPoint o = owned[i];
  const CellPlace at = place_of<Shape::none>(a, o.cell);
  for_shape<Shape::none>(at, [&]<Shape S>() {
    write_answer(a.out, o.point, o.cell, at, Gathered<S>(at), o.decision.reason(),
                 cells::put_on(S, o.decision, parametric[i]));
  });
}

template <bool hard>
__global__ void gather_kernel(const __grid_constant__ LocateArguments a, std::uint32_t first,
                              std::uint32_t count, PairData* out) {
  const std::int64_t i = global_thread();
  if (i >= count)
    return;
  std::uint32_t flat, point;
  if constexpr (hard) {
    flat = a.lists.hard_points[first + i].cell;
    point = a.lists.hard_points[first + i].point;
  } else {
    flat = a.lists.left_pairs[first + i].cell;
    point = a.lists.open_points[a.lists.left_pairs[first + i].open].point;
  }
  mesh::CellVertices cell;
  mesh::gather(a.mesh, flat, cell);
  for (int v = 0; v < cell.count; ++v)
    out[i].x[v] = cell.x[v];
  out[i].p = point_of(a, point);
  out[i].cell = flat;
  out[i].shape = cell.shape;
}

} // namespace

void launch_finish(const LocateArguments& a, std::uint32_t count, cudaStream_t stream) {
  if (count == 0)
    return;
  if (a.out.needs_map)
    finish_kernel<true><<<blocks_for(count, block), block, 0, stream>>>(a, count);
  else
    finish_kernel<false><<<blocks_for(count, block), block, 0, stream>>>(a, count);
  check_launch("writing answers");
}

void launch_decide_pairs(const LocateArguments& a, std::uint32_t count, cudaStream_t stream) {
  if (count == 0)
    return;
  decide_pairs_kernel<<<blocks_for(count, block), block, 0, stream>>>(a, count);
  check_launch("deciding in double-double");
}

void launch_take_decided(const LocateArguments& a, std::uint32_t first, std::uint32_t count,
                         const cells::Decision* decided, cudaStream_t stream) {
  if (count == 0)
    return;
  take_decided_kernel<<<blocks_for(count, block), block, 0, stream>>>(a, first, count, decided);
  check_launch("taking what the host decided");
}

void launch_finish_at(const LocateArguments& a, const OwnedPoint* owned, const Vec3d* parametric,
                      std::uint32_t count, cudaStream_t stream) {
  if (count == 0)
    return;
  finish_at_kernel<<<blocks_for(count, block), block, 0, stream>>>(a, owned, parametric, count);
  check_launch("writing answers");
}

void launch_gather_left(const LocateArguments& a, std::uint32_t first, std::uint32_t count,
                        PairData* out, cudaStream_t stream) {
  if (count == 0)
    return;
  gather_kernel<false><<<blocks_for(count, block), block, 0, stream>>>(a, first, count, out);
  check_launch("gathering undecided cells");
}

void launch_gather_hard(const LocateArguments& a, std::uint32_t first, std::uint32_t count,
                        PairData* out, cudaStream_t stream) {
  if (count == 0)
    return;
  gather_kernel<true><<<blocks_for(count, block), block, 0, stream>>>(a, first, count, out);
  check_launch("gathering cells for damped iterations");
}

} // namespace insitu::accel::cuda
