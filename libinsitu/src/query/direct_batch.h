#pragma once

#include <span>

#include "query/batch.h"

namespace insitu::query {

/// What one thread needs for them; kept for the thread's life, since it is small.
struct DirectScratch {
  Location locations[batch_size];
  Reason reasons[batch_size];
  math::Vec3d rest[batch_size]; ///< points that are left
  QueryId rest_at[batch_size];  ///< their numbers
};

/// Answers batches on lattices: first by the points' places, without a tree, then through it those
/// without an owner, unless Finder::finds_all. Finder: bool find(point, location, reason), an owner
/// proven by the arithmetic of boxes, or none.
template <class Finder>
class DirectBatch {
public:
  DirectBatch(const Finder& finder, BatchLocator& locator, DirectScratch& scratch)
      : finder_(finder), locator_(locator), s_(scratch) {}

  Answered run(std::span<const math::Vec3d> points) {
    std::size_t left = 0;
    for (std::size_t q = 0; q < points.size(); ++q) {
      s_.locations[q] = {};
      const bool found = finder_.find(points[q], s_.locations[q], s_.reasons[q]);
      s_.rest[left] = points[q];
      s_.rest_at[left] = QueryId(q);
      left += !found;
    }
    if (!Finder::finds_all && left > 0) {
      locator_.run({s_.rest, left});
      for (std::size_t k = 0; k < left; ++k) {
        s_.locations[s_.rest_at[k]] = locator_.locations()[k];
        s_.reasons[s_.rest_at[k]] = locator_.reasons()[k];
      }
    }
    return {{s_.locations, points.size()}, {s_.reasons, points.size()}};
  }

private:
  Finder finder_;
  BatchLocator& locator_;
  DirectScratch& s_;
};

} // namespace insitu::query
