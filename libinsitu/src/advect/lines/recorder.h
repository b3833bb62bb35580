#pragma once

#include "advect/effects/flight.h"
#include "advect/field/journey.h"
#include "advect/integrate/dense.h"
#include "advect/integrate/settings.h"

namespace insitu::advect {

/// Is told by a Mover where its particle goes. Of the integrator's steps it hears as a visitor of
/// integrate(); positions are then the integrator's, and the particle's velocity still has the
/// coordinates that they are in.
class Recorder : public Marked {
public:
  /// It begins, or goes on, from there.
  virtual void operator()(const State& p) = 0;
  virtual void operator()(const State& p, const DenseStep& path) = 0;
  /// The same of one with inertia.
  virtual void flew(const State& p, const Flight& path) = 0;
  /// It went straight to p since the last call, through periodic sides if that is the shorter way;
  /// in no time, if it came in at the opposite side.
  virtual void straight(const State& p) = 0;
  /// The same on a parabola: after a part s of the time, s (1 - s) bend beside the straight way.
  /// Who does not ask for places on the way takes it as straight.
  virtual void bent(const State& p, const Vec3d& /*bend*/) { straight(p); }
  /// It was displaced to p, at p's time: so it is there at that time.
  virtual void displaced(const State& p) = 0;
  /// What it did since it was `before`, then at this point among the cells, was undone.
  virtual void back_to(const State& before, const Vec3d& point) = 0;

  /// Whether the particle has come to where it ends as removed: its mover stops then.
  virtual bool is_over() const { return false; }
};

} // namespace insitu::advect
