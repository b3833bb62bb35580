// The ray methods on OptiX answer as the CPU's tree does, whatever the rays find.
#include <cuda_runtime_api.h>
#include <gtest/gtest.h>

#include "core/status.h"
#include "gpu_mesh.h"
#include "query/device/optix/locator.h"

using namespace insitu;
using accel::Method;
using math::Vec3d;

namespace {

constexpr std::int64_t one_level = std::int64_t(1) << 40;

class Optix : public testing::Test {
protected:
  void SetUp() override {
    if (const std::string why = query::why_no_optix(); !why.empty())
      GTEST_SKIP() << why;
  }
};

void expect_exact(const test::RayMesh& mesh, const query::DeviceLocator& locator,
                  const std::vector<Vec3d>& points, const std::string& what) {
  const std::vector<query::Location> exact = mesh.exact(points);
  const std::vector<std::int64_t> cells = test::cells_of(locator, points, INSITU_EXACT);
  int wrong = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (cells[i] != exact[i].cell && ++wrong < 4)
      ADD_FAILURE() << what << ", point " << i << " (" << points[i].x << ", " << points[i].y << ", "
                    << points[i].z << "): cell " << cells[i] << ", exactly " << exact[i].cell;
  EXPECT_EQ(wrong, 0) << what;
}

/// The share of points whose owner `fast` does not tell.
double wrong_share(const test::RayMesh& mesh, const query::DeviceLocator& locator,
                   const std::vector<Vec3d>& points) {
  const std::vector<query::Location> exact = mesh.exact(points);
  const std::vector<std::int64_t> cells = test::cells_of(locator, points, INSITU_FAST);
  std::int64_t wrong = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    wrong += cells[i] != exact[i].cell;
  return double(wrong) / double(points.size());
}

} // namespace

TEST_F(Optix, TellsTheExactOwnersOfEveryShape) {
  for (const test::Case& c : test::cases) {
    const test::TestMesh from = test::make_mesh(c.options, 11);
    test::RayMesh mesh(from);
    const std::vector<Vec3d> points = test::hard_points(from, 20000, 12);
    for (const Method method : test::ray_methods)
      for (const std::int64_t group : {one_level, std::int64_t(150)}) {
        const auto locator = query::make_optix_locator(method, mesh.on_cpu.memory, group);
        mesh.commit(*locator);
        EXPECT_EQ(locator->report().ray_groups > 1, locator->report().primitives > group);
        expect_exact(mesh, *locator, points,
                     std::string(c.name) + ", " + name(method) + ", groups " +
                         std::to_string(locator->report().ray_groups));
      }
  }
}

TEST_F(Optix, MostCandidatesOfTheRaysAreKept) {
  const test::TestMesh from =
      test::make_mesh({.kind = test::MeshKind::hexahedra, .size = 12, .jitter = 0.2}, 21);
  test::RayMesh mesh(from);
  test::Random random(22);
  std::vector<Vec3d> points;
  for (int i = 0; i < 50000; ++i)
    points.push_back(random.uniform(from.low, from.high));
  for (const Method method : test::ray_methods) {
    const auto locator = query::make_optix_locator(method, mesh.on_cpu.memory);
    mesh.commit(*locator);
    query::DeviceCounts counts;
    test::cells_of(*locator, points, INSITU_STANDARD, &counts);
    const bool flat = method == Method::shared_faces || method == Method::replicated_faces;
    EXPECT_GT(double(counts.candidates_kept), (flat ? 0.88 : 0.99) * 50000) << name(method);
    EXPECT_LT(counts.settled_on_host, 50) << name(method);
  }
}

TEST_F(Optix, FollowsMovedVertices) {
  for (const test::Case& c : test::cases) {
    const test::TestMesh from = test::make_mesh(c.options, 31);
    test::RayMesh mesh(from);
    for (const Method method : test::ray_methods)
      for (const std::int64_t group : {one_level, std::int64_t(150)}) {
        const auto locator = query::make_optix_locator(method, mesh.on_cpu.memory, group);
        mesh.commit(*locator);
        for (int step = 0; step < 3; ++step) {
          // A shear, then jitter, which makes planar quads curved.
          test::TestMesh moved = from;
          test::Random random(32 + std::uint64_t(step));
          for (std::size_t v = 0; v < from.vertices.size(); ++v) {
            Vec3d& x = moved.vertices[v];
            x.x += 0.3 * c.options.scale.x * (x.y - from.low.y) / c.options.scale.y;
            if (step == 1)
              for (int a = 0; a < 3; ++a)
                x[a] += random.uniform(-0.03, 0.03) * c.options.scale[a];
            for (int a = 0; a < 3; ++a)
              mesh.on_cpu.arrays.points[3 * v + std::size_t(a)] =
                  step == 2 ? from.vertices[v][a] : x[a];
          }
          moved.high.x +=
              0.3 * (moved.high.y - moved.low.y) * c.options.scale.x / c.options.scale.y;
          mesh.on_cpu.commit(INSITU_CHANGED_GEOMETRY);
          mesh.commit(*locator, INSITU_CHANGED_GEOMETRY);
          expect_exact(mesh, *locator, test::hard_points(step == 2 ? from : moved, 2000, 33),
                       std::string(c.name) + ", " + name(method) + ", step " +
                           std::to_string(step) + ", group " + std::to_string(group));
        }
      }
  }
}

