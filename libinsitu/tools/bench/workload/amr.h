#pragma once

#include <cstdint>
#include <vector>

#include "math/vec.h"

/// The standard adaptive mesh: blocks about a sphere, three levels, ratio 2.
namespace insitu::workload {

struct AmrMesh {
  struct Block {
    int level = 0;
    std::int64_t lower[3] = {0, 0, 0}; ///< of its first cell, on its level
  };
  int level_count = 3;
  int side = 16;        ///< cells along an edge of a block
  double spacing = 4.0; ///< of level 0; the box is [0, 256]^3
  std::vector<Block> blocks;
  std::vector<double> values; ///< [block][cell], i fastest: field() / 256 at the cell's centre

  std::int64_t cells_a_block() const { return std::int64_t(side) * side * side; }
  std::int64_t cell_count() const { return std::int64_t(blocks.size()) * cells_a_block(); }
  double width(int level) const { return spacing / double(1 << level); }
  math::Vec3d centre(const Block& block, std::int64_t cell) const;
};

/// With the number of cells nearest to `cells` (masked ones left out); 4,018,176 for blocks of
/// 16^3.
AmrMesh make_amr(std::int64_t cells);

/// The same cells as leaves of octrees: those without finer ones, block by block.
struct AmrLeaves {
  std::vector<std::int32_t> levels, corners; ///< corners interleaved, each on its level
  std::vector<double> values;
};
AmrLeaves leaves_of(const AmrMesh& mesh);

/// A random octree about a wavy sphere in the box [0, 256]^3, its leaves in depth-first order. A
/// leaf is split where the surface is nearer than about `reach` of its widths; levels may differ by
/// more than one between neighbours. Values as of AmrMesh. Seed 9.
struct Octree {
  AmrLeaves leaves;
  int level_count = 1;
  double spacing = 64.0; ///< of level 0
  double reach = 0.0;
};
Octree make_octree(double reach, int level_count);
/// With about `cells` leaves, in as few levels as a reach of 1 allows.
Octree make_octree(std::int64_t cells);
/// The same with leaves split until levels differ by one at most across faces, edges and corners,
/// as p4est keeps its forests.
Octree balanced(const Octree& octree);

/// An octree as solvers refine theirs: `roots` cells of level 0 along an axis of the box, and a
/// cell is split where a sphere, the front, passes through it or within two of its widths.
/// Neighbours then differ by one level at most. Values as of AmrMesh.
Octree make_front_octree(int roots, int level_count);
/// With about `cells` leaves, in four levels.
Octree make_front_octree(std::int64_t cells);

/// count points at random in the box, seed 7; and the raster of n^3 points, x fastest.
std::vector<math::Vec3d> random_amr_points(std::int64_t count);
std::vector<math::Vec3d> raster_amr_points(int n);

} // namespace insitu::workload
