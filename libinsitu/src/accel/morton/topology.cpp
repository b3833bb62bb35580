#include "accel/morton/topology.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace insitu::accel::morton {

namespace {

constexpr std::int64_t node_grain = 512;
constexpr std::uint32_t width = 8;
/// From this level on, ranges are halved by count, whatever the codes: what 2^32 cells then still
/// need is 16 levels.
constexpr std::size_t most_levels_by_code = 32;

/// The parts of a node while it waits for its boxes, in their place: child c holds the cells
/// [begin[c], begin[c + 1]) of the order; without inner children, only begin[0] is set.
struct Parts {
  std::uint32_t begin[width + 1];

  static Parts of(const Node& node) {
    Parts p;
    std::memcpy(&p, node.child_lower, sizeof p);
    return p;
  }
  void store(Node& node) const { std::memcpy(node.child_lower, this, sizeof *this); }
};
static_assert(sizeof(Parts) <= sizeof(Node::child_lower) + sizeof(Node::child_upper));

class Topology {
public:
  Topology(Coded* cells, Coded* scratch, const Box* boxes, const core::Threads& threads)
      : cells_(cells), scratch_(scratch), boxes_(boxes), threads_(threads) {}

  /// How many of a node's children are nodes, and how many are cells.
  struct Counts {
    std::uint32_t nodes, cells;
  };

  /// Makes [begin, end) the children of `node` and stores their parts in it.
  Counts open(Node& node, std::uint32_t begin, std::uint32_t end, bool by_count) const {
    Parts parts;
    node.inner = 0;
    if (end - begin <= width) {
      for (std::uint32_t c = 0; c < width; ++c)
        node.meta[c] = c < end - begin ? leaf(c) : 0;
      parts.begin[0] = begin;
      parts.store(node);
      return {0, end - begin};
    }
    std::uint32_t at[width + 1] = {begin, end}; // [at[i], at[i + 1]) for n of them
    std::uint32_t n = 1;
    if (by_count)
      code_by_rank(begin, end);
    while (n < width) {
      std::uint32_t fullest = 0;
      for (std::uint32_t i = 1; i < n; ++i)
        if (at[i + 1] - at[i] > at[fullest + 1] - at[fullest])
          fullest = i;
      if (at[fullest + 1] - at[fullest] <= width)
        break;
      const std::uint32_t middle = split(at[fullest], at[fullest + 1]);
      for (std::uint32_t i = ++n; i > fullest + 1; --i)
        at[i] = at[i - 1];
      at[fullest + 1] = middle;
    }
    const unsigned dissolved = n < width ? fit_among(at, n) : 0u;
    Counts counts{0, 0};
    std::uint32_t c = 0;
    std::memset(node.meta, 0, sizeof node.meta);
    for (std::uint32_t i = 0; i < n; ++i) {
      if (at[i + 1] - at[i] > 1 && !((dissolved >> i) & 1)) {
        parts.begin[c] = at[i];
        node.inner |= std::uint8_t(1u << c);
        node.meta[c++] = 1;
        ++counts.nodes;
        continue;
      }
      for (std::uint32_t k = at[i]; k < at[i + 1]; ++k) {
        parts.begin[c] = k;
        node.meta[c++] = leaf(counts.cells++);
      }
    }
    for (; c <= width; ++c)
      parts.begin[c] = end;
    parts.store(node);
    return counts;
  }

  /// Prefetches what opening a waiting node of few cells will read.
  void ask_for(const Node& node) const {
    constexpr std::uint32_t line = 64 / sizeof(Coded), few = 16 * line;
    const std::uint32_t begin = node.first_child, end = node.first_cell;
    if (end - begin > width && end - begin <= few)
      for (std::uint32_t i = begin; i < end; i += line)
        __builtin_prefetch(cells_ + i);
  }

private:
  static std::uint8_t leaf(std::uint32_t cell) { return std::uint8_t((cell << 3) | 1); }

  /// The parts (a bit each) whose cells fit beside the other parts, the smallest first: that
  /// spares a node.
  static unsigned fit_among(const std::uint32_t* at, std::uint32_t n) {
    unsigned chosen = 0;
    for (std::uint32_t room = width - n;;) {
      std::uint32_t smallest = n, cells = room + 2;
      for (std::uint32_t i = 0; i < n; ++i)
        if (const std::uint32_t size = at[i + 1] - at[i];
            size > 1 && size < cells && !((chosen >> i) & 1)) {
          smallest = i;
          cells = size;
        }
      if (smallest == n)
        return chosen;
      chosen |= 1u << smallest;
      room -= cells - 1;
    }
  }

