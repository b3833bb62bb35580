#pragma once

#include <memory>
#include <span>

#include "accel/ray_locator.h"
#include "query/batch/proven_batch.h"

namespace insitu::query {

/// Answers batches of at most batch_size points by a ray method. In `standard` and `exact` the cell
/// that the rays tell is a candidate: Newton's certificate proves it, or else the cell beyond the
/// face that was hit, as in BatchLocator::try_likeliest; what is left goes through the tree.
/// So the answers are BatchLocator's. In `fast` the rule alone answers: the reason is `certified`
/// where Newton's method proves the cell, and else `on_face`, since the point is on the cell's
/// boundary or beside a face that the rule takes for another; coordinates then lie out of the cell
/// by as much. Where cells alone are asked for (LocateOptions::coordinates), Newton's method does
/// not run in `fast`.
///
/// The tree answers everything while the mesh is between two steps, and in `standard` and `exact`
/// the points for which no proof counts (ProofRule).
class RayBatch {
public:
  RayBatch(const PointQuery& query, const accel::RayLocator& rays, BatchScratch& scratch,
           BatchLocator& tree, BatchAnswers& answers);

  /// The answers; valid until the next run.
  Answered run(std::span<const math::Vec3d> points);

  /// Of all runs but those in `fast`; see RayCounts.
  std::int64_t kept = 0, by_neighbour = 0, by_tree = 0;

private:
  void answer_by_rule();
  void answer_by_cells(std::size_t count);
  /// Tries a cell of each point that has no answer; returns how many were proven.
  std::int64_t certify(const std::int64_t* cells);
  Answered answer_by_tree(std::span<const math::Vec3d> points, std::span<const Location> known);

  const PointQuery& query_;
  const accel::RayLocator& rays_;
  BatchLocator& tree_;
  ProvenBatch batch_;
  std::int64_t cells_[batch_size], beyond_[batch_size]; ///< as the rays tell
};

} // namespace insitu::query
