#include "query/batch.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "cells/robust_inverse.h"

namespace insitu::query {

using math::Vec3d;

namespace {

constexpr int first_shape = int(mesh::Shape::tetrahedron), shape_count = 5;

/// Calls f(k) for every set bit k.
template <class F>
void for_each_bit(std::uint64_t bits, F&& f) {
  for (; bits; bits &= bits - 1)
    f(std::countr_zero(bits));
}

} // namespace

BatchLocator::BatchLocator(const PointQuery& query, BatchScratch& scratch)
    : query_(query), gather_(query.mesh, query.options.alpha), s_(scratch) {}

void BatchLocator::run(std::span<const Vec3d> points) {
  points_ = points;
  count_ = int(points.size());
  // Points of no box keep their place: an empty box meets nothing.
  s_.boxes.count = count_;
  for (int q = 0; q < count_; ++q) {
    float lower[3], upper[3];
    if (!query_.box(points[std::size_t(q)], lower, upper))
      for (int a = 0; a < 3; ++a) {
        lower[a] = std::numeric_limits<float>::infinity();
        upper[a] = -lower[a];
      }
    s_.boxes.set(q, lower, upper);
    best_[q] = {};
    reason_[q] = Reason::outside;
    located_[q] = false;
  }
  if (query_.tree.empty())
    return;
  find_candidates(query_.tree, s_.boxes, s_.traversal);
  const std::size_t found = s_.traversal.found;
  order_by_shape();
  // At more candidates a point than this, inverting the maps of all of them costs more than
  // filtering them.
  const bool few = 4 * found <= 5 * points.size();
  const bool newton_first = few && query_.mesh.free_of_folds && query_.options.alpha == 1.0;
  for_each_block([&](mesh::Shape shape, const std::int64_t* cells, const std::uint8_t* queries) {
    newton_first ? decide_by_newton(shape, cells, queries)
                 : decide_by_filter(shape, cells, queries);
  });
  find_parametric();
}

/// The candidates' cells, those of a shape side by side, and their ids asked for.
void BatchLocator::order_by_shape() {
  const std::size_t found = s_.traversal.found;
  const Candidate* candidates = s_.traversal.candidates.data();
  if (const std::size_t room = std::max<std::size_t>(2 * found, batch_size);
      s_.cells.size() < found || s_.cells.empty()) {
    s_.cells.resize(room);
    s_.queries.resize(room);
    s_.unsorted.resize(room);
  }
  if (gather_.one_shape()) {
    const std::uint32_t* tree_cells = query_.tree.cells();
    for (std::size_t c = 0; c < found; ++c) {
      s_.cells[c] = std::int64_t(tree_cells[candidates[c].slot]);
      s_.queries[c] = std::uint8_t(candidates[c].query);
      gather_.prefetch_ids(s_.cells[c]);
    }
    const int shape = found ? int(gather_.shape(0)) - first_shape : 0;
    for (int i = 0; i < shape_count; ++i)
      run_end_[i] = i < shape ? 0 : found;
    return;
  }
  std::size_t start[shape_count + 1] = {};
  for (std::size_t c = 0; c < found; ++c) {
    s_.unsorted[c] = std::int64_t(query_.tree.cells()[candidates[c].slot]);
    ++start[int(gather_.shape(s_.unsorted[c])) - first_shape + 1];
  }
  for (int i = 0; i < shape_count; ++i)
    start[i + 1] += start[i];
  for (std::size_t c = 0; c < found; ++c) {
    const std::size_t at = start[int(gather_.shape(s_.unsorted[c])) - first_shape]++;
    s_.cells[at] = s_.unsorted[c];
    s_.queries[at] = std::uint8_t(candidates[c].query);
  }
  std::copy_n(start, shape_count, run_end_);
}

template <class F>
void BatchLocator::for_each_block(F&& f) {
  std::size_t begin = 0;
  for (int i = 0; i < shape_count; ++i)
    for (; begin < run_end_[i]; begin += std::size_t(s_.block.cells.count)) {
      const std::size_t left = run_end_[i] - begin;
      s_.block.cells.count = int(std::min<std::size_t>(left, cells::CellBlock::size));
      gather_.fill(&s_.cells[begin], s_.block.cells.count, int(left) - s_.block.cells.count,
                   s_.block.cells);
      set_points(&s_.queries[begin]);
      f(mesh::Shape(first_shape + i), &s_.cells[begin], &s_.queries[begin]);
    }
}

void BatchLocator::set_points(const std::uint8_t* queries) {
  for (int k = 0; k < s_.block.cells.count; ++k) {
    const Vec3d& p = points_[queries[k]];
    s_.block.point[0][k] = p.x;
    s_.block.point[1][k] = p.y;
    s_.block.point[2][k] = p.z;
  }
}

Vec3d BatchLocator::block_point(int k) const {
  return {s_.block.point[0][k], s_.block.point[1][k], s_.block.point[2][k]};
}

/// The cell holds the query's point. The lowest id stays.
void BatchLocator::claim(int query, std::int64_t cell, Reason reason) {
  Location& best = best_[query];
  if (best.cell >= 0 && best.cell <= cell)
    return;
  best.cell = cell;
  reason_[query] = reason;
  located_[query] = false;
}

void BatchLocator::decide_by_filter(mesh::Shape shape, const std::int64_t* cells,
                                    const std::uint8_t* queries) {
  contain(shape, s_.block);
  const std::uint64_t all = s_.block.cells.all();
  for_each_bit(s_.block.inside & all,
               [&](int k) { claim(queries[k], cells[k], Reason::certified); });
  decide_rest(shape, all & ~(s_.block.inside | s_.block.outside), cells, queries);
}

void BatchLocator::decide_by_newton(mesh::Shape shape, const std::int64_t* cells,
                                    const std::uint8_t* queries) {
  PairBlock& b = s_.block;
  invert(shape, b);
  std::uint64_t inside = 0;
  for (int k = 0; k < b.cells.count; ++k)
    inside |= std::uint64_t(b.margin[k] > b.error[k]) << k;
  for_each_bit(inside, [&](int k) {
    const int q = queries[k];
    claim(q, cells[k], Reason::certified);
    if (best_[q].cell == cells[k]) {
      best_[q].parametric = {b.parametric[0][k], b.parametric[1][k], b.parametric[2][k]};
      located_[q] = true;
    }
  });
  decide_rest(shape, b.cells.all() & ~inside, cells, queries);
}

void BatchLocator::decide_rest(mesh::Shape shape, std::uint64_t open, const std::int64_t* cells,
                               const std::uint8_t* queries) {
  for_each_bit(open, [&](int k) {
    const Location& best = best_[queries[k]];
    if (best.cell >= 0 && best.cell <= cells[k])
      return;
    Vec3d x[8];
    s_.block.cells.get(shape, k, x);
    if (const Reason why = decide(shape, x, block_point(k)); why != Reason::outside)
      claim(queries[k], cells[k], why);
  });
}

/// The owners that Newton has not seen yet become the candidates, one a query.
void BatchLocator::find_parametric() {
  std::size_t left[shape_count + 1] = {};
  const auto shape_of = [&](int q) {
    return gather_.one_shape() ? int(gather_.shape(0)) - first_shape
                               : int(gather_.shape(best_[q].cell)) - first_shape;
  };
  for (int q = 0; q < count_; ++q)
    if (best_[q] && !located_[q])
      ++left[shape_of(q) + 1];
  for (int i = 0; i < shape_count; ++i)
    left[i + 1] += left[i];
  if (left[shape_count] == 0)
    return;
  for (int q = 0; q < count_; ++q)
    if (best_[q] && !located_[q]) {
      const std::size_t at = left[shape_of(q)]++;
      s_.cells[at] = best_[q].cell;
      s_.queries[at] = std::uint8_t(q);
    }
  std::copy_n(left, shape_count, run_end_);
  for_each_block([&](mesh::Shape shape, const std::int64_t*, const std::uint8_t* queries) {
    const PairBlock& b = s_.block;
    invert(shape, s_.block);
    for (int k = 0; k < b.cells.count; ++k) {
      Vec3d& r = best_[queries[k]].parametric;
      if (is_plausible((b.converged >> k) & 1, b.margin[k])) {
        r = {b.parametric[0][k], b.parametric[1][k], b.parametric[2][k]};
        continue;
      }
      Vec3d x[8];
      s_.block.cells.get(shape, k, x);
      r = cells::robust_inverse(shape, x, block_point(k));
    }
  });
}

} // namespace insitu::query
