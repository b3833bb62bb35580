#include "query/batch.h"

#include <algorithm>
#include <bit>

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
    : query_(query), rule_(query.box_rule()), gather_(query.mesh, query.options.alpha),
      s_(scratch) {}

void BatchLocator::run(std::span<const Vec3d> points) {
  points_ = points;
  count_ = int(points.size());
  for (int q = 0; q < count_; ++q) {
    best_[q] = {};
    reason_[q] = Reason::outside;
    located_[q] = false;
  }
  if (query_.tree.empty())
    return;
  set_boxes(rule_, points, s_.boxes);
  find_candidates(query_.tree, s_.boxes, s_.traversal);
  const bool one_to_one = query_.mesh.free_of_folds && query_.options.alpha == 1.0;
  if (one_to_one && try_deepest() == s_.traversal.found)
    return; // no candidate is left
  const Candidate* candidates = s_.traversal.candidates.data();
  order_by_shape(
      s_.traversal.found,
      [&](std::size_t c) {
        const std::int64_t cell = query_.tree.cells()[candidates[c].slot];
        return could_own(cell, candidates[c].query) ? cell : -1;
      },
      [&](std::size_t c) { return candidates[c].query; });
  for_each_block([&](mesh::Shape shape, const std::int64_t* cells, const std::uint8_t* queries) {
    decide_by_filter(shape, cells, queries);
  });
  find_parametric();
}

/// Pairs i of [0, n), cell_of(i) and query_of(i), none where the cell is negative; those of a shape
/// side by side. The cells' ids are asked for.
template <class CellOf, class QueryOf>
void BatchLocator::order_by_shape(std::size_t n, CellOf&& cell_of, QueryOf&& query_of) {
  s_.make_room(n + 1); // one more is written than is kept
  if (gather_.one_shape()) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const std::int64_t cell = cell_of(i);
      s_.cells[kept] = cell;
      s_.queries[kept] = std::uint8_t(query_of(i));
      gather_.prefetch_ids(std::max(cell, std::int64_t(0)));
      kept += cell >= 0;
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
      s_.queries[at] = std::uint8_t(query_of(i));
    }
  std::copy_n(end, shape_count, run_end_);
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
  if (!could_own(cell, query))
    return;
  best_[query].cell = cell;
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

/// Each query's deepest candidate, by Newton; claimed where the certificate puts it inside. Returns
/// how many are.
std::size_t BatchLocator::try_deepest() {
  const Candidate* candidates = s_.traversal.candidates.data();
  const std::size_t found = s_.traversal.found;
  constexpr int number_bits = 24;
  constexpr std::uint32_t number = (1u << number_bits) - 1;
  if (found >= number)
    return 0;
  std::uint32_t deepest[batch_size] = {}; // depth, and below it 1 + the candidate's number
  for (std::size_t c = 0; c < found; ++c) {
    std::uint32_t& most = deepest[candidates[c].query];
    most = std::max(most, std::uint32_t(candidates[c].depth) << number_bits | std::uint32_t(c + 1));
  }
  order_by_shape(
      std::size_t(count_),
      [&](std::size_t q) {
        const std::uint32_t c = deepest[q] & number;
        return c > 0 ? std::int64_t(query_.tree.cells()[candidates[c - 1].slot]) : -1;
      },
      [](std::size_t q) { return q; });
  std::size_t tried = 0, proven = 0;
  for_each_block([&](mesh::Shape shape, const std::int64_t* cells, const std::uint8_t* queries) {
    const PairBlock& b = s_.block;
    invert(shape, s_.block);
    for (int k = 0; k < b.cells.count; ++k)
      if (b.margin[k] > b.error[k]) {
        const int q = queries[k];
        best_[q] = {cells[k], {b.parametric[0][k], b.parametric[1][k], b.parametric[2][k]}};
        reason_[q] = Reason::certified;
        located_[q] = true;
        ++proven;
      }
    tried += std::size_t(b.cells.count);
    // Points on faces, as a batch often has throughout, cannot be proven so: no further blocks.
    if (2 * proven < tried)
      std::fill_n(run_end_, shape_count, 0);
  });
  return proven;
}

void BatchLocator::decide_rest(mesh::Shape shape, std::uint64_t open, const std::int64_t* cells,
                               const std::uint8_t* queries) {
  for_each_bit(open, [&](int k) {
    if (!could_own(cells[k], queries[k]))
      return;
    Vec3d x[8];
    s_.block.cells.get(shape, k, x);
    if (const Reason why = decide(shape, x, block_point(k)); why != Reason::outside)
      claim(queries[k], cells[k], why);
  });
}

/// The owners that Newton has not seen yet.
void BatchLocator::find_parametric() {
  order_by_shape(
      std::size_t(count_), [&](std::size_t q) { return located_[q] ? -1 : best_[q].cell; },
      [](std::size_t q) { return q; });
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
