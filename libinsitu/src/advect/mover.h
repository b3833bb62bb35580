#pragma once

#include "advect/drift.h"
#include "advect/effects.h"
#include "advect/inertia.h"
#include "advect/integrate.h"
#include "advect/mesh_velocity.h"
#include "advect/particles.h"
#include "advect/random_walk.h"
#include "advect/snapshots.h"
#include "advect/walls.h"
#include "core/parallel.h"

namespace insitu::advect {

/// Throws Error(INSITU_ERROR_FIELD or INSITU_ERROR_ARGUMENT): see Tracer::set_effects.
void check_effects(const Effects& effects);

/// What all threads share in one advance under effects.
struct EffectSetup {
  EffectSetup(const Effects& effects, const query::Sampler& sampler, const core::Threads& threads);

  Effects effects;
  Box box;             ///< of the mesh, if a side is periodic
  math::Vec3d largest; ///< diffusion coefficient
};

inline insitu_ending ending_of(Moved moved) {
  return moved == Moved::left      ? INSITU_END_LEFT
         : moved == Moved::stopped ? INSITU_END_STOPPED
                                   : INSITU_END_ALIVE;
}

/// Moves particles under effects; the counterpart of a plain call of integrate(). One object serves
/// one thread.
class Mover {
public:
  /// The arguments must outlive the object.
  Mover(const EffectSetup& setup, MeshVelocity& flow, const IntegratorSettings& settings,
        double max_length);
  Mover(const Mover&) = delete;

  /// Where the next particle's snapshots go, or null.
  void take(SnapshotTaker<MeshVelocity>* taker) { taker_ = taker; }

  /// Moves the particle, whose last cell was `hint`, from p.time to `to`. Returns as integrate().
  insitu_ending advance(State& p, std::int64_t hint, Carried& carried, double to, Work& work);

  /// The cell of the particle's position, or -1.
  std::int64_t cell() const { return spot_cell_ >= 0 ? spot_cell_ : flow_.cell(); }
  const EffectWork& effect_work() const { return work_; }

private:
  insitu_ending flow_to(State& p, Carried& carried, double to, Work& work);
  insitu_ending fly(State& p, Carried& carried, double to, Work& work);
  insitu_ending touch(State& p, double to, Work& work);
  insitu_ending pass(State& p, Spot at);
  insitu_ending touch_flying(State& p, Carried& carried, double to, Work& work);
  insitu_ending walk(State& p, Carried& carried, double dt);
  Sampled force(const math::Vec3d& x, double t, math::Vec3d& b);
  bool place(State& p, Spot& at);
  void placed(State& p, const Spot& at);
  void take_contact(const State& p);

  const EffectSetup* setup_;
  const Effects* effects_;
  IntegratorSettings settings_;
  double max_length_;
  MeshVelocity& flow_;
  DriftVelocity velocity_;
  EffectWork work_;
  Walls walls_;
  BoundaryEffect boundary_, walk_boundary_;
  std::int64_t spot_cell_ = -1; ///< of the position, if a displacement was the last to move it
  std::int64_t steps_left_ = 0;
  SnapshotTaker<MeshVelocity>* taker_ = nullptr;
  double last_bounce_ = -1.0; ///< length of the path then; -1: none yet
};

} // namespace insitu::advect
