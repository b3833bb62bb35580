// Steps before the current one, as far as they are kept.
#include <gtest/gtest.h>

#include "fixtures/committed.h"

using namespace insitu;

namespace {

test::TestMesh box(test::MeshKind kind, int size) {
  return test::make_mesh({.kind = kind, .size = size}, 21);
}

} // namespace

TEST(Earlier, KeepsAStepUntilToldOtherwise) {
  fixtures::Committed m(box(test::MeshKind::wedges, 3));
  mesh::Mesh& mesh = m.mesh.mesh();
  const auto n = std::size_t(m.arrays.vertex_count());
  std::vector<float> velocity(3 * n);
  std::vector<double> density(std::size_t(m.arrays.cell_count()), 7.0);
  for (std::size_t i = 0; i < velocity.size(); ++i)
    velocity[i] = float(i);
  const insitu_array v = insitu_array_of(velocity.data(), INSITU_FLOAT32, std::int64_t(n), 3),
                     d = insitu_array_of(density.data(), INSITU_FLOAT64, m.arrays.cell_count(), 1);
  mesh.set_field(0, "velocity", INSITU_VERTEX, &v, 1);
  mesh.set_field(0, "density", INSITU_CELL, &d, 1);
  m.commit();
  EXPECT_FALSE(mesh.earlier_field("velocity"));
  mesh.keep_earlier({{"velocity"}, {"density"}}, m.threads);
  EXPECT_EQ(m.memory.current(INSITU_MEMORY_EARLIER),
            std::int64_t(8 * (3 * n + density.size() + 3 * n)));
  mesh.expose_earlier(true, m.threads);
  EXPECT_EQ(mesh.view().earlier_points, nullptr) << "nothing moved";

  const std::vector<double> before = m.arrays.points;
  for (std::size_t i = 0; i < velocity.size(); ++i) {
    velocity[i] = -1;
    m.arrays.points[i] += i == 5 ? 0.375 : (i % 3 == 1 ? -0.125 : 0.0);
  }
  density.assign(density.size(), 8.0);
  m.commit(INSITU_CHANGED_GEOMETRY | INSITU_CHANGED_FIELDS);
  mesh.expose_earlier(true, m.threads);
  ASSERT_NE(mesh.view().earlier_points, nullptr);
  EXPECT_EQ(mesh.view().largest_displacement, 0.375);
  const auto earlier = mesh.earlier_field("velocity"), rho = mesh.earlier_field("density");
  ASSERT_TRUE(earlier && rho);
  EXPECT_EQ(rho->pieces[0].load(3, 0), 7.0);
  for (std::size_t i = 0; i < n; ++i)
    for (int c = 0; c < 3; ++c) {
      ASSERT_EQ(earlier->pieces[0].load(std::int64_t(i), c), double(3 * i + std::size_t(c)));
      ASSERT_EQ(mesh.view().earlier_points[i][c], before[3 * i + std::size_t(c)]);
    }
  // A blended cell is what the two steps' vertices blend to.
  mesh::CellVertices then, now, half;
  mesh::gather(mesh.view(), 4, now);
  mesh::gather(mesh.view(), 4, then, 0.0);
  mesh::gather(mesh.view(), 4, half, 0.25);
  for (int i = 0; i < now.count; ++i)
    for (int c = 0; c < 3; ++c) {
      EXPECT_EQ(then.x[i][c], before[std::size_t(3 * now.ids[i] + c)]);
      EXPECT_EQ(half.x[i][c], 0.75 * then.x[i][c] + 0.25 * now.x[i][c]);
    }
  mesh.keep_earlier({{"density"}}, m.threads); // no more velocity
  EXPECT_FALSE(mesh.earlier_field("velocity"));
  mesh.expose_earlier(false, m.threads);
  EXPECT_EQ(mesh.view().earlier_points, nullptr);
  mesh.release_earlier();
  EXPECT_EQ(m.memory.current(INSITU_MEMORY_EARLIER), 0);
  EXPECT_FALSE(mesh.earlier_field("density"));
}

