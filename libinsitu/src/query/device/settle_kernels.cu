#include "cells/kernels/contain_query.h"
#include "device/launch.cuh"
#include "query/device/answer.cuh"

/// What follows for points that the first kernel leaves open.
namespace insitu::query::on_device {

namespace {

constexpr int block = 128;

template <Shape S>
INSITU_HD inline cells::Decision decide_in_double_double(const Vec3d* x, const Vec3d& p,
                                                         bool& failed) {
  constexpr cells::FaceTable table = cells::face_table(S);
  cells::ContainQuery<math::DoubleDoublePredicates> query(table, x, p);
  const cells::ExactResult result = query.answer();
  failed = query.predicates().failed;
  return cells::decision_of(result);
}

struct DecidePairsKernel {
  LocateArguments a;
  INSITU_HD void operator()(std::int64_t i) const {
    const OpenPair pair = a.lists.pairs[i];
    OpenPoint& open = a.lists.open_points[pair.open];
    if (open.point == none)
      return;
    const Vec3d p = point_of(a, open.point);
    const CellPlace at = place_of<Shape::none>(a.in.mesh, pair.cell);
    bool failed = false;
    const cells::Decision decision = for_shape<Shape::none>(at, [&]<Shape S>() {
      const Gathered<S> cell(at);
      return decide_in_double_double<S>(cell.x, p, failed);
    });
    if (failed)
      a.lists.left_pairs[device::add_to(a.lists.counters + Lists::left, 1u)] = pair;
    else if (decision)
      device::lower_to(&open.best, as_best(pair.cell, decision));
  }
};

struct TakeDecidedKernel {
  LocateArguments a;
  std::uint32_t first;
  const cells::Decision* decided;
  INSITU_HD void operator()(std::int64_t i) const {
    if (!decided[i])
      return;
    const OpenPair pair = a.lists.left_pairs[first + i];
    device::lower_to(&a.lists.open_points[pair.open].best, as_best(pair.cell, decided[i]));
  }
};

template <bool map>
struct FinishKernel {
  LocateArguments a;
  INSITU_HD void operator()(std::int64_t i) const {
    const OpenPoint o = a.lists.open_points[i];
    if (o.point == none)
      return;
    const std::uint32_t cell = o.best == no_cell ? none : std::uint32_t(o.best >> 8);
    finish<map, Shape::none>(a, o.point, cell,
                             cells::Decision::from_code(std::uint8_t(o.best & 255u)),
                             point_of(a, o.point));
  }
};

struct FinishAtKernel {
  LocateArguments a;
  const OwnedPoint* owned;
  const Vec3d* parametric;
  INSITU_HD void operator()(std::int64_t i) const {
    const OwnedPoint o = owned[i];
    const CellPlace at = place_of<Shape::none>(a.in.mesh, o.cell);
    for_shape<Shape::none>(at, [&]<Shape S>() {
      write_answer(a.out, o.point, o.cell, at, Gathered<S>(at), o.decision.reason(),
                   cells::put_on(S, o.decision, parametric[i]));
    });
  }
};

template <bool hard>
struct GatherKernel {
  LocateArguments a;
  std::uint32_t first;
  PairData* out;
  INSITU_HD void operator()(std::int64_t i) const {
    std::uint32_t flat, point;
    if constexpr (hard) {
      flat = a.lists.hard_points[first + i].cell;
      point = a.lists.hard_points[first + i].point;
    } else {
      flat = a.lists.left_pairs[first + i].cell;
      point = a.lists.open_points[a.lists.left_pairs[first + i].open].point;
    }
    mesh::CellVertices cell;
    mesh::gather(a.in.mesh.view, flat, cell);
    for (int v = 0; v < cell.count; ++v)
      out[i].x[v] = cell.x[v];
    out[i].p = point_of(a, point);
    out[i].cell = flat;
    out[i].shape = cell.shape;
  }
};

} // namespace

void launch_finish(const LocateArguments& a, std::uint32_t count, StreamHandle stream) {
  const auto start = [&](const auto& kernel) {
    device::launch<block>(count, kernel, stream, "writing answers");
  };
  a.out.needs_map ? start(FinishKernel<true>{a}) : start(FinishKernel<false>{a});
}

void launch_decide_pairs(const LocateArguments& a, std::uint32_t count, StreamHandle stream) {
  device::launch<block>(count, DecidePairsKernel{a}, stream, "deciding in double-double");
}

void launch_take_decided(const LocateArguments& a, std::uint32_t first, std::uint32_t count,
                         const cells::Decision* decided, StreamHandle stream) {
  device::launch<block>(count, TakeDecidedKernel{a, first, decided}, stream,
                        "taking what the host decided");
}

void launch_finish_at(const LocateArguments& a, const OwnedPoint* owned, const Vec3d* parametric,
                      std::uint32_t count, StreamHandle stream) {
  device::launch<block>(count, FinishAtKernel{a, owned, parametric}, stream, "writing answers");
}

void launch_gather_left(const LocateArguments& a, std::uint32_t first, std::uint32_t count,
                        PairData* out, StreamHandle stream) {
  device::launch<block>(count, GatherKernel<false>{a, first, out}, stream,
                        "gathering undecided cells");
}

void launch_gather_hard(const LocateArguments& a, std::uint32_t first, std::uint32_t count,
                        PairData* out, StreamHandle stream) {
  device::launch<block>(count, GatherKernel<true>{a, first, out}, stream,
                        "gathering cells for damped iterations");
}

} // namespace insitu::query::on_device
