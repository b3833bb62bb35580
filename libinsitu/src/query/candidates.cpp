#include "query/candidates.h"

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>

// Three x86 targets are enough: each one more costs compile time and gains little here.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/candidates.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "cells/kernels_simd.h"

HWY_BEFORE_NAMESPACE();
namespace insitu::query::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Bit c: the query's box meets child c's box, or misses it by less than a step of the node's grid.
///
/// The query is taken to the node's grid and compared there, in bytes, with all children at once.
/// A point p of child c has decoded lower[c] <= p, where decoding rounds once, by half a step at
/// most (a step is no less than an ulp of the node's coordinates). So lower[c] <= t + 1/2 for p's
/// place t on the grid, and as lower[c] is an integer, lower[c] <= nearest(t + 1/16); the sixteenth
/// takes the roundings of t. Likewise upper[c] >= nearest(t - 1/16). A lower byte is never above
/// 254 and an absent child's is 255, so the query's upper byte stops at 254.
HWY_INLINE unsigned overlapping_children(const accel::Node& node, const float* bounds) {
  // Bytes 0 to 2: what an upper byte must reach; 4 to 6: what 255 - a lower byte must reach.
  std::uint64_t grid = 0;
#if HWY_MAX_BYTES >= 32
  const hn::FixedTag<float, 8> d;
  const hn::RebindToUnsigned<decltype(d)> du;
  const hn::FixedTag<std::uint8_t, 8> d8;
  alignas(32) static constexpr float sign[8] = {1, 1, 1, 0, -1, -1, -1, 0};
  alignas(32) static constexpr float bias[8] = {-0.0625f,  -0.0625f,  -0.0625f,  0,
                                                254.9375f, 254.9375f, 254.9375f, 0};
  alignas(32) static constexpr float least[8] = {0, 0, 0, 0, 1, 1, 1, 0};
  alignas(32) static constexpr std::uint32_t shift[8] = {0, 8, 16, 24, 0, 8, 16, 24};
  std::uint32_t exponents;
  std::memcpy(&exponents, node.exponent, sizeof exponents); // and `inner`, in an unused lane
  const auto e = hn::And(hn::Shr(hn::Set(du, exponents), hn::Load(du, shift)), hn::Set(du, 255u));
  const auto inverse = hn::BitCast(d, hn::ShiftLeft<23>(hn::Sub(hn::Set(du, 254u), e)));
  const auto t = hn::Mul(hn::Sub(hn::Load(d, bounds), hn::LoadDup128(d, node.lower)), inverse);
  const auto z = hn::Add(hn::Mul(t, hn::Load(d, sign)), hn::Load(d, bias));
  const auto clamped = hn::Min(hn::Max(z, hn::Load(d, least)), hn::Set(d, 255.0f));
  const hn::FixedTag<std::uint64_t, 1> d64;
  grid = hn::GetLane(hn::BitCast(d64, hn::DemoteTo(d8, hn::NearestInt(clamped))));
#else
  for (int a = 0; a < 3; ++a) {
    const float inverse = std::bit_cast<float>((254u - node.exponent[a]) << 23);
    const float l = (bounds[a] - node.lower[a]) * inverse - 0.0625f;
    const float u = 254.9375f - (bounds[4 + a] - node.lower[a]) * inverse;
    const float upper = std::nearbyint(l > 0.0f ? (l < 255.0f ? l : 255.0f) : 0.0f);
    const float lower = std::nearbyint(u > 1.0f ? (u < 255.0f ? u : 255.0f) : 1.0f);
    grid |= std::uint64_t(upper) << (8 * a) | std::uint64_t(lower) << (8 * (4 + a));
  }
#endif
  // Bytes 16 to 79 of the node: two ids, meta, lower x, y, z, upper x, y, z, eight bytes each.
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(&node) + 16;
  static_assert(offsetof(accel::Node, child_lower) == 32 && sizeof(accel::Node) == 80);
  std::uint64_t mask = 0;
#if HWY_TARGET != HWY_SCALAR
  const hn::CappedTag<std::uint8_t, 64> db;
  // clang-format off
#define INSITU_EIGHT(x) x, x, x, x, x, x, x, x
  alignas(64) static constexpr std::uint8_t places[64] = {
      INSITU_EIGHT(0x80), INSITU_EIGHT(0x80), INSITU_EIGHT(4), INSITU_EIGHT(5),
      INSITU_EIGHT(6), INSITU_EIGHT(0), INSITU_EIGHT(1), INSITU_EIGHT(2)};
  alignas(64) static constexpr std::uint8_t flip[64] = {
      INSITU_EIGHT(0), INSITU_EIGHT(0), INSITU_EIGHT(255), INSITU_EIGHT(255),
      INSITU_EIGHT(255), INSITU_EIGHT(0), INSITU_EIGHT(0), INSITU_EIGHT(0)};
#undef INSITU_EIGHT
  // clang-format on
  const auto query = hn::BitCast(db, hn::Set(hn::Repartition<std::uint64_t, decltype(db)>(), grid));
  for (std::size_t i = 0; i < 64; i += hn::MaxLanes(db)) {
    const auto least_byte = hn::TableLookupBytesOr0(query, hn::Load(db, places + i));
    const auto child = hn::Xor(hn::LoadU(db, bytes + i), hn::Load(db, flip + i));
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(db, hn::Eq(hn::Max(child, least_byte), child), bits);
    std::uint64_t part = 0;
    std::memcpy(&part, bits, hn::MaxLanes(db) / 8); // as wide as it was stored
    mask |= part << i;
  }
#else
  for (int i = 16; i < 64; ++i) {
    const bool lower = i < 40;
    const int axis = (lower ? i - 16 : i - 40) / 8;
    const std::uint8_t child = lower ? std::uint8_t(255 - bytes[i]) : bytes[i];
    mask |= std::uint64_t(child >= ((grid >> (8 * (lower ? 4 + axis : axis))) & 255)) << i;
  }
#endif
  mask &= mask >> 8;
  return unsigned((mask >> 16) & (mask >> 32) & (mask >> 48) & 0xff);
}

