#include "accel/tree/value_ranges.h"

#include <cmath>
#include <limits>

#include "accel/tree/subtrees.h"

namespace insitu::accel {

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

double scalar_at(const mesh::FieldPieceView& piece, int components, int component,
                 std::int64_t item) {
  if (component >= 0)
    return piece.load(item, component);
  double sum = 0.0;
  for (int c = 0; c < components; ++c) {
    const double v = piece.load(item, c);
    sum += v * v;
  }
  return std::sqrt(sum);
}

} // namespace

ValueRanges::ValueRanges(const Tree& tree, const mesh::MeshView& mesh, const mesh::FieldView& field,
                         int component, const core::Threads& threads, core::Memory& memory)
    : ranges_(memory, INSITU_MEMORY_RANGES) {
  ranges_.resize_discard(tree.node_count());
  refresh(tree, mesh, field, component, threads);
}

void ValueRanges::refresh(const Tree& tree, const mesh::MeshView& mesh,
                          const mesh::FieldView& field, int component,
                          const core::Threads& threads) {
  min_ = infinity;
  max_ = -infinity;
  if (tree.empty())
    return;
  const auto cell_range = [&](std::uint32_t flat, float& lo, float& hi) {
    const std::int32_t p = mesh.piece_of(flat);
    const std::int64_t cell = flat - mesh.first_cell[p];
    const mesh::FieldPieceView& values = field.pieces[p];
    const auto add = [&](std::int64_t item) {
      const double v = scalar_at(values, field.components, component, item);
      if (std::isnan(v))
        return;
      const float l = float_below(v), u = float_above(v);
      lo = l < lo ? l : lo;
      hi = u > hi ? u : hi;
    };
    if (field.association == INSITU_CELL)
      return add(cell);
    mesh.pieces[p].for_each_item_vertex(cell, add);
  };

  const Node* nodes = tree.nodes();
  const Subtrees subtrees(nodes, tree.levels());
  subtrees.bottom_up(threads, [&](std::size_t, std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t at = begin; at < end; ++at) {
      const Node& node = nodes[at];
      for (int c = 0; c < 8; ++c) {
        float lo = infinity, hi = -infinity;
        if (node.meta[c] && node.is_inner(c)) {
          const Range& below = ranges_[node.child_node(c)];
          for (int k = 0; k < 8; ++k) {
            lo = below.lower[k] < lo ? below.lower[k] : lo;
            hi = below.upper[k] > hi ? below.upper[k] : hi;
          }
        } else if (node.meta[c]) {
          for (int k = 0; k < node.child_cell_count(c); ++k)
            cell_range(tree.cells()[node.child_cells(c) + std::uint32_t(k)], lo, hi);
        }
        ranges_[at].lower[c] = lo;
        ranges_[at].upper[c] = hi;
      }
    }
  });
  for (int c = 0; c < 8; ++c) {
    min_ = ranges_[0].lower[c] < min_ ? ranges_[0].lower[c] : min_;
    max_ = ranges_[0].upper[c] > max_ ? ranges_[0].upper[c] : max_;
  }
}

} // namespace insitu::accel
