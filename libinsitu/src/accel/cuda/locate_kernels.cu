#include "accel/cuda/answer.cuh"
#include "accel/cuda/launch.h"
#include "accel/cuda/traverse.cuh"

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

/// Counts a point whose candidate was kept, or that asks the tree: once a warp, or all would wait for
/// one number.
__device__ inline void count_kept(const Lists& lists, bool kept) {
  const unsigned here = __activemask(), those = __ballot_sync(here, kept);
  const unsigned lane = threadIdx.x % 32;
  if (lane != unsigned(__ffs(int(here))) - 1)
    return;
  if (those)
    atomicAdd(lists.counters + Lists::kept, unsigned(__popc(those)));
  if (here & ~those)
    atomicAdd(lists.counters + Lists::asked, unsigned(__popc(here & ~those)));
}

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
  cells::Decision decision(cells::Reason::certified);
  int vertex = -1;
  bool proven = false;
  if (a.candidates) {
#pragma unroll 1
    for (int k = 0; k < 2 && best == none; ++k) {
      const std::uint32_t* likely = k == 0 ? a.candidates : a.others;
      const std::uint32_t candidate = likely ? likely[i] : none;
      if (candidate != none && prove<S>(a, candidate, p, vertex) == Proof::inside) {
        best = candidate;
        proven = alone;
      }
    }
    count_kept(a.lists, proven);
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
        const Proof proof = prove<S>(a, list.cell[k], p, vertex);
        if (proof == Proof::undecided)
          undecided |= 1u << k;
        if (proof != Proof::inside && proof != Proof::on_vertex)
          continue;
        best = list.cell[k]; // in exact no lower one is left in the list
        decision = proof == Proof::inside ? cells::Decision(cells::Reason::certified)
                                          : cells::Decision(cells::Reason::on_vertex, vertex);
        proven = alone && proof == Proof::inside;
      }
      if (!proven)
        for (int k = 0; k < list.count; ++k)
          if ((undecided >> k) & 1u && list.cell[k] < best)
            open.add(list.cell[k]);
    }
  }
  if (!open.close(best == none ? no_cell : as_best(best, decision)))
    finish<map, S>(a, i, best, decision, p);
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

} // namespace insitu::accel::cuda
