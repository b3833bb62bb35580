#include "accel/cuda/traverse.cuh"
#include "accel/locator.h"
#include "advect/device/advance.h"
#include "advect/integrate/fields.h"
#include "advect/integrate/kutta.h"
#include "cells/kernels/on_feature.h"
#include "device/launch.cuh"
#include "query/device/interpolate.cuh"
#include "query/device/proof.cuh"

namespace insitu::advect::on_device {

namespace {

using namespace query::on_device;
using accel::none;
using accel::cuda::CandidateList;
using accel::cuda::Traversal;

constexpr int block = 128;

/// The velocity at points of one particle's way.
template <Shape S>
class KernelVelocity {
public:
  INSITU_HD KernelVelocity(const AdvanceArguments& a, std::uint32_t cell) : a_(a), cell_(cell) {}

  INSITU_HD Sampled operator()(const Vec3d& x, Vec3d& v) {
    // The last cell answers alone with a certificate, as in query::Sampler::locate.
    if (!(a_.in.alone && cell_ != none && sample(cell_, x, true, v))) {
      const std::uint32_t owner = find(x);
      if (owner == none)
        return Sampled::outside;
      cell_ = owner;
      sample(owner, x, false, v);
    }
    const bool finite = v.x - v.x + (v.y - v.y) + (v.z - v.z) == 0.0;
    return finite ? Sampled::inside : Sampled::not_finite;
  }
  INSITU_HD std::uint32_t cell() const { return cell_; }

private:
  INSITU_HD bool sample(std::uint32_t flat, const Vec3d& x, bool with_certificate, Vec3d& v) {
    const CellPlace at = place_of<S>(a_.in.mesh, flat);
    return for_shape<S>(at, [&]<Shape Of>() {
      const Gathered<Of> cell(at);
      const auto map = invert<Of>(cell.x, x);
      if (with_certificate && !(map.margin > map.error))
        return false;
      const device::KernelField& field = *a_.velocity;
      const mesh::FieldPieceView& from = field.pieces[at.number];
      if (field.association == INSITU_CELL) {
        for (int c = 0; c < 3; ++c)
          v[c] = from.load(at.cell, c);
        return true;
      }
      double weight[8];
      Vec3d r = map.r;
      if (!with_certificate) // on faces to rounding is on them: what is 0 on a wall is 0 there
        r = cells::put_on_nearest(Of, cell.x, x, r, map.error);
      cells::shape_functions(Of, r, weight);
      INSITU_UNROLL
      for (int c = 0; c < 3; ++c)
        v[c] = query::on_device::interpolated(from, c, cell, weight);
      return true;
    });
  }

  /// Whether Newton's method puts the point in the closed cell.
  INSITU_HD bool is_in(std::uint32_t flat, const Vec3d& x) {
    const CellPlace at = place_of<S>(a_.in.mesh, flat);
    return for_shape<S>(at, [&]<Shape Of>() {
      const Gathered<Of> cell(at);
      const auto map = invert<Of>(cell.x, x);
      return map.converged && map.margin >= -1e-12;
    });
  }

  /// The lowest cell proven to hold the point, on a mesh free of folds the only one; else the
  /// lowest where Newton's method puts it.
  INSITU_HD std::uint32_t find(const Vec3d& x) {
    std::uint32_t best = none, maybe = none;
    Traversal traversal(a_.in.tree, x);
    while (!traversal.finished() && !(a_.in.alone && best != none)) {
      CandidateList list;
      traversal.run(list);
      for (int k = 0; k < list.count && !(a_.in.alone && best != none); ++k) {
        const std::uint32_t cell = list.cell[k];
        if (cell >= best)
          continue;
        int vertex;
        const Proof proof = prove<S>(a_.in, cell, x, vertex);
        if (proof == Proof::inside || proof == Proof::on_vertex)
          best = cell;
        else if (proof == Proof::undecided && cell < maybe && is_in(cell, x))
          maybe = cell;
      }
    }
    return best < maybe ? best : maybe;
  }

  const AdvanceArguments& a_;
  std::uint32_t cell_;
};

/// Moves one particle.
template <Shape S>
struct AdvanceKernel {
  AdvanceArguments a;
  INSITU_HD void operator()(std::int64_t i) const {
    if (a.endings[i] != INSITU_END_ALIVE)
      return;
    double* const position = a.positions + 3 * i;
    Vec3d x{position[0], position[1], position[2]}, k1;
    const std::uint32_t before = a.cells[i];
    KernelVelocity<S> velocity(a, before);
    std::uint32_t cell = before;
    std::uint8_t ending = INSITU_END_ALIVE;
    const auto sampled = [&](const Vec3d& at, Vec3d& k) {
      const Sampled s = velocity(at, k);
      if (s != Sampled::inside)
        ending = s == Sampled::outside ? INSITU_END_LEFT : INSITU_END_NOT_FINITE;
      return s == Sampled::inside;
    };
    if (sampled(x, k1))
      cell = velocity.cell();
    else if (ending == INSITU_END_LEFT && before == none)
      ending = INSITU_END_SEED_OUTSIDE;
    for (std::int64_t n = 0; n < a.steps && ending == INSITU_END_ALIVE; ++n) {
      Vec3d k2, k3, k4;
      const auto point = [&](int s) { return kutta_point(s, x, a.step, k1, k2, k3, k4); };
      if (!sampled(point(0), k2) || !sampled(point(1), k3) || !sampled(point(2), k4))
        break;
      const Vec3d next = point(3);
      if (!sampled(next, k1))
        break;
      x = next;
      cell = velocity.cell();
    }
    for (int c = 0; c < 3; ++c)
      position[c] = x[c];
    a.cells[i] = cell;
    a.endings[i] = ending;
  }
};

} // namespace

void launch_advance(const AdvanceArguments& a, std::int64_t count, device::StreamHandle stream) {
  device::with_shape(a.in.mesh.shape, [&]<Shape S>() {
    device::launch<block>(count, AdvanceKernel<S>{a}, stream, "moving tracers");
  });
}

} // namespace insitu::advect::on_device
