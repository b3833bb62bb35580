#include "accel/fit.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/fit.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace insitu::accel::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr Box empty_box{}; ///< for absent children: inverted, encodes as 255, 0

#if HWY_TARGET == HWY_SCALAR

HWY_INLINE float encode(Node& node, const Box* const* boxes, Box& all) {
  Box children[8];
  float area = 0.0f;
  all = Box{};
  for (int c = 0; c < 8; ++c) {
    children[c] = *boxes[c];
    all.extend(children[c]);
    area += node.meta[c] ? children[c].half_area() : 0.0f;
  }
  encode_boxes(node, children);
  return area;
}

#else

using Half = hn::Vec<hn::FixedTag<float, 4>>;

/// The children's boxes, transposed: bounds of one axis side by side, in two halves.
struct Children {
  Half lower[3][2];
  Half upper[3][2];
};

/// Children c and on.
template <class D>
HWY_INLINE hn::Vec<D> some(D d, const Half* halves, std::size_t c) {
  if constexpr (hn::MaxLanes(d) == 8)
    return hn::Combine(d, halves[1], halves[0]);
  else
    return halves[c / 4];
}

/// Transposes eight boxes; all: their union.
HWY_INLINE void gather(const Box* const* from, Children& to, Box& all) {
  // A box in two overlapping rows of four: lower and upper[0]; lower[2] and upper.
  const hn::FixedTag<float, 4> d;
  Half lowest = hn::LoadU(d, from[0]->lower), highest = hn::LoadU(d, from[0]->lower + 2);
  static_assert(sizeof(Box) == 6 * sizeof(float));
  for (int h = 0; h < 2; ++h) {
    Half low[4], high[4];
    for (int k = 0; k < 4; ++k) {
      low[k] = hn::LoadU(d, from[4 * h + k]->lower);
      high[k] = hn::LoadU(d, from[4 * h + k]->lower + 2);
      lowest = hn::Min(lowest, low[k]);
      highest = hn::Max(highest, high[k]);
    }
    const auto a = hn::InterleaveLower(d, low[0], low[2]);
    const auto b = hn::InterleaveLower(d, low[1], low[3]);
    to.lower[0][h] = hn::InterleaveLower(d, a, b);
    to.lower[1][h] = hn::InterleaveUpper(d, a, b);
    const auto e = hn::InterleaveLower(d, high[0], high[2]);
    const auto f = hn::InterleaveLower(d, high[1], high[3]);
    to.lower[2][h] = hn::InterleaveLower(d, e, f);
    to.upper[0][h] = hn::InterleaveUpper(d, e, f);
    const auto i = hn::InterleaveUpper(d, high[0], high[2]);
    const auto j = hn::InterleaveUpper(d, high[1], high[3]);
    to.upper[1][h] = hn::InterleaveLower(d, i, j);
    to.upper[2][h] = hn::InterleaveUpper(d, i, j);
  }
  alignas(16) float rows[8];
  hn::Store(lowest, d, rows);
  hn::Store(highest, d, rows + 4);
  for (int a = 0; a < 3; ++a) {
    all.lower[a] = rows[a];
    all.upper[a] = rows[5 + a];
  }
}

