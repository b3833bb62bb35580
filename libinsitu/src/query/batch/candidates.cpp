#include "query/batch/candidates.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <numeric>
#include <utility>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/batch/candidates.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "query/batch/bit_tables.h"
#include "query/batch/child_boxes_simd.h"

HWY_BEFORE_NAMESPACE();
namespace insitu::query::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// The chosen of eight queries side by side; all eight of `out` are written.
HWY_INLINE void compress(const QueryId* from, unsigned chosen, QueryId* out) {
#if HWY_MAX_BYTES >= 32
  const hn::FixedTag<QueryId, 8> dq;
  const hn::FixedTag<std::uint8_t, 16> db;
  const auto places = hn::Load(db, set_bit_pairs[chosen].byte);
  hn::StoreU(hn::BitCast(dq, hn::TableLookupBytes(hn::BitCast(db, hn::LoadU(dq, from)), places)),
             dq, out);
#else
  for (int i = 0; i < 8; ++i)
    out[i] = from[set_bits[chosen][std::size_t(i)]];
#endif
}

#if HWY_MAX_BYTES >= 32
using Quads = hn::FixedTag<std::uint64_t, 4>;
using Ids = hn::FixedTag<std::uint32_t, 8>;

/// The bytes at `places`, as numbers.
HWY_INLINE hn::Vec<Ids> choose(const std::uint8_t* from,
                               hn::Vec<hn::FixedTag<std::uint8_t, 8>> places) {
  return hn::PromoteTo(
      Ids(), hn::TableLookupBytes(hn::LoadU(hn::FixedTag<std::uint8_t, 8>(), from), places));
}

/// Eight items of two words: low[i], and the i-th of two quads of others.
HWY_INLINE void store_pairs(hn::Vec<Ids> low, hn::Vec<Quads> high0, hn::Vec<Quads> high1,
                            void* out) {
  const hn::Half<Ids> half;
  auto* words = static_cast<std::uint64_t*>(out); // little-endian: the first member is low
  hn::StoreU(hn::Or(hn::PromoteTo(Quads(), hn::LowerHalf(half, low)), high0), Quads(), words);
  hn::StoreU(hn::Or(hn::PromoteTo(Quads(), hn::UpperHalf(half, low)), high1), Quads(), words + 4);
}
#endif

/// Where the next level's runs go; there is room for all.
struct RunWriter {
  NodeRun* runs;
  QueryId* queries;
  std::size_t run_count = 0, query_count = 0;

  explicit RunWriter(TraversalLevel& level)
      : runs(level.runs.data()), queries(level.queries.data()) {}

  /// Bit i of byte j becomes bit j of byte i (Warren 2012, section 7-3).
  static HWY_INLINE std::uint64_t transpose(std::uint64_t x) {
    std::uint64_t t = (x ^ (x >> 7)) & 0x00aa00aa00aa00aaull;
    x ^= t ^ (t << 7);
    t = (x ^ (x >> 14)) & 0x0000cccc0000ccccull;
    x ^= t ^ (t << 14);
    t = (x ^ (x >> 28)) & 0x00000000f0f0f0f0ull;
    return x ^ t ^ (t << 28);
  }

  /// Of n queries, query[i] goes on to node[c] for every set bit c of hits[i]; a run for each c.
  /// Both arrays have room for eight more.
  HWY_INLINE void add(const QueryId* query, std::uint8_t* hits, std::size_t n,
                      const std::uint32_t* node) {
    std::memset(hits + n, 0, 8);
    if (n <= 8)
      return add_eight(query, hits, node);
    std::uint64_t chosen[batch_size / 8]; // byte c of the k-th: bits of eight queries
    const std::size_t eights = (n + 7) / 8;
    for (std::size_t k = 0; k < eights; ++k) {
      std::memcpy(&chosen[k], hits + 8 * k, 8);
      chosen[k] = transpose(chosen[k]);
    }
    for (unsigned c = 0; c < 8; ++c) {
      const std::size_t begin = query_count;
      for (std::size_t k = 0; k < eights; ++k) {
        const auto some = unsigned(chosen[k] >> (8 * c)) & 255u;
        compress(query + 8 * k, some, queries + query_count);
        query_count += std::size_t(std::popcount(some));
      }
      runs[run_count] = {node[c], std::uint32_t(begin)};
      run_count += query_count != begin;
    }
  }

  /// The same of eight at most; the others have no hits.
  HWY_INLINE void add_eight(const QueryId* query, const std::uint8_t* hits,
                            const std::uint32_t* node) {
    std::uint64_t chosen;
    std::memcpy(&chosen, hits, 8);
    chosen = transpose(chosen);
    for (unsigned c = 0; c < 8; ++c) {
      const auto some = unsigned(chosen >> (8 * c)) & 255u;
      compress(query, some, queries + query_count);
      runs[run_count] = {node[c], std::uint32_t(query_count)};
      query_count += std::size_t(std::popcount(some));
      run_count += some != 0;
    }
  }

