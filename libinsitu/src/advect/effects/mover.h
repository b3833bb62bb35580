#pragma once

#include <optional>

#include "advect/effects/drift.h"
#include "advect/effects/effects.h"
#include "advect/effects/inertia.h"
#include "advect/effects/random_walk.h"
#include "advect/effects/sides.h"
#include "advect/effects/walls.h"
#include "advect/field/chart_velocity.h"
#include "advect/field/crossing_velocity.h"
#include "advect/integrate/integrate.h"
#include "advect/lines/recorder.h"
#include "advect/particles.h"
#include "core/parallel.h"

namespace insitu::advect {

/// Throws Error(INSITU_ERROR_FIELD or INSITU_ERROR_ARGUMENT): see Tracer::set_effects.
void check_effects(const Effects& effects);

/// What all threads share in one advance under effects.
struct EffectSetup {
  EffectSetup(const Effects& effects, const query::Sampler& sampler, const core::Threads& threads);

  Effects effects;
  Sides sides;         ///< that are periodic
  math::Vec3d largest; ///< diffusion coefficient
};

inline insitu_ending ending_of(Moved moved) {
  return moved == Moved::left      ? INSITU_END_LEFT
         : moved == Moved::stopped ? INSITU_END_STOPPED
                                   : INSITU_END_ALIVE;
}

/// Moves particles under effects; the counterpart of a plain call of integrate(). V: DriftVelocity,
/// CrossingVelocity, or ChartVelocity on a geodetic mesh. The integrator's positions (State::x) are
/// V's; displacements go between points among the cells (Space), in metres. One object serves one
/// thread.
template <class V>
class Mover final : private MarkedMover {
public:
  /// The arguments must outlive the object.
  Mover(const EffectSetup& setup, V& velocity, const IntegratorSettings& settings,
        double max_length);
  Mover(const Mover&) = delete;

  /// Who is told of the next particle's way, or null.
  void take(Recorder* recorder) { recorder_ = recorder; }

  /// Moves the particle, whose last cell was `hint`, from p.time to `to`; backwards, which neither
  /// a walk nor inertia can, the velocity that walls meet is the opposite one. Returns as
  /// integrate(), or INSITU_END_REMOVED where the recorder says so. On several processes (the
  /// velocity has a Journey, which has begun) it may go on from a mark, or end at one.
  insitu_ending advance(State& p, std::int64_t hint, Carried& carried, double to, Work& work);

  /// The cell of the particle's position, or -1.
  std::int64_t cell() const { return spot_cell_ >= 0 ? spot_cell_ : velocity_.cell(); }
  const EffectWork& effect_work() const { return work_; }
  void set_effect_work(const EffectWork& work) { work_ = work; }

private:
  const MeshVelocity& flow() const { return velocity_.flow(); }
  insitu_ending go(State& p, Carried& carried, double to, Work& work);
  insitu_ending put_back(State& p, const State& before, const Spot& start, double to);
  insitu_ending flow_to(State& p, double to, Work& work);
  insitu_ending touch(State& p, double to, Work& work);
  bool is_behind(const Spot& at, const Vec3d& n, double alpha) const;
  struct Contact;
  struct Glide;
  std::optional<insitu_ending> step_along(Contact& c, State& p, double to, Work& work);
  std::optional<insitu_ending> glided(Contact& c, const Glide& step, State& p, Work& work);
  bool same_axes(const Vec3d& x, const Vec3d& y) const;
  bool glide(const State& p, Glide& step, double to, Work& work);
  insitu_ending pass(State& p, Spot at);
  Sampled velocity_at(const Vec3d& point, double time, Vec3d& v);
  /// Of the point among the cells at which the velocity was asked last.
  Vec3d kept_inside(const Vec3d& point) { return velocity_.kept_at(point); }
  bool is_over() const { return recorder_ && recorder_->is_over(); }
  double cells_along(const Spot& at, const Vec3d& v, const Vec3d& wall, double alpha) const;
  insitu_ending walk(State& p, Carried& carried, double dt);
  bool find(const Vec3d& point, double time, Spot& at);
  bool find(const State& p, Spot& at);
  void placed(State& p, Spot at);

  // On several processes: see KeptMover.
  using Stage = KeptMover::Stage;
  void mark(KeptMover& to) const override;
  void go_on_from_mark(Carried& carried);
  void take_up();
  bool goes_on_at(Stage stage) const { return goes_on_ && now_.stage == stage; }
  bool travels() const {
    if constexpr (TravellingField<V>)
      return velocity_.journey() != nullptr;
    return false;
  }
  bool moves_on(Stage stage, std::int64_t cell);
  void name_start(KeptMover::Undo& undo) const;
  bool moves_back(const KeptMover::Undo& undo);

  // With inertia: see fly.cpp and touch_flying.cpp. x is the particle's point among the cells.
  struct Flier;
  struct FlightStep;
  insitu_ending fly(State& p, Carried& carried, double to, Work& work);
  insitu_ending fly_from(Vec3d& x, State& p, Carried& carried, double to, Work& work);
  insitu_ending feel(Flier& f);
  insitu_ending plan(const Flier& f, FlightStep& step) const;
  insitu_ending try_lengths(Flier& f, FlightStep& step);
  void try_once(const Flier& f, FlightStep& step);
  bool is_kept_back(const Flier& f, const FlightStep& step);
  double factor_after(FlightStep& step, bool is_last) const;
  insitu_ending accept(Flier& f, FlightStep& step);
  std::optional<insitu_ending> meet_flying(Vec3d& x, State& p, Carried& carried, double now);
  insitu_ending touch_flying(Vec3d& x, State& p, Carried& carried, double to, Work& work);
  Sampled force(const Vec3d& x, double t, Vec3d& b);
  Inertia law_at(const Vec3d& x) const;
  void landed(Vec3d& x, const Spot& at);

  const EffectSetup* setup_;
  const Effects* effects_;
  IntegratorSettings settings_;
  double max_length_;
  V& velocity_;
  EffectWork work_;
  Space space_;
  Walls walls_;
  BoundaryEffect boundary_, walk_boundary_; ///< the former without put_back, which is go()'s
  bool puts_back_ = false;
  std::int64_t spot_cell_ = -1; ///< of the position, if a displacement was the last to move it
  std::int64_t steps_left_ = 0;
  Recorder* recorder_ = nullptr;
  double direction_ = 1.0;    ///< in time; -1: backwards
  double last_bounce_ = -1.0; ///< length of the path then; -1: none yet
  KeptMover now_; ///< what a mark of the particle will have; spot_cell etc. are set by mark()
  bool goes_on_ = false;             ///< from there
  std::int64_t steps_before_ = 0;    ///< of the work, before this call of integrate()
  const Carried* carried_ = nullptr; ///< the particle's
  const Work* flow_work_ = nullptr;
};

/// Compiles what has been defined of Mover for every velocity.
#define INSITU_MOVERS(EXTERN)                                                                      \
  EXTERN template class Mover<DriftVelocity>;                                                      \
  EXTERN template class Mover<ChartVelocity>;                                                      \
  EXTERN template class Mover<CrossingVelocity<DriftVelocity>>;                                    \
  EXTERN template class Mover<CrossingVelocity<ChartVelocity>>;
INSITU_MOVERS(extern)

} // namespace insitu::advect
