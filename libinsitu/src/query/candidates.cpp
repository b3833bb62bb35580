#include "query/candidates.h"

#include <bit>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/candidates.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "query/bit_tables.h"

HWY_BEFORE_NAMESPACE();
namespace insitu::query::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// A node's child boxes, decoded: kept while consecutive queries are at the same node, as the upper
/// levels' are.
class ChildBoxes {
public:
  /// The product of decoding is exact, so this is the sum that encode_boxes checked, fused or not.
  HWY_INLINE void decode(const accel::Node& node) {
    for (int a = 0; a < 3; ++a) {
      steps_a_unit_[a] = std::bit_cast<float>((254u - node.exponent[a]) << 23);
      const auto base = hn::Set(d, node.lower[a]), scale = hn::Set(d, node.scale(a));
      for (std::size_t c = 0; c < 8; c += hn::MaxLanes(d)) {
        const auto lo = hn::ConvertTo(d, hn::PromoteTo(di, hn::LoadU(db, node.child_lower[a] + c)));
        const auto hi = hn::ConvertTo(d, hn::PromoteTo(di, hn::LoadU(db, node.child_upper[a] + c)));
        hn::Store(hn::Add(base, hn::Mul(scale, lo)), d, lower_[a] + c);
        hn::Store(hn::Add(base, hn::Mul(scale, hi)), d, upper_[a] + c);
      }
    }
  }

  /// Box `to` becomes another's box `child`.
  HWY_INLINE void take(int to, const ChildBoxes& from, int child) {
    for (int a = 0; a < 3; ++a) {
      lower_[a][to] = from.lower_[a][child];
      upper_[a][to] = from.upper_[a][child];
    }
  }

  /// Bit c: the query's box meets child c's.
  HWY_INLINE unsigned overlapping(const float* bounds) const {
    unsigned bits = 0;
    for (std::size_t c = 0; c < 8; c += hn::MaxLanes(d)) {
      const auto axis = [&](int a) HWY_ATTR {
        return hn::And(hn::Le(hn::Load(d, lower_[a] + c), hn::Set(d, bounds[4 + a])),
                       hn::Ge(hn::Load(d, upper_[a] + c), hn::Set(d, bounds[a])));
      };
      std::uint8_t byte[8] = {};
      hn::StoreMaskBits(d, hn::And(axis(0), hn::And(axis(1), axis(2))), byte);
      bits |= unsigned(byte[0]) << c;
    }
    return bits;
  }

  /// How far inside child c's box the query lies: Candidate::depth.
  HWY_INLINE void depths(const float* bounds, std::uint8_t* depth) const {
    for (std::size_t c = 0; c < 8; c += hn::MaxLanes(d)) {
      const auto axis = [&](int a) HWY_ATTR {
        const auto x = hn::Set(d, bounds[a]);
        return hn::Mul(
            hn::Min(hn::Sub(x, hn::Load(d, lower_[a] + c)), hn::Sub(hn::Load(d, upper_[a] + c), x)),
            hn::Set(d, steps_a_unit_[a]));
      };
      const auto least = hn::Min(axis(0), hn::Min(axis(1), axis(2)));
      hn::StoreU(hn::DemoteTo(db, hn::ConvertTo(di, least)), db, depth + c);
    }
  }

private:
  static constexpr hn::CappedTag<float, 8> d{};
  static constexpr hn::Rebind<std::int32_t, hn::CappedTag<float, 8>> di{};
  static constexpr hn::Rebind<std::uint8_t, hn::CappedTag<float, 8>> db{};
  alignas(32) float lower_[3][8] = {};
  alignas(32) float upper_[3][8] = {};
  float steps_a_unit_[3] = {};
};

