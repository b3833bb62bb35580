// The CUDA backend with arrays, points and tracers in device memory.
#include <gtest/gtest.h>

#include "advect/device/device_tracer.h"
#include "advect/field/mesh_velocity.h"
#include "cuda_mesh.h"

using namespace insitu;
using namespace insitu::test;

TEST_F(Cuda, ArraysAndPointsInDeviceMemory) {
  const test::TestMesh from = one_shape(test::MeshKind::wedges, 6, 0.2, 91);
  GpuMesh mesh(from);
  mesh.commit();
  const std::vector<Vec3d> points = test::hard_points(from, 20000, 92);
  const fixtures::SolverArrays& arrays = mesh.on_cpu.arrays;
  const test::OnDevice<double> x(arrays.points);
  const test::OnDevice<std::int32_t> ids(arrays.ids);
  const test::OnDevice<double> vectors(mesh.vectors);
  mesh::Mesh m("device", mesh.on_cpu.memory);
  insitu_array a = arrays.point_array();
  a.data = x.data();
  a.memory = INSITU_DEVICE;
  m.set_points(0, &a, 1);
  insitu_cells cells = arrays.cells();
  cells.connectivity.data = ids.data();
  cells.connectivity.memory = INSITU_DEVICE;
  m.set_cells(0, &cells);
  a = insitu_array_of(vectors.data(), INSITU_FLOAT64, std::int64_t(from.vertices.size()), 3);
  a.memory = INSITU_DEVICE;
  m.set_field(0, "v", INSITU_VERTEX, &a, 1);
  m.update();
  const auto locator = make_locator(mesh.on_cpu.memory);
  locator->commit(m, test::view_of(m), INSITU_CHANGED_ALL, nullptr, mesh.on_cpu.threads);
  EXPECT_EQ(locator->report().bytes_copied, 0);
  const mesh::FieldView fields[] = {m.field("v")};
  const mesh::FieldView host_fields[] = {mesh.on_cpu.mesh.mesh().field("v")};
  const Answers expected = mesh.on_cpu_answers(points, INSITU_EXACT, host_fields);
  expect_same(on_gpu(*locator, points, INSITU_EXACT, fields), expected, points, "device arrays");

  // The same, asked on a stream with all in device memory.
  const device::Stream stream;
  std::vector<double> flat(&points[0].x, &points[0].x + 3 * points.size());
  const test::OnDevice<double> p(flat), parametric(flat.size()), values(flat.size());
  const test::OnDevice<std::int64_t> owners(points.size());
  const test::OnDevice<std::uint8_t> reasons(points.size());
  double* value_arrays[] = {values.data()};
  query::DeviceQuery query;
  query.points = p.data();
  query.count = std::int64_t(points.size());
  query.on_device = true;
  query.accuracy = INSITU_EXACT;
  query.stream = stream.get();
  query.cells = owners.data();
  query.parametric = parametric.data();
  query.reasons = reasons.data();
  query.fields = fields;
  query.values = value_arrays;
  Answers got(points.size(), fields);
  got.counts = locator->locate(query);
  stream.wait("answering");
  got.cells = owners.read();
  got.parametric = parametric.read();
  got.reasons = reasons.read();
  got.values = {values.read()};
  expect_same(got, expected, points, "on a stream");
}

TEST_F(Cuda, TracersMoveAsOnTheCpu) {
  for (const auto kind : {test::MeshKind::hexahedra, test::MeshKind::mixed}) {
    const test::TestMesh from = one_shape(kind, 8, 0.2, 97);
    GpuMesh mesh(from);
    for (std::size_t v = 0; v < from.vertices.size(); ++v) { // around the middle, and upwards
      const Vec3d r = from.vertices[v] - 0.5 * (from.low + from.high);
      mesh.vectors[3 * v] = -r.y;
      mesh.vectors[3 * v + 1] = r.x;
      mesh.vectors[3 * v + 2] = 0.3;
    }
    mesh.commit();
    const mesh::FieldView field = mesh.on_cpu.mesh.mesh().field("v");
    test::Random random(98);
    std::vector<Vec3d> seeds;
    for (int i = 0; i < 5000; ++i)
      seeds.push_back(random.uniform(from.low - Vec3d{0.5, 0.5, 0.5}, from.high));
    constexpr int steps = 100;
    constexpr double h = 0.05;
    std::vector<Vec3d> expected = seeds;
    std::vector<std::uint8_t> expected_endings;
    const query::Sampler sampler = mesh.on_cpu.sampler();
    for (Vec3d& x : expected) {
      advect::MeshVelocity velocity(sampler, field, nullptr, 0, 0, INSITU_STANDARD);
      velocity.begin(-1);
      Vec3d k1;
      int ending = velocity(x, 0, k1) == advect::Sampled::inside ? INSITU_END_ALIVE
                                                                 : INSITU_END_SEED_OUTSIDE;
      for (int n = 0; n < steps && ending == INSITU_END_ALIVE; ++n) {
        const advect::Trial trial = advect::trial_of<advect::Rk4>(velocity, x, 0, h, k1);
        if (trial.sampled != advect::Sampled::inside) {
          ending = INSITU_END_LEFT;
          break;
        }
        x = trial.x;
        k1 = trial.v;
      }
      expected_endings.push_back(std::uint8_t(ending));
    }
    const test::OnDevice<double> positions(
        std::vector<double>(&seeds[0].x, &seeds[0].x + 3 * seeds.size()));
    const test::OnDevice<std::uint32_t> cells(
        std::vector<std::uint32_t>(seeds.size(), accel::none));
    const test::OnDevice<std::uint8_t> endings(std::vector<std::uint8_t>(seeds.size(), 0));
    advect::DeviceParticles particles;
    particles.positions = positions.data();
    particles.cells = cells.data();
    particles.endings = endings.data();
    particles.count = std::int64_t(seeds.size());
    particles.velocity = field;
    particles.step = h;
    particles.steps = steps / 4; // in parts, as a solver's steps are
    for (int part = 0; part < 4; ++part)
      advect::DeviceTracer(*mesh.locator).advance(particles);
    const std::vector<double> got = positions.read();
    const std::vector<std::uint8_t> got_endings = endings.read();
    EXPECT_EQ(got_endings, expected_endings);
    int wrong = 0;
    for (std::size_t i = 0; i < seeds.size(); ++i)
      for (int a = 0; a < 3; ++a)
        wrong += !same_bits(got[3 * i + std::size_t(a)], expected[i][a]);
    EXPECT_EQ(wrong, 0);
    EXPECT_GT(std::count(got_endings.begin(), got_endings.end(), INSITU_END_ALIVE), 500);
    EXPECT_GT(std::count(got_endings.begin(), got_endings.end(), INSITU_END_LEFT), 500);
  }
}
