#pragma once

#include <algorithm>
#include <limits>

#include "accel/tree/tree.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "mesh/view.h"

namespace insitu::accel {

/// A value as a float that is not above it, or not below; beyond floats 2^127 and infinity.
inline float float_below(double v) {
  return v < -0x1p127 ? -std::numeric_limits<float>::infinity() : round_down(std::min(v, 0x1p127));
}
inline float float_above(double v) {
  return v > 0x1p127 ? std::numeric_limits<float>::infinity() : round_up(std::max(v, -0x1p127));
}

/// Value ranges of one scalar over a tree's children, in side arrays of their own: made when a
/// frame asks for them, and refreshed when values change. Rounded outwards to float.
class ValueRanges {
public:
  /// component -1: the magnitude of a vector field.
  ValueRanges(const Tree& tree, const mesh::MeshView& mesh, const mesh::FieldView& field,
              int component, const core::Threads& threads, core::Memory& memory);

  /// Other values over the same tree, in place.
  void refresh(const Tree& tree, const mesh::MeshView& mesh, const mesh::FieldView& field,
               int component, const core::Threads& threads);

  /// Bit c: a cell below child c may take a value in [lo, hi]. Conservative. Cells with a NaN at a
  /// vertex keep the range of their other vertices.
  unsigned may_contain(std::uint32_t node, float lo, float hi) const {
    const Range& r = ranges_[node];
    unsigned bits = 0;
    for (int c = 0; c < 8; ++c)
      bits |= (unsigned(r.lower[c] <= hi) & unsigned(r.upper[c] >= lo)) << c;
    return bits;
  }

  /// Over all owning cells; min() > max() if there is no value.
  float min() const { return min_; }
  float max() const { return max_; }

private:
  struct Range {
    float lower[8], upper[8];
  };

public:
  static constexpr std::int64_t bytes_a_node = sizeof(Range);

private:
  core::Buffer<Range> ranges_;
  float min_, max_;
};

} // namespace insitu::accel
