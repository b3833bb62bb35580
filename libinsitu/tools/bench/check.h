#pragma once

#include <cstdint>
#include <span>

#include "workload/mesh.h"
#include "workload/queries.h"

namespace insitu::bench {

/// What the answers to a set of queries are worth.
struct Verdict {
  std::int64_t lost = 0;  ///< no cell, though the point was made in one
  std::int64_t wrong = 0; ///< a cell that does not hold the point, by exact arithmetic
  double max_error = 0.0; ///< of the field, over found points
};

/// cells: the answers, -1 for none. values: the sampled field. expected_outside: whether point i
/// may rightly have no cell (marched points through a mesh that does not fill its box); empty: none
/// may.
Verdict check(const workload::Mesh& mesh, const workload::Queries& queries,
              std::span<const std::int64_t> cells, std::span<const double> values,
              std::span<const std::uint8_t> expected_outside, bool tells_cells = true);

} // namespace insitu::bench
