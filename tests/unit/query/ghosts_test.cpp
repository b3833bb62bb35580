#include <cmath>
#include <cstdlib>
#include <gtest/gtest.h>

#include "core/random.h"
#include "unit/query/ghosted_amr.h"

/// The solver's ghost cells beyond the domain of an adaptive mesh.
namespace insitu::test {
namespace {

using math::Vec3d;

double linear(const Vec3d& p) {
  return 3.0 + p.x - 2.0 * p.y + 0.5 * p.z;
}
double rough(const Vec3d& p) {
  return std::sin(40 * p.x) + std::cos(31 * p.y + 7 * p.z);
}
std::uint8_t all_faces(std::size_t) {
  return 63;
}

/// Points in the mesh, a third of them on faces of leaves.
std::vector<Vec3d> points_in(AmrMesh& mesh, int count, std::uint64_t seed) {
  std::vector<Vec3d> points;
  const std::vector<Leaf> leaves = leaves_of(mesh);
  const mesh::Lattice& lattice = mesh.lattice;
  for (int i = 0; i < count; ++i) {
    const auto r = [&](int c) {
      return core::random_unit(seed, std::uint64_t(i), std::uint64_t(c));
    };
    const Leaf& leaf = leaves[std::size_t(r(0) * double(leaves.size()))];
    Vec3d p;
    for (int a = 0; a < 3; ++a)
      p[a] = lattice.place(a, leaf.depth, 2 * leaf.index[std::size_t(a)]) +
             r(1 + a) * lattice.width(a, leaf.depth);
    if (i % 3 == 0) {
      const int a = int(3 * r(4));
      p[a] = lattice.place(a, leaf.depth, 2 * leaf.index[std::size_t(a)] + (r(5) < 0.5 ? 0 : 2));
    }
    points.push_back(p);
  }
  return points;
}

double value_at(const fixtures::Committed& committed, const Vec3d& p) {
  const query::Sampler sampler = committed.sampler();
  const query::Location at = sampler.locate(p);
  if (!at)
    return std::numeric_limits<double>::infinity();
  double value;
  sampler.interpolate(committed.mesh.mesh().field("f"), at, &value);
  return value;
}

class Ghosts : public testing::TestWithParam<Recipe> {};

/// Nothing but the ghosts beyond faces is read: all others are NaN.
TEST_P(Ghosts, LinearFieldsAreReproducedUpToTheBoundary) {
  GhostedAmr mesh(GetParam(), all_faces, linear);
  for (const Vec3d& p : points_in(mesh.amr, 3000, GetParam().seed))
    ASSERT_NEAR(value_at(mesh.committed, p), linear(p), 1e-10)
        << GetParam().name() << " at " << p.x << ", " << p.y << ", " << p.z;
}

TEST_P(Ghosts, FieldsAloneReadThemAgain) {
  GhostedAmr mesh(GetParam(), all_faces, linear);
  const Vec3d p = points_in(mesh.amr, 1, 3)[0]; // on a face
  EXPECT_NEAR(value_at(mesh.committed, p), linear(p), 1e-10);
  mesh.fill([](const Vec3d& x) { return 5.0 - 3.0 * linear(x); });
  EXPECT_EQ(mesh.committed.commit(INSITU_CHANGED_FIELDS).action, INSITU_KEEP);
  for (const Vec3d& q : points_in(mesh.amr, 500, 4))
    ASSERT_NEAR(value_at(mesh.committed, q), 5.0 - 3.0 * linear(q), 1e-9) << GetParam().name();
}

/// A face has ghosts or not, at random: the interpolant has no jumps, and where a leaf and all its
/// neighbours have none it is as without any.
TEST_P(Ghosts, SomeOfThemMakeNoCracks) {
  const auto some = [](std::size_t p) {
    return std::uint8_t(64 * core::random_unit(8, std::uint64_t(p), 0));
  };
  GhostedAmr mesh(GetParam(), some, rough);
  int compared = 0;
  for (const Vec3d& p : points_in(mesh.amr, 6000, 50 + GetParam().seed)) {
    const auto r = [&](int c) {
      return core::random_unit(9, std::uint64_t(compared), std::uint64_t(c));
    };
    const Vec3d step = 1e-11 * Vec3d{r(0) - 0.5, r(1) - 0.5, r(2) - 0.5};
    const double a = value_at(mesh.committed, p - step), b = value_at(mesh.committed, p + step);
    if (std::isinf(a) || std::isinf(b))
      continue; // across the domain's boundary
    ++compared;
    // Slopes of some hundreds a unit, in thin corners of stitching cells, make some 1e-9.
    ASSERT_NEAR(a, b, 1e-8) << GetParam().name() << " at " << p.x << ", " << p.y << ", " << p.z;
  }
  EXPECT_GT(compared, 1000);
}

/// No ghost is a cell: counts, owners and the cells' values stay as they are without.
TEST_P(Ghosts, OwnNothing) {
  GhostedAmr with(GetParam(), all_faces, rough),
      without(
          GetParam(), [](std::size_t) { return std::uint8_t(0); }, rough);
  const insitu_amr_info a = with.committed.mesh.amr_info(), b = without.committed.mesh.amr_info();
  EXPECT_EQ(a.leaves, b.leaves);
  EXPECT_EQ(a.gridlets, b.gridlets);
  EXPECT_EQ(a.cubes, b.cubes);
  EXPECT_EQ(a.stitching, b.stitching);
  EXPECT_GT(a.bytes, b.bytes); // the weights of vertices on the boundary
  for (const Vec3d& p : points_in(with.amr, 1000, 20 + GetParam().seed)) {
    const query::Location x = with.committed.sampler().locate(p),
                          y = without.committed.sampler().locate(p);
    ASSERT_EQ(x.cell, y.cell);
    ASSERT_EQ(with.committed.mesh.own(x, p).cell, without.committed.mesh.own(y, p).cell);
  }
  for (const Leaf& leaf : leaves_of(with.amr)) {
    Vec3d centre;
    for (int axis = 0; axis < 3; ++axis)
      centre[axis] = with.amr.lattice.centre(axis, leaf.depth, leaf.index[std::size_t(axis)]);
    ASSERT_NEAR(value_at(with.committed, centre), rough(centre), 1e-12);
    ASSERT_NEAR(value_at(without.committed, centre), rough(centre), 1e-12);
  }
}

std::vector<Recipe> recipes() {
  std::vector<Recipe> all;
  for (const int kind : {0, 1, 2, 3, 4, 5})
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
      const Recipe recipe{.seed = seed, .kind = kind, .roots = 2, .levels = kind == 5 ? 4 : 3};
      AmrMesh mesh = make_mesh(recipe);
      if (!leaves_of(mesh).empty())
        all.push_back(recipe);
    }
  all.push_back({.seed = 3, .kind = 5, .roots = 2, .levels = 7}); // levels differ by up to six
  return all;
}

INSTANTIATE_TEST_SUITE_P(Random, Ghosts, testing::ValuesIn(recipes()), [](const auto& of) {
  return "kind" + std::to_string(of.param.kind) + "_seed" + std::to_string(of.param.seed);
});

TEST(GhostCells, OfOneFaceAlone) {
  GhostedAmr mesh(
      {.kind = 1, .roots = 1, .levels = 1},
      [](std::size_t p) { return std::uint8_t(p == 0 ? 2 : 0); }, linear);
  const mesh::AmrView& view = mesh.amr.view();
  const mesh::AmrPieceView& piece = view.pieces[0];
  // At the middle of the upper face of its last cell along x, where another patch may lie instead
  // of ghosts, and along y, where it has none.
  mesh::AmrCell cell = view.cell(piece, piece.cell_count - 1);
  Vec3d at = RegisteredAmr::centre_of(view, cell);
  const double centre = linear(at);
  at.x += 0.5 * view.lattice.width(0, 0);
  EXPECT_NEAR(value_at(mesh.committed, at), linear(at), 1e-12);
  at.x -= 0.5 * view.lattice.width(0, 0);
  at.y += 0.5 * view.lattice.width(1, 0);
  EXPECT_NEAR(value_at(mesh.committed, at), centre, 1e-12); // kept
}

/// Two meshes, as of two processes, whose ghosts hold each other's cells: the same samples on the
/// face between them, away from its rim, where the ghosts beyond its sides count as well.
TEST(GhostCells, OfAnotherProcess) {
  const std::int64_t n = 6;
  std::vector<double> values; // of both, [n + 2][n + 2][2 n + 2], with a layer of ghosts
  for (std::int64_t i = 0; i < (2 * n + 2) * (n + 2) * (n + 2); ++i)
    values.push_back(core::random_unit(31, std::uint64_t(i), 0));
  fixtures::Committed sides[2];
  for (int side = 0; side < 2; ++side) {
    mesh::Mesh& mesh = sides[side].mesh.mesh();
    const insitu_amr levels = insitu_amr_default();
    mesh.set_amr(&levels);
    insitu_patch patch = insitu_patch_default();
    insitu_array a =
        insitu_array_of(&values[std::size_t(side * n + 1 + (2 * n + 2) * (1 + (n + 2)))],
                        INSITU_FLOAT64, n * n * n, 1);
    patch.lower[0] = side * n;
    for (int axis = 0; axis < 3; ++axis) {
      patch.cells[axis] = a.extent[axis] = n;
      patch.ghosts_before[axis] = patch.ghosts_after[axis] = 1;
      a.stride[axis] = axis == 0 ? 8 : axis == 1 ? 8 * (2 * n + 2) : 8 * (2 * n + 2) * (n + 2);
    }
    mesh.set_patch(0, &patch);
    mesh.set_field(0, "f", INSITU_CELL, &a, 1);
    sides[side].commit();
  }
  for (int i = 0; i < 500; ++i) {
    const auto r = [&](int c) {
      return 0.5 + double(n - 1) * core::random_unit(32, std::uint64_t(i), std::uint64_t(c));
    };
    const Vec3d p{double(n), r(0), r(1)};
    ASSERT_NEAR(value_at(sides[0], p), value_at(sides[1], p), 1e-14) << p.y << ", " << p.z;
  }
}

/// A patch with ghosts beside leaves, which have none; two components in arrays of their own.
TEST(GhostCells, BesideLeaves) {
  fixtures::Committed committed;
  mesh::Mesh& mesh = committed.mesh.mesh();
  insitu_amr levels = insitu_amr_default();
  levels.level_count = 2;
  mesh.set_amr(&levels);
  // Cells (0..1)^3 with a layer of ghosts all around, and eight leaves that fill the cell (2, 0,
  // 0).
  insitu_patch patch = insitu_patch_default();
  for (int a = 0; a < 3; ++a) {
    patch.cells[a] = 2;
    patch.ghosts_before[a] = patch.ghosts_after[a] = 1;
  }
  mesh.set_patch(0, &patch);
  const auto f = [](double x, double y, double z, int c) {
    return c == 0 ? 1.0 + 2.0 * x - y + 0.5 * z : 4.0 * y - 3.0 * z;
  };
  std::vector<float> of_patch[2], of_leaves[2];
  std::vector<std::int32_t> depths, corners;
  for (int c = 0; c < 2; ++c) {
    for (int n = 0; n < 64; ++n)
      of_patch[c].push_back(float(f(n % 4 - 0.5, n / 4 % 4 - 0.5, n / 16 - 0.5, c)));
    for (int o = 0; o < 8; ++o)
      of_leaves[c].push_back(
          float(f(2.25 + 0.5 * (o & 1), 0.25 + 0.5 * (o >> 1 & 1), 0.25 + 0.5 * (o >> 2), c)));
  }
  for (int o = 0; o < 8; ++o) {
    depths.push_back(1);
    corners.insert(corners.end(), {4 + (o & 1), o >> 1 & 1, o >> 2});
  }
  insitu_leaves leaves = insitu_leaves_default();
  leaves.levels = insitu_array_of(depths.data(), INSITU_INT32, 8, 1);
  leaves.corners = insitu_array_of(corners.data(), INSITU_INT32, 8, 3);
  mesh.set_leaves(1, &leaves);
  insitu_array arrays[2][2];
  for (int c = 0; c < 2; ++c) {
    insitu_array& a = arrays[0][c] = insitu_array_of(&of_patch[c][21], INSITU_FLOAT32, 8, 1);
    for (int axis = 0; axis < 3; ++axis) {
      a.extent[axis] = 2;
      a.stride[axis] = 4 << (2 * axis);
    }
    arrays[1][c] = insitu_array_of(of_leaves[c].data(), INSITU_FLOAT32, 8, 1);
  }
  for (int p = 0; p < 2; ++p)
    mesh.set_field(p, "f", INSITU_CELL, arrays[p], 2);
  committed.commit();
  const query::Sampler sampler = committed.sampler();
  const mesh::FieldView field = mesh.field("f");
  const auto expect = [&](const Vec3d& p, const Vec3d& as_at) {
    const query::Location at = sampler.locate(p);
    ASSERT_TRUE(at);
    double values[2];
    sampler.interpolate(field, at, values);
    for (int c = 0; c < 2; ++c) // float32 values of some units
      EXPECT_NEAR(values[c], f(as_at.x, as_at.y, as_at.z, c), 2e-6)
          << p.x << ", " << p.y << ", " << p.z;
  };
  for (const Vec3d& p : {Vec3d{0, 1, 1}, Vec3d{0, 0, 0}, Vec3d{1, 0, 2}, Vec3d{0.3, 0.1, 1.9},
                         Vec3d{1, 2, 1}, Vec3d{2, 2, 2}}) // the patch's
    expect(p, p);
  expect({2.75, 0.75, 1}, {2.75, 0.75, 0.75}); // leaves keep theirs
  expect({3, 0.25, 0.25}, {2.75, 0.25, 0.25});
  expect({2, 0.5, 0.5}, {2, 0.5, 0.5}); // between both
}

} // namespace
} // namespace insitu::test