/// Bit c: meta[c] is not 0.
HWY_INLINE unsigned present_children(const accel::Node& node) {
  std::uint64_t meta;
  std::memcpy(&meta, node.meta, sizeof meta);
  // The high bit of every byte that is not 0, then these eight bits side by side.
  constexpr std::uint64_t low = 0x7f7f7f7f7f7f7f7full;
  const std::uint64_t high = (((meta & low) + low) | meta) & ~low;
  return unsigned(((high >> 7) * 0x0102040810204080ull) >> 56);
}

/// Writes an item {base + offsets[c], high, marks[c]} for every set bit c of hits, in order; the
/// high word is high + 256 * marks[c]. Returns how many. Up to eight items at `out` are written
/// whatever hits is: branches on it would be guessed wrongly too often.
template <bool marked, class Item>
HWY_INLINE std::size_t append(unsigned hits, const std::uint8_t* offsets, std::uint32_t base,
                              std::uint32_t high, const std::uint8_t* marks, Item* out) {
  static_assert(sizeof(Item) == 8);
  auto* words = reinterpret_cast<std::uint64_t*>(out); // little-endian: the first member is low
#if HWY_MAX_BYTES >= 32
  const hn::FixedTag<std::uint8_t, 8> d8;
  const hn::FixedTag<std::uint32_t, 8> d32;
  const hn::FixedTag<std::uint32_t, 4> d32_half;
  const hn::FixedTag<std::uint64_t, 4> d64;
  const auto places = hn::LoadU(d8, set_bits[hits].data());
  const auto chosen = hn::TableLookupBytes(hn::LoadU(d8, offsets), places);
  const auto ids = hn::Add(hn::PromoteTo(d32, chosen), hn::Set(d32, base));
  const auto word = [&](auto ids_half, auto marks_half) HWY_ATTR {
    auto highs = hn::Set(d64, std::uint64_t(high) << 32);
    if constexpr (marked)
      highs = hn::Or(highs, hn::ShiftLeft<40>(hn::PromoteTo(d64, marks_half)));
    return hn::Or(hn::PromoteTo(d64, ids_half), highs);
  };
  auto chosen_marks = ids;
  if constexpr (marked)
    chosen_marks = hn::PromoteTo(d32, hn::TableLookupBytes(hn::LoadU(d8, marks), places));
  hn::StoreU(word(hn::LowerHalf(d32_half, ids), hn::LowerHalf(d32_half, chosen_marks)), d64, words);
  hn::StoreU(word(hn::UpperHalf(d32_half, ids), hn::UpperHalf(d32_half, chosen_marks)), d64,
             words + 4);
#else
  for (unsigned rest = hits; rest; rest &= rest - 1) {
    const int c = std::countr_zero(rest);
    const std::uint64_t mark = marked ? marks[c] : 0;
    *words++ = (base + offsets[c]) | (std::uint64_t(high) | mark << 8) << 32;
  }
#endif
  return std::size_t(std::popcount(hits));
}

/// The nodes from which a batch goes on, with their boxes: down from the root, level by level,
/// while at most eight nodes meet the box of the whole batch. Batches of neighbours spare half of
/// the levels this way.
struct Entry {
  std::uint32_t node[8] = {0};
  int count = 1; ///< 1 at first: the root, whose box need not be tested
  ChildBoxes boxes;
};

HWY_INLINE void find_entry(const accel::Node* nodes, const QueryBoxes& queries, Entry& entry) {
  const hn::CappedTag<float, 4> d;
  alignas(16) float all[8];
  for (std::size_t o = 0; o < 4; o += hn::MaxLanes(d)) {
    auto lower = hn::Load(d, queries.bounds[0] + o), upper = hn::Load(d, queries.bounds[0] + 4 + o);
    for (int q = 1; q < queries.count; ++q) {
      lower = hn::Min(lower, hn::Load(d, queries.bounds[q] + o));
      upper = hn::Max(upper, hn::Load(d, queries.bounds[q] + 4 + o));
    }
    hn::Store(lower, d, all + o);
    hn::Store(upper, d, all + 4 + o);
  }
  ChildBoxes children;
  while (entry.count > 0) {
    Entry next;
    next.count = 0;
    for (int i = 0; i < entry.count; ++i) {
      const accel::Node& node = nodes[entry.node[i]];
      children.decode(node);
      const unsigned hits = children.overlapping(all) & present_children(node);
      if ((hits & ~unsigned(node.inner)) || next.count + std::popcount(hits) > 8)
        return;
      for (unsigned rest = hits; rest; rest &= rest - 1) {
        const int c = std::countr_zero(rest);
        next.boxes.take(next.count, children, c);
        next.node[next.count++] = node.child_node(c);
      }
    }
    entry = next;
  }
}

