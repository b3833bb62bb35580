#pragma once

#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "cells/exact/contain_exact.h"
#include "cells/kernels/kernels.h"
#include "fixtures/cells.h"
#include "fixtures/committed.h"

/// What the tests of locate share: meshes, points that are hard, and the answer by brute force.
namespace insitu::test {

constexpr MeshKind all_kinds[] = {MeshKind::hexahedra, MeshKind::voxels,     MeshKind::wedges,
                                  MeshKind::pyramids,  MeshKind::tetrahedra, MeshKind::mixed};

inline const char* kind_name(MeshKind kind) {
  constexpr const char* names[] = {"hexahedra", "voxels",     "wedges",
                                   "pyramids",  "tetrahedra", "mixed"};
  return names[int(kind)];
}

inline TestMesh box(MeshKind kind, int size, double jitter = 0.2, double offset = 0,
                    Vec3d scale = {1, 1, 1}, std::uint64_t seed = 71) {
  return make_mesh({.kind = kind, .size = size, .jitter = jitter, .offset = offset, .scale = scale},
                   seed);
}

/// By the definition: the lowest of all cells that hold the point, -1 if none does.
inline std::int64_t owner(const mesh::MeshView& view, const Vec3d& p, double alpha = 1.0) {
  for (std::int64_t c = 0; c < view.cell_count(); ++c) {
    const std::int32_t piece = view.piece_of(c);
    if (!view.pieces[piece].owns(c - view.first_cell[piece]))
      continue;
    mesh::CellVertices cell;
    mesh::gather(view, c, cell, alpha);
    if (cells::holds(cells::contain_exact(cell.shape, cell.x, p).where))
      return c;
  }
  return -1;
}

/// Points near and on the faces, edges and vertices of random cells, and within them.
inline std::vector<Vec3d> hard_points(const mesh::MeshView& view, int count, std::uint64_t seed) {
  Random random(seed);
  std::vector<Vec3d> points;
  for (int i = 0; i < count; ++i) {
    mesh::CellVertices cell;
    mesh::gather(view, random.below(int(view.cell_count())), cell);
    points.push_back(adversarial_point(cell.shape, cell.x, random, false));
  }
  return points;
}

/// Random points within random cells, by the cell's own map.
inline std::vector<Vec3d> inner_points(const mesh::MeshView& view, int count, std::uint64_t seed) {
  Random random(seed);
  std::vector<Vec3d> points;
  for (int i = 0; i < count; ++i) {
    mesh::CellVertices cell;
    mesh::gather(view, random.below(int(view.cell_count())), cell);
    points.push_back(cells::map_to_physical(
        cell.shape, cell.x, fixtures::random_parametric(cell.shape, seed, std::uint64_t(i))));
  }
  return points;
}

inline std::string text(const Vec3d& p) {
  char line[120];
  std::snprintf(line, sizeof line, "{%a, %a, %a}", p.x, p.y, p.z);
  return line;
}

inline bool same_bits(const query::Location& a, const query::Location& b) {
  return a.cell == b.cell && std::memcmp(&a.parametric, &b.parametric, sizeof a.parametric) == 0;
}

/// The located parametric coordinates lead back to the point: to some roundings of the numbers that
/// the map adds up.
inline void expect_maps_back(const mesh::MeshView& view, const query::Location& at, const Vec3d& p,
                             double roundings = 32) {
  mesh::CellVertices cell;
  mesh::gather(view, at.cell, cell);
  const Vec3d back = cells::map_to_physical(cell.shape, cell.x, at.parametric);
  for (int a = 0; a < 3; ++a) {
    double largest = std::fabs(p[a]);
    for (int v = 0; v < cell.count; ++v)
      largest = std::fmax(largest, std::fabs(cell.x[v][a]));
    ASSERT_NEAR(back[a], p[a], roundings * 0x1p-53 * largest)
        << "cell " << at.cell << ", axis " << a << ", point " << text(p);
  }
}

/// Every way to ask gives what brute force gives: one by one and in batches, in standard and exact.
inline void check_owners(const fixtures::Committed& m, const std::vector<Vec3d>& points,
                         const std::string& what, double roundings = 32) {
  const query::Sampler sampler = m.sampler();
  const mesh::MeshView& view = sampler.mesh();
  for (const insitu_accuracy accuracy : {INSITU_STANDARD, INSITU_EXACT}) {
    std::vector<query::Location> batch(points.size());
    sampler.locate(m.threads, points, batch, {accuracy, 1.0});
    for (std::size_t i = 0; i < points.size(); ++i) {
      const query::Location one = sampler.locate(points[i], -1, {accuracy, 1.0});
      ASSERT_EQ(one.cell, owner(view, points[i]))
          << what << ", accuracy " << accuracy << ", point " << i << " " << text(points[i]);
      ASSERT_TRUE(same_bits(one, batch[i])) << what << ", point " << i << " " << text(points[i]);
      if (one && roundings > 0)
        expect_maps_back(view, one, points[i], roundings);
    }
  }
}

} // namespace insitu::test