TEST_F(Optix, AnswersOnTheDeviceAsOnTheHost) {
  const test::TestMesh from =
      test::make_mesh({.kind = test::MeshKind::mixed, .size = 8, .jitter = 0.2}, 41);
  test::RayMesh mesh(from);
  std::vector<double> at_vertices, at_cells;
  for (const Vec3d& x : from.vertices)
    at_vertices.insert(at_vertices.end(), {x.x + 2 * x.y + 3 * x.z, x.x * x.y});
  for (std::size_t c = 0; c < from.cells.size(); ++c)
    at_cells.push_back(double(c) + 0.5);
  const insitu_array v =
      insitu_array_of(at_vertices.data(), INSITU_FLOAT64, std::int64_t(from.vertices.size()), 2);
  const insitu_array w =
      insitu_array_of(at_cells.data(), INSITU_FLOAT64, std::int64_t(at_cells.size()), 1);
  mesh.on_cpu.mesh.mesh().set_field(0, "v", INSITU_VERTEX, &v, 1);
  mesh.on_cpu.mesh.mesh().set_field(0, "c", INSITU_CELL, &w, 1);
  mesh.on_cpu.commit(INSITU_CHANGED_FIELDS);
  const mesh::FieldView fields[] = {mesh.on_cpu.mesh.mesh().field("v"),
                                    mesh.on_cpu.mesh.mesh().field("c")};

  const std::vector<Vec3d> points = test::hard_points(from, 20000, 42);
  const std::size_t n = points.size();
  const std::vector<query::Location> exact = mesh.exact(points);
  const test::OnDevice<Vec3d> on_device(points);
  cudaStream_t stream;
  ASSERT_EQ(cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking), cudaSuccess);
  for (const Method method : test::ray_methods) {
    const auto locator = query::make_optix_locator(method, mesh.on_cpu.memory, 1000);
    mesh.commit(*locator);
    for (const insitu_accuracy accuracy : {INSITU_FAST, INSITU_STANDARD, INSITU_EXACT}) {
      SCOPED_TRACE(std::string(name(method)) + ", accuracy " + std::to_string(int(accuracy)));
      const test::OnDevice<std::int64_t> cells(n);
      const test::OnDevice<double> parametric(3 * n), values_v(2 * n), values_c(n);
      const test::OnDevice<std::uint8_t> reasons(n);
      double* const values[] = {values_v.data(), values_c.data()};
      query::DeviceQuery query;
      query.points = &on_device.data()->x;
      query.count = std::int64_t(n);
      query.on_device = true;
      query.accuracy = accuracy;
      query.stream = stream;
      query.cells = cells.data();
      query.parametric = parametric.data();
      query.reasons = reasons.data();
      query.fields = fields;
      query.values = values;
      locator->locate(query);
      ASSERT_EQ(cudaStreamSynchronize(stream), cudaSuccess);
      const auto told = cells.read();
      const auto r = parametric.read(), f = values_v.read(), g = values_c.read();
      const auto why = reasons.read();
      EXPECT_EQ(accuracy == INSITU_FAST ? told : test::cells_of(*locator, points, accuracy), told);
      std::size_t other = 0;
      for (std::size_t i = 0; i < n; ++i) {
        ASSERT_EQ(why[i] == 0, told[i] < 0) << i;
        if (told[i] != exact[i].cell) {
          ++other;
          continue;
        }
        if (told[i] < 0) {
          ASSERT_TRUE(std::isnan(f[2 * i]) && std::isnan(g[i]) && std::isnan(r[3 * i])) << i;
          continue;
        }
        const Vec3d p = points[i];
        const bool fast = accuracy == INSITU_FAST; // in float
        ASSERT_NEAR(f[2 * i], p.x + 2 * p.y + 3 * p.z, fast ? 1e-3 : 1e-9) << i;
        ASSERT_EQ(g[i], double(told[i]) + 0.5) << i;
        if (fast) // near a pyramid's apex coordinates say little
          continue;
        for (int a = 0; a < 3; ++a)
          ASSERT_NEAR(r[3 * i + std::size_t(a)], exact[i].parametric[a], 1e-6) << i;
      }
      if (accuracy != INSITU_FAST) {
        EXPECT_EQ(other, 0u);
      }
    }
  }
  EXPECT_EQ(cudaStreamDestroy(stream), cudaSuccess);
}

