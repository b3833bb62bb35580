#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "cells/kernels/gather.h"
#include "query/batch/candidates.h"
#include "query/batch/pairs.h"

/// (cell, point) pairs of a batch, put into blocks of cells of one shape.
namespace insitu::query {

/// What one thread needs for batches; kept for the thread's life, since it is small.
struct BatchScratch {
  QueryBoxes boxes;
  TraversalScratch traversal;
  std::vector<std::int64_t> cells;    ///< of the candidates, shape by shape
  std::vector<QueryId> queries;       ///< of the candidates, shape by shape
  std::vector<std::int64_t> unsorted; ///< cells in the tree's order
  PairBlock block;
  std::vector<Candidate> aside; ///< candidates that are not tried any more, but may be owners
  std::size_t aside_count = 0;
  // Of the queries, by number: BatchLocator's.
  Location best[batch_size];
  std::int64_t below[batch_size]; ///< cells of lower ids may still own the query
  Reason reason[batch_size];
  cells::Decision decision[batch_size]; ///< of the owner, where one was claimed
  bool located[batch_size];             ///< the parametric coordinates are known

  /// For n candidates.
  void make_room(std::size_t n) {
    if (cells.size() >= n)
      return;
    cells.resize(2 * n);
    queries.resize(2 * n);
    unsorted.resize(2 * n);
  }
  /// For n candidates; one more is written than is kept.
  void make_room_aside(std::size_t n) {
    aside_count = 0;
    if (aside.size() < n + 1)
      aside.resize(2 * n + 1);
  }
};

class PairOrder {
public:
  PairOrder(const mesh::MeshView& mesh, double alpha, BatchScratch& scratch)
      : gather_(mesh, alpha), s_(scratch) {}

  /// The batch's points, which queries are numbers of.
  void set_points(std::span<const math::Vec3d> points) { points_ = points; }

  /// Pairs i of [0, n), cell_of(i) and query_of(i), none where the cell is negative; those of a
  /// shape side by side in the scratch. The cells' ids are asked for.
  template <class CellOf, class QueryOf>
  void order(std::size_t n, CellOf&& cell_of, QueryOf&& query_of);

  /// Calls f(shape, cells, queries) for blocks of those pairs, filled into the scratch's block.
  template <class F>
  void for_each_block(F&& f);

private:
  static constexpr int first_shape = int(mesh::Shape::tetrahedron), shape_count = 5;
  void fill_points(const QueryId* queries);

  const cells::CellGather gather_;
  BatchScratch& s_;
  std::span<const math::Vec3d> points_;
  std::size_t run_end_[shape_count] = {}; ///< of the pairs of shapes 10 to 14
};

// Implementation

template <class CellOf, class QueryOf>
void PairOrder::order(std::size_t n, CellOf&& cell_of, QueryOf&& query_of) {
  s_.make_room(n + 1); // one more is written than is kept
  if (gather_.one_shape()) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const std::int64_t cell = cell_of(i), none = cell >> 63; // -1 or 0: comparing would branch
      s_.cells[kept] = cell;
      s_.queries[kept] = QueryId(query_of(i));
      gather_.prefetch_ids(cell & ~none);
      kept += std::size_t(1 + none);
    }
    const int shape = kept > 0 ? int(gather_.shape(0)) - first_shape : 0;
    for (int i = 0; i < shape_count; ++i)
      run_end_[i] = i < shape ? 0 : kept;
    return;
  }
  std::size_t end[shape_count + 1] = {};
  for (std::size_t i = 0; i < n; ++i) {
    s_.unsorted[i] = cell_of(i);
    if (s_.unsorted[i] >= 0)
      ++end[int(gather_.shape(s_.unsorted[i])) - first_shape + 1];
  }
  for (int i = 0; i < shape_count; ++i)
    end[i + 1] += end[i];
  for (std::size_t i = 0; i < n; ++i)
    if (const std::int64_t cell = s_.unsorted[i]; cell >= 0) {
      const std::size_t at = end[int(gather_.shape(cell)) - first_shape]++;
      s_.cells[at] = cell;
      s_.queries[at] = QueryId(query_of(i));
    }
  std::copy_n(end, shape_count, run_end_);
}

template <class F>
void PairOrder::for_each_block(F&& f) {
  std::size_t begin = 0;
  for (int i = 0; i < shape_count; ++i)
    for (; begin < run_end_[i]; begin += std::size_t(s_.block.cells.count)) {
      const std::size_t left = run_end_[i] - begin;
      s_.block.cells.count = int(std::min<std::size_t>(left, cells::CellBlock::size));
      gather_.fill(&s_.cells[begin], s_.block.cells.count, int(left) - s_.block.cells.count,
                   s_.block.cells);
      fill_points(&s_.queries[begin]);
      f(mesh::Shape(first_shape + i), &s_.cells[begin], &s_.queries[begin]);
    }
}

inline void PairOrder::fill_points(const QueryId* queries) {
  for (int k = 0; k < s_.block.cells.count; ++k) {
    const math::Vec3d& p = points_[queries[k]];
    s_.block.point[0][k] = p.x;
    s_.block.point[1][k] = p.y;
    s_.block.point[2][k] = p.z;
  }
}

} // namespace insitu::query
