#pragma once

#include <cstdint>
#include <vector>

#include "accel/tree.h"
#include "query/query_boxes.h"

/// A batch's way through the tree, compiled per SIMD target and dispatched at run time.
namespace insitu::query {

struct NodeTask {
  std::uint32_t node;
  std::uint32_t query;
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
  std::vector<NodeTask> level, next;
  std::vector<Candidate> candidates;
  std::size_t found = 0;   ///< candidates of the last batch
  std::size_t visited = 0; ///< (node, query) pairs of the last batch, counted a level at a time
};

/// Takes the whole batch through the tree level by level, so that the misses of a level overlap;
/// the candidates are scratch.candidates[0, scratch.found).
void find_candidates(const accel::Tree& tree, const QueryBoxes& queries, TraversalScratch& scratch);

} // namespace insitu::query
