#pragma once

#include <span>
#include <vector>

#include "options.h"
#include "query/sampler.h"
#include "report.h"
#include "setup.h"

namespace insitu::bench {

Report commit(const Options& options);
Report locate(const Options& options);

/// The answers to a set of queries: cells as ids or -1, and the field (NaN outside).
struct Answers {
  explicit Answers(std::size_t points) : locations(points), cells(points), values(points) {}
  std::vector<query::Location> locations;
  std::vector<std::int64_t> cells;
  std::vector<double> values;
};

/// Locates, then interpolates "f": what a sample of one field costs.
void sample(const core::Threads& threads, const query::CommittedMesh& mesh,
            std::span<const math::Vec3d> points, Answers& answers,
            const query::LocateOptions& options);

} // namespace insitu::bench
