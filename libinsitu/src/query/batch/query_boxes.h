#pragma once

#include <cstdint>
#include <span>

#include "math/vec.h"
#include "query/point_query.h"

namespace insitu::query {

constexpr int batch_size = 1024;

/// A query's number in its batch.
using QueryId = std::uint16_t;
static_assert(batch_size <= 1 << 16);

/// A batch of at most batch_size query boxes in the tree's local frame: -lower and upper beside
/// each other, but the other way about, for faces of nodes: upper x, -lower x, upper y, -lower y,
/// upper z, -lower z, and two unused. A box that is none meets nothing.
struct QueryBoxes {
  int count = 0;
  alignas(32) float bounds[batch_size][8];
};

/// The boxes of at most batch_size points by the rule. Compiled per SIMD target and dispatched at
/// run time.
void set_boxes(const BoxRule& rule, std::span<const math::Vec3d> points, QueryBoxes& boxes);

} // namespace insitu::query
