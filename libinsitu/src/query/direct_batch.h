#pragma once

#include <span>

#include "query/batch_answers.h"

namespace insitu::query {

/// Answers batches on lattices: first by the points' places, without a tree, then through it those
/// without an owner, unless Finder::finds_all. Finder: bool find(point, location, reason), an owner
/// proven by the arithmetic of boxes, or none; and, if it has that, find_ahead(points, n,
/// locations, reasons), how many of the next points it has answered so in one go.
template <class Finder>
class DirectBatch {
public:
  DirectBatch(const Finder& finder, BatchLocator& locator, BatchAnswers& answers)
      : finder_(finder), locator_(locator), s_(answers) {}

  Answered run(std::span<const math::Vec3d> points) {
    std::size_t left = 0;
    for (std::size_t q = 0; q < points.size(); ++q) {
      if constexpr (requires { &Finder::find_ahead; }) {
        q += finder_.find_ahead(&points[q], points.size() - q, &s_.locations[q], &s_.reasons[q]);
        if (q == points.size())
          break;
      }
      s_.locations[q] = {};
      const bool found = finder_.find(points[q], s_.locations[q], s_.reasons[q]);
      s_.rest[left] = points[q];
      s_.rest_at[left] = QueryId(q);
      left += !found;
    }
    if (!Finder::finds_all)
      s_.answer_rest(left, locator_);
    return s_.of(points.size());
  }

private:
  Finder finder_;
  BatchLocator& locator_;
  BatchAnswers& s_;
};

} // namespace insitu::query
