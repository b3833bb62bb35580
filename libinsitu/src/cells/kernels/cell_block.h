#pragma once

#include <cstdint>

#include "math/vec.h"
#include "mesh/shape.h"

namespace insitu::cells {

/// Vertices of at most 64 cells of one shape, transposed for packs. Rows are a cache line longer
/// than they need be, so that a cell's numbers do not fall into few sets of the cache.
struct CellBlock {
  static constexpr int size = 64, row = size + 8;
  int count = 0;
  alignas(64) double vertex[8][3][row];

  /// A bit a cell: all of them.
  std::uint64_t all() const {
    return count == size ? ~std::uint64_t(0) : (std::uint64_t(1) << count) - 1;
  }
  void get(mesh::Shape shape, int k, math::Vec3d* x) const {
    for (int v = 0; v < mesh::vertex_count(shape); ++v)
      x[v] = {vertex[v][0][k], vertex[v][1][k], vertex[v][2][k]};
  }
  void set(int n, int k, const math::Vec3d* x) {
    for (int v = 0; v < n; ++v)
      for (int a = 0; a < 3; ++a)
        vertex[v][a][k] = x[v][a];
  }
  /// Idle lanes of the last pack repeat the first cell, so that they do nothing odd.
  void fill_up(mesh::Shape shape) {
    for (int k = count; k % 8 != 0; ++k)
      for (int v = 0; v < mesh::vertex_count(shape); ++v)
        for (int a = 0; a < 3; ++a)
          vertex[v][a][k] = vertex[v][a][0];
  }
};

} // namespace insitu::cells
