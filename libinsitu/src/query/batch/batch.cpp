#include "query/batch/batch.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>

#include "cells/exact/robust_inverse.h"
#include "cells/kernels/on_feature.h"
#include "query/batch/bit_tables.h"
#include "query/lattice/gridlet_query.h"

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
  if (query_.mesh.first_single_cell() > 0)
    claim_in_runs(points);
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
void BatchLocator::claim_in_runs(std::span<const Vec3d> points) {
  TraversalScratch& t = s_.traversal;
  Candidate* const candidates = t.candidates.data();
  const std::int64_t first = query_.mesh.first_single_cell();
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
    claim(q, at.cell, cells::Decision(why));
    best_[q] = at;
    located_[q] = true;
  }
  t.found = kept;
}

/// The cell holds the query's point. The lowest id stays.
void BatchLocator::claim(int query, std::int64_t cell, const cells::Decision& decision) {
  if (!could_own(cell, query))
    return;
  best_[query].cell = below_[query] = cell;
  reason_[query] = decision.reason();
  decision_[query] = decision;
  located_[query] = false;
}

void BatchLocator::decide_by_filter(mesh::Shape shape, const std::int64_t* cells,
                                    const QueryId* queries) {
  contain(shape, s_.block);
  const std::uint64_t all = s_.block.cells.all();
  for_each_bit(s_.block.inside & all,
               [&](int k) { claim(queries[k], cells[k], cells::Decision(Reason::certified)); });
  decide_rest(shape, all & ~(s_.block.inside | s_.block.outside), cells, queries);
}

/// Keeps the candidates of lower rank than their query's `untried`; of the others, appends those
/// that may own it to s_.aside.
template <bool ProofIsEnough>
void BatchLocator::set_aside(const std::uint64_t* untried) {
  Candidate* const candidates = s_.traversal.candidates.data();
  Candidate* const aside = s_.aside.data();
  const std::uint32_t* const cells = query_.tree.cells();
  std::size_t kept = 0, aside_count = s_.aside_count;
  // Without branches: they would be guessed wrongly too often.
  for (std::size_t c = 0; c < s_.traversal.found; ++c) {
    const Candidate candidate = candidates[c];
    const int q = candidate.query;
    const bool keep = candidate.rank() < untried[q];
    const bool owns = ProofIsEnough ? !located_[q] : could_own(cells[candidate.slot], q);
    aside[aside_count] = candidate;
    aside_count += !keep & owns;
    candidates[kept] = candidate;
    kept += keep;
  }
  s_.traversal.found = kept;
  s_.aside_count = aside_count;
}

/// Each query's likeliest candidates, one after the other, by Newton, until a certificate puts one
/// inside. True if no other candidate is left; those of points that have their answer are taken
/// out, but for cells of lower ids where a proof is not enough.
bool BatchLocator::try_likeliest(int tries) {
  TraversalScratch& t = s_.traversal;
  const Candidate* const candidates = t.candidates.data();
  const ProofRule proof = query_.proof();
  const bool enough = proof.is_enough();
  const auto set_aside = [&](const std::uint64_t* untried) {
    enough ? this->set_aside<true>(untried) : this->set_aside<false>(untried);
  };
  std::uint64_t next[batch_size]; // the ranks to try, and those below are untried
  QueryId open[batch_size];
  std::iota(open, open + count_, QueryId(0));
  std::size_t open_count = std::size_t(count_);
  s_.make_room_aside(t.found);
  if (const accel::OddSlots& odd = query_.tree.odd(); !odd.empty()) {
    std::fill_n(next, count_, ~std::uint64_t(0));
    for (std::size_t c = 0; c < t.found; ++c)
      if (odd.has(candidates[c].slot))
        next[candidates[c].query] = 0;
    set_aside(next);
  }
  for (; tries > 0 && open_count > 0; --tries) {
    std::fill_n(next, count_, 0); // no candidate's rank
    for (std::size_t c = 0; c < t.found; ++c)
      next[candidates[c].query] = std::max(next[candidates[c].query], candidates[c].rank());
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
            below_[q] = proof.is_enough(cells[k]) ? 0 : cells[k];
            reason_[q] = Reason::certified;
            located_[q] = true;
            next[q] = 0;
          });
        });
    std::size_t left = 0;
    for (std::size_t k = 0; k < open_count; ++k) {
      open[left] = open[k];
      left += next[open[k]] > 0;
    }
    open_count = left;
    set_aside(next);
  }
  std::copy_n(s_.aside.data(), s_.aside_count, t.candidates.data() + t.found);
  t.found += s_.aside_count;
  return t.found == 0;
}

void BatchLocator::decide_rest(mesh::Shape shape, std::uint64_t open, const std::int64_t* cells,
                               const QueryId* queries) {
  for_each_bit(open, [&](int k) {
    if (!could_own(cells[k], queries[k]))
      return;
    Vec3d x[8];
    s_.block.cells.get(shape, k, x);
    if (const cells::Decision why = decide(shape, x, s_.block.point_of(k)))
      claim(queries[k], cells[k], why);
  });
}

/// The owners that Newton has not seen yet.
void BatchLocator::find_parametric() {
  if (!query_.options.coordinates)
    return;
  pairs_.order(
      std::size_t(count_), [&](std::size_t q) { return located_[q] ? -1 : best_[q].cell; },
      [](std::size_t q) { return q; });
  pairs_.for_each_block([&](mesh::Shape shape, const std::int64_t*, const QueryId* queries) {
    const PairBlock& b = s_.block;
    invert(shape, s_.block);
    for (int k = 0; k < b.cells.count; ++k) {
      Vec3d r = b.parametric_of(k);
      if (is_plausible((b.converged >> k) & 1, b.margin[k])) {
        if (!(b.margin[k] > b.error[k])) {
          Vec3d x[8];
          s_.block.cells.get(shape, k, x);
          r = cells::put_on_nearest(shape, x, s_.block.point_of(k), r, b.error[k]);
        }
      } else {
        Vec3d x[8];
        s_.block.cells.get(shape, k, x);
        r = cells::robust_inverse(shape, x, s_.block.point_of(k));
      }
      best_[queries[k]].parametric = cells::put_on(shape, decision_[queries[k]], r);
    }
  });
}

} // namespace insitu::query
