#pragma once

#include <cstdint>
#include <span>

#include "advect/lines/streamlines.h"

namespace insitu::test {

/// One of several lines.
struct LineView {
  std::span<const Vec3d> points;
  std::span<const double> times;
  std::span<const std::int64_t> cells;
  insitu_ending ending;
};
inline LineView line(const advect::Streamlines& s, std::size_t l) {
  const auto first = std::size_t(s.lines.offsets[l]),
             count = std::size_t(s.lines.offsets[l + 1]) - first;
  return {s.lines.points.span().subspan(first, count), s.lines.times.span().subspan(first, count),
          s.lines.cells.span().subspan(first, count), insitu_ending(s.lines.endings[l])};
}

} // namespace insitu::test
