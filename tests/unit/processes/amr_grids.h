#pragma once

#include "unit/amr/amr_mesh.h"

/// Adaptive meshes that scenes over processes are tested on: places from 0 to 4 along each axis.
namespace insitu::test {

/// A block of 4 x 4 x 4 cells, of which some are refined, once or twice, with holes: places from 0
/// to 4. Leaves in Morton order, or patches.
inline AmrMesh octree() {
  AmrMesh mesh;
  mesh.lattice = {{0, 0, 0}, {1, 1, 1}};
  mesh.depth_of = {0, 1, 2};
  for (std::int64_t k = 0; k < 4; ++k)
    for (std::int64_t j = 0; j < 4; ++j)
      for (std::int64_t i = 0; i < 4; ++i) {
        if ((i * 7 + j * 3 + k * 5) % 4 != 0) {
          mesh.add_leaf(0, {i, j, k});
          continue;
        }
        for (int o = 0; o < 8; ++o) {
          const Index at = {2 * i + (o & 1), 2 * j + (o >> 1 & 1), 2 * k + (o >> 2)};
          if (o != int((i + j) % 8)) {
            mesh.add_leaf(1, at);
            continue;
          }
          for (int p = 0; p < 8; ++p)
            mesh.add_leaf(2, {2 * at[0] + (p & 1), 2 * at[1] + (p >> 1 & 1), 2 * at[2] + (p >> 2)});
        }
      }
  return mesh;
}

inline AmrMesh patches() {
  AmrMesh mesh;
  mesh.lattice = {{0, 0, 0}, {1, 1, 1}};
  mesh.depth_of = {0, 1, 2};
  for (std::int64_t k = 0; k < 2; ++k)
    for (std::int64_t i = 0; i < 2; ++i)
      mesh.add_patch(0, {2 * i, 0, 2 * k}, {2, 4, 2});
  mesh.add_patch(1, {2, 2, 2}, {2, 4, 4});
  mesh.add_patch(1, {4, 2, 2}, {2, 4, 4});
  mesh.add_patch(2, {6, 6, 6}, {4, 4, 4});
  return mesh;
}

/// A block of 16 cells along each axis, of which those in a box that moves are refined.
inline AmrMesh refined_block(std::int64_t from) {
  constexpr std::int64_t cells = 16;
  AmrMesh mesh;
  mesh.lattice = {{0, 0, 0}, {4.0 / double(cells), 4.0 / double(cells), 4.0 / double(cells)}};
  mesh.depth_of = {0, 1, 2};
  for (std::int64_t k = 0; k < cells; ++k)
    for (std::int64_t j = 0; j < cells; ++j)
      for (std::int64_t i = 0; i < cells; ++i) {
        const bool is_refined = i >= from && i < from + 4 && j >= 4 && j < 9 && k >= 2 && k < 8;
        if (!is_refined) {
          mesh.add_leaf(0, {i, j, k});
          continue;
        }
        for (int o = 0; o < 8; ++o)
          mesh.add_leaf(1, {2 * i + (o & 1), 2 * j + (o >> 1 & 1), 2 * k + (o >> 2)});
      }
  return mesh;
}

/// A block of 20 cells along each axis, every other one refined: most cells of the dual stitch.
inline AmrMesh checkers(std::int64_t odd) {
  constexpr std::int64_t cells = 20;
  AmrMesh mesh;
  mesh.lattice = {{0, 0, 0}, {0.2, 0.2, 0.2}};
  mesh.depth_of = {0, 1};
  for (std::int64_t k = 0; k < cells; ++k)
    for (std::int64_t j = 0; j < cells; ++j)
      for (std::int64_t i = 0; i < cells; ++i)
        if ((i + j + k) % 2 == odd)
          mesh.add_leaf(0, {i, j, k});
        else
          for (int o = 0; o < 8; ++o)
            mesh.add_leaf(1, {2 * i + (o & 1), 2 * j + (o >> 1 & 1), 2 * k + (o >> 2)});
  return mesh;
}

} // namespace insitu::test