  /// Where the range's codes first differ; more than eight cells.
  std::uint32_t split(std::uint32_t begin, std::uint32_t end) const {
    if (cells_[begin].code == cells_[end - 1].code)
      order_anew(begin, end);
    const std::uint32_t last = cells_[end - 1].code;
    const std::uint32_t bit = std::bit_floor(cells_[begin].code ^ last);
    const std::uint32_t from = last & ~(bit - 1);
    const Coded* base = cells_ + begin;
    for (std::uint32_t rest = end - begin; rest > 1;) {
      const std::uint32_t half = rest / 2;
      base += base[half - 1].code < from ? half : 0;
      rest -= half;
    }
    return std::uint32_t(base - cells_) + (base->code < from ? 1 : 0);
  }

  void order_anew(std::uint32_t begin, std::uint32_t end) const {
    Centres centres;
    for (std::uint32_t i = begin; i < end; ++i)
      centres.add(Centres(&boxes_[cells_[i].id], 1));
    if (centres.are_one_point())
      code_by_rank(begin, end);
    else
      order(cells_ + begin, scratch_ + begin, end - begin, boxes_, centres, threads_);
  }

  /// Codes that fill nodes to the brim.
  void code_by_rank(std::uint32_t begin, std::uint32_t end) const {
    for (std::uint32_t i = begin; i < end; ++i)
      cells_[i].code = (i - begin) / width;
  }

  Coded* cells_;
  Coded* scratch_;
  const Box* boxes_;
  const core::Threads& threads_;
};

} // namespace

void make_nodes(Coded* cells, Coded* scratch, std::uint32_t count, const Box* boxes,
                const core::Threads& threads, core::Buffer<Node>& nodes,
                core::Buffer<std::uint32_t>& slots, std::vector<std::uint32_t>& levels) {
  const Topology topology(cells, scratch, boxes, threads);
  slots.resize_discard(count);
  // About as many as meshes need, so that growing neither copies nor overshoots.
  nodes.resize_discard(std::size_t(count) * 21 / 100 + 8);
  nodes.resize(1);
  // Until its level's turn a node keeps its range here.
  nodes[0].first_child = 0;
  nodes[0].first_cell = count;
  std::vector<std::uint32_t> first_inner, first_leaf; // of each chunk
  std::uint32_t begin_node = 0, used = 0;
  while (begin_node < nodes.size()) {
    const auto end_node = std::uint32_t(nodes.size());
    const std::int64_t n = end_node - begin_node;
    const bool by_count = levels.size() >= most_levels_by_code;
    levels.push_back(begin_node);
    const std::size_t chunks = std::size_t((n + node_grain - 1) / node_grain);
    first_inner.assign(chunks + 1, end_node);
    first_leaf.assign(chunks + 1, used);
    threads.parallel_for(n, node_grain, [&](std::int64_t begin, std::int64_t end) {
      std::uint32_t inner = 0, leaves = 0;
      for (std::int64_t i = begin; i < end; ++i) {
        if (constexpr std::int64_t ahead = 8; i + ahead < end)
          topology.ask_for(nodes[begin_node + std::size_t(i + ahead)]);
        Node& node = nodes[begin_node + std::size_t(i)];
        const auto made = topology.open(node, node.first_child, node.first_cell, by_count);
        inner += made.nodes;
        leaves += made.cells;
      }
      const auto chunk = std::size_t(begin / node_grain);
      first_inner[chunk + 1] = inner;
      first_leaf[chunk + 1] = leaves;
    });
    for (std::size_t c = 0; c < chunks; ++c) {
      first_inner[c + 1] += first_inner[c];
      first_leaf[c + 1] += first_leaf[c];
    }
    nodes.resize(first_inner[chunks]);
    used = first_leaf[chunks];
    threads.parallel_for(n, node_grain, [&](std::int64_t begin, std::int64_t end) {
      std::uint32_t inner = first_inner[std::size_t(begin / node_grain)];
      std::uint32_t slot = first_leaf[std::size_t(begin / node_grain)];
      for (std::int64_t i = begin; i < end; ++i) {
        Node& node = nodes[begin_node + std::size_t(i)];
        const Parts parts = Parts::of(node);
        node.first_child = inner;
        node.first_cell = slot;
        for (unsigned c = 0; c < width && node.meta[c]; ++c) {
          if (!node.is_inner(int(c))) {
            slots[slot++] = cells[node.inner ? parts.begin[c] : parts.begin[0] + c].id;
            continue;
          }
          nodes[inner].first_child = parts.begin[c];
          nodes[inner++].first_cell = parts.begin[c + 1];
        }
      }
    });
    begin_node = end_node;
  }
  levels.push_back(begin_node);
}

} // namespace insitu::accel::morton
