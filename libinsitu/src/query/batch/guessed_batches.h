#pragma once

#include <cstdint>
#include <span>

#include "query/batch/proven_batch.h"

namespace insitu::query {

struct GuessScratch; // of one thread

/// Answers a grain of points that follow each other, as a solver's own cell centres or the places
/// of a fine raster do: cells are mostly numbered row by row, so where every few points' cells are
/// known, those between can be guessed by number. A guess is proven by Newton's certificate, or
/// goes for nothing. The first few hundred points, answered by the tree, tell whether their cells
/// could have been guessed so, and from how few; if not, the tree answers all. So answers depend on
/// the points and the mesh alone. They are BatchLocator's, but where cells overlap without folding
/// (see Sampler).
class GuessedBatches {
public:
  static constexpr std::size_t grain = 4096; ///< points at most

  GuessedBatches(const PointQuery& query, BatchScratch& scratch, BatchLocator& tree,
                 BatchAnswers& answers);

  /// False: no guess could be proven, or would be worth it.
  static bool may_pay(const PointQuery& query);

  /// The first `count` points, at most a grain; those behind are next, and asked for early.
  /// put(first, answered): of the points from `first` on, at most batch_size; valid until the next.
  using Put = core::FunctionRef<void(std::size_t first, const Answered& answered)>;
  void run(std::span<const math::Vec3d> points, std::size_t count, Put put);

  /// Of all runs: points that a guess answered.
  std::int64_t proven() const { return proven_; }

private:
  void run_by_tree(std::span<const math::Vec3d> points, std::size_t begin, std::size_t end,
                   Put put);
  void find_anchors(std::span<const math::Vec3d> points, std::size_t from);
  void guess(std::span<const math::Vec3d> points, std::size_t from);
  void check_guesses(std::span<const math::Vec3d> points);

  const PointQuery& query_;
  BatchLocator& tree_;
  GuessScratch& s_;
  ProvenBatch batch_;
  bool all_own_; ///< any number below the count of cells may own a point
  std::int64_t proven_ = 0;
  int spacing_log_ = 0; ///< every 2^n-th point's cell is known; 0: none
};

} // namespace insitu::query
