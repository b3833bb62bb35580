#pragma once

#include <algorithm>
#include <span>

#include "query/batch/pair_order.h"
#include "query/point_query.h"

namespace insitu::query {

/// The batch that begins at `from`, if there is one, into the second cache: it will be read next.
/// Always inlined, since GCC takes a function of prefetches for one without effects, and drops its
/// calls.
[[gnu::always_inline]] inline void ask_for_batch(std::span<const math::Vec3d> points,
                                                 std::size_t from) {
  from = std::min(from, points.size());
  const auto bytes =
      std::as_bytes(points.subspan(from, std::min<std::size_t>(batch_size, points.size() - from)));
  for (std::size_t line = 0; line < bytes.size(); line += 64)
    __builtin_prefetch(&bytes[line], 0, 2);
}

/// Answers batches of at most batch_size points: all of them through the tree, then blocks of
/// (cell, point) pairs of one shape through the containment filter; what it leaves open goes
/// through the exact test, one by one. Last the owners' parametric coordinates. Where
/// PointQuery::tries says so, likeliest candidates are tried before, by Newton: if a
/// certificate proves one, only those of lower ids are left to refute, or none
/// (ProofRule::is_enough). The answers are PointQuery's.
class BatchLocator {
public:
  BatchLocator(const PointQuery& query, BatchScratch& scratch);

  /// known: empty, or for each point a cell that is known to hold it strictly inside, with the
  /// point's coordinates there, or none; then none is tried, and only cells of lower ids are looked
  /// at.
  void run(std::span<const math::Vec3d> points, std::span<const Location> known = {});

  // Of the batch's points, until the scratch's next run.
  std::span<const Location> locations() const { return {best_, std::size_t(count_)}; }
  std::span<const Reason> reasons() const { return {reason_, std::size_t(count_)}; }

private:
  void claim_in_runs(std::span<const math::Vec3d> points);
  bool try_likeliest(int tries);
  template <bool ProofIsEnough>
  void set_aside(const std::uint64_t* untried);
  bool could_own(std::int64_t cell, int query) const { return cell < below_[query]; }
  void claim(int query, std::int64_t cell, const cells::Decision& decision);
  void decide_by_filter(mesh::Shape shape, const std::int64_t* cells, const QueryId* queries);
  void decide_rest(mesh::Shape shape, std::uint64_t open, const std::int64_t* cells,
                   const QueryId* queries);
  void find_parametric();
  const PointQuery& query_;
  const BoxRule rule_;
  BatchScratch& s_;
  PairOrder pairs_;
  int count_ = 0;
  // See BatchScratch.
  Location* const best_ = s_.best;
  std::int64_t* const below_ = s_.below;
  Reason* const reason_ = s_.reason;
  cells::Decision* const decision_ = s_.decision;
  bool* const located_ = s_.located;
};

} // namespace insitu::query
