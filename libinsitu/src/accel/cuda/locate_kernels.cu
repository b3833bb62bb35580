#include "accel/cuda/answer.cuh"
#include "accel/cuda/launch.h"
#include "accel/cuda/traverse.cuh"
#include "cells/contain_query.h"

namespace insitu::accel::cuda {

namespace {

constexpr int block = 128;

/// Appends what the filter leaves undecided of one point.
class OpenList {
public:
  __device__ OpenList(const Lists& lists, std::uint32_t point) : lists_(lists), point_(point) {}
  __device__ void add(std::uint32_t cell) {
    if (place_ == none)
      place_ = atomicAdd(lists_.counters + Lists::open, 1u);
    const std::uint32_t at = atomicAdd(lists_.counters + Lists::pair, 1u);
    if (at < lists_.pair_room)
      lists_.pairs[at] = {place_, cell};
    else
      full_ = true;
  }
  /// True if the host has to look at the point.
  __device__ bool close(unsigned long long best) {
    if (place_ == none)
      return false;
    lists_.open_points[place_] = {full_ ? none : point_, 0, best};
    if (full_)
      lists_.again_points[atomicAdd(lists_.counters + Lists::again, 1u)] = point_;
    return true;
  }

private:
  const Lists& lists_;
  std::uint32_t point_, place_ = none;
  bool full_ = false;
};

/// The list's best candidate below a rank, or -1. alone: the deepest; else the lowest id.
template <bool alone>
__device__ inline int next_candidate(const CandidateList& list, unsigned tried,
                                     std::uint32_t best) {
  int next = -1;
  for (int k = 0; k < list.count; ++k) {
    if ((tried >> k) & 1u || list.cell[k] >= best)
      continue;
    if (next < 0 || (alone ? list.depth[k] > list.depth[next] : list.cell[k] < list.cell[next]))
      next = k;
  }
  return next;
}

template <bool alone, bool map, Shape S>
__global__ void __launch_bounds__(block) locate_kernel(const __grid_constant__ LocateArguments a) {
  const std::int64_t thread = global_thread();
  if (thread >= a.count)
    return;
  const std::uint32_t i = a.subset ? a.subset[thread] : std::uint32_t(thread);
  const Vec3d p = point_of(a, i);
  std::uint32_t best = none;
  cells::Reason reason = cells::Reason::certified;
  bool proven = false;
  if (a.candidates) {
    const std::uint32_t candidate = a.candidates[i];
    if (candidate != none && prove<S>(a, candidate, p) == Proof::inside) {
      best = candidate;
      proven = alone;
    }
    atomicAdd(a.lists.counters + (proven ? Lists::kept : Lists::asked), 1u);
  }
  OpenList open(a.lists, i);
  if (!proven) {
    Traversal traversal(a.tree, p);
    while (!traversal.finished() && !proven) {
      CandidateList list;
      traversal.run(list);
      unsigned tried = 0, undecided = 0;
      for (int k; !proven && (k = next_candidate<alone>(list, tried, best)) >= 0;) {
        tried |= 1u << k;
        const Proof proof = prove<S>(a, list.cell[k], p);
        if (proof == Proof::undecided)
          undecided |= 1u << k;
        if (proof != Proof::inside && proof != Proof::on_vertex)
          continue;
        best = list.cell[k]; // in exact no lower one is left in the list
        reason = proof == Proof::inside ? cells::Reason::certified : cells::Reason::on_vertex;
        proven = alone && proof == Proof::inside;
      }
      if (!proven)
        for (int k = 0; k < list.count; ++k)
          if ((undecided >> k) & 1u && list.cell[k] < best)
            open.add(list.cell[k]);
    }
  }
  if (!open.close(best == none ? no_cell : as_best(best, reason)))
    finish<map, S>(a, i, best, reason, p);
}

template <Shape S>
__device__ inline cells::Reason decide_in_double_double(const Vec3d* x, const Vec3d& p,
                                                        bool& failed) {
  constexpr cells::FaceTable table = cells::face_table(S);
  cells::ContainQuery<math::DoubleDoublePredicates> query(table, x, p);
  const cells::ExactResult result = query.answer();
  failed = query.predicates().failed;
  return cells::reason_of(result);
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
  const cells::Reason reason = for_shape<Shape::none>(at, [&]<Shape S>() {
    const Gathered<S> cell(at);
    return decide_in_double_double<S>(cell.x, p, failed);
  });
  if (failed)
    a.lists.left_pairs[atomicAdd(a.lists.counters + Lists::left, 1u)] = pair;
  else if (reason != cells::Reason::outside)
    atomicMin(&open.best, as_best(pair.cell, reason));
}

__global__ void take_decided_kernel(const __grid_constant__ LocateArguments a, std::uint32_t first,
                                    std::uint32_t count, const cells::Reason* decided) {
  const std::int64_t i = global_thread();
  if (i >= count || decided[i] == cells::Reason::outside)
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
  finish<map, Shape::none>(a, o.point, cell, cells::Reason(o.best & 255u), point_of(a, o.point));
}

__global__ void finish_at_kernel(const __grid_constant__ LocateArguments a, const OwnedPoint* owned,
                                 const Vec3d* parametric, std::uint32_t count) {
  const std::int64_t i = global_thread();
  if (i >= count)
    return;
  const OwnedPoint o = owned[i];
  const CellPlace at = place_of<Shape::none>(a, o.cell);
  for_shape<Shape::none>(at, [&]<Shape S>() {
    write_answer(a.out, o.point, o.cell, at, Gathered<S>(at), o.reason, parametric[i]);
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

void launch_locate(const LocateArguments& a, cudaStream_t stream) {
  if (a.count == 0)
    return;
  with_shape(a.shape, [&]<Shape S>() {
    const auto launch = [&](auto kernel) {
      kernel<<<blocks_for(a.count, block), block, 0, stream>>>(a);
    };
    if (a.alone)
      a.out.needs_map ? launch(locate_kernel<true, true, S>)
                      : launch(locate_kernel<true, false, S>);
    else
      a.out.needs_map ? launch(locate_kernel<false, true, S>)
                      : launch(locate_kernel<false, false, S>);
  });
  check_launch("locating points");
}

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
                         const cells::Reason* decided, cudaStream_t stream) {
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
