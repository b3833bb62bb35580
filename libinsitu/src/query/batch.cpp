#include "query/batch.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>

#include "cells/robust_inverse.h"
#include "query/bit_tables.h"
#include "query/gridlet_query.h"

namespace insitu::query {

using math::Vec3d;

BatchLocator::BatchLocator(const PointQuery& query, BatchScratch& scratch)
    : query_(query), rule_(query.box_rule()), s_(scratch),
      pairs_(query.mesh, query.options.alpha, scratch) {}

void BatchLocator::run(std::span<const Vec3d> points, std::span<const Location> known) {
  pairs_.set_points(points);
  count_ = int(points.size());
  for (int q = 0; q < count_; ++q) {
    best_[q] = {};
    below_[q] = std::numeric_limits<std::int64_t>::max();
    reason_[q] = Reason::outside;
    located_[q] = false;
  }
  for (std::size_t q = 0; q < known.size(); ++q)
    if (known[q]) {
      best_[q] = known[q];
      below_[q] = known[q].cell;
      reason_[q] = Reason::certified;
      located_[q] = true;
    }
  if (query_.tree.empty())
    return;
  set_boxes(rule_, points, s_.boxes);
  find_candidates(query_.tree, s_.boxes, s_.traversal);
  if (query_.first_stored_cell() > 0)
    claim_in_gridlets(points);
  if (const int tries = known.empty() ? query_.tries() : 0; tries > 0 && try_likeliest(tries))
    return;
  const Candidate* candidates = s_.traversal.candidates.data();
  pairs_.order(
      s_.traversal.found,
      [&](std::size_t c) {
        // The cell or -1, without a branch: it would be guessed wrongly too often.
        const std::int64_t cell = query_.tree.cells()[candidates[c].slot];
        return cell | (std::int64_t(could_own(cell, candidates[c].query)) - 1);
      },
      [&](std::size_t c) { return candidates[c].query; });
  pairs_.for_each_block([&](mesh::Shape shape, const std::int64_t* cells, const QueryId* queries) {
    decide_by_filter(shape, cells, queries);
  });
  find_parametric();
}

/// Takes gridlets out of the candidates, and claims their cells.
void BatchLocator::claim_in_gridlets(std::span<const Vec3d> points) {
  TraversalScratch& t = s_.traversal;
  Candidate* const candidates = t.candidates.data();
  const std::int64_t first = query_.first_stored_cell();
  const mesh::GridletsView& gridlets = *gridlets_of(query_.mesh);
  std::size_t kept = 0;
  for (std::size_t c = 0; c < t.found; ++c) {
    const std::int64_t flat = query_.tree.cells()[candidates[c].slot];
    const int q = candidates[c].query;
    if (flat >= first) {
      candidates[kept++] = candidates[c];
      continue;
    }
    Reason why;
    const Location at =
        locate_in_gridlet(gridlets, flat >> mesh::Gridlet::cell_bits, points[std::size_t(q)], why);
    if (!at || !could_own(at.cell, q))
      continue;
    claim(q, at.cell, why);
    best_[q] = at;
    located_[q] = true;
  }
  t.found = kept;
}

/// The cell holds the query's point. The lowest id stays.
void BatchLocator::claim(int query, std::int64_t cell, Reason reason) {
  if (!could_own(cell, query))
    return;
  best_[query].cell = below_[query] = cell;
  reason_[query] = reason;
  located_[query] = false;
}

void BatchLocator::decide_by_filter(mesh::Shape shape, const std::int64_t* cells,
                                    const QueryId* queries) {
  contain(shape, s_.block);
  const std::uint64_t all = s_.block.cells.all();
  for_each_bit(s_.block.inside & all,
               [&](int k) { claim(queries[k], cells[k], Reason::certified); });
  decide_rest(shape, all & ~(s_.block.inside | s_.block.outside), cells, queries);
}

/// Each query's likeliest candidates, one after the other, by Newton, until a certificate puts one
/// inside. True if no other candidate is left; in standard those of points that have their answer
/// are taken out.
bool BatchLocator::try_likeliest(int tries) {
  TraversalScratch& t = s_.traversal;
  Candidate* const candidates = t.candidates.data();
  const bool enough = query_.proof_is_enough();
  std::uint64_t tried[batch_size]; // ranks from this on; of queries that have their answer, all
  QueryId open[batch_size];
  std::fill_n(tried, count_, ~std::uint64_t(0));
  std::iota(open, open + count_, QueryId(0));
  std::size_t open_count = std::size_t(count_), proven = 0;
  if (const accel::OddSlots& odd = query_.tree.odd(); !odd.empty())
    for (std::size_t c = 0; c < t.found; ++c)
      if (odd.has(candidates[c].slot))
        tried[candidates[c].query] = 0;
  for (; tries > 0 && open_count > 0; --tries) {
    std::uint64_t next[batch_size];
    std::fill_n(next, count_, 0); // no candidate's rank
    for (std::size_t c = 0; c < t.found; ++c) {
      const QueryId q = candidates[c].query;
      const std::uint64_t rank = candidates[c].rank();
      next[q] = std::max(next[q], rank < tried[q] ? rank : 0);
    }
    pairs_.order(
        open_count,
        [&](std::size_t k) {
          const std::uint64_t rank = next[open[k]];
          return rank ? std::int64_t(query_.tree.cells()[slot_of_rank(rank)]) : -1;
        },
        [&](std::size_t k) { return open[k]; });
    pairs_.for_each_block(
        [&](mesh::Shape shape, const std::int64_t* cells, const QueryId* queries) {
          const PairBlock& b = s_.block;
          invert(shape, s_.block);
          for_each_bit(b.on_boundary, [&](int k) { next[queries[k]] = 0; }); // no use in more tries
          for_each_bit(b.certified, [&](int k) {
            const int q = queries[k];
            best_[q] = {cells[k], b.parametric_of(k)};
            below_[q] = enough ? 0 : cells[k];
            reason_[q] = Reason::certified;
            located_[q] = true;
          });
          proven += std::size_t(std::popcount(b.certified));
        });
    std::size_t left = 0;
    for (std::size_t k = 0; k < open_count; ++k) {
      const QueryId q = open[k];
      open[left] = q;
      tried[q] = located_[q] ? 0 : next[q];
      left += tried[q] > 0;
    }
    open_count = left;
    if (!enough)
      continue;
    std::size_t found = 0;
    for (std::size_t c = 0; c < t.found; ++c) {
      candidates[found] = candidates[c];
      found += !located_[candidates[c].query];
    }
    t.found = found;
  }
  return enough ? t.found == 0 : t.found == proven;
}

void BatchLocator::decide_rest(mesh::Shape shape, std::uint64_t open, const std::int64_t* cells,
                               const QueryId* queries) {
  for_each_bit(open, [&](int k) {
    if (!could_own(cells[k], queries[k]))
      return;
    Vec3d x[8];
    s_.block.cells.get(shape, k, x);
    if (const Reason why = decide(shape, x, s_.block.point_of(k)); why != Reason::outside)
      claim(queries[k], cells[k], why);
  });
}

/// The owners that Newton has not seen yet.
void BatchLocator::find_parametric() {
  pairs_.order(
      std::size_t(count_), [&](std::size_t q) { return located_[q] ? -1 : best_[q].cell; },
      [](std::size_t q) { return q; });
  pairs_.for_each_block([&](mesh::Shape shape, const std::int64_t*, const QueryId* queries) {
    const PairBlock& b = s_.block;
    invert(shape, s_.block);
    for (int k = 0; k < b.cells.count; ++k) {
      Vec3d& r = best_[queries[k]].parametric;
      if (is_plausible((b.converged >> k) & 1, b.margin[k])) {
        r = b.parametric_of(k);
        continue;
      }
      Vec3d x[8];
      s_.block.cells.get(shape, k, x);
      r = cells::robust_inverse(shape, x, s_.block.point_of(k));
    }
  });
}

} // namespace insitu::query
