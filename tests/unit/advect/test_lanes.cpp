// Many particles at a time on one thread: the same, to the bit, as one by one.
#include <algorithm>
#include <array>
#include <cstring>
#include <deque>
#include <gtest/gtest.h>
#include <optional>
#include <random>
#include <string>

#include "advect/lanes.h"
#include "analytic.h"
#include "box_mesh.h"
#include "fixtures/committed.h"
#include "fixtures/simd_targets.h"

namespace insitu::test {
namespace {

using advect::IntegratorSettings;
using advect::LaneVelocity;
using advect::Method;

constexpr double infinity = std::numeric_limits<double>::infinity();

struct Flow {
  const mesh::FieldView& now;
  advect::EarlierSteps earlier = nullptr;
  double t0 = 0.0, t1 = 0.0;
};

struct Ends {
  std::vector<advect::State> states;
  std::vector<insitu_ending> endings;
  std::vector<std::int64_t> cells;
  advect::Work work;
};

Ends one_by_one(const query::Sampler& sampler, const Flow& flow, const IntegratorSettings& settings,
                const std::vector<Vec3d>& seeds, double to, const advect::CellsBeyond* beyond) {
  Ends ends;
  advect::MeshVelocity field(sampler, flow.now, flow.earlier, flow.t0, flow.t1, INSITU_STANDARD);
  field.walk_by(beyond);
  for (const Vec3d& seed : seeds) {
    field.begin(-1);
    const Outcome r = run(field, settings, seed, to);
    ends.states.push_back(r.p);
    ends.endings.push_back(r.ending);
    ends.cells.push_back(field.cell());
    ends.work += r.work;
  }
  return ends;
}

Ends in_lanes(const query::Sampler& sampler, const Flow& flow, const IntegratorSettings& settings,
              const std::vector<Vec3d>& seeds, double to, const advect::CellsBeyond* beyond) {
  Ends ends;
  ends.states.resize(seeds.size());
  ends.endings.resize(seeds.size());
  ends.cells.resize(seeds.size());
  advect::run_lanes(
      sampler, 0, std::int64_t(seeds.size()),
      [&](std::deque<LaneVelocity>& lanes) {
        lanes.emplace_back(sampler, flow.now, flow.earlier, flow.t0, flow.t1, INSITU_STANDARD)
            .walk_by(beyond);
      },
      [&](std::int64_t i, std::size_t, LaneVelocity& field) {
        field.begin(-1);
        advect::State& p = ends.states[std::size_t(i)];
        p.x = seeds[std::size_t(i)];
        return advect::integration(field, settings, to, infinity, p, ends.work,
                                   [](const advect::State&) {});
      },
      [&](std::int64_t i, std::size_t, LaneVelocity& field, insitu_ending ending) {
        ends.endings[std::size_t(i)] = ending;
        ends.cells[std::size_t(i)] = field.cell();
      });
  return ends;
}

bool same_bits(double a, double b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

std::size_t different(const Ends& a, const Ends& b) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.states.size(); ++i) {
    const advect::State &p = a.states[i], &q = b.states[i];
    const bool same = same_bits(p.x.x, q.x.x) && same_bits(p.x.y, q.x.y) &&
                      same_bits(p.x.z, q.x.z) && same_bits(p.time, q.time) &&
                      same_bits(p.length, q.length) && a.endings[i] == b.endings[i] &&
                      a.cells[i] == b.cells[i];
    count += !same;
  }
  return count;
}

/// By every method, plain and face-aware; with cells guessed by their numbers and without.
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

Vec3d swirl(const Vec3d& p) {
  return {-p.y + 0.3 * std::sin(5 * p.z), p.x - 0.2 * p.z, 0.4 * std::cos(4 * p.x) - 0.1};
}

/// More than there are lanes, some outside, some that leave.
std::vector<Vec3d> seeds() {
  std::vector<Vec3d> points = random_points(31, 3 * advect::LaneBatch::lane_count + 5, -1.1, 1.1);
  points.push_back({0, 0, 0});
  points.push_back({1, 1, 1});
  points.push_back({-1, 0.25, 0.5});
  return points;
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

/// A mesh with the velocity swirl().
struct Swirling {
  fixtures::Committed m;
  std::vector<double> v;

  explicit Swirling(const TestMesh& mesh, const std::vector<std::uint8_t>& ghosts = {}) : m(mesh) {
    for (const Vec3d& p : mesh.vertices)
      for (int a = 0; a < 3; ++a)
        v.push_back(swirl(p)[a]);
    const insitu_array array =
        insitu_array_of(v.data(), INSITU_FLOAT64, std::int64_t(mesh.vertices.size()), 3);
    m.mesh.mesh().set_field(0, "velocity", INSITU_VERTEX, &array, 1);
    if (!ghosts.empty()) {
      const insitu_array g =
          insitu_array_of(ghosts.data(), INSITU_UINT8, std::int64_t(ghosts.size()), 1);
      m.mesh.mesh().set_ghosts(0, &g, INSITU_GHOSTS_VTK);
    }
    m.commit();
    m.mesh.look_for_folds(m.threads);
  }
  query::Sampler sampler() const { return m.sampler(); }
  mesh::FieldView field() { return m.mesh.mesh().field("velocity"); }
};

/// Of blocks along each axis, about the box of seeds().
TestMesh mesh_of(MeshKind kind, int size) {
  Random random(5);
  TestMesh mesh = make_mesh({.kind = kind, .size = size, .jitter = 0.15}, random);
  for (Vec3d& p : mesh.vertices)
    p = (2.0 / size) * p - Vec3d{1, 1, 1};
  return mesh;
}

TEST(Lanes, SameBitsOnEveryShape) {
  for (const MeshKind kind : {MeshKind::hexahedra, MeshKind::voxels, MeshKind::wedges,
                              MeshKind::pyramids, MeshKind::tetrahedra, MeshKind::mixed}) {
    Swirling mesh(mesh_of(kind, 5));
    const mesh::FieldView field = mesh.field();
    expect_the_same(mesh.sampler(), {field}, seeds(), 1.0, "shape " + std::to_string(int(kind)));
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

/// The cell that holds a point beyond the middle of each side, as the sampler says.
TEST(CellsBeyond, StepsOfRowsAreLearnt) {
  constexpr std::int64_t n = 7;
  BoxMesh box(n, -1.0, 1.0);
  const advect::CellsBeyond beyond(box.sampler());
  ASSERT_TRUE(beyond.knows());
  const mesh::Shape hexahedron = mesh::Shape::hexahedron;
  const std::int64_t cell = 3 + n * (3 + n * 3), steps[3] = {1, n, n * n};
  for (int a = 0; a < 3; ++a)
    for (const double sign : {-1.0, 1.0}) {
      Vec3d r{0.5, 0.5, 0.5};
      r[a] += 0.6 * sign;
      EXPECT_EQ(beyond.guess(cell, hexahedron, r), cell + std::int64_t(sign) * steps[a]);
      r[(a + 1) % 3] = -0.1; // across an edge
      EXPECT_EQ(beyond.guess(cell, hexahedron, r),
                cell + std::int64_t(sign) * steps[a] - steps[(a + 1) % 3]);
    }
  EXPECT_EQ(beyond.guess(cell, hexahedron, {0.5, 0.5, 0.5}), -1) << "inside";
  EXPECT_EQ(beyond.guess(cell, hexahedron, {0.5, 0.5, 1.0 - 1e-9}, 1e-6), cell + n * n)
      << "on a face";
  EXPECT_EQ(beyond.guess(cell, mesh::Shape::tetrahedron, {-0.5, 0.5, 0.5}), -1) << "no steps";
}

/// Cells that are numbered at random have no steps, and nothing is guessed.
TEST(CellsBeyond, ShuffledNumbersTellNothing) {
  Random random(8);
  TestMesh mesh = make_mesh({.kind = MeshKind::hexahedra, .size = 8, .jitter = 0.1}, random);
  const auto knows = [](const TestMesh& m) {
    fixtures::Committed committed(m);
    committed.mesh.look_for_folds(committed.threads);
    return advect::CellsBeyond(committed.sampler()).knows();
  };
  EXPECT_TRUE(knows(mesh));
  std::shuffle(mesh.cells.begin(), mesh.cells.end(), std::mt19937(3));
  EXPECT_FALSE(knows(mesh));
}

} // namespace
} // namespace insitu::test
