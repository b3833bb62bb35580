#include <bit>
#include <numeric>

#include "accel/tree/fit.h"
#include "accel/tree/subtrees.h"
#include "accel/tree/tree.h"

/// Trees over some of another tree's cells.
namespace insitu::accel {

namespace {

static_assert(most_leaf_cells == 1);

constexpr std::int64_t node_grain = 512; ///< nodes a task

/// What of a tree is kept: by node, which children lead to kept cells.
struct Kept {
  const Node* nodes;
  const std::uint64_t* slots; ///< a bit a place in the tree's cells
  std::uint8_t* children;

  bool keeps(std::uint32_t slot) const { return (slots[slot >> 6] >> (slot & 63)) & 1; }

  /// From the bottom up.
  void find(std::uint32_t n) const {
    const Node& node = nodes[n];
    unsigned kept = 0;
    for (int c = 0; c < 8; ++c) {
      if (!node.meta[c])
        continue;
      const bool is_kept =
          node.is_inner(c) ? children[node.child_node(c)] != 0 : keeps(node.child_cells(c));
      kept |= unsigned(is_kept) << c;
    }
    children[n] = std::uint8_t(kept);
  }

  /// A child, or what is below it where it leads to one thing alone: child `at` of a node.
  struct Child {
    std::uint32_t parent;
    int at;
  };
  Child child(std::uint32_t n, int c) const {
    while (nodes[n].is_inner(c)) {
      const std::uint32_t below = nodes[n].child_node(c);
      if (!std::has_single_bit(children[below]))
        break;
      n = below;
      c = std::countr_zero(children[below]);
    }
    return {n, c};
  }
};

} // namespace

void Tree::take_part(const Tree& from, std::span<const std::uint64_t> kept_slots,
                     const core::Threads& threads) {
  nodes_.resize_discard(0);
  cells_.resize_discard(0);
  levels_.clear();
  odd_ = {};
  bounds_ = Box{};
  origin_ = from.origin_;
  builder_ = from.builder_;
  cost_ = built_cost_ = 0.0;
  if (from.empty())
    return;
  core::Buffer<std::uint8_t> children(*memory_, INSITU_MEMORY_BUILD);
  children.resize_discard(from.node_count());
  const Kept kept{from.nodes(), kept_slots.data(), children.data()};
  Subtrees(from.nodes(), from.levels())
      .bottom_up(threads, [&](std::size_t, std::uint32_t begin, std::uint32_t end) {
        for (std::uint32_t n = begin; n < end; ++n)
          kept.find(n);
      });
  if (children[0] != 0)
    emit_part(from, kept, threads);
}

/// Breadth first, as the other tree's order has them.
template <class Kept>
void Tree::emit_part(const Tree& from, const Kept& kept, const core::Threads& threads) {
  std::vector<std::uint32_t> level{0}, next, first_child, first_cell;
  std::vector<double> areas;
  std::uint32_t node_total = 0, cell_total = 0;
  const auto for_each_child = [&](std::uint32_t source, auto&& visit) {
    for (unsigned rest = kept.children[source]; rest; rest &= rest - 1)
      visit(kept.child(source, std::countr_zero(rest)));
  };
  while (!level.empty()) {
    const std::size_t n = level.size();
    levels_.push_back(node_total);
    first_child.assign(n + 1, 0);
    first_cell.assign(n + 1, 0);
    threads.parallel_for(std::int64_t(n), node_grain, [&](std::int64_t begin, std::int64_t end) {
      for (auto i = std::size_t(begin); i < std::size_t(end); ++i)
        for_each_child(level[i], [&](const auto& child) {
          const bool is_inner = kept.nodes[child.parent].is_inner(child.at);
          ++(is_inner ? first_child : first_cell)[i + 1];
        });
    });
    first_cell[0] = cell_total;
    std::partial_sum(first_child.begin(), first_child.end(), first_child.begin());
    std::partial_sum(first_cell.begin(), first_cell.end(), first_cell.begin());
    const std::uint32_t below = node_total + std::uint32_t(n);
    next.resize(first_child[n]);
    nodes_.resize(below);
    cells_.resize(first_cell[n]);
    const std::size_t first_area = areas.size();
    areas.resize(first_area + (n + node_grain - 1) / node_grain);
    threads.parallel_for(std::int64_t(n), node_grain, [&](std::int64_t begin, std::int64_t end) {
      double area = 0.0;
      for (auto i = std::size_t(begin); i < std::size_t(end); ++i) {
        Node node{};
        Box boxes[8];
        node.first_child = below + first_child[i];
        node.first_cell = first_cell[i];
        std::uint32_t inner = first_child[i], cell = 0;
        int c = 0;
        for_each_child(level[i], [&](const auto& child) {
          const Node& parent = kept.nodes[child.parent];
          boxes[c] = parent.child_box(child.at);
          if (parent.is_inner(child.at)) {
            node.inner |= std::uint8_t(1u << c);
            node.meta[c] = 1;
            next[inner++] = parent.child_node(child.at);
          } else {
            node.meta[c] = std::uint8_t((cell << 3) | 1);
            cells_[first_cell[i] + cell++] = from.cells_[parent.child_cells(child.at)];
          }
          ++c;
        });
        area += double(encode_node(node, boxes));
        if (node_total + i == 0)
          for (int k = 0; k < c; ++k)
            bounds_.extend(boxes[k]);
        nodes_[node_total + i] = node;
      }
      areas[first_area + std::size_t(begin / node_grain)] = area;
    });
    cell_total = first_cell[n];
    node_total = below;
    level.swap(next);
  }
  levels_.push_back(node_total);
  set_cost(areas);
  built_cost_ = cost_;
}

} // namespace insitu::accel
