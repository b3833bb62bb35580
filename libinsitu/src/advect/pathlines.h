#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "advect/across/rounds.h"
#include "advect/effects/effects.h"
#include "advect/exits.h"
#include "advect/field/crossing_velocity.h"
#include "advect/integrate/settings.h"
#include "advect/lines/snapshots.h"
#include "advect/particles.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "mesh/view.h"
#include "query/sampler.h"

namespace insitu::advect {

struct TracerSettings {
  IntegratorSettings integrator; ///< max_steps: of one particle in one advance
  insitu_accuracy accuracy = INSITU_STANDARD;
  double duration = std::numeric_limits<double>::infinity(); ///< age at which a particle expires
  double length = std::numeric_limits<double>::infinity();   ///< length of path at which it expires
  TimeInterpolation time_interpolation = TimeInterpolation::linear; ///< of the velocity
  bool backward = false; ///< time goes back from advance to advance, and particles with it
  bool attached = false; ///< particles go with the mesh's material: follow() instead of advance()
};

/// What one advance took of the processes: sums over all of them.
struct Travel {
  std::int64_t hops = 0;      ///< of particles, from process to process
  std::int64_t questions = 0; ///< about places that no cell of the asker holds
  std::int64_t rounds = 0;    ///< of this process
  std::int64_t bytes = 0;     ///< sent, of travellers, questions and answers
};

/// What one advance did.
struct Advance {
  Counts counts; ///< after it
  Work work;
  EffectWork effects;
  Travel travel;
  bool blended_velocity = false; ///< false: the current velocity was used throughout
  int velocity_steps = 1;        ///< through which it was interpolated, the current one included
  bool blended_geometry =
      false; ///< false: the mesh did not move, or its earlier points are unknown
};

/// Particles that follow the flow from commit to commit: pathlines, and streaklines when the caller
/// seeds again at every cycle.
class Tracer {
public:
  Tracer(const TracerSettings& settings, core::Memory& memory);

  /// What particles feel in the next advances; its fields must be of their steps. Throws
  /// Error(INSITU_ERROR_FIELD or _ARGUMENT) for fields of the wrong number of components and for
  /// values out of range, or, backwards, for what has no way back: a random walk, and inertia,
  /// whose errors would grow as exp(t / response time). Attached particles have `removes` alone.
  void set_effects(const Effects& effects);

  /// Who tells apart how particles left in the next advances, or null; it must outlive them.
  void tell_exits_by(Exits* exits) { exits_ = exits; }

  /// Adds particles at points (in mesh coordinates) that begin at `time`: not beyond the next
  /// advance's end, or they wait for the one that reaches it. Whether a point is inside is found
  /// then.
  void seed(std::span<const math::Vec3d> points, double time);

  /// The same on several processes, all of which have all the points: each keeps the particles
  /// whose places now its cells own, and the root those that no process has. Collective.
  void seed(std::span<const math::Vec3d> points, double time, const query::Sampler& sampler,
            const Across& across);

  /// Moves every living particle from t0, or from its seeding time in between, to t1. sampler and
  /// velocity are of the step at t1; earlier_velocity is of the step at t0 and those before, on
  /// the same cells, and the sampler's mesh may have the coordinates of t0
  /// (MeshView::earlier_points). None in the first step: then the current velocity is used
  /// throughout; of fewer steps than the interpolation takes, those serve that there are. After a
  /// change of topology there are none either, but `before`, if not null, is the step at t0 on its
  /// own cells, and the velocity is interpolated between it and the current one
  /// (CrossingVelocity). A particle that the cells of t1 do not hold then has left. Throws
  /// Error(INSITU_ERROR_FIELD) if a velocity has not three components, Error(INSITU_ERROR_ARGUMENT)
  /// if t1 < t0, or backwards if t1 > t0. Particles come out the same for any thread count.
  /// snapshots, if not null: filled in for its times within [t0, t1]; particles go the same ways
  /// with and without it. Under effects they are, between the moments at which a random walk
  /// displaces them, on the flow's path; along walls they go by their steps' own parabola where
  /// they slide, and straight from step to step else.
  Advance advance(const query::Sampler& sampler, const mesh::FieldView& velocity,
                  const EarlierSteps& earlier_velocity, double t0, double t1,
                  const core::Threads& threads, Snapshots* snapshots = nullptr,
                  const StepBefore* before = nullptr);
  /// The same with the particles of several processes, which go to where their cells are. The
  /// sampler's mesh has the cells of other processes that touch this one's, over periodic sides and
  /// the seam of longitude too; `before` has what all processes had where these cells are. Cells
  /// beyond these that a step needs come from their owners for the interval (FarCells).
  /// Counts, work and effects are those of all processes, and so is the travel. Collective; all
  /// processes throw alike.
  Advance advance(const Across& across, const query::Sampler& sampler,
                  const mesh::FieldView& velocity, const EarlierSteps& earlier_velocity, double t0,
                  double t1, const core::Threads& threads, Snapshots* snapshots = nullptr,
                  const StepBefore* before = nullptr);

  /// Takes attached particles from t0 to t1, where the sampler's mesh is: with the same cells as
  /// before (same_cells) to the same place in their cells, otherwise they are located where they
  /// are. Particles seeded since are located, and begin there. snapshots: as of advance(), on the
  /// straight way, which material within a cell takes.
  Counts follow(const query::Sampler& sampler, bool same_cells, double t0, double t1,
                const core::Threads& threads, Snapshots* snapshots = nullptr);
  /// The same with the particles of several processes. same_cells: of all of them; else particles
  /// go to where the cells that hold them are. Returns the sum over all processes. Collective;
  /// throws parallel::AgreedError.
  Counts follow(const Across& across, const query::Sampler& sampler, bool same_cells, double t0,
                double t1, const core::Threads& threads, Snapshots* snapshots = nullptr);

  /// Ends the particles that are still alive as killed: the session closes.
  void finish() { particles_.kill(); }

  /// Forgets particles that have ended (their counts stay).
  void drop_ended() { particles_.drop_ended(); }
  /// Forgets those that went to other processes.
  void drop_gone() { particles_.drop_gone(); }

  Counts counts() const { return particles_.counts(); }
  const Particles& particles() const { return particles_; }
  /// For who brings them back from a checkpoint.
  Particles& particles() { return particles_; }
  std::span<const math::Vec3d> positions() const { return particles_.positions.span(); }
  const TracerSettings& settings() const { return settings_; }

private:
  void check_interval(double t0, double t1) const;
  EarlierSteps check_fields(const query::Sampler& sampler, const mesh::FieldView& velocity,
                            const EarlierSteps& earlier, const StepBefore* before) const;
  /// Whether a comes before b, on the way the particles go.
  bool is_before(double a, double b) const { return settings_.backward ? b < a : a < b; }
  /// When a particle that began at `from` has this age.
  double at_age(double from, double age) const {
    return settings_.backward ? from - age : from + age;
  }

  TracerSettings settings_;
  Effects effects_;
  Exits* exits_ = nullptr;
  Particles particles_;
};

} // namespace insitu::advect
