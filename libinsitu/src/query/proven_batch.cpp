#include "query/proven_batch.h"

#include <algorithm>

namespace insitu::query {

void ProvenBatch::begin(std::span<const math::Vec3d> points) {
  points_ = points;
  pairs_.set_points(points);
  std::fill_n(best_, points.size(), Location{});
  std::fill_n(reason_, points.size(), Reason::outside);
}

std::int64_t ProvenBatch::answer_rest() {
  std::size_t left = 0;
  for (std::size_t q = 0; q < points_.size(); ++q) {
    rest_[left] = QueryId(q);
    rest_points_[left] = points_[q];
    left += !has_answer(q);
  }
  if (left == 0)
    return 0;
  tree_.run({rest_points_, left});
  for (std::size_t k = 0; k < left; ++k)
    answer(rest_[k], tree_.locations()[k], tree_.reasons()[k]);
  return std::int64_t(left);
}

} // namespace insitu::query
