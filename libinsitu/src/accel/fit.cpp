#include "accel/fit.h"

#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/fit.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace insitu::accel::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Eight boxes, transposed; without a child, an inverted box (which encodes as 255, 0).
struct Children {
  alignas(32) float lower[3][8];
  alignas(32) float upper[3][8];

  HWY_INLINE void set(int c, const Box& b) {
    for (int a = 0; a < 3; ++a) {
      lower[a][c] = b.lower[a];
      upper[a][c] = b.upper[a];
    }
  }
};

/// encode_boxes, eight children at a time and with its operations in its order. all: the union.
HWY_INLINE float encode(Node& node, const Children& children, Box& all) {
  const hn::CappedTag<float, 8> d;
  const hn::Rebind<std::int32_t, decltype(d)> di;
  const hn::Rebind<std::uint8_t, decltype(d)> db;
  constexpr std::size_t lanes = hn::MaxLanes(d);
  const auto zero = hn::Zero(d), one = hn::Set(d, 1.0f), most = hn::Set(d, 255.0f);
  for (int a = 0; a < 3; ++a) {
    auto lowest = hn::Load(d, children.lower[a]), highest = hn::Load(d, children.upper[a]);
    for (std::size_t c = lanes; c < 8; c += lanes) {
      lowest = hn::Min(lowest, hn::Load(d, children.lower[a] + c));
      highest = hn::Max(highest, hn::Load(d, children.upper[a] + c));
    }
    const float lo = hn::GetLane(hn::MinOfLanes(d, lowest));
    const float hi = hn::GetLane(hn::MaxOfLanes(d, highest));
    all.lower[a] = lo;
    all.upper[a] = hi;
    node.lower[a] = lo;
    node.exponent[a] = grid_exponent(lo, hi);
    const float s = node.scale(a);
    const auto base = hn::Set(d, lo), scale = hn::Set(d, s), inverse = hn::Set(d, 1.0f / s);
    for (std::size_t c = 0; c < 8; c += lanes) {
      const auto lower = hn::Load(d, children.lower[a] + c);
      const auto upper = hn::Load(d, children.upper[a] + c);
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
  }
  auto area = zero;
  for (std::size_t c = 0; c < 8; c += lanes) {
    const auto x = hn::Sub(hn::Load(d, children.upper[0] + c), hn::Load(d, children.lower[0] + c));
    const auto y = hn::Sub(hn::Load(d, children.upper[1] + c), hn::Load(d, children.lower[1] + c));
    const auto z = hn::Sub(hn::Load(d, children.upper[2] + c), hn::Load(d, children.lower[2] + c));
    const auto half = hn::Add(hn::Add(hn::Mul(x, y), hn::Mul(y, z)), hn::Mul(z, x));
    area = hn::Add(area, hn::IfThenElseZero(hn::Ge(x, zero), half));
  }
  return hn::GetLane(hn::SumOfLanes(d, area));
}

float encode_node_target(Node& node, const Box* boxes) {
  Children children;
  for (int c = 0; c < 8; ++c)
    children.set(c, node.meta[c] ? boxes[c] : Box{});
  Box all;
  return encode(node, children, all);
}

double fit_nodes_target(Node* nodes, std::uint32_t begin, std::uint32_t end, const Box* cell_boxes,
                        std::uint32_t first_slot, Box* node_boxes) {
  double area = 0.0;
  for (std::uint32_t i = begin; i < end; ++i) {
    Node& node = nodes[i];
    Children children;
    std::uint32_t child = node.first_child;
    for (int c = 0; c < 8; ++c) {
      if (node.is_inner(c)) {
        children.set(c, node_boxes[child++]);
        continue;
      }
      const int count = node.child_cell_count(c);
      const Box* cells = cell_boxes + (node.child_cells(c) - first_slot);
      if (count == 1) {
        children.set(c, cells[0]);
        continue;
      }
      Box all;
      for (int k = 0; k < count; ++k)
        all.extend(cells[k]);
      children.set(c, all);
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
                 std::uint32_t first_slot, Box* node_boxes) {
  return HWY_DYNAMIC_DISPATCH(fit_nodes_target)(nodes, begin, end, cell_boxes, first_slot,
                                                node_boxes);
}

} // namespace insitu::accel
#endif