// Of each field as many steps as are asked for, the latest first, in as much memory and no more.
TEST(Earlier, OlderStepsStayAsFarAsTheyAreAskedFor) {
  fixtures::Committed m(box(test::MeshKind::hexahedra, 3));
  mesh::Mesh& mesh = m.mesh.mesh();
  const std::int64_t n = m.arrays.vertex_count();
  std::vector<double> values(static_cast<std::size_t>(n));
  const insitu_array a = insitu_array_of(values.data(), INSITU_FLOAT64, n, 1);
  mesh.set_field(0, "f", INSITU_VERTEX, &a, 1);
  mesh.set_field(0, "g", INSITU_VERTEX, &a, 1);
  m.commit();
  const auto kept = [&](const char* name) {
    std::vector<double> found;
    for (const mesh::FieldView& f : mesh.earlier_fields(name))
      found.push_back(f.pieces[0].load(n - 1, 0));
    return found;
  };
  const auto step = [&](double value, const std::vector<mesh::KeptField>& fields) {
    values.assign(values.size(), value);
    m.commit(INSITU_CHANGED_FIELDS);
    mesh.keep_earlier(fields, m.threads);
  };
  for (int k = 1; k <= 5; ++k)
    step(k, {{"f", 3}, {"g", 1}});
  EXPECT_EQ(kept("f"), (std::vector<double>{5, 4, 3}));
  EXPECT_EQ(kept("g"), std::vector<double>{5});
  EXPECT_EQ(m.memory.current(INSITU_MEMORY_EARLIER), 8 * n * (3 + 1 + 3));
  const mesh::EarlierStep copy = mesh.copy_earlier();
  step(6, {{"f", 2}, {"g", 2}});
  EXPECT_EQ(kept("f"), (std::vector<double>{6, 5}));
  EXPECT_EQ(kept("g"), (std::vector<double>{6, 5}));
  EXPECT_EQ(m.memory.current(INSITU_MEMORY_EARLIER), 8 * n * (2 + 2 + 3));
  step(7, {{"g", 2}});
  step(8, {{"f", 2}, {"g", 2}});
  EXPECT_EQ(kept("f"), std::vector<double>{8}) << "a step was left out";
  ASSERT_TRUE(mesh.set_earlier(copy));
  EXPECT_EQ(kept("f"), (std::vector<double>{5, 4, 3}));
  EXPECT_EQ(kept("g"), std::vector<double>{5});
  m.commit(INSITU_CHANGED_TOPOLOGY);
  EXPECT_EQ(kept("f"), std::vector<double>{}) << "of other cells, it was said";
}

// An earlier step of other cells is not shown, though it is still held.
TEST(Earlier, IsHiddenWhenTheVerticesAreOthers) {
  fixtures::Committed m(box(test::MeshKind::hexahedra, 3));
  m.mesh.mesh().keep_earlier({}, m.threads);
  m.arrays.points[5] += 0.25;
  m.commit(INSITU_CHANGED_GEOMETRY);
  m.mesh.mesh().expose_earlier(true, m.threads);
  ASSERT_NE(m.mesh.mesh().view().earlier_points, nullptr);
  m.arrays = fixtures::SolverArrays(box(test::MeshKind::hexahedra, 4));
  const insitu_array points = m.arrays.point_array();
  const insitu_cells cells = m.arrays.cells();
  m.mesh.mesh().set_points(0, &points, 1);
  m.mesh.mesh().set_cells(0, &cells);
  m.commit();
  EXPECT_EQ(m.mesh.mesh().view().earlier_points, nullptr) << "of 64 vertices, where there are 125";
  m.mesh.mesh().expose_earlier(true, m.threads);
  EXPECT_EQ(m.mesh.mesh().view().earlier_points, nullptr);
}