  /// One query goes on to the nodes first + offsets[c].
  HWY_INLINE void add_one(QueryId query, unsigned hits, const std::uint8_t* offsets,
                          std::uint32_t first) {
    std::fill_n(queries + query_count, 8, query);
#if HWY_MAX_BYTES >= 32
    const auto places = hn::LoadU(hn::FixedTag<std::uint8_t, 8>(), set_bits[hits].data());
    const auto begins = hn::ShiftLeft<32>(hn::Iota(Quads(), query_count));
    store_pairs(hn::Add(choose(offsets, places), hn::Set(Ids(), first)), begins,
                hn::Add(begins, hn::Set(Quads(), 4ull << 32)), runs + run_count);
#else
    NodeRun* run = runs + run_count;
    for (unsigned rest = hits, i = 0; rest; rest &= rest - 1, ++i)
      *run++ = {first + offsets[std::countr_zero(rest)], std::uint32_t(query_count) + i};
#endif
    query_count += std::size_t(std::popcount(hits));
    run_count += std::size_t(std::popcount(hits));
  }

  /// The end of the last run.
  void close() {
    runs[run_count] = {0, std::uint32_t(query_count)};
  }
};

/// The nodes of a node's children; those of leaf children mean nothing.
HWY_INLINE void child_nodes(const accel::Node& node, std::uint32_t* to) {
  const hn::CappedTag<std::uint32_t, 8> d;
  const hn::Rebind<std::uint8_t, decltype(d)> db;
  for (std::size_t c = 0; c < 8; c += hn::MaxLanes(d)) {
    const auto below = hn::PromoteTo(d, hn::LoadU(db, bits_below[node.inner].data() + c));
    hn::StoreU(hn::Add(below, hn::Set(d, node.first_child)), d, to + c);
  }
}

void find_candidates_target(const accel::Tree& tree, const QueryBoxes& queries,
                            TraversalScratch& scratch) {
  static_assert(accel::most_leaf_cells == 1, "a leaf child is one candidate below");
  const accel::Node* nodes = tree.nodes();
  scratch.found = scratch.visited = 0;
  if (queries.count == 0)
    return;
  scratch.level.make_room(1, std::size_t(queries.count));
  scratch.level.runs[0] = {0, 0}; // the root
  scratch.level.runs[1] = {0, std::uint32_t(queries.count)};
  std::iota(scratch.level.queries.begin(), scratch.level.queries.begin() + queries.count,
            QueryId(0));
  std::size_t run_count = 1, found = 0;
  ChildBoxes children;
  while (run_count > 0) {
    const NodeRun* runs = scratch.level.runs.data();
    const QueryId* at = scratch.level.queries.data();
    const std::size_t tasks = runs[run_count].begin;
    scratch.visited += tasks;
    // A query adds at most eight; one check here spares one for each.
    scratch.next.make_room(8 * run_count, 8 * tasks);
    if (scratch.candidates.size() < found + tasks * 8)
      scratch.candidates.resize(2 * found + tasks * 8);
    Candidate* candidates = scratch.candidates.data();
    RunWriter next(scratch.next);
    constexpr std::size_t ahead = 24; // nodes are asked for so many runs early
    for (std::size_t r = 0; r < run_count; ++r) {
      const auto* later = reinterpret_cast<const char*>(
          nodes + runs[r + ahead < run_count ? r + ahead : run_count - 1].node);
      hwy::Prefetch(later);
      hwy::Prefetch(later + 64);
      const accel::Node& node = nodes[runs[r].node];
      const QueryId* query = at + runs[r].begin;
      const std::size_t n = runs[r + 1].begin - runs[r].begin;
      children.decode(node);
      // A box as wide as the node meets its absent children as well.
      const unsigned inner = node.inner, leaves = node.children() & ~inner;
      std::uint8_t hits[batch_size + 8];
      if (leaves) {
        hwy::Prefetch(tree.cells() + node.first_cell);
        children.set_leaves(leaves, node.first_cell, bits_below[leaves].data());
        for (std::size_t i = 0; i < n; ++i) {
          unsigned met;
          found += children.append(queries.bounds[query[i]], query[i], candidates + found, met);
          hits[i] = std::uint8_t(met & inner);
        }
      } else {
        for (std::size_t i = 0; i < n; ++i)
          hits[i] = std::uint8_t(children.overlapping(queries.bounds[query[i]]) & inner);
      }
      if (inner && n == 1) {
        next.add_one(query[0], hits[0], bits_below[inner].data(), node.first_child);
      } else if (inner) {
        std::uint32_t below[8];
        child_nodes(node, below);
        next.add(query, hits, n, below);
      }
    }
    next.close();
    run_count = next.run_count;
    std::swap(scratch.level, scratch.next);
  }
  scratch.found = found;
}

} // namespace insitu::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace insitu::query {

HWY_EXPORT(find_candidates_target);

void find_candidates(const accel::Tree& tree, const QueryBoxes& queries,
                     TraversalScratch& scratch) {
  HWY_DYNAMIC_DISPATCH(find_candidates_target)(tree, queries, scratch);
}

} // namespace insitu::query
#endif
