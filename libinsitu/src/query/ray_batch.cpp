#include "query/ray_batch.h"

#include <algorithm>
#include <bit>

#include "cells/robust_inverse.h"
#include "query/bit_tables.h"

namespace insitu::query {

using math::Vec3d;

RayBatch::RayBatch(const PointQuery& query, const accel::RayLocator& rays, BatchScratch& scratch,
                   BatchLocator& tree)
    : query_(query), rays_(rays), s_(scratch), tree_(tree),
      pairs_(query.mesh, query.options.alpha, scratch) {}

Answered RayBatch::run(std::span<const Vec3d> points) {
  const bool fast = query_.options.accuracy == INSITU_FAST;
  if (query_.options.alpha != 1.0 || (!fast && !query_.mesh.free_of_folds))
    return answer_by_tree(points, {});
  const std::size_t n = points.size();
  count_ = int(n);
  pairs_.set_points(points);
  rays_.find(points, {cells_, n}, fast ? std::span<std::int64_t>() : std::span(beyond_, n));
  std::fill_n(best_, n, Location{});
  std::fill_n(reason_, n, Reason::outside);
  if (fast) {
    answer_by_rule();
    return {{best_, n}, {reason_, n}};
  }
  const std::int64_t first = certify(cells_);
  const std::int64_t second = certify(beyond_);
  if (!query_.proof_is_enough())
    return answer_by_tree(points, {best_, n});
  kept += first;
  by_neighbour += second;
  answer_rest_by_tree(points);
  return {{best_, n}, {reason_, n}};
}

void RayBatch::answer_by_rule() {
  constexpr double farthest = -0.5; // beyond, Newton's method has found another part of the map
  pairs_.order(
      std::size_t(count_), [&](std::size_t q) { return cells_[q]; },
      [](std::size_t q) { return q; });
  pairs_.for_each_block([&](mesh::Shape shape, const std::int64_t* cells, const QueryId* queries) {
    const PairBlock& b = s_.block;
    invert(shape, s_.block);
    for (int k = 0; k < b.cells.count; ++k) {
      const int q = queries[k];
      best_[q] = {cells[k], b.parametric_of(k)};
      reason_[q] = b.margin[k] > b.error[k] ? Reason::certified : Reason::on_face;
      if (((b.converged >> k) & 1) == 0 || !(b.margin[k] >= farthest)) {
        Vec3d x[8];
        b.cells.get(shape, k, x);
        best_[q].parametric = cells::robust_inverse(shape, x, b.point_of(k));
      }
    }
  });
  kept += count_;
}

std::int64_t RayBatch::certify(const std::int64_t* cells_of) {
  std::int64_t proven = 0;
  pairs_.order(
      std::size_t(count_), [&](std::size_t q) { return answers(int(q)) ? -1 : cells_of[q]; },
      [](std::size_t q) { return q; });
  pairs_.for_each_block([&](mesh::Shape shape, const std::int64_t* cells, const QueryId* queries) {
    const PairBlock& b = s_.block;
    invert(shape, s_.block);
    for_each_bit(b.on_boundary,
                 [&](int k) { beyond_[queries[k]] = -1; }); // no use in a further try
    for_each_bit(b.certified, [&](int k) {
      best_[queries[k]] = {cells[k], b.parametric_of(k)};
      reason_[queries[k]] = Reason::certified;
    });
    proven += std::popcount(b.certified);
  });
  return proven;
}

void RayBatch::answer_rest_by_tree(std::span<const Vec3d> points) {
  std::size_t left = 0;
  for (int q = 0; q < count_; ++q) {
    if (answers(q))
      continue;
    rest_[left] = QueryId(q);
    rest_points_[left++] = points[std::size_t(q)];
  }
  if (left == 0)
    return;
  tree_.run({rest_points_, left});
  for (std::size_t k = 0; k < left; ++k) {
    best_[rest_[k]] = tree_.locations()[k];
    reason_[rest_[k]] = tree_.reasons()[k];
  }
  by_tree += std::int64_t(left);
}

/// The tree looks at every point: at all of its candidates, or at those below the known cell.
Answered RayBatch::answer_by_tree(std::span<const Vec3d> points, std::span<const Location> known) {
  tree_.run(points, known);
  by_tree += std::int64_t(points.size());
  return {tree_.locations(), tree_.reasons()};
}

} // namespace insitu::query
