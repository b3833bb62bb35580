// Where paths go out of cells, against bisection by the inverse map.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "advect/field/face_on_path.h"
#include "cells/kernels/kernels.h"
#include "numerics/exact/cases.h"

namespace insitu::test {
namespace {

using advect::DenseStep;

mesh::CellVertices cell_of(const TestMesh& mesh, const MeshCell& cell) {
  mesh::CellVertices c;
  c.shape = cell.shape;
  c.count = mesh::vertex_count(cell.shape);
  const Vertices x = mesh.cell_vertices(cell);
  std::copy_n(x.begin(), c.count, c.x);
  return c;
}

double depth(const mesh::CellVertices& c, const Vec3d& x) {
  const auto map = cells::inverse_map(c.shape, c.x, x);
  return map.converged ? map.margin : -1.0;
}
Vec3d coordinates(const mesh::CellVertices& c, const Vec3d& x) {
  return cells::inverse_map(c.shape, c.x, x).r;
}

/// A cubic path from a to b that begins and ends in these directions.
DenseStep path_from(const Vec3d& a, const Vec3d& b, const Vec3d& begins, const Vec3d& ends) {
  advect::Trial trial;
  trial.x = b;
  trial.v = ends;
  return {a, 0.0, 1.0, begins, trial, false};
}

/// Between a place inside and one outside.
double face_by_bisection(const mesh::CellVertices& c, const DenseStep& path, double low,
                         double high) {
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (depth(c, path.at(middle)) > 0.0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// How often the path goes from inside to outside, at 200 places.
int ways_out(const mesh::CellVertices& c, const DenseStep& path, double to, double& last_inside) {
  int count = 0;
  bool inside = true;
  for (int i = 1; i <= 200; ++i) {
    const bool now = depth(c, path.at(to * i / 200)) > 0.0;
    if (inside && !now && ++count == 1)
      last_inside = to * (i - 1) / 200;
    inside = now;
  }
  return count;
}

/// Paths of about a cell, as curved as steps of a flow are and far more.
TEST(FaceOnPath, IsWhereBisectionFindsIt) {
  Random random(17);
  int known = 0, all = 0, in_again = 0;
  for (const MeshKind kind :
       {MeshKind::hexahedra, MeshKind::voxels, MeshKind::wedges, MeshKind::tetrahedra}) {
    const TestMesh mesh = make_mesh({.kind = kind, .size = 4, .jitter = 0.2}, random);
    for (const MeshCell& cell : mesh.cells) {
      const mesh::CellVertices c = cell_of(mesh, cell);
      Vec3d centre;
      for (int v = 0; v < c.count; ++v)
        centre += (1.0 / c.count) * c.x[v];
      if (!(depth(c, centre) > 0.0))
        continue;
      const double size = std::sqrt(dot(c.x[1] - c.x[0], c.x[1] - c.x[0]));
      for (int k = 0; k < 20; ++k) {
        const auto vector = [&](double length) {
          return (length * size) *
                 Vec3d{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
        };
        const Vec3d way = vector(1.0), bend = vector(k % 2 == 0 ? 0.1 : 3.0);
        const DenseStep path = path_from(centre, centre + way, way + bend, way - bend);
        const Vec3d end = path.at(1.0);
        const auto at_end = cells::inverse_map(c.shape, c.x, end);
        if (!at_end.converged || at_end.margin > -1e-3 || at_end.margin < -0.5)
          continue;
        double low = 0.0;
        const int ways = ways_out(c, path, 1.0, low);
        const advect::PlaceOnPath found = face_on_path(c, 0, path, 0.0, 1.0, at_end.r);
        if (found.theta >= 0.0) {
          // On the inside of a face, and inside before.
          EXPECT_LT(depth(c, path.at(found.theta)), 1e-10);
          EXPECT_GT(depth(c, path.at(found.theta)), 1e-11);
          EXPECT_GT(depth(c, path.at(found.theta - 1e-4)), 0.0);
          const Vec3d r = coordinates(c, path.at(found.theta));
          EXPECT_LT(std::abs(r.x - found.r.x) + std::abs(r.y - found.r.y) +
                        std::abs(r.z - found.r.z),
                    1e-9);
        }
        if (ways == 1 && found.theta < low + 1.0 / 200) { // else it was in for a moment
          all += k % 2 == 0;
          if (found.theta < 0.0)
            continue;
          known += k % 2 == 0;
          EXPECT_NEAR(found.theta, face_by_bisection(c, path, low, low + 1.0 / 200), 1e-9);
        } else {
          ++in_again;
          if (found.theta >= 0.0) {
            EXPECT_GT(depth(c, path.at(0.5 * found.theta)), 0.0);
          }
        }
      }
    }
  }
  // Those that are not known cost time alone.
  EXPECT_GT(all, 1000);
  EXPECT_GT(double(known), 0.9 * all) << known << " of " << all;
  EXPECT_GT(in_again, 50);
}

/// What is said to be inside at its quarters is, and most paths that are get said so.
TEST(FaceOnPath, QuartersThatAreSaidToBeInsideAre) {
  Random random(18);
  const TestMesh mesh = make_mesh({.kind = MeshKind::mixed, .size = 6, .jitter = 0.2}, random);
  int said = 0, all = 0, outside = 0;
  for (const MeshCell& cell : mesh.cells) {
    const mesh::CellVertices c = cell_of(mesh, cell);
    if (c.shape == mesh::Shape::pyramid) {
      EXPECT_FALSE(is_inside_before(c, 0, path_from(c.x[0], c.x[1], {}, {}), {0.5, 0.5, 0.5}));
      continue;
    }
    for (int k = 0; k < 20; ++k) {
      const auto place = [&] {
        Vec3d x;
        double weight[8], sum = 0.0;
        for (int v = 0; v < c.count; ++v)
          sum += weight[v] = random.uniform(0.0, 1.0);
        for (int v = 0; v < c.count; ++v)
          x += (weight[v] / sum) * c.x[v];
        return x;
      };
      const Vec3d a = place(), b = place(), bend = double(k % 8) * (k % 8) * (place() - a);
      const DenseStep path = path_from(a, b, b - a + bend, b - a - bend);
      const auto at_end = cells::inverse_map(c.shape, c.x, b);
      if (!at_end.converged || at_end.margin < 1e-3)
        continue;
      bool inside = true;
      for (const double theta : {0.25, 0.5, 0.75})
        inside &= depth(c, path.at(theta)) > 0.0;
      const bool is_said = is_inside_before(c, 0, path, at_end.r);
      EXPECT_TRUE(inside || !is_said);
      all += inside;
      outside += !inside;
      said += is_said;
    }
  }
  EXPECT_GT(all, 1000);
  EXPECT_GT(outside, 1000);
  EXPECT_GT(double(said), 0.7 * all) << said << " of " << all;
}

/// Along a face that is no end of its way a path goes on to the next one.
TEST(FaceOnPath, FacesAlongTheWayAreNoEnds) {
  mesh::CellVertices c;
  c.shape = mesh::Shape::hexahedron;
  c.count = 8;
  const Vertices x = unit_cell(c.shape);
  std::copy_n(x.begin(), 8, c.x);
  const Vec3d a{0.25, 0.5, 0.0}, b{1.75, 0.5, -1e-12}; // along t = 0, face 4
  const DenseStep path = path_from(a, b, b - a, b - a);
  const advect::PlaceOnPath found = face_on_path(c, 1U << 4, path, 0.0, 1.0, b);
  EXPECT_NEAR(found.theta, 0.5, 1e-10);
  EXPECT_NEAR(found.r.x, 1.0, 1e-10);
  EXPECT_LT(found.r.x, 1.0);
}

} // namespace
} // namespace insitu::test
