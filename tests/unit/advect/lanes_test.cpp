// Many particles at a time on one thread: the same, to the bit, as one by one.
#include <algorithm>
#include <array>
#include <gtest/gtest.h>
#include <random>
#include <string>

#include "box_mesh.h"
#include "fixtures/simd_targets.h"
#include "lane_runs.h"

namespace insitu::test {
namespace {

/// By every method, plain and face-aware; with cells guessed, by numbers or neighbours, and
/// without.
void expect_the_same(const query::Sampler& sampler, const Flow& flow,
                     const std::vector<Vec3d>& seeds, double to, const std::string& what) {
  const advect::CellsBeyond beyond(sampler);
  for (const Method method : {Method::euler, Method::rk4, Method::bs32, Method::dopri5})
    for (const bool aware : {false, true}) {
      IntegratorSettings settings;
      settings.method = method;
      settings.face_aware = aware;
      const std::string how =
          what + ", method " + std::to_string(int(method)) + (aware ? ", by faces" : "");
      const Ends a = one_by_one(sampler, flow, settings, seeds, to, nullptr);
      EXPECT_EQ(different(a, one_by_one(sampler, flow, settings, seeds, to, &beyond)), 0U)
          << how << ", guessed";
      for (const advect::CellsBeyond* cells :
           {static_cast<const advect::CellsBeyond*>(nullptr), &beyond}) {
        const Ends b = in_lanes(sampler, flow, settings, seeds, to, cells);
        EXPECT_EQ(different(a, b), 0U) << how << (cells ? ", lanes, guessed" : ", lanes");
        EXPECT_EQ(a.work.steps, b.work.steps);
        EXPECT_EQ(a.work.evaluations, b.work.evaluations);
        EXPECT_EQ(a.work.rejected, b.work.rejected);
      }
    }
}

TEST(Lanes, SameBitsOnHexahedra) {
  BoxMesh box(7, -1.0, 1.0);
  auto values = box.vertex_field();
  box.fill(values, swirl);
  expect_the_same(box.sampler(), {values.view}, seeds(), 1.5, "vertex field");
  auto by_cell = box.cell_field();
  const auto place = [](std::size_t i) { return -1.0 + (double(i % 7) + 0.5) * 2.0 / 7; };
  for (std::size_t c = 0; c < box.cell_count(); ++c)
    by_cell.set(c, swirl({place(c), place(c / 7), place(c / 49)}));
  expect_the_same(box.sampler(), {by_cell.view}, seeds(), 0.4, "cell field");
}

TEST(Lanes, SameBitsBetweenStepsOfAMovingMesh) {
  BoxMesh box(6, -1.0, 1.0);
  auto before = box.vertex_field(), now = box.vertex_field();
  box.fill(before, swirl);
  box.fill(now, [](const Vec3d& p) { return 1.2 * swirl(p); });
  expect_the_same(box.sampler(), {now.view, &before.view, 0.0, 0.5}, seeds(), 0.5, "at rest");
  auto long_before = box.vertex_field(), first = box.vertex_field();
  box.fill(long_before, [](const Vec3d& p) { return 0.9 * swirl(p); });
  box.fill(first, [](const Vec3d& p) { return 0.7 * swirl(p); });
  const std::vector<mesh::FieldView> steps{before.view, long_before.view, first.view};
  const std::vector<double> times{-0.4, -1.0};
  expect_the_same(box.sampler(), {now.view, {steps, times}, 0.0, 0.5}, seeds(), 0.5, "four steps");
  box.move([](const Vec3d& p) { return Vec3d{p.x * 1.05, p.y, p.z + 0.04 * std::sin(3 * p.x)}; });
  box.fill(now, [](const Vec3d& p) { return 1.3 * swirl(p); });
  expect_the_same(box.sampler(), {now.view, &before.view, 0.0, 0.5}, seeds(), 0.5, "moving");
}

TEST(Lanes, SameBitsOnEveryShape) {
  for (const MeshKind kind : all_kinds) {
    Swirling mesh(mesh_of(kind, 5));
    ASSERT_TRUE(mesh.sampler().mesh().free_of_folds);
    const mesh::FieldView field = mesh.field();
    expect_the_same(mesh.sampler(), {field}, seeds(), 1.0, "shape " + std::to_string(int(kind)));
  }
  Swirling mirrored(mesh_of(MeshKind::tetrahedra, 5, true));
  ASSERT_FALSE(mirrored.sampler().mesh().free_of_folds);
  const mesh::FieldView field = mirrored.field();
  expect_the_same(mirrored.sampler(), {field}, seeds(), 1.0, "mirrored by halves");
}

TEST(Lanes, SameBitsByNeighboursOnEveryShape) {
  for (const MeshKind kind : all_kinds) {
    TestMesh from = mesh_of(kind, 5);
    std::shuffle(from.cells.begin(), from.cells.end(), std::mt19937(6));
    Swirling mesh(from);
    mesh.m.mesh.find_neighbours(mesh.m.threads);
    ASSERT_NE(mesh.sampler().neighbours(), nullptr);
    ASSERT_TRUE(mesh.sampler().mesh().free_of_folds);
    const mesh::FieldView field = mesh.field();
    expect_the_same(mesh.sampler(), {field}, seeds(), 1.0,
                    "neighbours, shape " + std::to_string(int(kind)));
  }
}

/// Numbers that tell most neighbours, but not all: behind a hole, and among cells that are
/// shuffled; and ghosts, which are neighbours and own no points.
TEST(Lanes, SameBitsWhereGuessesAreWrong) {
  constexpr int n = 8;
  TestMesh mesh = mesh_of(MeshKind::hexahedra, n);
  mesh.cells.erase(mesh.cells.begin() + 250, mesh.cells.begin() + 253);
  std::shuffle(mesh.cells.begin() + 300, mesh.cells.begin() + 330, std::mt19937(4));
  std::vector<std::uint8_t> ghosts(mesh.cells.size(), 0);
  for (std::size_t c = 90; c < 130; ++c)
    ghosts[c] = 1;
  Swirling with_holes(mesh, ghosts);
  ASSERT_TRUE(advect::CellsBeyond(with_holes.sampler()).knows());
  const mesh::FieldView field = with_holes.field();
  expect_the_same(with_holes.sampler(), {field}, seeds(), 1.0, "holes");
  with_holes.m.mesh.find_neighbours(with_holes.m.threads);
  expect_the_same(with_holes.sampler(), {field}, seeds(), 1.0, "holes, by neighbours");
}

/// Where cells overlap, what is guessed does not depend on other particles.
TEST(Lanes, OtherParticlesDoNotMatterWhereCellsOverlap) {
  TestMesh mesh = mesh_of(MeshKind::hexahedra, 6);
  TestMesh other = mesh_of(MeshKind::hexahedra, 6);
  for (Vec3d& p : other.vertices)
    p += Vec3d{0.1, 0.13, 0.07};
  const int first = int(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (MeshCell cell : other.cells) {
    for (int v = 0; v < 8; ++v)
      cell.vertices[std::size_t(v)] += first;
    mesh.cells.push_back(cell);
  }
  Swirling twofold(mesh);
  const mesh::FieldView field = twofold.field();
  const advect::CellsBeyond beyond(twofold.sampler());
  ASSERT_TRUE(beyond.knows());
  const std::vector<Vec3d> forwards = seeds(), backwards(forwards.rbegin(), forwards.rend());
  const IntegratorSettings settings;
  const Ends a = in_lanes(twofold.sampler(), {field}, settings, forwards, 1.0, &beyond);
  Ends b = in_lanes(twofold.sampler(), {field}, settings, backwards, 1.0, &beyond);
  std::reverse(b.states.begin(), b.states.end());
  std::reverse(b.endings.begin(), b.endings.end());
  std::reverse(b.cells.begin(), b.cells.end());
  EXPECT_EQ(different(a, b), 0U);
}

/// Any number of points and cells, through one step and three, on every SIMD target.
TEST(LaneKernels, SameBitsAsScalarsOnEveryTarget) {
  constexpr int most = 37, steps = 3;
  Random random(11);
  for (const MeshKind kind : {MeshKind::hexahedra, MeshKind::voxels, MeshKind::wedges,
                              MeshKind::pyramids, MeshKind::tetrahedra}) {
    const TestMesh mesh = make_mesh({.kind = kind, .size = 4, .jitter = 0.2}, random);
    const mesh::Shape shape = mesh.cells.front().shape;
    const int vertices = mesh::vertex_count(shape);
    std::vector<Vertices> cells(most);
    std::vector<std::array<std::array<Vec3d, 8>, steps>> velocity(most);
    std::vector<advect::LaneQuery> queries(most);
    for (std::size_t i = 0; i < most; ++i) {
      cells[i] = mesh.cell_vertices(mesh.cells[std::size_t(random.below(int(mesh.cells.size())))]);
      for (auto& step : velocity[i])
        for (Vec3d& u : step)
          u = random.uniform({-1, -1, -1}, {1, 1, 1});
      Vec3d x = cells[i][0];
      for (int v = 1; v < vertices; ++v)
        x += random.uniform(0.0, 1.8 / vertices) * (cells[i][std::size_t(v)] - cells[i][0]);
      queries[i] = {
          x, cells[i].data(), reinterpret_cast<const Vec3d(*)[8]>(velocity[i].data()), {}};
      for (int s = 0; s < steps; ++s)
        queries[i].weights[s] = random.uniform(-1.0, 1.0);
    }
    for (const std::int64_t target : fixtures::simd_targets()) {
      fixtures::use_simd_target(target);
      std::size_t wrong = 0;
      for (const int n : {1, 3, 4, 5, 8, 9, 16, 17, most})
        for (const int through : {1, steps}) {
          std::vector<advect::LaneAnswer> answers(most);
          advect::invert_lanes(shape, queries.data(), n, through, answers.data());
          for (std::size_t i = 0; i < std::size_t(n); ++i) {
            const auto map = cells::inverse_map(shape, cells[i].data(), queries[i].point);
            double weight[8];
            cells::shape_functions(shape, map.r, weight);
            Vec3d u;
            for (int s = 0; s < through; ++s) {
              Vec3d at_step = weight[0] * velocity[i][std::size_t(s)][0];
              for (int v = 1; v < vertices; ++v)
                at_step += weight[v] * velocity[i][std::size_t(s)][std::size_t(v)];
              const Vec3d part = through == 1 ? at_step : queries[i].weights[s] * at_step;
              u = s == 0 ? part : u + part;
            }
            const advect::LaneAnswer& a = answers[i];
            wrong += !(same_bits(a.r.x, map.r.x) && same_bits(a.r.y, map.r.y) &&
                       same_bits(a.r.z, map.r.z) && same_bits(a.margin, map.margin) &&
                       same_bits(a.error, map.error) && a.converged == map.converged &&
                       same_bits(a.velocity.x, u.x) && same_bits(a.velocity.y, u.y) &&
                       same_bits(a.velocity.z, u.z));
          }
        }
      EXPECT_EQ(wrong, 0U) << mesh::shape_name(shape) << " on " << hwy::TargetName(target);
    }
    fixtures::use_simd_target(0);
  }
}

/// A particle's last cell is tried first, and tells nothing new.
TEST(Lanes, SameBitsWithTheLastCell) {
  Swirling mesh(mesh_of(MeshKind::tetrahedra, 5));
  const mesh::FieldView field = mesh.field();
  const query::Sampler sampler = mesh.sampler();
  const std::int64_t cells = sampler.mesh().cell_count();
  std::int64_t asked = 0;
  for (const Vec3d& x : seeds()) {
    const query::Location at = sampler.locate(x);
    Vec3d v, w;
    query::Location there;
    advect::MeshVelocity plain(sampler, field, nullptr, 0.0, 0.0, INSITU_STANDARD);
    plain.begin(-1);
    const advect::Sampled found = plain(x, 0.0, v);
    for (const std::int64_t hint : {at.cell, (at.cell + 1) % cells, cells + 3}) {
      advect::MeshVelocity hinted(sampler, field, nullptr, 0.0, 0.0, INSITU_STANDARD);
      hinted.begin(hint);
      ASSERT_EQ(hinted.sample(x, 0.0, w, there), found);
      ASSERT_EQ(there.cell, at.cell);
      ASSERT_TRUE(found != advect::Sampled::inside ||
                  (same_bits(v.x, w.x) && same_bits(v.y, w.y) && same_bits(v.z, w.z)));
      ++asked;
    }
  }
  EXPECT_GT(asked, 500);
}

} // namespace
} // namespace insitu::test
