#pragma once

#include "query/batch/batch_answers.h"
#include "query/point_locator.h"

namespace insitu::query {

/// The scratch of the calling thread, kept for its life.
BatchScratch& batch_scratch();
BatchAnswers& batch_answers();

/// Points are located by the tree alone, where their order allows with guesses by number
/// (GuessedBatches).
class TreeLocator : public PointLocator {
public:
  void with_batches(const PointQuery& query, Ask ask) const override;
  /// The one for meshes that nobody has chosen a locator for.
  static const TreeLocator& plain();
};

/// Batches by something that has run(points): RayBatch, DirectBatch.
template <class Way>
class BatchesBy final : public Batches {
public:
  explicit BatchesBy(Way& way) : way_(way) {}
  Answered run(std::span<const math::Vec3d> points) override { return way_.run(points); }

private:
  Way& way_;
};

} // namespace insitu::query
