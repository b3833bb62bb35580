#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "accel/cuda/tree_node.h"
#include "device/arithmetic.cuh"

/// A point's way through the tree, on the device.
namespace insitu::accel::cuda {

/// The point in the tree's frame, rounded outwards. False for points that are not finite or beyond
/// any mesh (query::BoxRule is the CPU's).
INSITU_HD inline bool query_box(const math::Vec3d& p, const math::Vec3d& origin, float* lower,
                                float* upper) {
  bool finite = true;
  for (int a = 0; a < 3; ++a) {
    const double d = p[a] - origin[a];
    finite &= std::fabs(d) <= 3e37;
    lower[a] = round_down(d);
    upper[a] = round_up(d);
  }
  return finite;
}

/// Cells in whose boxes a point lies, with how deep: 0 on the box's boundary, 1 in the middle.
struct CandidateList {
  static constexpr int room = 16;
  std::uint32_t cell[room];
  float depth[room];
  int count = 0;
};

/// Depth first, in parts: as many candidates a call as the list has room for.
class Traversal {
public:
  INSITU_HD Traversal(const TreeView& tree, const math::Vec3d& p) : tree_(tree) {
    finished_ = !query_box(p, tree.origin, lower_, upper_) || !tree.nodes;
  }

  INSITU_HD bool finished() const { return finished_; }

  /// Adds candidates to the list until it may be full or the tree is done with.
  INSITU_HD void run(CandidateList& list) {
    while (!finished_ && list.count <= CandidateList::room - 8)
      visit(list);
  }

private:
  /// Bytes of `words` that are at most / at least those of `limit`, as 8 bits.
  INSITU_HD static unsigned bits_of(unsigned low, unsigned high) {
    const unsigned l = ((low & 0x01010101u) * 0x01020408u) >> 24;
    const unsigned h = ((high & 0x01010101u) * 0x01020408u) >> 24;
    return (l & 15u) | (h & 15u) << 4;
  }

  struct alignas(16) Words {
    unsigned x, y, z, w;
  };
  /// The k-th sixteen bytes of the node, by way of the cache for what nobody writes.
  INSITU_HD Words words(int k) const {
#if defined(__CUDA_ARCH__)
    const uint4 v = __ldg(reinterpret_cast<const uint4*>(tree_.nodes + node_) + k);
    return {v.x, v.y, v.z, v.w};
#else
    Words v;
    std::memcpy(&v, reinterpret_cast<const char*>(tree_.nodes + node_) + 16 * k, sizeof v);
    return v;
#endif
  }
  INSITU_HD static std::uint32_t load(const std::uint32_t* p) {
#if defined(__CUDA_ARCH__)
    return __ldg(p);
#else
    return *p;
#endif
  }

  INSITU_HD void visit(CandidateList& list) {
    const Words head = words(0), links = words(1), w2 = words(2), w3 = words(3), w4 = words(4);
    const unsigned lower[3][2] = {{w2.x, w2.y}, {w2.z, w2.w}, {w3.x, w3.y}};
    const unsigned upper[3][2] = {{w3.z, w3.w}, {w4.x, w4.y}, {w4.z, w4.w}};
    const float corner[3] = {std::bit_cast<float>(head.x), std::bit_cast<float>(head.y),
                             std::bit_cast<float>(head.z)};
    unsigned from[3], to[3]; // the query in steps of the grid, outwards
    unsigned low = 0xffffffffu, high = 0xffffffffu;
    bool meets = true;
    INSITU_UNROLL
    for (int a = 0; a < 3; ++a) {
      const float inverse = inverse_scale(std::uint8_t(head.w >> (8 * a)));
      const float u = device::difference_above(upper_[a], corner[a]) * inverse;
      const float l = device::difference_below(lower_[a], corner[a]) * inverse;
      meets = meets && u >= 0.0f && l <= 255.0f;
      to[a] = device::whole_number(std::fmin(u, 255.0f));
      from[a] = device::whole_number(std::ceil(std::fmax(l, 0.0f)));
      const unsigned t = to[a] * 0x01010101u, f = from[a] * 0x01010101u;
      low &= device::bytes_at_most(lower[a][0], t) & device::bytes_at_least(upper[a][0], f);
      high &= device::bytes_at_most(lower[a][1], t) & device::bytes_at_least(upper[a][1], f);
    }
    const unsigned hits = meets ? bits_of(low, high) : 0u;
    const unsigned inner = head.w >> 24, leaves = links.z & 255u;
    for (unsigned rest = hits & leaves; rest; rest &= rest - 1) {
      const int c = device::lowest_bit(rest);
      const int shift = 8 * (c & 3);
      float depth = 1.0f;
      INSITU_UNROLL
      for (int a = 0; a < 3; ++a) {
        const int l = int(((c < 4 ? lower[a][0] : lower[a][1]) >> shift) & 255u);
        const int u = int(((c < 4 ? upper[a][0] : upper[a][1]) >> shift) & 255u);
        const int inside = std::min(int(to[a]) - l, u - int(from[a]));
        depth = std::fmin(depth, device::quotient_about(float(2 * inside), float(u - l)));
      }
      list.cell[list.count] =
          load(tree_.cells + links.y + device::count_bits(leaves & ((1u << c) - 1u)));
      list.depth[list.count++] = depth;
    }
    step(links.x, inner, hits & inner);
  }

  /// On to a child that was hit, or to what was left for later.
  INSITU_HD void step(unsigned first, unsigned inner, unsigned hits) {
    if (!hits) {
      if (size_ == 0) {
        finished_ = true;
        return;
      }
      const Group group = stack_[--size_];
      first = group.x;
      inner = group.y >> 8;
      hits = group.y & 255u;
    }
    const int c = device::lowest_bit(hits);
    node_ = first + device::count_bits(inner & ((1u << c) - 1u));
    hits &= hits - 1;
    if (hits)
      stack_[size_++] = {first, inner << 8 | hits};
  }

  /// Children to visit: the node of the first, the mask of inner ones and the hits.
  struct alignas(8) Group {
    unsigned x, y;
  };

  const TreeView& tree_;
  float lower_[3], upper_[3];
  std::uint32_t node_ = 0;
  bool finished_ = false;
  int size_ = 0;
  Group stack_[most_levels];
};

} // namespace insitu::accel::cuda
