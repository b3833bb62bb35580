#pragma once

#include "advect/integrate/integration.h"
#include "advect/integrate/stepping.h"
#include "advect/integrate/visitor.h"

namespace insitu::advect {

/// A field that takes its questions and answers them later: ask(x, t), and when answer(v) is called
/// both v and what was sampled are known; ask_crossing(), and answer_crossing() is what cross()
/// would be (CellwiseField). Many such fields are answered at once (lanes.h).
template <class F>
concept WaitingField = requires(F& f, const Vec3d& x, double t, Vec3d& v) {
  f.ask(x, t);
  { f.answer(v) } -> std::same_as<Sampled>;
  f.ask_crossing(x, x, t);
  { f.answer_crossing() } -> std::same_as<Crossed>;
};

/// A velocity that a coroutine waits for, if the field makes it wait.
template <VelocityField F>
class Awaited {
public:
  Awaited(F& field, const Vec3d& x, double t, Vec3d& v) : field_(field), v_(v) {
    if constexpr (WaitingField<F>)
      field.ask(x, t);
    else
      sampled_ = field(x, t, v);
  }
  bool await_ready() const { return !WaitingField<F>; }
  void await_suspend(std::coroutine_handle<>) const {}
  Sampled await_resume() {
    if constexpr (WaitingField<F>)
      return field_.answer(v_);
    return sampled_;
  }

private:
  F& field_;
  Vec3d& v_;
  Sampled sampled_ = Sampled::inside;
};

/// The same for the next cell at a face.
template <class F>
class AwaitedCrossing {
public:
  AwaitedCrossing(F& field, const Vec3d& x, const Vec3d& towards, double t) : field_(field) {
    if constexpr (WaitingField<F>)
      field.ask_crossing(x, towards, t);
    else if constexpr (CellwiseField<F>)
      crossed_ = field.cross(x, towards, t);
  }
  bool await_ready() const { return !WaitingField<F>; }
  void await_suspend(std::coroutine_handle<>) const {}
  Crossed await_resume() {
    if constexpr (WaitingField<F>)
      return field_.answer_crossing();
    return crossed_;
  }

private:
  F& field_;
  Crossed crossed_ = Crossed::nowhere;
};

/// A field whose particle may go on in another process: journey() is null where there is but one.
/// See Journey.
template <class F>
concept TravellingField = requires(F& f) {
  f.journey();
};

/// Whether the particle has come from elsewhere, in the midst of its way: takes that up.
template <class F, class Steps>
bool goes_on(F& velocity, Steps& steps, bool& settled) {
  if constexpr (TravellingField<F>)
    if (auto* const journey = velocity.journey())
      return journey->go_on(velocity, steps, settled);
  return false;
}

/// Between two steps: whether the particle goes on elsewhere.
template <class F, class Steps>
bool moves_on(const F& velocity, const Steps& steps, bool settled) {
  if constexpr (TravellingField<F>)
    if (auto* const journey = velocity.journey()) [[unlikely]]
      return journey->moves_on(velocity, steps, settled);
  return false;
}

/// Moves a particle from p.time until `to` (before p.time: backwards; may be infinite), or until
/// its path is max_length long. visit(p) is called at the start and after every step, except those
/// that only close in on an exit. A visitor that can be called with (p, DenseStep) is called so
/// after every step, those included, and at the start with p alone. By returning false, if it
/// returns a bool, it ends the way there, as INSITU_END_REMOVED unless `to` is reached. Ends with
/// INSITU_END_ALIVE at `to`, INSITU_END_EXPIRED at max_length, or why it ended. p.x is always a
/// point found inside, unless it was seeded outside or the mesh has moved away from it. Ends with
/// INSITU_END_COUNT between two steps if the particle goes on in another process (Journey). All
/// that is given by reference must outlive the coroutine.
template <class M, VelocityField F>
Stepping integration(F& velocity, const IntegratorSettings& settings, double to, double max_length,
                     State& p, Work& work, Visitor visit) {
  using Steps = Integration<M, F, Visitor>;
  Steps steps(velocity, settings, to, max_length, p, work, visit);
  Vec3d v;
  Trial trial;
  insitu_ending ending = INSITU_END_COUNT;
  bool settled = false; // for the next step, in its cell, when it was taken up there
  if (!goes_on(velocity, steps, settled)) {
    const Sampled first = co_await Awaited(velocity, p.x, p.time, v);
    ending = steps.begin(first, v);
    if (ending != INSITU_END_COUNT)
      co_return ending;
  }
  while (ending == INSITU_END_COUNT && !steps.at_end()) {
    if (!settled) {
      if (moves_on(velocity, steps, settled))
        co_return INSITU_END_COUNT;
      if (steps.confine()) {
        const Sampled sampled = co_await Awaited(velocity, p.x, steps.time(), v);
        steps.confined(sampled, v);
        if (moves_on(velocity, steps, true))
          co_return INSITU_END_COUNT;
      }
    }
    settled = false;
    ending = steps.plan();
    if (ending != INSITU_END_COUNT)
      break;
    const double t = steps.time();
    typename Steps::Verdict verdict;
    do {
      const double h = steps.h();
      trial.error = {};
      for (int s = 0; s < M::evaluations; ++s) {
        trial.x = M::point(s, p.x, h, steps.k1(), trial);
        trial.sampled = co_await Awaited(velocity, trial.x, t + M::time(s) * h, trial.k[s]);
        if (trial.sampled != Sampled::inside)
          break;
      }
      if (trial.sampled == Sampled::inside) {
        trial.v = trial.k[M::evaluations - 1];
        M::finish(trial, steps.k1());
      }
      verdict = steps.judge(trial);
      if (verdict == Steps::Verdict::crosses)
        verdict = steps.enter(
            co_await AwaitedCrossing(velocity, trial.x, steps.way(trial), steps.end_time()), trial);
    } while (verdict == Steps::Verdict::again);
    if (verdict == Steps::Verdict::ends)
      ending = steps.ending();
  }
  if (steps.finish()) {
    const Sampled sampled = co_await Awaited(velocity, p.x, p.time, v);
    steps.released(sampled);
  }
  co_return ending == INSITU_END_COUNT ? INSITU_END_ALIVE : ending;
}

/// The same by the method that the settings name.
template <VelocityField F>
Stepping integration(F& velocity, const IntegratorSettings& settings, double to, double max_length,
                     State& p, Work& work, Visitor visit) {
  switch (settings.method) {
  case Method::euler:
    return integration<Euler>(velocity, settings, to, max_length, p, work, visit);
  case Method::rk4:
    return integration<Rk4>(velocity, settings, to, max_length, p, work, visit);
  case Method::bs32:
    return integration<Bs32>(velocity, settings, to, max_length, p, work, visit);
  default:
    return integration<Dopri5>(velocity, settings, to, max_length, p, work, visit);
  }
}

/// The same at once, for a field that does not make it wait.
template <VelocityField F, class Visit>
requires(!WaitingField<F>) insitu_ending
    integrate(F& velocity, const IntegratorSettings& settings, double to, double max_length,
              State& p, Work& work, Visit&& visit) {
  Stepping stepping = integration(velocity, settings, to, max_length, p, work, Visitor(visit));
  stepping.resume();
  return stepping.ending();
}

} // namespace insitu::advect
