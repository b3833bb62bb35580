#pragma once

#include <cstdint>
#include <vector>

#include "accel/tree/tree.h"
#include "query/batch/query_boxes.h"

/// A batch's way through the tree, compiled per SIMD target and dispatched at run time.
namespace insitu::query {

/// Queries that are at one node: those at [begin, begin of the next run) of the level's.
struct NodeRun {
  std::uint32_t node;
  std::uint32_t begin;
};

/// The nodes of a level that queries have come to, each once.
struct TraversalLevel {
  std::vector<NodeRun> runs;    ///< and one behind the last, where it ends; with room for more
  std::vector<QueryId> queries; ///< with room for eight more

  void make_room(std::size_t run_count, std::size_t query_count) {
    if (runs.size() < run_count + 8)
      runs.resize(run_count + 8);
    if (queries.size() < query_count + 8)
      queries.resize(query_count + 8);
  }
};

/// A cell whose leaf box holds a query. slot is its place in tree.cells(); depth is the node's for
/// the query: a guess at which cell holds it.
struct Candidate {
  std::uint32_t slot;
  QueryId query;
  std::uint8_t depth, unused;

  /// Of a query's candidates, the one to try first has the largest; the same in any order.
  std::uint64_t rank() const { return std::uint64_t(depth) << 32 | (0xffffffffu - slot); }
};
inline std::uint32_t slot_of_rank(std::uint64_t rank) {
  return 0xffffffffu - std::uint32_t(rank);
}

/// Kept between batches; the vectors only grow.
struct TraversalScratch {
  TraversalLevel level, next;
  std::vector<Candidate> candidates;
  std::size_t found = 0;   ///< candidates of the last batch
  std::size_t visited = 0; ///< (node, query) pairs of the last batch, counted a level at a time
};

/// Takes the whole batch through the tree level by level, so that the misses of a level overlap,
/// and a node is decoded once for all that come to it; the candidates are scratch.candidates[0,
/// scratch.found).
void find_candidates(const accel::Tree& tree, const QueryBoxes& queries, TraversalScratch& scratch);

} // namespace insitu::query
