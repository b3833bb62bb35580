#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "math/vec.h"

namespace insitu::bench::scaling {

/// The standard workload's even box of hexahedra as several processes have it: cut across its axes
/// into equal parts.
struct Layout {
  int processes = 1;
  std::array<int, 3> parts{1, 1, 1}; ///< along each axis
  std::array<int, 3> cells{1, 1, 1}; ///< of the whole box
  double width = 1.0;                ///< of a cell before the jitter
  double jitter = 0.0;               ///< in it

  struct Part {
    std::array<int, 3> first, end; ///< cells along each axis
    int count(int axis) const { return end[std::size_t(axis)] - first[std::size_t(axis)]; }
    std::int64_t cells() const { return std::int64_t(count(0)) * count(1) * count(2); }
  };
  std::array<int, 3> place(int rank) const {
    return {rank % parts[0], rank / parts[0] % parts[1], rank / parts[0] / parts[1]};
  }
  Part part(int rank) const;
  math::Vec3d size() const { return {width * cells[0], width * cells[1], width * cells[2]}; }
  std::int64_t cell_count() const { return std::int64_t(cells[0]) * cells[1] * cells[2]; }
  /// Where the jitter has it; i, j, k: of all vertices.
  math::Vec3d vertex(int i, int j, int k) const;
  /// Of the parts before the jitter.
  math::Vec3d low(const Part& part) const;
  math::Vec3d high(const Part& part) const;
};

/// A box of about so many cells in all; or, weak, of so many on each process, by the same cuts.
Layout make_layout(int processes, std::int64_t cells, bool weak, double jitter);

/// The arrays of a process: vertices that other processes have too are equal to the bit.
struct PartMesh {
  std::vector<double> points;             ///< interleaved
  std::vector<std::int32_t> connectivity; ///< hexahedra, x fastest
  std::vector<std::int64_t> ids;          ///< global, of cells
  std::vector<double> distance;           ///< from the box's middle, at vertices
  std::vector<double> velocity;           ///< workload::abc_flow, interleaved
  std::int64_t vertex_count() const { return std::int64_t(distance.size()); }
};
PartMesh make_part(const Layout& layout, int rank);

} // namespace insitu::bench::scaling
