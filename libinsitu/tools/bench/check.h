#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "workload/mesh.h"
#include "workload/queries.h"

namespace insitu::bench {

/// What the answers to a set of queries are worth.
struct Verdict {
  std::int64_t lost = 0;       ///< no cell, though one holds the point
  std::int64_t wrong = 0;      ///< a cell that does not hold the point, by exact arithmetic
  std::int64_t not_lowest = 0; ///< a cell that holds the point, but not the lowest id that does
  double max_error = 0.0;      ///< of the field, over found points
};

/// owners: the true answer to each point, -1 for none; or empty: every point has one, not known
/// which. cells: the answers, -1 for none. values: the sampled field. tells_cells: whether an
/// answer means more than found or not.
Verdict check(const workload::Mesh& mesh, const workload::Queries& queries,
              std::span<const std::int64_t> owners, std::span<const std::int64_t> cells,
              std::span<const double> values, bool tells_cells = true);

} // namespace insitu::bench