/// The first level's tasks, node by node.
HWY_INLINE std::size_t enter(const Entry& entry, const QueryBoxes& queries, NodeTask* tasks) {
  std::uint8_t hits[batch_size];
  for (int q = 0; q < queries.count; ++q)
    hits[q] = std::uint8_t(entry.node[0] == 0 ? 1 : entry.boxes.overlapping(queries.bounds[q]));
  std::size_t n = 0;
  for (int i = 0; i < entry.count; ++i)
    for (int q = 0; q < queries.count; ++q) {
      tasks[n] = {entry.node[i], std::uint32_t(q)};
      n += (hits[q] >> i) & 1;
    }
  return n;
}

void find_candidates_target(const accel::Tree& tree, const QueryBoxes& queries,
                            TraversalScratch& scratch) {
  static_assert(accel::most_leaf_cells == 1, "a leaf child is one candidate below");
  const accel::Node* nodes = tree.nodes();
  if (scratch.level.size() < 8 * batch_size + 1)
    scratch.level.resize(8 * batch_size + 1); // enter writes one more than it keeps
  Entry entry;
  if (queries.count == 0)
    entry.count = 0;
  find_entry(nodes, queries, entry);
  std::size_t tasks = enter(entry, queries, scratch.level.data()), found = 0, visited = 0;
  ChildBoxes children;
  std::uint32_t decoded = ~0u;
  while (tasks > 0) {
    visited += tasks;
    // A task adds at most eight children; one check here spares one for each.
    if (scratch.next.size() < tasks * 8)
      scratch.next.resize(tasks * 8);
    if (scratch.candidates.size() < found + tasks * 8)
      scratch.candidates.resize(2 * found + tasks * 8);
    const NodeTask* level = scratch.level.data();
    NodeTask* next = scratch.next.data();
    Candidate* candidates = scratch.candidates.data();
    constexpr std::size_t ahead = 24; // nodes are asked for so many tasks early
    std::size_t n = 0;
    for (std::size_t t = 0; t < tasks; ++t) {
      const auto* later = reinterpret_cast<const char*>(
          nodes + level[t + ahead < tasks ? t + ahead : tasks - 1].node);
      hwy::Prefetch(later);
      hwy::Prefetch(later + 64);
      const NodeTask task = level[t];
      const accel::Node& node = nodes[task.node];
      if (task.node != decoded) {
        children.decode(node);
        decoded = task.node;
      }
      const unsigned hits = children.overlapping(queries.bounds[task.query]);
      // Whether there are any is mostly a matter of the level, and guessed rightly.
      if (const unsigned inner = hits & node.inner)
        n += append<false>(inner, bits_below[node.inner].data(), node.first_child, task.query,
                           nullptr, next + n);
      if (hits & ~unsigned(node.inner)) {
        // A box as wide as the node meets its absent children as well.
        const unsigned leaves = present_children(node) & ~unsigned(node.inner);
        hwy::Prefetch(tree.cells() + node.first_cell);
        std::uint8_t depth[8];
        children.depths(queries.bounds[task.query], depth);
        found += append<true>(hits & leaves, bits_below[leaves].data(), node.first_cell, task.query,
                              depth, candidates + found);
      }
    }
    scratch.level.swap(scratch.next);
    tasks = n;
  }
  scratch.found = found;
  scratch.visited = visited;
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
