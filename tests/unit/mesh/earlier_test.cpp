// Steps before the current one, as far as they are kept.
#include <gtest/gtest.h>
#include <memory>

#include "fixtures/committed.h"

using namespace insitu;

namespace {

test::TestMesh box(test::MeshKind kind, int size) {
  return test::make_mesh({.kind = kind, .size = size}, 21);
}

/// With how far vertices moved, which queries find when they ask.
void show_earlier(mesh::Mesh& mesh, const core::Threads& threads) {
  if (mesh.show_earlier(threads))
    mesh.find_displacement(threads);
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
  show_earlier(mesh, m.threads);
  EXPECT_EQ(mesh.view().earlier_points, nullptr) << "nothing moved";

  const std::vector<double> before = m.arrays.points;
  for (std::size_t i = 0; i < velocity.size(); ++i) {
    velocity[i] = -1;
    m.arrays.points[i] += i == 5 ? 0.375 : (i % 3 == 1 ? -0.125 : 0.0);
  }
  density.assign(density.size(), 8.0);
  m.commit(INSITU_CHANGED_GEOMETRY | INSITU_CHANGED_FIELDS);
  show_earlier(mesh, m.threads);
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
  mesh.hide_earlier();
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
  m.mesh.show_earlier(m.threads);
  ASSERT_NE(m.mesh.mesh().view().earlier_points, nullptr);
  m.arrays = fixtures::SolverArrays(box(test::MeshKind::hexahedra, 4));
  const insitu_array points = m.arrays.point_array();
  const insitu_cells cells = m.arrays.cells();
  m.mesh.mesh().set_points(0, &points, 1);
  m.mesh.mesh().set_cells(0, &cells);
  m.commit();
  EXPECT_EQ(m.mesh.mesh().view().earlier_points, nullptr) << "of 64 vertices, where there are 125";
  m.mesh.show_earlier(m.threads);
  EXPECT_EQ(m.mesh.mesh().view().earlier_points, nullptr);
}

namespace {

/// A rectilinear block of n^3 vertices, and a velocity in three sections of larger arrays.
template <class Real>
struct Sections {
  static constexpr std::int64_t n = 5, ghosts = 2, wide = n + 2 * ghosts;
  std::vector<double> axis = std::vector<double>(n), tall = std::vector<double>(n);
  std::vector<Real> values = std::vector<Real>(3 * wide * wide * wide);
  fixtures::Committed m;

  Sections() {
    for (std::int64_t i = 0; i < n; ++i)
      tall[std::size_t(i)] = axis[std::size_t(i)] = 0.1 * double(i);
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = Real(i) / 7;
    insitu_block block = insitu_block_default();
    block.kind = INSITU_BLOCK_RECTILINEAR;
    insitu_array sections[3];
    for (int a = 0; a < 3; ++a) {
      block.vertices[a] = n;
      block.coordinates[a] =
          insitu_array_of(a == 2 ? tall.data() : axis.data(), INSITU_FLOAT64, n, 1);
      sections[a] =
          insitu_array_of(&values[at(a, 0, 0, 0)],
                          sizeof(Real) == 4 ? INSITU_FLOAT32 : INSITU_FLOAT64, n * n * n, 1);
      std::int64_t stride = sizeof(Real);
      for (int d = 0; d < 3; ++d, stride *= wide) {
        sections[a].extent[d] = n;
        sections[a].stride[d] = stride;
      }
    }
    m.mesh.mesh().set_block(0, &block);
    m.mesh.mesh().set_field(0, "v", INSITU_VERTEX, sections, 3);
    m.mesh.mesh().set_field(0, "one", INSITU_VERTEX, sections, 1);
    m.commit();
  }
  static std::size_t at(int c, std::int64_t i, std::int64_t j, std::int64_t k) {
    return std::size_t(((c * wide + k + ghosts) * wide + j + ghosts) * wide + i + ghosts);
  }
  /// The copies are the values that these arrays had.
  void check(const std::vector<Real>& then) const {
    const auto v = m.mesh.mesh().earlier_field("v"), one = m.mesh.mesh().earlier_field("one");
    ASSERT_TRUE(v && one);
    for (std::int64_t id = 0; id < n * n * n; ++id)
      for (int c = 0; c < 3; ++c) {
        const double expected = then[at(c, id % n, id / n % n, id / (n * n))];
        ASSERT_EQ(v->pieces[0].load(id, c), expected);
        if (c == 0) {
          ASSERT_EQ(one->pieces[0].load(id, 0), expected);
        }
      }
  }
};

} // namespace

// Sections go row by row, and of a block's coordinates nothing is kept but the axes, until it
// moves.
TEST(Earlier, OfABlockKeepsSectionsByRowsAndTheAxesAlone) {
  const auto run = [](auto s) {
    constexpr std::int64_t n = decltype(s)::element_type::n;
    mesh::Mesh& mesh = s->m.mesh.mesh();
    mesh.keep_earlier({{"v"}, {"one"}}, s->m.threads);
    EXPECT_EQ(s->m.memory.current(INSITU_MEMORY_EARLIER), 8 * (4 * n * n * n + 3 * n));
    EXPECT_EQ(mesh.earlier_points_bytes(), 8 * 3 * n);
    const auto then = s->values;
    s->values.assign(s->values.size(), -1);
    s->m.commit(INSITU_CHANGED_FIELDS);
    s->check(then);
    show_earlier(mesh, s->m.threads);
    EXPECT_EQ(mesh.view().earlier_points, nullptr);
    const std::vector<math::Vec3d> kept = mesh.copy_earlier().points;
    ASSERT_EQ(kept.size(), std::size_t(n * n * n));
    s->tall.back() += 0.25;
    s->m.commit(INSITU_CHANGED_GEOMETRY);
    show_earlier(mesh, s->m.threads);
    ASSERT_NE(mesh.view().earlier_points, nullptr);
    EXPECT_EQ(mesh.view().largest_displacement, (0.4 + 0.25) - 0.4);
    for (std::int64_t id = 0; id < n * n * n; ++id) {
      const math::Vec3d expected{0.1 * double(id % n), 0.1 * double(id / n % n),
                                 0.1 * double(id / (n * n))};
      EXPECT_EQ(mesh.view().earlier_points[id], expected);
      EXPECT_EQ(kept[std::size_t(id)], expected);
    }
    EXPECT_EQ(mesh.take_earlier(s->m.threads).points.size(), std::size_t(n * n * n));
    EXPECT_EQ(s->m.memory.current(INSITU_MEMORY_EARLIER), 0);
  };
  run(std::make_unique<Sections<double>>());
  run(std::make_unique<Sections<float>>());
}
