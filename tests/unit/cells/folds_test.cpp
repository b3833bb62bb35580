/// Folds anywhere in a cell, against the Jacobian sampled finely.

#include <gtest/gtest.h>

#include "cells/checks/folds.h"
#include "cells/kernels/kernels.h"
#include "fixtures/committed.h"

using namespace insitu;
using math::Vec3d;
using mesh::Shape;

namespace {

/// The Jacobian's determinant; a pyramid's about its apex, without the factor that vanishes there.
double determinant(Shape shape, const Vec3d* x, Vec3d r) {
  if (shape == Shape::pyramid)
    r.z = 0.0;
  Vec3d j[3];
  cells::jacobian(shape, x, r, j);
  if (shape == Shape::pyramid)
    j[2] = x[4] - cells::map_to_physical(shape, x, r);
  return dot(j[0], cross(j[1], j[2]));
}

struct Range {
  double least = HUGE_VAL, greatest = -HUGE_VAL;
};
Range sampled(Shape shape, const Vec3d* x, int n) {
  Range range;
  for (int k = 0; k <= n; ++k)
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        if (shape == Shape::wedge && i + j > n)
          continue;
        const double d = determinant(shape, x, {double(i) / n, double(j) / n, double(k) / n});
        range.least = std::fmin(range.least, d);
        range.greatest = std::fmax(range.greatest, d);
      }
  return range;
}

test::Vertices random_cell(Shape shape, double jitter, test::Random& random) {
  test::Vertices v = test::unit_cell(shape);
  for (Vec3d& p : v)
    p += random.uniform({-jitter, -jitter, -jitter}, {jitter, jitter, jitter});
  return v;
}

} // namespace

TEST(Folds, AreFoundWhereTheJacobianChangesSign) {
  test::Random random(901);
  int found = 0, between_corners = 0, sound = 0;
  for (const Shape shape : test::all_shapes)
    for (const double jitter : {0.2, 0.35, 0.5})
      for (int i = 0; i < 600; ++i) {
        const test::Vertices v = random_cell(shape, jitter, random);
        const bool changes = cells::jacobian_changes_sign(shape, v.data());
        const Range coarse = sampled(shape, v.data(), 8);
        if (coarse.least < -1e-12 && coarse.greatest > 1e-12) {
          ASSERT_TRUE(changes) << test::describe(shape, v.data(), {});
        } else if (changes) {
          // Samples of every 40th may just miss it.
          const Range fine = sampled(shape, v.data(), 40);
          ASSERT_TRUE(fine.least < 2e-3 && fine.greatest > -2e-3)
              << test::describe(shape, v.data(), {});
        }
        const Range corners = sampled(shape, v.data(), 1);
        found += changes;
        sound += !changes;
        between_corners += changes && (corners.least > 0 || corners.greatest < 0);
      }
  EXPECT_GT(found, 500);
  EXPECT_GT(sound, 500);
  EXPECT_GT(between_corners, 0) << "what the corners alone would miss";
}

/// Every cell that is proven free of folds has its numbering's sign turned, scaled and moved.
TEST(Folds, DoNotDependOnOrientationScaleOrPlace) {
  test::Random random(902);
  for (const Shape shape : test::all_shapes)
    for (int i = 0; i < 300; ++i) {
      const test::Vertices v = random_cell(shape, 0.35, random);
      const bool changes = cells::jacobian_changes_sign(shape, v.data());
      test::Vertices w = v;
      for (Vec3d& p : w)
        p = {-p.x, p.y * 0x1p-40, p.z * 0x1p40};
      EXPECT_EQ(cells::jacobian_changes_sign(shape, w.data()), changes);
    }
}

/// Validation takes another way, eight cells at a time, and comes to the same counts.
TEST(Folds, AreCountedByValidation) {
  test::Random random(903);
  std::int64_t between_corners = 0;
  for (const Shape shape : test::all_shapes)
    for (const double jitter : {0.2, 0.5}) {
      test::TestMesh mesh;
      std::int64_t folded = 0, inverted = 0;
      for (int i = 0; i < 6000; ++i) {
        const test::Vertices v = random_cell(shape, jitter, random);
        const Range corners = sampled(shape, v.data(), 1);
        const bool mixed = corners.least < 0 && corners.greatest > 0;
        const bool folds = cells::jacobian_changes_sign(shape, v.data());
        folded += folds || mixed;
        between_corners += folds && !mixed;
        // The wedge of unit_cell is VTK's, whose shape functions turn it the other way.
        inverted += !folds && !mixed && (shape == Shape::wedge) == (corners.least > 0);
        test::MeshCell cell{shape, {}};
        for (int k = 0; k < mesh::vertex_count(shape); ++k) {
          cell.vertices[std::size_t(k)] = int(mesh.vertices.size());
          mesh.vertices.push_back(v[std::size_t(k)]);
        }
        mesh.cells.push_back(cell);
      }
      fixtures::Committed m(mesh);
      const insitu_validation c = m.mesh.validate(m.threads).counts;
      EXPECT_EQ(c.folded_cells, folded) << mesh::shape_name(shape) << ", jitter " << jitter;
      EXPECT_EQ(c.inverted_cells, inverted) << mesh::shape_name(shape) << ", jitter " << jitter;
    }
  EXPECT_GT(between_corners, 0);
}

TEST(Folds, CollapsedAndFlatCellsHaveNone) {
  test::Vertices v = test::unit_cell(Shape::hexahedron);
  v[3] = v[0]; // an edge fell on its neighbour: the Jacobian is 0 there
  v[7] = v[4];
  EXPECT_FALSE(cells::jacobian_changes_sign(Shape::hexahedron, v.data()));
  v = test::unit_cell(Shape::hexahedron);
  for (int k : {5, 6, 7})
    v[std::size_t(k)] = v[4];
  EXPECT_FALSE(cells::jacobian_changes_sign(Shape::hexahedron, v.data()));
  for (const Shape shape : test::all_shapes) {
    test::Vertices flat = test::unit_cell(shape);
    for (Vec3d& p : flat)
      p.z = 0.0;
    EXPECT_FALSE(cells::jacobian_changes_sign(shape, flat.data()));
  }
}
