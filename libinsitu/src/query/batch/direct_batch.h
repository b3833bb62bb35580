#pragma once

#include <span>

#include "query/batch/batch_answers.h"
#include "query/batch/bit_tables.h"

namespace insitu::query {

/// Answers batches on lattices: first by the points' places, without a tree, then through it those
/// without an owner, unless Finder::finds_all. Finder: bool find(point, location, reason), an owner
/// proven by the arithmetic of boxes, or none; or, unless it finds all, find(point, location,
/// reason, guess), with a cell to try by Newton's method before the tree; and, if it has that,
/// find_ahead(points, q, answers), which answers some from the q-th on in one go and returns the
/// next.
template <class Finder>
class DirectBatch {
public:
  DirectBatch(const Finder& finder, const PointQuery& query, BatchScratch& scratch,
              BatchLocator& locator, BatchAnswers& answers)
      : finder_(finder), query_(query), guesses_(query.tries() > 0 && query.proof().is_enough()),
        locator_(locator), pairs_(query.mesh, query.options.alpha, scratch), scratch_(scratch),
        s_(answers) {}

  Answered run(std::span<const math::Vec3d> points) {
    std::size_t left = 0, one_by_one = 0;
    for (std::size_t q = 0; q < points.size(); ++q) {
      if constexpr (requires { &Finder::find_ahead; }) {
        q = finder_.find_ahead(points, q, s_);
        if (q == points.size())
          break;
      }
      s_.one_by_one[one_by_one++] = QueryId(q);
      s_.locations[q] = {};
      bool found;
      if constexpr (Finder::finds_all) {
        found = finder_.find(points[q], s_.locations[q], s_.reasons[q]);
      } else {
        s_.guess[left] = -1;
        found = finder_.find(points[q], s_.locations[q], s_.reasons[q], s_.guess[left]);
      }
      s_.rest[left] = points[q];
      s_.rest_at[left] = QueryId(q);
      left += !found;
    }
    if (!Finder::finds_all)
      answer_rest(guesses_ ? try_guesses(left) : left);
    Answered all = s_.of(points.size());
    all.one_by_one = {s_.one_by_one, one_by_one};
    return all;
  }

private:
  static constexpr std::size_t few = 8; ///< for which a batch through the tree does not pay

  void answer_rest(std::size_t left) {
    if (left > few)
      return s_.answer_rest(left, locator_);
    for (std::size_t k = 0; k < left; ++k)
      s_.locations[s_.rest_at[k]] = query_.locate(s_.rest[k], s_.reasons[s_.rest_at[k]]);
  }

  /// Of the first `left` of the rest; returns how many are left, which then come first.
  std::size_t try_guesses(std::size_t left) {
    pairs_.set_points({s_.rest, left});
    pairs_.order(
        left, [&](std::size_t k) { return s_.guess[k]; }, [](std::size_t k) { return k; });
    pairs_.for_each_block(
        [&](mesh::Shape shape, const std::int64_t* cells, const QueryId* numbers) {
          invert(shape, scratch_.block);
          for_each_bit(scratch_.block.certified, [&](int k) {
            const QueryId at = s_.rest_at[numbers[k]];
            s_.locations[at] = {cells[k], scratch_.block.parametric_of(k)};
            s_.reasons[at] = Reason::certified;
          });
        });
    std::size_t kept = 0;
    for (std::size_t k = 0; k < left; ++k) {
      s_.rest[kept] = s_.rest[k];
      s_.rest_at[kept] = s_.rest_at[k];
      kept += s_.locations[s_.rest_at[k]].cell < 0;
    }
    return kept;
  }

  Finder finder_;
  const PointQuery& query_;
  bool guesses_; ///< can be proven
  BatchLocator& locator_;
  PairOrder pairs_;
  BatchScratch& scratch_;
  BatchAnswers& s_;
};

} // namespace insitu::query
