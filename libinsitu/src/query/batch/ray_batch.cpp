#include "query/batch/ray_batch.h"

#include "cells/exact/robust_inverse.h"

namespace insitu::query {

using math::Vec3d;

RayBatch::RayBatch(const PointQuery& query, const accel::RayLocator& rays, BatchScratch& scratch,
                   BatchLocator& tree, BatchAnswers& answers)
    : query_(query), rays_(rays), tree_(tree), batch_(query, scratch, tree, answers) {}

Answered RayBatch::run(std::span<const Vec3d> points) {
  const bool fast = query_.options.accuracy == INSITU_FAST;
  const ProofRule proof = query_.proof();
  if (query_.options.alpha != 1.0 || (!fast && !proof.for_some()))
    return answer_by_tree(points, {});
  const std::size_t n = points.size();
  batch_.begin(points);
  rays_.find(points, {cells_, n}, fast ? std::span<std::int64_t>() : std::span(beyond_, n));
  if (fast) {
    query_.options.coordinates ? answer_by_rule() : answer_by_cells(n);
    return batch_.answered();
  }
  for (std::size_t q = 0; q < n && !proof.for_all(); ++q)
    if (!proof.counts_for(points[q]))
      cells_[q] = beyond_[q] = -1;
  const std::int64_t first = certify(cells_);
  const std::int64_t second = certify(beyond_);
  if (!proof.is_enough())
    return answer_by_tree(points, batch_.answered().locations);
  kept += first;
  by_neighbour += second;
  by_tree += batch_.answer_rest();
  return batch_.answered();
}

void RayBatch::answer_by_rule() {
  constexpr double farthest = -0.5; // beyond, Newton's method has found another part of the map
  batch_.invert_each(cells_, [&](mesh::Shape shape, const std::int64_t* cells,
                                 const QueryId* queries, const PairBlock& b) {
    for (int k = 0; k < b.cells.count; ++k) {
      Vec3d r = b.parametric_of(k);
      if (((b.converged >> k) & 1) == 0 || !(b.margin[k] >= farthest)) {
        Vec3d x[8];
        b.cells.get(shape, k, x);
        r = cells::robust_inverse(shape, x, b.point_of(k));
      }
      batch_.answer(queries[k], {cells[k], r},
                    b.margin[k] > b.error[k] ? Reason::certified : Reason::on_face);
    }
  });
}

/// What face methods save most by: the hit tells the cell, and nothing else is looked at.
void RayBatch::answer_by_cells(std::size_t count) {
  for (std::size_t q = 0; q < count; ++q)
    if (cells_[q] >= 0)
      batch_.answer(q, {cells_[q], {}}, Reason::on_face);
}

std::int64_t RayBatch::certify(const std::int64_t* cells) {
  return batch_.certify(cells, [&](QueryId q) { beyond_[q] = -1; });
}

/// The tree looks at every point: at all of its candidates, or at those below the known cell.
Answered RayBatch::answer_by_tree(std::span<const Vec3d> points, std::span<const Location> known) {
  tree_.run(points, known);
  by_tree += std::int64_t(points.size());
  return {tree_.locations(), tree_.reasons()};
}

} // namespace insitu::query
