#pragma once

#include <cstdint>

#include "advect/effects/effects.h"
#include "advect/effects/walls.h"
#include "core/parallel.h"

namespace insitu::advect {

/// The random walk of particles, one step after the other. Its random numbers are a function of the
/// seed, the particle's id and the number of its step alone: tracks are the same whatever the
/// threads and after a restart.
class RandomWalk {
public:
  /// largest: the largest coefficient anywhere, along x and y and along z. The arguments must
  /// outlive the object.
  RandomWalk(const Diffusion& diffusion, const math::Vec3d& largest, const query::Sampler& sampler,
             insitu_accuracy accuracy)
      : diffusion_(&diffusion), largest_(largest), sampler_(&sampler), accuracy_(accuracy) {}

  /// The time of a step in a cell with these edges (in metres): the one given, or such that one
  /// step is a quarter of the cell along any axis where the coefficient is largest (a half where it
  /// is a constant).
  double step(const math::Vec3d& edges) const;

  /// Moves the particle by one step of dt, in metres about where it is
  /// (Space::level_displacement).
  /// alpha: of the fields; geometry: of the coordinates. Returns false if a coefficient there is
  /// not finite. The walk is reflected where the boundary has no other response.
  bool walk(Spot& at, double dt, std::int64_t id, std::int64_t number,
            const BoundaryEffect& boundary, double alpha, double geometry, Walls& walls,
            Moved& moved) const;

private:
  bool coefficients(const query::Location& at, double alpha, math::Vec3d& k) const;
  math::Vec3d gradients(const math::Vec3d& x, const query::Location& at, double alpha,
                        double geometry, const Space& space) const;

  const Diffusion* diffusion_;
  math::Vec3d largest_;
  const query::Sampler* sampler_;
  insitu_accuracy accuracy_;
};

/// The largest value of both coefficients' fields or constants, as RandomWalk wants it.
math::Vec3d largest_coefficients(const Diffusion& diffusion, const mesh::MeshView& mesh,
                                 const core::Threads& threads);

} // namespace insitu::advect
