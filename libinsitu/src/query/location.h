#pragma once

#include <cstdint>
#include <span>

#include "accel/morton/sort.h"
#include "cells/exact/decide.h"
#include "core/parallel.h"
#include "insitu/insitu.h"
#include "math/vec.h"

namespace insitu::query {

/// The owner of a point: flat cell id (see mesh::MeshView), or -1 outside, and VTK's parametric
/// coordinates in it.
struct Location {
  std::int64_t cell = -1;
  math::Vec3d parametric;
  explicit operator bool() const { return cell >= 0; }
};

using cells::Reason;
using cells::reason_count;

struct LocateOptions {
  /// They differ only where cells overlap without folding; see insitu_accuracy.
  insitu_accuracy accuracy = INSITU_STANDARD;
  /// Coordinates between the earlier (0) and the current step (1); needs MeshView::earlier_points
  /// unless 1.
  double alpha = 1.0;
  /// Whether parametric coordinates and reasons are asked for; false: cells alone. Coordinates then
  /// may be 0, and where only Newton's method tells whether a cell is proven (`fast` by rays) it
  /// does not run and the reason is on_face.
  bool coordinates = true;
};

/// Answers of some points of a batch: those of points[item(k)], for k below locations.size().
struct Answered {
  std::span<const Location> locations;
  std::span<const Reason> reasons;
  std::size_t first = 0;                       ///< added to the items
  const accel::morton::Coded* order = nullptr; ///< [locations.size()] of the items; null: 0, 1, ...
  /// Locations that were found one by one; the others lie in gridlets, many next to each other.
  /// Empty where nobody knows.
  std::span<const std::uint16_t> one_by_one = {};

  std::size_t item(std::size_t k) const { return first + (order ? order[k].id : k); }
};

/// Receives the answers of a call, from any thread, each point's once, in any order.
using PutAnswers = core::FunctionRef<void(const Answered& answered)>;

} // namespace insitu::query