void find_candidates_target(const accel::Tree& tree, const QueryBoxes& queries,
                            TraversalScratch& scratch) {
  const accel::Node* nodes = tree.nodes();
  if (scratch.level.size() < std::size_t(queries.count))
    scratch.level.resize(batch_size);
  for (int q = 0; q < queries.count; ++q)
    scratch.level[std::size_t(q)] = {0, std::uint32_t(q)};
  auto tasks = std::size_t(queries.count);
  std::size_t found = 0, visited = 0;
  while (tasks > 0) {
    visited += tasks;
    // A task adds at most eight children; one check here spares one for each.
    if (scratch.next.size() < tasks * 8)
      scratch.next.resize(tasks * 8);
    if (scratch.candidates.size() < found + tasks * 8 * accel::most_leaf_cells)
      scratch.candidates.resize(2 * found + tasks * 8 * accel::most_leaf_cells);
    NodeTask* next = scratch.next.data();
    Candidate* candidates = scratch.candidates.data();
    std::size_t n = 0;
    for (std::size_t t = 0; t < tasks; ++t) {
      const NodeTask task = scratch.level[t];
      const accel::Node& node = nodes[task.node];
      for (unsigned bits = overlapping_children(node, queries.bounds[task.query]); bits;
           bits &= bits - 1) {
        const int c = std::countr_zero(bits);
        if (node.is_inner(c)) {
          const std::uint32_t child = node.child_node(c);
          hwy::Prefetch(nodes + child);
          hwy::Prefetch(reinterpret_cast<const char*>(nodes + child) + 64);
          next[n++] = {child, task.query};
        } else {
          const std::uint32_t slot = node.child_cells(c);
          const int cells = node.child_cell_count(c);
          hwy::Prefetch(tree.cells() + slot);
          for (int k = 0; k < cells; ++k)
            candidates[found++] = {slot + std::uint32_t(k), task.query};
        }
      }
    }
    scratch.level.swap(scratch.next);
    tasks = n;
  }
  scratch.found = found;
  scratch.visited = visited;
}

void invert_target(mesh::Shape shape, InverseBlock& block) {
  using cells::HWY_NAMESPACE::Pack;
  using PackVec = cells::HWY_NAMESPACE::Vec3<Pack>;
  const cells::HWY_NAMESPACE::PackTag d;
  const int lanes = int(hn::Lanes(d)), vertices = mesh::vertex_count(shape);
  for (int i = 0; i < block.count; i += lanes) {
    const auto load = [&](const double* p) HWY_ATTR { return Pack(hn::Load(d, p + i)); };
    PackVec x[8];
    for (int v = 0; v < vertices; ++v)
      x[v] = {load(block.vertex[v][0]), load(block.vertex[v][1]), load(block.vertex[v][2])};
    const PackVec p{load(block.point[0]), load(block.point[1]), load(block.point[2])};
    const auto found = cells::HWY_NAMESPACE::inverse_map(shape, x, p);
    hn::Store(found.r.x.v, d, block.parametric[0] + i);
    hn::Store(found.r.y.v, d, block.parametric[1] + i);
    hn::Store(found.r.z.v, d, block.parametric[2] + i);
    hn::Store(found.margin.v, d, block.margin + i);
    hn::Store(select(found.converged, Pack(1.0), Pack(0.0)).v, d, block.converged + i);
  }
}

} // namespace insitu::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace insitu::query {

HWY_EXPORT(find_candidates_target);
HWY_EXPORT(invert_target);

void find_candidates(const accel::Tree& tree, const QueryBoxes& queries,
                     TraversalScratch& scratch) {
  HWY_DYNAMIC_DISPATCH(find_candidates_target)(tree, queries, scratch);
}

void invert(mesh::Shape shape, InverseBlock& block) {
  // The last pack's idle lanes repeat the first pair, so that they converge.
  for (int i = block.count; i % 8 != 0; ++i)
    for (int a = 0; a < 3; ++a) {
      block.point[a][i] = block.point[a][0];
      for (int v = 0; v < mesh::vertex_count(shape); ++v)
        block.vertex[v][a][i] = block.vertex[v][a][0];
    }
  HWY_DYNAMIC_DISPATCH(invert_target)(shape, block);
}

} // namespace insitu::query
#endif
