#include "accel/cuda/traverse.cuh"
#include "device/launch.cuh"
#include "query/device/answer.cuh"

namespace insitu::query::on_device {

using accel::cuda::CandidateList;
using accel::cuda::Traversal;

namespace {

constexpr int block = 128;

/// Appends what the filter leaves undecided of one point.
class OpenList {
public:
  INSITU_HD OpenList(const Lists& lists, std::uint32_t point) : lists_(lists), point_(point) {}
  INSITU_HD void add(std::uint32_t cell) {
    if (place_ == none)
      place_ = device::add_to(lists_.counters + Lists::open, 1u);
    const std::uint32_t at = device::add_to(lists_.counters + Lists::pair, 1u);
    if (at < lists_.pair_room)
      lists_.pairs[at] = {place_, cell};
    else
      full_ = true;
  }
  /// True if the host has to look at the point.
  INSITU_HD bool close(unsigned long long best) {
    if (place_ == none)
      return false;
    lists_.open_points[place_] = {full_ ? none : point_, 0, best};
    if (full_)
      lists_.again_points[device::add_to(lists_.counters + Lists::again, 1u)] = point_;
    return true;
  }

private:
  const Lists& lists_;
  std::uint32_t point_, place_ = none;
  bool full_ = false;
};

/// Counts a point whose candidate was kept, or that asks the tree: once a warp, or all would wait
/// for one number.
INSITU_HD inline void count_kept(const Lists& lists, bool kept) {
#if defined(__CUDA_ARCH__)
  const unsigned here = __activemask(), those = __ballot_sync(here, kept);
  const unsigned lane = threadIdx.x % 32;
  if (lane != unsigned(device::lowest_bit(here)))
    return;
  const int kept_here = device::count_bits(those), asked_here = device::count_bits(here & ~those);
#else
  const int kept_here = kept, asked_here = !kept;
#endif
  if (kept_here > 0)
    device::add_to(lists.counters + Lists::kept, unsigned(kept_here));
  if (asked_here > 0)
    device::add_to(lists.counters + Lists::asked, unsigned(asked_here));
}

/// The list's best candidate below a rank, or -1. alone: the deepest; else the lowest id.
template <bool alone>
INSITU_HD inline int next_candidate(const CandidateList& list, unsigned tried, std::uint32_t best) {
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
struct LocateKernel {
  LocateArguments a;
  INSITU_HD void operator()(std::int64_t item) const {
    const std::uint32_t i = a.subset ? a.subset[item] : std::uint32_t(item);
    const Vec3d p = point_of(a, i);
    std::uint32_t best = none;
    cells::Decision decision(cells::Reason::certified);
    int vertex = -1;
    bool proven = false;
    if (a.candidates) {
      INSITU_NO_UNROLL
      for (int k = 0; k < 2 && best == none; ++k) {
        const std::uint32_t* likely = k == 0 ? a.candidates : a.others;
        const std::uint32_t candidate = likely ? likely[i] : none;
        if (candidate != none && prove<S>(a.in, candidate, p, vertex) == Proof::inside) {
          best = candidate;
          proven = alone;
        }
      }
      count_kept(a.lists, proven);
    }
    OpenList open(a.lists, i);
    if (!proven) {
      Traversal traversal(a.in.tree, p);
      while (!traversal.finished() && !proven) {
        CandidateList list;
        traversal.run(list);
        unsigned tried = 0, undecided = 0;
        for (int k; !proven && (k = next_candidate<alone>(list, tried, best)) >= 0;) {
          tried |= 1u << k;
          const Proof proof = prove<S>(a.in, list.cell[k], p, vertex);
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
};

} // namespace

void launch_locate(const LocateArguments& a, StreamHandle stream) {
  device::with_shape(a.in.mesh.shape, [&]<Shape S>() {
    const auto start = [&](const auto& kernel) {
      device::launch<block>(a.count, kernel, stream, "locating points");
    };
    if (a.in.alone)
      a.out.needs_map ? start(LocateKernel<true, true, S>{a})
                      : start(LocateKernel<true, false, S>{a});
    else
      a.out.needs_map ? start(LocateKernel<false, true, S>{a})
                      : start(LocateKernel<false, false, S>{a});
  });
}

} // namespace insitu::query::on_device
