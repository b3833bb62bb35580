#pragma once

#include <span>

#include "query/batch/batch.h"

namespace insitu::query {

/// What one thread needs for batches that something else than the tree answers first; kept for the
/// thread's life, since it is small.
struct BatchAnswers {
  Location locations[batch_size];
  Reason reasons[batch_size];
  math::Vec3d rest[batch_size];   ///< points that are left
  QueryId rest_at[batch_size];    ///< their numbers
  std::int64_t guess[batch_size]; ///< cells to try for them, or -1
  QueryId one_by_one[batch_size]; ///< see Answered

  /// Of the first n points; until the next batch.
  Answered of(std::size_t n) const { return {{locations, n}, {reasons, n}}; }

  /// By the tree, the first `left` of rest.
  void answer_rest(std::size_t left, BatchLocator& tree) {
    if (left == 0)
      return;
    tree.run({rest, left});
    for (std::size_t k = 0; k < left; ++k) {
      locations[rest_at[k]] = tree.locations()[k];
      reasons[rest_at[k]] = tree.reasons()[k];
    }
  }
};

} // namespace insitu::query