/// encode_boxes, eight children at a time and with its operations in its order. all: the union.
HWY_INLINE float encode(Node& node, const Box* const* boxes, Box& all) {
  const hn::CappedTag<float, 8> d;
  const hn::Rebind<std::int32_t, decltype(d)> di;
  const hn::Rebind<std::uint8_t, decltype(d)> db;
  constexpr std::size_t lanes = hn::MaxLanes(d);
  const auto zero = hn::Zero(d), one = hn::Set(d, 1.0f), most = hn::Set(d, 255.0f);
  Children children;
  gather(boxes, children, all);
  const auto encode_axis = [&](int a) HWY_ATTR {
    const float lo = all.lower[a];
    node.lower[a] = lo;
    node.exponent[a] = grid_exponent(lo, all.upper[a]);
    const float s = node.scale(a);
    const auto base = hn::Set(d, lo), scale = hn::Set(d, s), inverse = hn::Set(d, 1.0f / s);
    for (std::size_t c = 0; c < 8; c += lanes) {
      const auto lower = some(d, children.lower[a], c);
      const auto upper = some(d, children.upper[a], c);
      auto l = hn::Floor(hn::Mul(hn::Sub(lower, base), inverse));
      auto u = hn::Ceil(hn::Mul(hn::Sub(upper, base), inverse));
      l = hn::Min(hn::Max(l, zero), most);
      u = hn::Min(hn::Max(u, zero), most);
      for (;;) {
        const auto high = hn::And(hn::Gt(l, zero), hn::Gt(hn::Add(base, hn::Mul(scale, l)), lower));
        const auto low = hn::And(hn::Lt(u, most), hn::Lt(hn::Add(base, hn::Mul(scale, u)), upper));
        if (hn::AllFalse(d, hn::Or(high, low)))
          break;
        l = hn::IfThenElse(high, hn::Sub(l, one), l);
        u = hn::IfThenElse(low, hn::Add(u, one), u);
      }
      hn::StoreU(hn::DemoteTo(db, hn::ConvertTo(di, l)), db, node.child_lower[a] + c);
      hn::StoreU(hn::DemoteTo(db, hn::ConvertTo(di, u)), db, node.child_upper[a] + c);
    }
  };
  encode_axis(0);
  encode_axis(1);
  encode_axis(2);
  auto area = zero;
  for (std::size_t c = 0; c < 8; c += lanes) {
    const auto x = hn::Sub(some(d, children.upper[0], c), some(d, children.lower[0], c));
    const auto y = hn::Sub(some(d, children.upper[1], c), some(d, children.lower[1], c));
    const auto z = hn::Sub(some(d, children.upper[2], c), some(d, children.lower[2], c));
    const auto half = hn::Add(hn::Add(hn::Mul(x, y), hn::Mul(y, z)), hn::Mul(z, x));
    area = hn::Add(area, hn::IfThenElseZero(hn::Ge(x, zero), half));
  }
  return hn::GetLane(hn::SumOfLanes(d, area));
}

#endif

float encode_node_target(Node& node, const Box* boxes) {
  const Box* children[8];
  for (int c = 0; c < 8; ++c)
    children[c] = node.meta[c] ? boxes + c : &empty_box;
  Box all;
  return encode(node, children, all);
}

double fit_nodes_target(Node* nodes, std::uint32_t begin, std::uint32_t end, const Box* cell_boxes,
                        const std::uint32_t* places, Box* node_boxes) {
  static_assert(most_leaf_cells == 1);
  constexpr std::uint32_t ahead = 16;
  double area = 0.0;
  const std::uint32_t first_slot = nodes[begin].first_cell;
  std::uint32_t asked = 0;
  for (std::uint32_t i = begin; i < end; ++i) {
    Node& node = nodes[i];
    std::uint32_t slot = node.first_cell - first_slot;
    if (places && i + ahead < end)
      for (const std::uint32_t to = nodes[i + ahead].first_cell - first_slot; asked < to; ++asked)
        __builtin_prefetch(cell_boxes + places[asked]);
    const Box* children[8];
    const Box* below = node_boxes + node.first_child;
    for (int c = 0; c < 8; ++c) {
      if (node.is_inner(c))
        children[c] = below++;
      else if (node.meta[c])
        children[c] = cell_boxes + (places ? places[slot++] : slot++);
      else
        children[c] = &empty_box;
    }
    area += double(encode(node, children, node_boxes[i]));
  }
  return area;
}

} // namespace insitu::accel::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace insitu::accel {

HWY_EXPORT(encode_node_target);
HWY_EXPORT(fit_nodes_target);

float encode_node(Node& node, const Box* children) {
  return HWY_DYNAMIC_DISPATCH(encode_node_target)(node, children);
}

double fit_nodes(Node* nodes, std::uint32_t begin, std::uint32_t end, const Box* cell_boxes,
                 const std::uint32_t* places, Box* node_boxes) {
  return HWY_DYNAMIC_DISPATCH(fit_nodes_target)(nodes, begin, end, cell_boxes, places, node_boxes);
}

} // namespace insitu::accel
#endif
