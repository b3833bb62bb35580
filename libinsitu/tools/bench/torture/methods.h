#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "query/sampler.h"
#include "torture/cases.h"
#include "torture/points.h"

namespace insitu::bench::torture {

/// What a method answers: cells (-1: none), parametric coordinates and, ours, why; if asked with
/// hints, these.
struct Answers {
  std::vector<std::int64_t> cells;
  std::vector<math::Vec3d> parametric;
  std::vector<query::Reason> reasons;
  std::vector<std::int64_t> hints;
};

/// A way to locate points.
struct Method {
  std::string name; ///< JSON key
  int column;       ///< 0: standard, 1: exact, from 2 on: peers
  Answers answers;
};

/// Every way of ours, through one committed mesh, then VTK's locators where there are any. Columns
/// are named in `columns`.
std::vector<Method> answer_by_all(const Case& c, const std::vector<Point>& points,
                                  std::vector<std::string>& columns);

} // namespace insitu::bench::torture
