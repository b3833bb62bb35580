#include "accel/cuda/answer.cuh"
#include "accel/cuda/launch.h"
#include "accel/cuda/traverse.cuh"

namespace insitu::accel::cuda {

namespace {

constexpr int block = 128;

enum class Sampled : std::uint8_t { inside, outside, not_finite };

/// The velocity at points of one particle's way.
template <Shape S>
class Velocity {
public:
  __device__ Velocity(const LocateArguments& a, std::uint32_t cell) : a_(a), cell_(cell) {}

  __device__ Sampled operator()(const Vec3d& x, Vec3d& v) {
    // The last cell answers alone with a certificate, as in query::Sampler::locate.
    if (!(a_.alone && cell_ != none && sample(cell_, x, true, v))) {
      const std::uint32_t owner = find(x);
      if (owner == none)
        return Sampled::outside;
      cell_ = owner;
      sample(owner, x, false, v);
    }
    return isfinite(v.x) && isfinite(v.y) && isfinite(v.z) ? Sampled::inside : Sampled::not_finite;
  }
  __device__ std::uint32_t cell() const { return cell_; }

private:
  __device__ bool sample(std::uint32_t flat, const Vec3d& x, bool with_certificate, Vec3d& v) {
    const CellPlace at = place_of<S>(a_, flat);
    return for_shape<S>(at, [&]<Shape Of>() {
      const Gathered<Of> cell(at);
      const auto map = invert<Of>(cell.x, x);
      if (with_certificate && !(map.margin > map.error))
        return false;
      const DeviceField& field = a_.out.fields[0];
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
#pragma unroll
      for (int c = 0; c < 3; ++c) {
        double sum = weight[0] * from.load(cell.ids[0], c);
#pragma unroll
        for (int k = 1; k < Gathered<Of>::count; ++k)
          sum += weight[k] * from.load(cell.ids[k], c);
        v[c] = sum;
      }
      return true;
    });
  }

  /// Whether Newton's method puts the point in the closed cell.
  __device__ bool is_in(std::uint32_t flat, const Vec3d& x) {
    const CellPlace at = place_of<S>(a_, flat);
    return for_shape<S>(at, [&]<Shape Of>() {
      const Gathered<Of> cell(at);
      const auto map = invert<Of>(cell.x, x);
      return map.converged && map.margin >= -1e-12;
    });
  }

  /// The lowest cell proven to hold the point, on a mesh free of folds the only one; else the
  /// lowest where Newton's method puts it.
  __device__ std::uint32_t find(const Vec3d& x) {
    std::uint32_t best = none, maybe = none;
    Traversal traversal(a_.tree, x);
    while (!traversal.finished() && !(a_.alone && best != none)) {
      CandidateList list;
      traversal.run(list);
      for (int k = 0; k < list.count && !(a_.alone && best != none); ++k) {
        const std::uint32_t cell = list.cell[k];
        if (cell >= best)
          continue;
        int vertex;
        const Proof proof = prove<S>(a_, cell, x, vertex);
        if (proof == Proof::inside || proof == Proof::on_vertex)
          best = cell;
        else if (proof == Proof::undecided && cell < maybe && is_in(cell, x))
          maybe = cell;
      }
    }
    return best < maybe ? best : maybe;
  }

  const LocateArguments& a_;
  std::uint32_t cell_;
};

/// The sums are those of advect::Rk4, term by term.
template <Shape S>
__global__ void __launch_bounds__(block)
    advance_kernel(const __grid_constant__ LocateArguments a,
                   const __grid_constant__ DeviceTracers tracers) {
  const std::int64_t i = global_thread();
  if (i >= tracers.count || tracers.endings[i] != INSITU_END_ALIVE)
    return;
  double* const position = tracers.positions + 3 * i;
  Vec3d x{position[0], position[1], position[2]}, k1;
  const std::uint32_t before = tracers.cells[i];
  Velocity<S> velocity(a, before);
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
  const double h = tracers.step;
  for (std::int64_t n = 0; n < tracers.steps && ending == INSITU_END_ALIVE; ++n) {
    Vec3d k2, k3, k4, next = x + (0.5 * h) * k1;
    if (!sampled(next, k2))
      break;
    next = x + (0.5 * h) * k2;
    if (!sampled(next, k3))
      break;
    next = x + h * k3;
    if (!sampled(next, k4))
      break;
    next = x + ((h / 6) * k1 + (h / 3) * k2 + (h / 3) * k3 + (h / 6) * k4);
    if (!sampled(next, k1))
      break;
    x = next;
    cell = velocity.cell();
  }
  for (int c = 0; c < 3; ++c)
    position[c] = x[c];
  tracers.cells[i] = cell;
  tracers.endings[i] = ending;
}

} // namespace

void launch_advance(const LocateArguments& a, const DeviceTracers& tracers, cudaStream_t stream) {
  if (tracers.count == 0)
    return;
  with_shape(a.shape, [&]<Shape S>() {
    advance_kernel<S><<<blocks_for(tracers.count, block), block, 0, stream>>>(a, tracers);
  });
  check_launch("moving tracers");
}

} // namespace insitu::accel::cuda
