#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "check.h"
#include "measure.h"
#include "options.h"

namespace insitu::bench {

/// The figures of libinsitu or of a peer; what was not measured stays empty and is null in JSON.
struct Figures {
  std::string name;
  std::int64_t cells = 0;
  std::int64_t queries = 0;
  int threads = 1;
  Series build, refit, locate, sample;
  std::int64_t bytes = 0, bytes_peak = 0;
  Verdict verdict;
  bool tells_cells = true;

  double mqps(const Series& s) const {
    return s.empty() ? 0.0 : 1e-6 * double(queries) / s.median();
  }
};

struct Report {
  std::string title; ///< the mesh and the conditions, one line
  Figures ours;
  std::vector<Figures> peers;
  std::vector<std::pair<std::string, Series>> timings; ///< all that was timed, by JSON key
  std::vector<std::pair<std::string, double>> numbers; ///< further figures, by JSON key
  std::vector<std::string> notes;

  /// A peer's time a point over ours; ours: located by us, of all our points.
  double ratio(const Figures& peer, const Series& ours_located) const {
    return peer.locate.for_ratio(ours.threads) / double(peer.queries) /
           (ours_located.for_ratio(ours.threads) / double(ours.queries));
  }
};

/// The mesh and conditions, for titles.
std::string describe(const Options& options, std::int64_t cells, int threads);

/// With commas between groups of three digits.
std::string grouped(std::int64_t n);

std::string table(const Report& report);
std::string json(const Report& report, const Options& options);

} // namespace insitu::bench
