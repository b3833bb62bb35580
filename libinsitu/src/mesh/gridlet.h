#pragma once

#include <cstdint>

#include "mesh/lattice.h"

namespace insitu::mesh {

/// A small uniform grid of dual cells of one depth (Zellmann 2023, section 4.2). Its vertices are
/// centres of leaves; the cell (i, j, k) spans those of indices lower + (i, j, k) to one more each.
struct Gridlet {
  static constexpr int side = 8;      ///< cells, at most
  static constexpr int cell_bits = 9; ///< cells are numbered i + 8 (j + 8 k)
  static constexpr int most_cells = 512;

  std::int32_t lower[3]; ///< the leaf at the first vertex
  std::uint8_t depth;
  std::uint8_t size[3]; ///< cells
  std::uint32_t first;  ///< the first of its (size + 1)^3 vertices, i fastest

  INSITU_HD std::int64_t vertex_count() const {
    return std::int64_t(size[0] + 1) * (size[1] + 1) * (size[2] + 1);
  }
};
static_assert(sizeof(Gridlet) == 20);

/// The gridlets of a mesh; plain data.
struct GridletsView {
  static constexpr std::uint32_t no_leaf = 0xffffffff;
  Lattice lattice;
  const Gridlet* gridlets = nullptr;
  std::int64_t count = 0;
  const std::uint32_t* leaves = nullptr; ///< a vertex's; no_leaf: empty
  /// A bit a cell, [count][8]: word k is layer k, bit i + 8 j. Set: all its vertices have leaves.
  const std::uint64_t* full = nullptr;

  INSITU_HD bool is_full(std::int64_t cell) const { return (full[cell >> 6] >> (cell & 63)) & 1; }
  /// The vertex at the lower corner of a cell.
  INSITU_HD static std::int64_t first_vertex(const Gridlet& g, int local) {
    const int i = local & 7, j = (local >> 3) & 7, k = local >> 6;
    return std::int64_t(g.first) + i + (g.size[0] + 1) * (j + (g.size[1] + 1) * k);
  }
  /// In the order of a voxel's.
  INSITU_HD int vertex_ids(std::int64_t cell, std::int64_t* ids) const {
    const Gridlet& g = gridlets[cell >> Gridlet::cell_bits];
    const std::int64_t v = first_vertex(g, int(cell & (Gridlet::most_cells - 1)));
    const std::int64_t dj = g.size[0] + 1, dk = dj * (g.size[1] + 1);
    for (int c = 0; c < 8; ++c)
      ids[c] = v + (c & 1) + (c & 2 ? dj : 0) + (c & 4 ? dk : 0);
    return 8;
  }
  /// Where a vertex lies; searches for its gridlet.
  INSITU_HD math::Vec3d point(std::int64_t vertex) const {
    std::int64_t lo = 0, hi = count - 1;
    while (lo < hi) {
      const std::int64_t mid = (lo + hi + 1) / 2;
      if (std::int64_t(gridlets[mid].first) <= vertex)
        lo = mid;
      else
        hi = mid - 1;
    }
    const Gridlet& g = gridlets[lo];
    const std::int64_t at = vertex - g.first, ni = g.size[0] + 1, nj = g.size[1] + 1;
    return {coordinate(g, 0, int(at % ni)), coordinate(g, 1, int(at / ni % nj)),
            coordinate(g, 2, int(at / (ni * nj)))};
  }
  /// Where the vertices of a cell lie, in the order of a voxel's.
  INSITU_HD void points(std::int64_t cell, math::Vec3d* x) const {
    const Gridlet& g = gridlets[cell >> Gridlet::cell_bits];
    for (int a = 0; a < 3; ++a) {
      const int i = int(cell >> (3 * a)) & 7;
      const double lower = coordinate(g, a, i), upper = coordinate(g, a, i + 1);
      for (int v = 0; v < 8; ++v)
        x[v][a] = (v >> a) & 1 ? upper : lower;
    }
  }
  /// Along an axis, vertex i's coordinate.
  INSITU_HD double coordinate(const Gridlet& g, int axis, int i) const {
    return lattice.centre(axis, g.depth, std::int64_t(g.lower[axis]) + i);
  }
};

} // namespace insitu::mesh
