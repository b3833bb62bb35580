#include "check.h"

#include <cmath>

#include "cells/exact/contain_exact.h"

namespace insitu::bench {

Verdict check(const workload::Mesh& mesh, const workload::Queries& queries,
              std::span<const std::int64_t> owners, std::span<const std::int64_t> cells,
              std::span<const double> values, bool tells_cells) {
  Verdict out;
  for (std::size_t i = 0; i < queries.points.size(); ++i) {
    if (cells[i] < 0) {
      out.lost += owners.empty() || owners[i] >= 0;
      continue;
    }
    const math::Vec3d& p = queries.points[i];
    const double error = std::fabs(values[i] - workload::field(p));
    out.max_error = error <= out.max_error ? out.max_error : error; // a NaN stays
    if (!tells_cells) {
      out.wrong += !owners.empty() && owners[i] < 0;
      continue;
    }
    // What is known to be right need not be asked again: the owner, or else the cell that a point
    // was made inside of.
    if (owners.empty() ? !queries.made_in.empty() && cells[i] == queries.made_in[i]
                       : cells[i] == owners[i])
      continue;
    if (mesh.has_faces()) { // by exact arithmetic the owners are others
      ++out.wrong;
      continue;
    }
    math::Vec3d x[8];
    mesh.gather(cells[i], x);
    const bool holds = cells::holds(cells::contain_exact(mesh.shape(cells[i]), x, p).where);
    out.wrong += !holds;
    out.not_lowest += holds && !owners.empty();
  }
  return out;
}

} // namespace insitu::bench
