#pragma once

#include <cstdint>
#include <vector>

#include "accel/tree.h"

/// A batch's way through the tree, compiled per SIMD target and dispatched at run time.
namespace insitu::query {

constexpr int batch_size = 256;

/// A batch of at most batch_size query boxes in the tree's local frame: lower x, y, z, unused,
/// upper x, y, z, unused.
struct QueryBoxes {
  int count = 0;
  alignas(32) float bounds[batch_size][8] = {};

  void set(int query, const float* lower, const float* upper) {
    for (int a = 0; a < 3; ++a) {
      bounds[query][a] = lower[a];
      bounds[query][4 + a] = upper[a];
    }
  }
};

struct NodeTask {
  std::uint32_t node;
  std::uint32_t query;
};

/// A cell whose leaf box holds a query. slot is its place in tree.cells().
struct Candidate {
  std::uint32_t slot;
  std::uint32_t query;
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
