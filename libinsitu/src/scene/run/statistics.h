#pragma once

#include <array>
#include <cstdint>

#include "insitu/insitu.h"

namespace insitu::scene {

/// Totals of a session; see insitu_report.
struct Statistics {
  std::int64_t executions = 0;
  double commit_s = 0, query_s = 0, advect_s = 0, render_s = 0, output_s = 0;
  std::int64_t keeps = 0, refits = 0, rebuilds = 0;
  std::int64_t points_located = 0, points_outside = 0;
  std::int64_t frames = 0, probe_rows = 0, files = 0, failures = 0;
};

} // namespace insitu::scene
