#pragma once

#include <span>
#include <vector>

#include "cells/gather.h"
#include "query/candidates.h"
#include "query/pairs.h"
#include "query/point_query.h"

namespace insitu::query {

/// What one thread needs for batches; kept for the thread's life, since it is small.
struct BatchScratch {
  QueryBoxes boxes;
  TraversalScratch traversal;
  std::vector<std::int64_t> cells;    ///< of the candidates, shape by shape
  std::vector<QueryId> queries;       ///< of the candidates, shape by shape
  std::vector<std::int64_t> unsorted; ///< cells in the tree's order
  PairBlock block;

  /// For n candidates.
  void make_room(std::size_t n) {
    if (cells.size() >= n)
      return;
    cells.resize(2 * n);
    queries.resize(2 * n);
    unsorted.resize(2 * n);
  }
};

/// Answers batches of at most batch_size points: all of them through the tree, then blocks of
/// (cell, point) pairs of one shape through the containment filter; what it leaves open goes
/// through the exact test, one by one. Last the owners' parametric coordinates. Where
/// PointQuery::tries says so, likeliest candidates are tried before, by Newton: if a
/// certificate proves one, only those of lower ids are left to refute, or none
/// (PointQuery::proof_is_enough). The answers are PointQuery's.
class BatchLocator {
public:
  BatchLocator(const PointQuery& query, BatchScratch& scratch);

  void run(std::span<const math::Vec3d> points);

  // Of the batch's points, until the next run.
  std::span<const Location> locations() const { return {best_, std::size_t(count_)}; }
  std::span<const Reason> reasons() const { return {reason_, std::size_t(count_)}; }

private:
  template <class CellOf, class QueryOf>
  void order_by_shape(std::size_t n, CellOf&& cell_of, QueryOf&& query_of);
  bool try_likeliest(int tries);
  bool could_own(std::int64_t cell, int query) const { return cell < below_[query]; }
  void claim(int query, std::int64_t cell, Reason reason);
  void decide_by_filter(mesh::Shape shape, const std::int64_t* cells, const QueryId* queries);
  void decide_rest(mesh::Shape shape, std::uint64_t open, const std::int64_t* cells,
                   const QueryId* queries);
  void find_parametric();
  void set_points(const QueryId* queries);
  math::Vec3d block_point(int k) const;

  /// Calls f(shape, first, n) for blocks of cells of one shape within order_by_shape's runs.
  template <class F>
  void for_each_block(F&& f);

  const PointQuery& query_;
  const BoxRule rule_;
  cells::CellGather gather_;
  BatchScratch& s_;
  std::span<const math::Vec3d> points_;
  std::size_t run_end_[5] = {}; ///< of the candidates of shapes 10 to 14
  int count_ = 0;
  Location best_[batch_size];
  std::int64_t below_[batch_size]; ///< cells of lower ids may still own the query
  Reason reason_[batch_size];
  bool located_[batch_size]; ///< the parametric coordinates are known
};

} // namespace insitu::query
