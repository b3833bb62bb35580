#include "query/batch/proven_batch.h"

#include <algorithm>

namespace insitu::query {

void ProvenBatch::begin(std::span<const math::Vec3d> points) {
  points_ = points;
  pairs_.set_points(points);
  std::fill_n(answers_.locations, points.size(), Location{});
  std::fill_n(answers_.reasons, points.size(), Reason::outside);
}

std::int64_t ProvenBatch::answer_rest() {
  std::size_t left = 0;
  for (std::size_t q = 0; q < points_.size(); ++q) {
    answers_.rest[left] = points_[q];
    answers_.rest_at[left] = QueryId(q);
    left += !has_answer(q);
  }
  answers_.answer_rest(left, tree_);
  return std::int64_t(left);
}

} // namespace insitu::query
