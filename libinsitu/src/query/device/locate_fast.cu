#include "accel/cuda/traverse.cuh"
#include "device/launch.cuh"
#include "query/device/answer.cuh"
#include "query/device/fast_map.cuh"

namespace insitu::query::on_device {

using accel::cuda::CandidateList;
using accel::cuda::Traversal;

namespace {

constexpr int block = 128;

/// Writes the answer if the cell holds the point, or whatever it does.
template <Shape S>
INSITU_HD inline bool answer_from(const LocateArguments& a, std::uint32_t i, std::uint32_t flat,
                                  const Vec3d& p, bool always) {
  const CellPlace at = place_of<S>(a.in.mesh, flat);
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
INSITU_HD inline int deepest(const CandidateList& list, unsigned tried) {
  int next = -1;
  for (int k = 0; k < list.count; ++k)
    if (!((tried >> k) & 1u) && (next < 0 || list.depth[k] > list.depth[next]))
      next = k;
  return next;
}

template <bool from_candidates, Shape S>
struct FastKernel {
  LocateArguments a;
  INSITU_HD void operator()(std::int64_t item) const {
    const auto i = std::uint32_t(item);
    const Vec3d p = point_of(a, i);
    bool found = false;
    if constexpr (from_candidates) {
      const std::uint32_t candidate = a.candidates[i];
      found = candidate != none;
      if (found && a.out.needs_map) {
        answer_from<S>(a, i, candidate, p, true);
      } else if (found) {
        write_owner(a.out, i, candidate, cells::Reason::certified);
        write_cell_values(a.out, i, place_of<S>(a.in.mesh, candidate));
      }
    } else {
      Traversal traversal(a.in.tree, p);
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
};

} // namespace

void launch_locate_fast(const LocateArguments& a, StreamHandle stream) {
  device::with_shape(a.in.mesh.shape, [&]<Shape S>() {
    const auto start = [&](const auto& kernel) {
      device::launch<block>(a.count, kernel, stream, "locating points");
    };
    a.candidates ? start(FastKernel<true, S>{a}) : start(FastKernel<false, S>{a});
  });
}

} // namespace insitu::query::on_device
