#pragma once

#include <cstdint>
#include <span>

#include "core/memory.h"
#include "math/vec.h"

namespace insitu::advect {

/// Lines through space: vertices[offsets[l]] to vertices[offsets[l + 1] - 1] are line l's. A line
/// has no vertex if its seed was outside, and one if its particle never moved.
struct Polylines {
  explicit Polylines(core::Memory& memory)
      : points(memory, INSITU_MEMORY_TRACER), times(memory, INSITU_MEMORY_TRACER),
        cells(memory, INSITU_MEMORY_TRACER), offsets(memory, INSITU_MEMORY_TRACER),
        particles(memory, INSITU_MEMORY_TRACER), endings(memory, INSITU_MEMORY_TRACER) {}

  std::size_t line_count() const { return particles.size(); }
  std::size_t vertex_count() const { return points.size(); }

  // Per vertex.
  core::Buffer<math::Vec3d> points;
  core::Buffer<double> times;
  core::Buffer<std::int64_t> cells; ///< flat id of the owner, when the vertex was made
  // Per line.
  core::Buffer<std::int64_t> offsets; ///< [lines + 1]
  core::Buffer<std::int64_t> particles;
  core::Buffer<std::uint8_t> endings; ///< insitu_ending
};

} // namespace insitu::advect
