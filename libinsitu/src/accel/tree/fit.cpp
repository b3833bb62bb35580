#include "accel/tree/fit.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/tree/fit.cpp"
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

/// The children's boxes, transposed: bounds of one axis side by side, in two halves. Of all of them
/// the lowest, and the highest from lane 1 on.
struct Children {
  Half lower[3][2];
  Half upper[3][2];
  Half lowest, highest;
};

/// Children c and on.
template <class D>
HWY_INLINE hn::Vec<D> some(D d, const Half* halves, std::size_t c) {
  if constexpr (hn::MaxLanes(d) == 8)
    return hn::Combine(d, halves[1], halves[0]);
  else
    return halves[c / 4];
}

/// Transposes eight boxes.
HWY_INLINE void gather(const Box* const* from, Children& to) {
  // A box in two overlapping rows of four: lower and upper[0]; lower[2] and upper.
  const hn::FixedTag<float, 4> d;
  to.lowest = hn::LoadU(d, from[0]->lower);
  to.highest = hn::LoadU(d, from[0]->lower + 2);
  static_assert(sizeof(Box) == 6 * sizeof(float));
  for (int h = 0; h < 2; ++h) {
    Half low[4], high[4];
    for (int k = 0; k < 4; ++k) {
      low[k] = hn::LoadU(d, from[4 * h + k]->lower);
      high[k] = hn::LoadU(d, from[4 * h + k]->lower + 2);
      to.lowest = hn::Min(to.lowest, low[k]);
      to.highest = hn::Max(to.highest, high[k]);
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
}

/// The grids of the three axes at once: grid_exponent, scale and inverse_scale by axis.
struct Grids {
  alignas(16) std::uint32_t exponent[4];
  alignas(16) float scale[4];
  alignas(16) float inverse[4];
};
HWY_INLINE void fit_grids(Half lo, Half hi, Grids& to) {
  const hn::FixedTag<float, 4> d;
  const hn::FixedTag<std::uint32_t, 4> du;
  const auto at_least = hn::Mul(hn::Add(hn::Abs(lo), hn::Abs(hi)), hn::Set(d, 0x1p-23f));
  const auto unit = hn::Max(hn::Mul(hn::Sub(hi, lo), hn::Set(d, 1.0f / 253.0f)), at_least);
  auto e = hn::ShiftRight<23>(hn::Add(hn::BitCast(du, unit), hn::Set(du, 0x7fffffu)));
  e = hn::Min(hn::Max(e, hn::Set(du, 1u)), hn::Set(du, 254u));
  hn::Store(e, du, to.exponent);
  hn::Store(hn::BitCast(d, hn::ShiftLeft<23>(e)), d, to.scale);
  hn::Store(hn::BitCast(d, hn::ShiftLeft<23>(hn::Sub(hn::Set(du, 254u), e))), d, to.inverse);
}

/// encode_boxes, eight children at a time and with its operations in its order. all: the union.
HWY_INLINE float encode(Node& node, const Box* const* boxes, Box& all) {
  const hn::CappedTag<float, 8> d;
  const hn::FixedTag<float, 4> d4;
  const hn::Rebind<std::int32_t, decltype(d)> di;
  const hn::Rebind<std::uint8_t, decltype(d)> db;
  constexpr std::size_t lanes = hn::MaxLanes(d);
  const auto zero = hn::Zero(d), one = hn::Set(d, 1.0f), most = hn::Set(d, 255.0f);
  Children children;
  gather(boxes, children);
  const Half highest = hn::Shuffle0321(children.highest); // from lane 0 on
  Grids grids;
  fit_grids(children.lowest, highest, grids);
  const std::uint8_t inner = node.inner;
  hn::StoreU(children.lowest, d4, node.lower); // over the exponents and inner, which follow
  for (int a = 0; a < 3; ++a)
    node.exponent[a] = std::uint8_t(grids.exponent[a]);
  node.inner = inner;
  hn::StoreU(children.lowest, d4, all.lower); // over upper[0], which follows
  alignas(16) float upper[4];
  hn::Store(highest, d4, upper);
  for (int a = 0; a < 3; ++a)
    all.upper[a] = upper[a];
  const auto encode_axis = [&](int a) HWY_ATTR {
    const auto base = hn::Set(d, all.lower[a]), scale = hn::Set(d, grids.scale[a]),
               inverse = hn::Set(d, grids.inverse[a]);
    for (std::size_t c = 0; c < 8; c += lanes) {
      const auto lower = some(d, children.lower[a], c);
      const auto upper = some(d, children.upper[a], c);
      auto l = hn::Floor(hn::Mul(hn::Sub(lower, base), inverse));
      auto u = hn::Ceil(hn::Mul(hn::Sub(upper, base), inverse));
      l = hn::Min(hn::Max(l, zero), most);
      u = hn::Min(hn::Max(u, zero), most);
      for (;;) {
        const auto high = hn::Gt(hn::Add(base, hn::Mul(scale, l)), lower);
        const auto low = hn::Lt(hn::Add(base, hn::Mul(scale, u)), upper);
        if (HWY_LIKELY(hn::AllFalse(d, hn::Or(high, low))))
          break;
        // Rare: rounding went inwards. (Or, at the ends, the box cannot be encoded.)
        const auto down = hn::And(high, hn::Gt(l, zero)), up = hn::And(low, hn::Lt(u, most));
        if (hn::AllFalse(d, hn::Or(down, up)))
          break;
        l = hn::IfThenElse(down, hn::Sub(l, one), l);
        u = hn::IfThenElse(up, hn::Add(u, one), u);
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

template <bool by_place>
HWY_INLINE double fit_some_nodes(Node* nodes, std::uint32_t begin, std::uint32_t end,
                                 const Box* cell_boxes, const std::uint32_t* places,
                                 Box* node_boxes) {
  static_assert(most_leaf_cells == 1);
  constexpr std::uint32_t ahead = 16;
  double area = 0.0;
  const std::uint32_t first_slot = nodes[begin].first_cell;
  std::uint32_t asked = 0;
  for (std::uint32_t i = begin; i < end; ++i) {
    Node& node = nodes[i];
    const std::uint32_t first = node.first_cell - first_slot;
    if (by_place && i + ahead < end)
      for (const std::uint32_t to = nodes[i + ahead].first_cell - first_slot; asked < to; ++asked)
        __builtin_prefetch(cell_boxes + places[asked]);
    // Without branches: which children are leaves is hard to guess.
    const Box* children[8];
    const Box* below = node_boxes + node.first_child;
    for (int c = 0; c < 8; ++c) {
      const unsigned inner = (unsigned(node.inner) >> c) & 1u;
      const bool leaf = node.meta[c] != 0 && inner == 0;
      const std::uint32_t slot = first + (node.meta[c] >> 3);
      const Box* box = inner ? below : &empty_box;
      if constexpr (by_place) {
        if (leaf)
          box = cell_boxes + places[slot];
      } else {
        box = leaf ? cell_boxes + slot : box;
      }
      children[c] = box;
      below += inner;
    }
    area += double(encode(node, children, node_boxes[i]));
  }
  return area;
}

double fit_nodes_target(Node* nodes, std::uint32_t begin, std::uint32_t end, const Box* cell_boxes,
                        const std::uint32_t* places, Box* node_boxes) {
  return places ? fit_some_nodes<true>(nodes, begin, end, cell_boxes, places, node_boxes)
                : fit_some_nodes<false>(nodes, begin, end, cell_boxes, nullptr, node_boxes);
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
