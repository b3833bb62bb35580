#pragma once

#include <cstdint>

#include "advect/effects/kept_mover.h"
#include "advect/field/homes.h"
#include "advect/field/kept_velocity.h"
#include "advect/integrate/fields.h"
#include "advect/integrate/kept_steps.h"
#include "advect/integrate/settings.h"

namespace insitu::advect {

/// How far a Recorder has come.
struct RecorderMark {
  std::uint64_t first = 0, next = 0;
  math::Vec3d last;
  double last_time = 0.0;
  double begin = 0.0, travelled = 0.0; ///< of a line's even distances
  /// Of a line under effects: where it was, how long it was then, since which vertex distances are
  /// even, and where it may turn.
  struct Moved {
    math::Vec3d at;
    double time = 0.0, length = 0.0;
    std::uint64_t evens_from = 0;
    bool bends = false;
    math::Vec3d bend;
  } moved = {};
};

/// Who is told of a particle's way, as far as another process has to know of it.
class Marked {
public:
  virtual ~Marked() = default;
  virtual RecorderMark mark() const { return {}; }
};

/// A particle between two of its steps, in plain data: all that its integration and the velocity
/// hold but what follows from the mesh.
struct WayMark {
  std::int64_t cell; ///< its own
  CellName to;       ///< where it goes, if not to that
  bool settled;      ///< the velocity was asked in the cell into which it goes
  State p;
  Work work; ///< since the particle came to this process
  KeptSteps steps;
  KeptVelocity field;
  RecorderMark recorder;
  KeptMover mover; ///< under effects

  /// f(id) of each id of a cell.
  template <class F>
  void for_each_cell(F&& f) {
    f(cell);
    field.for_each_cell(f);
    mover.for_each_cell(f);
  }
};

/// Takes a particle through one interval of time on several processes. Before each of its steps
/// what it has come to is marked: there its way ends in this process if its cell is another's, and
/// there it is taken back where a step asks for a place that another process may hold
/// (query::Elsewhere). From a mark it goes on, in any process that has its cell, to the bit as it
/// would have here. One object serves one particle at a time.
class Journey {
public:
  explicit Journey(const Homes& homes) : homes_(&homes) {}

  /// A particle begins its way through the interval. p, work, recorder (or null): what is told of
  /// it; they must outlive the way.
  void begin(const State& p, const Work& work, const Marked* recorder) {
    watch(p, work, recorder);
    mark_.recorder = recorder ? recorder->mark() : RecorderMark{};
    is_marked_ = goes_on_ = stays_ = false;
  }
  /// A particle goes on from a mark. effects: of the mover here so far. stays: although its cell is
  /// not this process's, until it has made a step.
  void begin(const WayMark& from, bool stays, const State& p, const Work& work,
             const Marked* recorder, const EffectWork& effects = {}) {
    watch(p, work, recorder);
    mark_ = from;
    mark_.work = {};
    mark_.mover.effects = effects;
    is_marked_ = goes_on_ = true;
    stays_ = stays;
  }

  /// Whether there is a mark: not if the particle was not found inside yet, and only the
  /// recorder's is one.
  bool is_marked() const { return is_marked_; }
  const WayMark& mark() const { return mark_; }
  bool stays() const { return stays_; }

  /// For Mover: whose moves these are; where the particle goes on, if it comes from a mark, which
  /// then is taken up there unless it is in the midst of integrate(); and between two moves other
  /// than integrate()'s, with the particle in this cell: whether it goes on elsewhere.
  void set_mover(const MarkedMover* mover) { mover_ = mover; }
  const KeptMover* mover_to_go_on() const { return goes_on_ ? &mark_.mover : nullptr; }
  /// The particle's mover begins at the mark from which it comes.
  void begin_at_mark() { goes_on_ = false; }
  template <class F>
  void go_on(F& velocity) {
    goes_on_ = false;
    velocity.go_on_from(mark_.field);
  }
  template <class F>
  bool moves_on(const F& velocity, std::int64_t cell) {
    const bool has_moved = !is_marked_ || p_->time != mark_.p.time;
    return decide(velocity, {}, false, cell, has_moved);
  }

  const Homes& homes() const { return *homes_; }
  /// The particle goes to the process of this cell, wherever it is now.
  template <class F>
  void goes_to(const F& velocity, const CellName& cell) {
    (void)decide(velocity, {}, false, -1, true);
    mark_.to = cell;
  }

  // For integration().
  template <class F, class Steps>
  bool go_on(F& velocity, Steps& steps, bool& settled) {
    if (!goes_on_)
      return false;
    goes_on_ = false;
    velocity.go_on_from(mark_.field);
    steps.go_on_from(mark_.steps);
    settled = mark_.settled;
    return true;
  }
  template <class F, class Steps>
  bool moves_on(const F& velocity, const Steps& steps, bool settled) {
    const KeptSteps kept = steps.keep();
    const bool has_moved = !is_marked_ || kept.elapsed != mark_.steps.elapsed;
    return decide(velocity, kept, settled, velocity.cell(), has_moved);
  }

private:
  template <class F>
  bool decide(const F& velocity, const KeptSteps& steps, bool settled, std::int64_t cell,
              bool has_moved) {
    mark_.settled = settled;
    mark_.to = {};
    mark_.p = *p_;
    mark_.work = *work_;
    mark_.steps = steps;
    mark_.field = velocity.keep();
    if (recorder_)
      mark_.recorder = recorder_->mark();
    if (mover_)
      mover_->mark(mark_.mover);
    mark_.cell = cell;
    is_marked_ = true;
    if (cell == -1 || (cell >= 0 && homes_->is_own(cell))) // in no cell it stays where it is
      return stays_ = false;
    stays_ = stays_ && !has_moved;
    return !stays_;
  }
  void watch(const State& p, const Work& work, const Marked* recorder) {
    p_ = &p;
    work_ = &work;
    recorder_ = recorder;
    mover_ = nullptr;
  }

  const Homes* homes_;
  const State* p_ = nullptr;
  const Work* work_ = nullptr;
  const Marked* recorder_ = nullptr;
  const MarkedMover* mover_ = nullptr;
  WayMark mark_;
  bool is_marked_ = false, goes_on_ = false, stays_ = false;
};

} // namespace insitu::advect
