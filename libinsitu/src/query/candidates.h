#pragma once

#include <cstdint>
#include <vector>

#include "accel/tree.h"
#include "query/query_boxes.h"

/// A batch's way through the tree, compiled per SIMD target and dispatched at run time.
namespace insitu::query {

/// Queries that are at one node: those at [begin, begin of the next run) of the level's.
struct NodeRun {
  std::uint32_t node;
  std::uint32_t begin;
};

/// The nodes of a level that queries have come to, each once.
struct TraversalLevel {
  std::vector<NodeRun> runs;         ///< and one behind the last, where it ends; with room for more
  std::vector<std::uint8_t> queries; ///< with room for eight more

  void make_room(std::size_t run_count, std::size_t query_count) {
    if (runs.size() < run_count + 8)
      runs.resize(run_count + 8);
    if (queries.size() < query_count + 8)
      queries.resize(query_count + 8);
  }
};

/// A cell whose leaf box holds a query. slot is its place in tree.cells(); depth, 0 to 255, how far
/// inside the box the query lies, in steps of the node's grid: a guess at which cell holds it.
struct Candidate {
  std::uint32_t slot;
  std::uint8_t query, depth;
  std::uint16_t unused;
};

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
