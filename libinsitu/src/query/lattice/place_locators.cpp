#include "query/lattice/place_locators.h"

#include "query/batch/direct_batch.h"
#include "query/lattice/dual_query.h"
#include "query/lattice/leaf_query.h"

namespace insitu::query {

namespace {

template <class Finder>
void with_finder(const Finder& finder, const PointQuery& query, PointLocator::Ask ask) {
  BatchLocator tree(query, batch_scratch());
  DirectBatch<Finder> direct(finder, query, batch_scratch(), tree, batch_answers());
  BatchesBy batches(direct);
  ask(batches);
}

} // namespace

bool DualLocator::find(const math::Vec3d& p, std::int64_t hint, Location& at, Reason& reason,
                       std::int64_t& guess) const {
  guess = hint;
  return DualFinder(places_, hint).find(p, at, reason, guess);
}

void DualLocator::with_batches(const PointQuery& query, Ask ask) const {
  with_finder(DualFinder(places_), query, ask);
}

bool LeafLocator::find(const math::Vec3d& p, std::int64_t /*hint*/, Location& at, Reason& reason,
                       std::int64_t& /*guess*/) const {
  (void)LeafFinder(leaves_).find(p, at, reason); // false: p is outside, which is an answer too
  return true;
}

void LeafLocator::with_batches(const PointQuery& query, Ask ask) const {
  with_finder(LeafFinder(leaves_), query, ask);
}

} // namespace insitu::query