TEST_F(Optix, FastIsWrongAsOftenAsItsRuleIs) {
  const test::TestMesh from =
      test::make_mesh({.kind = test::MeshKind::hexahedra, .size = 24, .jitter = 0.2}, 51);
  test::RayMesh mesh(from);
  test::Random random(52);
  std::vector<Vec3d> points;
  for (int i = 0; i < 400000; ++i)
    points.push_back(random.uniform(from.low + Vec3d{1, 1, 1}, from.high - Vec3d{1, 1, 1}));
  for (const Method method : test::ray_methods) {
    const auto locator = query::make_optix_locator(method, mesh.on_cpu.memory);
    mesh.commit(*locator);
    const double wrong = wrong_share(mesh, *locator, points);
    RecordProperty(name(method), std::to_string(wrong));
    if (method == Method::shared_faces) {
      EXPECT_GT(wrong, 0.03);
      EXPECT_LT(wrong, 0.065);
    } else if (method == Method::replicated_faces) {
      EXPECT_LT(wrong, 0.065);
    } else {
      EXPECT_LT(wrong, 1e-4) << name(method);
    }
  }
}

TEST_F(Optix, SmallMeshWithGhosts) {
  const test::TestMesh from =
      test::make_mesh({.kind = test::MeshKind::hexahedra, .size = 6, .jitter = 0.2}, 61);
  test::RayMesh mesh(from);
  std::vector<std::uint8_t> ghosts(from.cells.size());
  for (std::size_t c = 0; c < ghosts.size(); c += 3)
    ghosts[c] = 1;
  const insitu_array g =
      insitu_array_of(ghosts.data(), INSITU_UINT8, std::int64_t(ghosts.size()), 1);
  mesh.on_cpu.mesh.mesh().set_ghosts(0, &g, INSITU_GHOSTS_VTK);
  mesh.on_cpu.commit(INSITU_CHANGED_TOPOLOGY);
  mesh.faces.build(mesh.view(), mesh.on_cpu.threads);
  const std::vector<Vec3d> points = test::hard_points(from, 5000, 62);
  for (const Method method : test::ray_methods) {
    const auto locator = query::make_optix_locator(method, mesh.on_cpu.memory);
    mesh.commit(*locator);
    expect_exact(mesh, *locator, points, name(method));
  }
}

TEST_F(Optix, SmallMeshOnTheDeviceIsReadInPlace) {
  const test::TestMesh from =
      test::make_mesh({.kind = test::MeshKind::hexahedra, .size = 5, .jitter = 0.3}, 71);
  test::RayMesh mesh(from);
  const test::OnDevice<double> points_there(mesh.on_cpu.arrays.points);
  const test::OnDevice<std::int32_t> ids_there(mesh.on_cpu.arrays.ids);
  insitu_array x = mesh.on_cpu.arrays.point_array();
  x.data = points_there.data();
  x.memory = INSITU_DEVICE;
  insitu_cells c = mesh.on_cpu.arrays.cells();
  c.connectivity.data = ids_there.data();
  c.connectivity.memory = INSITU_DEVICE;
  mesh::Mesh there("there", mesh.on_cpu.memory);
  there.set_points(0, &x, 1);
  there.set_cells(0, &c);
  there.update();
  const std::vector<Vec3d> points = test::hard_points(from, 3000, 72);
  for (const Method method : test::ray_methods) {
    const auto locator = query::make_optix_locator(method, mesh.on_cpu.memory);
    locator->commit(there, mesh.host(), INSITU_CHANGED_ALL, &mesh.faces, mesh.on_cpu.threads);
    EXPECT_EQ(locator->report().bytes_copied, 0);
    expect_exact(mesh, *locator, points, name(method));
  }
}

TEST_F(Optix, ProvenCandidatesAnswerAloneWhereCellsCoverOnce) {
  const test::TestMesh from =
      test::make_mesh({.kind = test::MeshKind::mixed, .size = 6, .jitter = 0.2}, 81);
  test::RayMesh mesh(from);
  mesh.on_cpu.mesh.mesh().set_covers_once(true);
  const std::vector<Vec3d> points = test::hard_points(from, 5000, 82);
  for (const Method method : test::ray_methods) {
    const auto locator = query::make_optix_locator(method, mesh.on_cpu.memory);
    mesh.commit(*locator);
    expect_exact(mesh, *locator, points, name(method));
    query::DeviceCounts counts;
    test::cells_of(*locator, points, INSITU_EXACT, &counts);
    EXPECT_GT(counts.candidates_kept, 1000) << name(method);
  }
}

TEST_F(Optix, RefusesWhatItCannotAnswer) {
  const test::TestMesh from = test::make_mesh({.size = 2}, 91);
  test::RayMesh mesh(from);
  EXPECT_THROW(query::make_optix_locator(Method::bvh, mesh.on_cpu.memory), core::Error);
  const auto locator = query::make_optix_locator(Method::shared_faces, mesh.on_cpu.memory);
  EXPECT_THROW(test::cells_of(*locator, {{1, 1, 1}}, INSITU_EXACT), core::Error);
  EXPECT_THROW(locator->commit(mesh.on_cpu.mesh.mesh(), mesh.host(), INSITU_CHANGED_ALL, nullptr,
                               mesh.on_cpu.threads),
               core::Error);
}
