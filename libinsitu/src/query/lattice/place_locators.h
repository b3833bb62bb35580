#pragma once

#include "query/batch/tree_locator.h"
#include "query/lattice/dual_places.h"

namespace insitu::query {

/// Points in the dual of an adaptive mesh: most of them by their places, the others by the tree.
class DualLocator final : public PointLocator {
public:
  explicit DualLocator(const DualPlaces& places) : places_(places) {}
  bool find(const math::Vec3d& p, std::int64_t hint, Location& at, Reason& reason,
            std::int64_t& guess) const override;
  void with_batches(const PointQuery& query, Ask ask) const override;
  const DualPlaces* dual() const override { return &places_; }

private:
  DualPlaces places_;
};

/// Points in the leaves of an adaptive mesh (`nearest`): all by their places.
class LeafLocator final : public PointLocator {
public:
  explicit LeafLocator(const amr::LeafMap& leaves) : leaves_(leaves) {}
  bool find(const math::Vec3d& p, std::int64_t hint, Location& at, Reason& reason,
            std::int64_t& guess) const override;
  void with_batches(const PointQuery& query, Ask ask) const override;
  /// The lattice decides.
  bool answers_by_proof(const LocateOptions&) const override { return false; }

private:
  const amr::LeafMap& leaves_;
};

} // namespace insitu::query
