#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "advect/effects.h"
#include "advect/integrate.h"
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
  bool attached = false; ///< particles go with the mesh's material: follow() instead of advance()
};

/// What one advance did.
struct Advance {
  Counts counts; ///< after it
  Work work;
  EffectWork effects;
  bool blended_velocity = false; ///< false: the current velocity was used throughout
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
  /// values out of range.
  void set_effects(const Effects& effects);

  /// Adds particles at points (in mesh coordinates) that begin at `time`: at most the next
  /// advance's end, or they wait for the one that reaches it. Whether a point is inside is found
  /// then.
  void seed(std::span<const math::Vec3d> points, double time);

  /// Moves every living particle from t0, or from its seeding time in between, to t1. sampler and
  /// velocity are of the step at t1; earlier_velocity (or null) is of the step at t0, on the same
  /// cells, and the sampler's mesh may have the coordinates of t0 (MeshView::earlier_points). Null
  /// after a change of topology and in the first step: then the current velocity is used
  /// throughout. Throws Error(INSITU_ERROR_FIELD) if a velocity has not three components,
  /// Error(INSITU_ERROR_ARGUMENT) if t1 < t0. Particles come out the same for any thread count.
  Advance advance(const query::Sampler& sampler, const mesh::FieldView& velocity,
                  const mesh::FieldView* earlier_velocity, double t0, double t1,
                  const core::Threads& threads);

  /// Takes attached particles from t0 to t1, where the sampler's mesh is: with the same cells as
  /// before (same_cells) to the same place in their cells, otherwise they are located where they
  /// are. Particles seeded since are located, and begin there.
  Counts follow(const query::Sampler& sampler, bool same_cells, double t0, double t1,
                const core::Threads& threads);

  /// Ends the particles that are still alive as killed: the session closes.
  void finish() { particles_.kill(); }

  /// Forgets particles that have ended (their counts stay).
  void drop_ended() { particles_.drop_ended(); }

  Counts counts() const { return particles_.counts(); }
  const Particles& particles() const { return particles_; }
  std::span<const math::Vec3d> positions() const { return particles_.positions.span(); }
  const TracerSettings& settings() const { return settings_; }

private:
  TracerSettings settings_;
  Effects effects_;
  Particles particles_;
};

} // namespace insitu::advect
