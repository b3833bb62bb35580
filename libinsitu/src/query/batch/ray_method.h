#pragma once

#include "accel/ray_locator.h"
#include "query/point_locator.h"

namespace insitu::query {

/// Batches are located by a ray method (RayBatch); single points by the tree.
class RayMethod final : public PointLocator {
public:
  RayMethod(const accel::RayLocator& rays, RayCounts& counts) : rays_(rays), counts_(counts) {}
  void with_batches(const PointQuery& query, Ask ask) const override;
  /// In `fast` the rule of the rays answers, not a proof.
  bool answers_by_proof(const LocateOptions& options) const override {
    return options.accuracy != INSITU_FAST;
  }

private:
  const accel::RayLocator& rays_;
  RayCounts& counts_;
};

} // namespace insitu::query
