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
  std::vector<std::uint8_t> queries;  ///< of the candidates, shape by shape
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
/// through the exact test, one by one. Last the owners' parametric coordinates. On meshes free of
/// folds each point's likeliest candidate is tried before, by Newton: where the certificate proves
/// it, only those of lower ids are left to refute. Either way the answers are PointQuery's.
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
  std::size_t try_deepest();
  /// The cell's id is lower than that of what owns the query so far; -1, none, is above all.
  bool could_own(std::int64_t cell, int query) const {
    return std::uint64_t(cell) < std::uint64_t(best_[query].cell);
  }
  void claim(int query, std::int64_t cell, Reason reason);
  void decide_by_filter(mesh::Shape shape, const std::int64_t* cells, const std::uint8_t* queries);
  void decide_rest(mesh::Shape shape, std::uint64_t open, const std::int64_t* cells,
                   const std::uint8_t* queries);
  void find_parametric();
  void set_points(const std::uint8_t* queries);
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
  Reason reason_[batch_size];
  bool located_[batch_size]; ///< the parametric coordinates are known
};

} // namespace insitu::query
