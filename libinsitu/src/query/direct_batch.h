#pragma once

#include <span>

#include "query/batch.h"

namespace insitu::query {

/// Answers batches on lattices: first by the points' places, without a tree, then through it those
/// without an owner, unless Find::finds_all. Find: Location(point, reason), an owner proven by the
/// arithmetic of boxes, or none.
template <class Find>
class DirectBatch {
public:
  DirectBatch(const Find& find, BatchLocator& locator) : find_(find), locator_(locator) {}

  Answered run(std::span<const math::Vec3d> points) {
    std::size_t left = 0;
    for (std::size_t q = 0; q < points.size(); ++q) {
      locations_[q] = find_(points[q], reasons_[q]);
      rest_[left] = points[q];
      rest_at_[left] = QueryId(q);
      left += !locations_[q];
    }
    if (!Find::finds_all && left > 0) {
      locator_.run({rest_, left});
      for (std::size_t k = 0; k < left; ++k) {
        locations_[rest_at_[k]] = locator_.locations()[k];
        reasons_[rest_at_[k]] = locator_.reasons()[k];
      }
    }
    return {{locations_, points.size()}, {reasons_, points.size()}};
  }

private:
  Find find_;
  BatchLocator& locator_;
  Location locations_[batch_size];
  Reason reasons_[batch_size];
  math::Vec3d rest_[batch_size]; ///< points that are left
  QueryId rest_at_[batch_size];  ///< their numbers
};

} // namespace insitu::query
