#pragma once

#include <bit>
#include <span>

#include "query/batch/batch_answers.h"
#include "query/batch/bit_tables.h"

namespace insitu::query {

/// Answers batches of at most batch_size points whose cells something else than the tree tells: a
/// certificate of Newton's method proves a cell, and the tree answers the rest.
class ProvenBatch {
public:
  ProvenBatch(const PointQuery& query, BatchScratch& scratch, BatchLocator& tree,
              BatchAnswers& answers)
      : s_(scratch), tree_(tree), pairs_(query.mesh, query.options.alpha, scratch),
        answers_(answers) {}

  /// Forgets the batch before; no point has an answer. The points stay the caller's.
  void begin(std::span<const math::Vec3d> points);

  bool has_answer(std::size_t query) const { return answers_.locations[query].cell >= 0; }
  void answer(std::size_t query, const Location& at, Reason reason) {
    answers_.locations[query] = at;
    answers_.reasons[query] = reason;
  }

  /// Calls f(shape, block's cells, their queries) with the inverse maps of the points without an
  /// answer in cells[query], where that is no cell's -1.
  template <class F>
  void invert_each(const std::int64_t* cells, F&& f);
  /// Of these, answers those that are proven inside; returns their number. on_boundary(query): no
  /// other cell will be proven to hold that one.
  template <class F>
  std::int64_t certify(const std::int64_t* cells, F&& on_boundary);
  /// By the tree, those without an answer; returns their number.
  std::int64_t answer_rest();

  /// Until the next begin().
  Answered answered() const { return answers_.of(points_.size()); }

private:
  BatchScratch& s_;
  BatchLocator& tree_;
  PairOrder pairs_;
  std::span<const math::Vec3d> points_;
  BatchAnswers& answers_;
};

// Implementation

template <class F>
void ProvenBatch::invert_each(const std::int64_t* cells, F&& f) {
  pairs_.order(
      points_.size(), [&](std::size_t q) { return has_answer(q) ? -1 : cells[q]; },
      [](std::size_t q) { return q; });
  pairs_.for_each_block(
      [&](mesh::Shape shape, const std::int64_t* block_cells, const QueryId* queries) {
        invert(shape, s_.block);
        f(shape, block_cells, queries, s_.block);
      });
}

template <class F>
std::int64_t ProvenBatch::certify(const std::int64_t* cells, F&& on_boundary) {
  std::int64_t proven = 0;
  invert_each(cells, [&](mesh::Shape, const std::int64_t* block_cells, const QueryId* queries,
                         const PairBlock& b) {
    for_each_bit(b.on_boundary, [&](int k) { on_boundary(queries[k]); });
    for_each_bit(b.certified, [&](int k) {
      answer(queries[k], {block_cells[k], b.parametric_of(k)}, Reason::certified);
    });
    proven += std::popcount(b.certified);
  });
  return proven;
}

} // namespace insitu::query
