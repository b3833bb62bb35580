#pragma once

#include <array>
#include <cstdint>

#include "insitu/insitu.h"

#include "core/timer.h"
#include "parallel/world.h"

namespace insitu::scene {

/// Totals of a session; see insitu_report.
struct Statistics {
  std::int64_t executions = 0;
  double commit_s = 0, query_s = 0, advect_s = 0, render_s = 0, output_s = 0;
  double work_s = 0; ///< in execute, but for what it waited for other processes
  std::int64_t keeps = 0, refits = 0, rebuilds = 0;
  std::int64_t points_located = 0, points_outside = 0;
  std::int64_t frames = 0, probe_rows = 0, files = 0, failures = 0;
};

/// Adds the seconds of its life to Statistics::work_s.
class WorkTimer {
public:
  WorkTimer(Statistics& to, const parallel::World& world)
      : to_(to), world_(world), waited_(world.traffic().seconds) {}
  WorkTimer(const WorkTimer&) = delete;
  WorkTimer& operator=(const WorkTimer&) = delete;
  ~WorkTimer() { to_.work_s += timer_.seconds() - (world_.traffic().seconds - waited_); }

private:
  Statistics& to_;
  const parallel::World& world_;
  const core::Timer timer_;
  const double waited_;
};

/// commit, query, advect, render, output.
using Seconds = std::array<double, 5>;
inline Seconds seconds_of(const Statistics& s) {
  return {s.commit_s, s.query_s, s.advect_s, s.render_s, s.output_s};
}

/// Seconds of several processes.
struct SecondsOfAll {
  int processes = 1;
  Seconds least{}, mean{}, greatest{};
};
/// Collective; means are of whole nanoseconds.
SecondsOfAll seconds_of_all(const Seconds& mine, parallel::World& world);

/// The seconds of all processes from one entry of the page to the next.
class ProcessSeconds {
public:
  /// Those since the last call, or since the beginning. Collective.
  SecondsOfAll since_last(const Statistics& now, parallel::World& world);
  /// The last call is as if it had not been.
  void go_back() { before_ = earlier_; }

private:
  Seconds before_{}, earlier_{};
};

} // namespace insitu::scene
