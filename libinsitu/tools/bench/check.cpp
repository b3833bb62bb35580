#include "check.h"

#include <algorithm>
#include <cmath>

#include "cells/contain_exact.h"

namespace insitu::bench {

Verdict check(const workload::Mesh& mesh, const workload::Queries& queries,
              std::span<const std::int64_t> cells, std::span<const double> values,
              std::span<const std::uint8_t> expected_outside, bool tells_cells) {
  Verdict out;
  for (std::size_t i = 0; i < queries.points.size(); ++i) {
    if (cells[i] < 0) {
      out.lost += expected_outside.empty() || !expected_outside[i];
      continue;
    }
    const math::Vec3d& p = queries.points[i];
    const double error = std::fabs(values[i] - workload::field(p));
    out.max_error = error <= out.max_error ? out.max_error : error; // a NaN stays
    // The cell that a point was made in need not be asked again; any other may own it by a tie.
    if (!tells_cells || (!queries.made_in.empty() && cells[i] == queries.made_in[i]))
      continue;
    math::Vec3d x[8];
    mesh.gather(cells[i], x);
    out.wrong += !cells::holds(cells::contain_exact(mesh.shape(cells[i]), x, p).where);
  }
  return out;
}

} // namespace insitu::bench
