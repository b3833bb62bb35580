#pragma once

#include <cstdint>

#include "accel/cuda/device_tree.h"
#include "accel/cuda/tree_node.h"

/// A point's way through the tree, on the device.
namespace insitu::accel::cuda {

/// The point in the tree's frame, rounded outwards. False for points that are not finite or beyond
/// any mesh (query::BoxRule is the CPU's).
__device__ inline bool query_box(const math::Vec3d& p, const math::Vec3d& origin, float* lower,
                                 float* upper) {
  bool finite = true;
  for (int a = 0; a < 3; ++a) {
    const double d = p[a] - origin[a];
    finite &= fabs(d) <= 3e37;
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
  __device__ Traversal(const TreeView& tree, const math::Vec3d& p) : tree_(tree) {
    finished_ = !query_box(p, tree.origin, lower_, upper_) || !tree.nodes;
  }

  __device__ bool finished() const { return finished_; }

  /// Adds candidates to the list until it may be full or the tree is done with.
  __device__ void run(CandidateList& list) {
    while (!finished_ && list.count <= CandidateList::room - 8)
      visit(list);
  }

private:
  /// Bytes of `words` that are at most / at least those of `limit`, as 8 bits.
  static __device__ unsigned bits_of(unsigned low, unsigned high) {
    const unsigned l = ((low & 0x01010101u) * 0x01020408u) >> 24;
    const unsigned h = ((high & 0x01010101u) * 0x01020408u) >> 24;
    return (l & 15u) | (h & 15u) << 4;
  }

  __device__ void visit(CandidateList& list) {
    const uint4* words = reinterpret_cast<const uint4*>(tree_.nodes + node_);
    const uint4 head = __ldg(words), links = __ldg(words + 1);
    const uint4 w2 = __ldg(words + 2), w3 = __ldg(words + 3), w4 = __ldg(words + 4);
    const unsigned lower[3][2] = {{w2.x, w2.y}, {w2.z, w2.w}, {w3.x, w3.y}};
    const unsigned upper[3][2] = {{w3.z, w3.w}, {w4.x, w4.y}, {w4.z, w4.w}};
    const float corner[3] = {__uint_as_float(head.x), __uint_as_float(head.y),
                             __uint_as_float(head.z)};
    unsigned from[3], to[3]; // the query in steps of the grid, outwards
    unsigned low = 0xffffffffu, high = 0xffffffffu;
    bool meets = true;
#pragma unroll
    for (int a = 0; a < 3; ++a) {
      const float inverse = inverse_scale(std::uint8_t(head.w >> (8 * a)));
      const float u = __fsub_ru(upper_[a], corner[a]) * inverse;
      const float l = __fsub_rd(lower_[a], corner[a]) * inverse;
      meets = meets && u >= 0.0f && l <= 255.0f;
      to[a] = unsigned(fminf(u, 255.0f)); // negative ones become 0
      from[a] = unsigned(ceilf(fmaxf(l, 0.0f)));
      const unsigned t = to[a] * 0x01010101u, f = from[a] * 0x01010101u;
      low &= __vcmpleu4(lower[a][0], t) & __vcmpgeu4(upper[a][0], f);
      high &= __vcmpleu4(lower[a][1], t) & __vcmpgeu4(upper[a][1], f);
    }
    const unsigned hits = meets ? bits_of(low, high) : 0u;
    const unsigned inner = head.w >> 24, leaves = links.z & 255u;
    for (unsigned rest = hits & leaves; rest; rest &= rest - 1) {
      const int c = __ffs(int(rest)) - 1;
      const int shift = 8 * (c & 3);
      float depth = 1.0f;
#pragma unroll
      for (int a = 0; a < 3; ++a) {
        const int l = int(((c < 4 ? lower[a][0] : lower[a][1]) >> shift) & 255u);
        const int u = int(((c < 4 ? upper[a][0] : upper[a][1]) >> shift) & 255u);
        const int inside = min(int(to[a]) - l, u - int(from[a]));
        depth = fminf(depth, __fdividef(float(2 * inside), float(u - l)));
      }
      list.cell[list.count] = __ldg(tree_.cells + links.y + __popc(leaves & ((1u << c) - 1u)));
      list.depth[list.count++] = depth;
    }
    step(links.x, inner, hits & inner);
  }

  /// On to a child that was hit, or to what was left for later.
  __device__ void step(unsigned first, unsigned inner, unsigned hits) {
    if (!hits) {
      if (size_ == 0) {
        finished_ = true;
        return;
      }
      const uint2 group = stack_[--size_];
      first = group.x;
      inner = group.y >> 8;
      hits = group.y & 255u;
    }
    const int c = __ffs(int(hits)) - 1;
    node_ = first + __popc(inner & ((1u << c) - 1u));
    hits &= hits - 1;
    if (hits)
      stack_[size_++] = make_uint2(first, inner << 8 | hits);
  }

  const TreeView& tree_;
  float lower_[3], upper_[3];
  std::uint32_t node_ = 0;
  bool finished_ = false;
  int size_ = 0;
  uint2 stack_[most_levels]; ///< children to visit: the first child's node, inner mask and hits
};

} // namespace insitu::accel::cuda
