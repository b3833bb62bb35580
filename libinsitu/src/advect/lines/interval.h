#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "advect/across/rounds.h"
#include "advect/effects/mover.h"
#include "advect/field/cells_beyond.h"
#include "advect/pathlines.h"

namespace insitu::advect {

/// Moves the particles of a tracer through one interval of time; see Tracer::advance(). Each way
/// of moving them has a file of its own: in lanes by the flow alone (interval_lanes.cpp), one by
/// one (interval_one_by_one.h), which interval.cpp does on the same cells and interval_crossing.cpp
/// from the cells of the step before to others; and on several processes (interval_across.cpp).
class Interval {
public:
  /// What an advance is asked for.
  struct Asked {
    const query::Sampler& sampler;
    const mesh::FieldView& velocity;
    const EarlierSteps& earlier; ///< as many steps as the interpolation takes
    double t0, t1;
    const core::Threads& threads;
    Snapshots* snapshots;           ///< or null
    const StepBefore* before;       ///< or null
    Exits* exits;                   ///< or null
    const Across* across = nullptr; ///< the processes that have the particles, or null
  };
  /// The arguments must outlive the object.
  Interval(const Asked& asked, const TracerSettings& settings, const Effects& effects,
           Particles& particles);

  Advance run();
  /// The same on several processes. Collective.
  Advance run_across();

private:
  bool is_before(double a, double b) const { return settings_.backward ? b < a : a < b; }
  double at_age(double from, double age) const {
    return settings_.backward ? from - age : from + age;
  }
  std::int64_t count() const { return std::int64_t(particles_.size()); }
  Work& work_of(std::int64_t begin) { return work_[std::size_t(begin / grain_)]; }
  /// The particle's state if it moves, and until when.
  bool prepare(std::size_t i, State& p, double& to) const;
  /// Returns how it ended, if it did.
  insitu_ending store(std::size_t i, const State& p, std::int64_t cell, insitu_ending ending,
                      double geometry_alpha);
  /// The particle's cell, if it is one of the current ones.
  std::int64_t hint(std::size_t i) const { return crosses_ ? -1 : particles_.cells[i]; }
  /// Of the velocity of one thread.
  template <class V>
  void note(const V& velocity) {
    result_.velocity_steps = velocity.velocity_steps();
    result_.blended_velocity = result_.velocity_steps > 1;
    result_.blended_geometry = velocity.blends_geometry();
  }

  EarlierSteps earlier() const { return {earlier_, asked_.earlier.before}; }
  bool moves_in_lanes() const { return !crosses_ && !asked_.sampler.chart() && !setup_; }
  void run_in_lanes();
  void run_on_same_cells();
  void run_crossing();

  /// The velocity between the step before and the current one on its own cells. V: a
  /// CrossingVelocity.
  template <class V>
  V crossing(Between what) const {
    return V(here_, velocity_, *before_, asked_.t0, asked_.t1, settings_.accuracy, effects_.drifts,
             what);
  }

  // On several processes: interval_across.cpp.
  template <class V>
  struct Leg;
  void run_across(parallel::World& world, FarCells& cells, FarCells* before);
  void carry_across(Rounds& rounds, std::span<const std::size_t> particles);
  void lanes_across(Rounds& rounds, std::span<const std::size_t> particles);
  template <class Make>
  void one_by_one_across(Rounds& rounds, std::span<const std::size_t> particles, Make&& make);
  template <class V>
  void cross_across(Rounds& rounds, std::span<const std::size_t> particles);
  template <class V>
  void crossing_across(Rounds& rounds, std::span<const std::size_t> particles);
  template <class V>
  void begin_leg(Leg<V>& leg, std::size_t i, V& velocity, const Rounds& rounds,
                 const EffectWork& effects);
  template <class V>
  std::optional<insitu_ending> come_in_across(Leg<V>& leg, V& velocity, std::int64_t hint,
                                              const KeptMover& beginning);
  template <class V>
  bool end_leg(Leg<V>& leg, std::size_t i, V& velocity, Rounds& rounds, Work& done,
               core::FunctionRef<insitu_ending(std::int64_t& cell)> end);
  void sum_up();

  // One by one: interval_one_by_one.h.
  template <class Make>
  void carry(Make&& make);
  template <class V>
  void flow(V& velocity, std::int64_t begin, std::int64_t end);
  template <class V>
  void move(V& velocity, Mover<V>& mover, std::int64_t begin, std::int64_t end);
  template <class V>
  math::Vec3d in_frame(const V& velocity, const State& p, std::int64_t cell) const;

  const Asked asked_;
  const TracerSettings& settings_;
  Effects effects_;
  mesh::FieldView velocity_;
  std::vector<mesh::FieldView> earlier_; ///< of the velocity
  std::optional<StepBefore> before_;
  Particles& particles_;
  const bool crosses_; ///< to other cells
  const IntegratorSettings integrator_;
  std::int64_t grain_; ///< particles of a chunk
  std::optional<EffectSetup> setup_;
  std::vector<Work> work_; ///< [chunk]
  std::vector<EffectWork> effect_work_;
  std::unique_ptr<const CellsBeyond> beyond_;
  const Sides no_sides_;
  query::Sampler here_; ///< on several processes: that which knows of the others, as fields do
  std::mutex left_mutex_;
  std::vector<LeftAt> left_; ///< the particles that leave, if there are exits
  Advance result_;
};

} // namespace insitu::advect
