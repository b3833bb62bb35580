#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "math/vec.h"
#include "query/point_query.h"

namespace insitu::query {

constexpr int batch_size = 1024;

/// A query's number in its batch.
using QueryId = std::uint16_t;
static_assert(batch_size <= 1 << 16);

/// A batch of at most batch_size query boxes in the tree's local frame: lower x, y, z, unused,
/// upper x, y, z, unused. A box that is none meets nothing.
struct QueryBoxes {
  int count = 0;
  alignas(32) float bounds[batch_size][8];

  /// Makes a query's box none.
  void clear(int query) {
    for (int a = 0; a < 3; ++a) {
      bounds[query][a] = std::numeric_limits<float>::infinity();
      bounds[query][4 + a] = -std::numeric_limits<float>::infinity();
    }
  }
};

/// The boxes of at most batch_size points by the rule. Compiled per SIMD target and dispatched at
/// run time.
void set_boxes(const BoxRule& rule, std::span<const math::Vec3d> points, QueryBoxes& boxes);

} // namespace insitu::query
