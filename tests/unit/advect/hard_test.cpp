// The hard cases of tracers, each with its truth and with every particle accounted for.
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>

#include "advect/field/mesh_velocity.h"
#include "advect/lines/streamlines.h"
#include "advect/pathlines.h"
#include "analytic.h"
#include "box_mesh.h"
#include "fixtures/committed.h"

namespace insitu::test {
namespace {

using advect::IntegratorSettings;
using advect::Method;

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Every method, plain and face-aware.
template <class F>
void for_all_methods(F f) {
  for (const Method method : {Method::euler, Method::rk4, Method::bs32, Method::dopri5})
    for (const bool aware : {false, true}) {
      IntegratorSettings settings;
      settings.method = method;
      settings.face_aware = aware;
      f(settings);
    }
}

Outcome trace(const query::Sampler& sampler, const mesh::FieldView& v,
              const IntegratorSettings& settings, const Vec3d& seed, double to) {
  advect::MeshVelocity field(sampler, v, nullptr, 0, 0, INSITU_STANDARD);
  field.begin(-1);
  const Outcome r = run(field, settings, seed, to);
  if (r.ending == INSITU_END_ALIVE || r.ending == INSITU_END_LEFT) {
    EXPECT_TRUE(sampler.locate(r.p.x)) << r.p.x.x << " " << r.p.x.y << " " << r.p.x.z;
  }
  return r;
}

TEST(Hard, SeedsOnVerticesEdgesFacesAndTheBoundary) {
  BoxMesh box(3, 0.0, 1.0, 0.0);
  const query::Sampler sampler = box.sampler();
  auto values = box.vertex_field();
  for (const Vec3d& v : {Vec3d{1, 0, 0}, Vec3d{-1, 1, 0}, Vec3d{0.5, 0.25, -1}}) {
    box.fill(values, [&](const Vec3d&) { return v; });
    for_all_methods([&](const IntegratorSettings& settings) {
      // Halves of the cells' sixths: all vertices, middles of edges and of faces, centres.
      for (int n = 0; n < 7 * 7 * 7; ++n) {
        const auto place = [](int i) { return i % 2 ? i / 6.0 : (i / 2) / 3.0; };
        const Vec3d seed{place(n % 7), place(n / 7 % 7), place(n / 49)};
        const double to = 0.21;
        const Vec3d end = seed + to * v;
        const Outcome r = trace(sampler, values.view, settings, seed, to);
        if (in_cube(end, 0.0, 1.0)) {
          ASSERT_EQ(r.ending, INSITU_END_ALIVE) << n << ", method " << int(settings.method);
          EXPECT_LT(distance(r.p.x, end), 1e-14);
        } else {
          ASSERT_EQ(r.ending, INSITU_END_LEFT) << n << ", method " << int(settings.method);
          EXPECT_LT(distance(r.p.x, seed + r.p.time * v), 1e-14);
          // On the side, or by a rounding off it where sides meet.
          EXPECT_LT(
              std::min({r.p.x.x, r.p.x.y, r.p.x.z, 1.0 - r.p.x.x, 1.0 - r.p.x.y, 1.0 - r.p.x.z}),
              1e-15);
        }
      }
    });
  }
}

TEST(Hard, VortexCentreSaddleAndZeroVelocity) {
  BoxMesh box(4, -1.0, 1.0, 0.0);
  const query::Sampler sampler = box.sampler();
  auto values = box.vertex_field();
  for_all_methods([&](IntegratorSettings settings) {
    box.fill(values, [](const Vec3d& p) { return rotation(p, 0); });
    Outcome r = trace(sampler, values.view, settings, {0, 0, 0.25}, 10.0);
    EXPECT_EQ(r.ending, INSITU_END_ALIVE);
    EXPECT_EQ(distance(r.p.x, {0, 0, 0.25}), 0.0);
    settings.ends_at_rest = true;
    EXPECT_EQ(trace(sampler, values.view, settings, {0, 0, 0.25}, infinity).ending,
              INSITU_END_STAGNATED);
    // A saddle on a vertex: in along y, out along x.
    box.fill(values, [](const Vec3d& p) { return Vec3d{p.x, -p.y, 0}; });
    r = trace(sampler, values.view, settings, {0, 0.7, 0.1}, infinity);
    EXPECT_EQ(r.ending, INSITU_END_STAGNATED);
    EXPECT_LT(distance(r.p.x, {0, 0, 0.1}), 1e-6);
    r = trace(sampler, values.view, settings, {1e-3, 0.7, 0.1}, infinity);
    EXPECT_EQ(r.ending, INSITU_END_LEFT);
    EXPECT_EQ(r.p.x.x, 1.0);
    if (settings.method != Method::euler) {
      // x y is constant. 2e-9 is seen at the tolerance of 1e-6, and 4e-5 of rk4, whose steps are
      // a quarter of a cell whatever their error.
      EXPECT_NEAR(r.p.x.y, 0.7e-3, settings.method == Method::rk4 ? 5e-5 : 2e-8);
    }
    r = trace(sampler, values.view, settings, {1e-3, 0.7, 0.1}, -infinity);
    EXPECT_EQ(r.ending, INSITU_END_LEFT);
    EXPECT_EQ(r.p.x.y, 1.0);
    box.fill(values, [](const Vec3d&) { return Vec3d{}; });
    EXPECT_EQ(trace(sampler, values.view, settings, {0.25, 0.5, 0.5}, 1.0).ending,
              INSITU_END_STAGNATED);
  });
}

TEST(Hard, CellsAHundredThousandTimesAsWideAsThick) {
  BoxMesh box(5, -1.0, 1.0, 0.2);
  box.move([](const Vec3d& p) { return Vec3d{1e5 * p.x, 1e5 * p.y, p.z}; });
  const query::Sampler sampler = box.sampler();
  auto values = box.vertex_field();
  // A turn that rises by a thickness; linear, so that interpolation is exact but for rounding.
  box.fill(values, [](const Vec3d& p) { return Vec3d{-p.y, p.x, 0.1}; });
  for_all_methods([&](IntegratorSettings settings) {
    settings.tolerance = 1e-3; // metres a unit of time
    const double to = 2.0;
    const Vec3d seed{4e4, 1e4, -0.5};
    const Outcome r = trace(sampler, values.view, settings, seed, to);
    ASSERT_EQ(r.ending, INSITU_END_ALIVE);
    EXPECT_NEAR(r.p.x.z, -0.3, 1e-11);
    if (settings.method != Method::euler) {
      const Vec3d truth{std::cos(to) * seed.x - std::sin(to) * seed.y,
                        std::sin(to) * seed.x + std::cos(to) * seed.y, -0.3};
      // Of 4e4 m; rk4, with steps of a quarter of a cell whatever their error: 9 m are seen.
      EXPECT_LT(distance(r.p.x, truth), settings.method == Method::rk4 ? 12 : 0.01);
    }
    const Outcome out = trace(sampler, values.view, settings, {4e4, 1e4, 0.95}, 100.0);
    EXPECT_EQ(out.ending, INSITU_END_LEFT);
    EXPECT_EQ(out.p.x.z, 1.0);
    EXPECT_NEAR(out.p.time, 0.5, 1e-9);
    EXPECT_NEAR(out.p.exit_normal.z, 1.0, 1e-12);
  });
}

TEST(Hard, AHoleInTheMesh) {
  // 6 x 6 x 6 cells without the middle 2 x 2 x 2; a flow along x.
  TestMesh mesh = make_mesh({.kind = MeshKind::hexahedra, .size = 6, .jitter = 0.0}, 5);
  std::erase_if(mesh.cells, [&](const MeshCell& c) {
    const Vec3d p = mesh.vertices[std::size_t(c.vertices[0])];
    return p.x >= 2 && p.x < 4 && p.y >= 2 && p.y < 4 && p.z >= 2 && p.z < 4;
  });
  fixtures::Committed m(mesh);
  std::vector<double> flow;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    flow.insert(flow.end(), {1.0, 0.0, 0.0});
  const insitu_array a =
      insitu_array_of(flow.data(), INSITU_FLOAT64, std::int64_t(mesh.vertices.size()), 3);
  m.mesh.mesh().set_field(0, "v", INSITU_VERTEX, &a, 1);
  m.commit();
  const query::Sampler sampler = m.sampler();
  for_all_methods([&](const IntegratorSettings& settings) {
    for (const Vec3d& p : random_points(21, 60, 0.0, 6.0)) {
      const Vec3d seed{0.25 * p.x, p.y, p.z};
      const bool hits = p.y >= 2 && p.y <= 4 && p.z >= 2 && p.z <= 4;
      const Outcome r = trace(sampler, m.mesh.mesh().field("v"), settings, seed, infinity);
      EXPECT_EQ(r.ending, INSITU_END_LEFT);
      EXPECT_EQ(r.p.x.x, hits ? 2.0 : 6.0);
      EXPECT_NEAR(r.p.time, (hits ? 2.0 : 6.0) - seed.x, 1e-13);
      EXPECT_NEAR(r.p.exit_normal.x, 1.0, 1e-15);
    }
  });
}

TEST(Hard, CoordinatesOfTheEarthsRadiusInFloatAndDouble) {
  // Cells of a kilometre, not on whole metres. In float32 vertices are rounded to half metres, and
  // the mesh is that one: the sides lie there, and positions, in double, are as exact as in
  // float64.
  for (const bool is_float : {false, true}) {
    const double scale = 1000.3;
    fixtures::Committed m;
    m.arrays = fixtures::SolverArrays(make_mesh({.kind = MeshKind::hexahedra,
                                                 .size = 4,
                                                 .jitter = 0.1,
                                                 .offset = 6.4e6,
                                                 .scale = {scale, scale, scale}},
                                                5));
    const std::int64_t n = m.arrays.vertex_count();
    std::vector<float> points(m.arrays.points.begin(), m.arrays.points.end());
    const insitu_array p =
        is_float ? insitu_array_of(points.data(), INSITU_FLOAT32, n, 3) : m.arrays.point_array();
    const insitu_cells c = m.arrays.cells();
    std::vector<double> flow;
    for (std::int64_t v = 0; v < n; ++v)
      flow.insert(flow.end(), {10.0, 2.5, -1.25});
    const insitu_array f = insitu_array_of(flow.data(), INSITU_FLOAT64, n, 3);
    m.mesh.mesh().set_points(0, &p, 1);
    m.mesh.mesh().set_cells(0, &c);
    m.mesh.mesh().set_field(0, "v", INSITU_VERTEX, &f, 1);
    m.commit();
    const double side = is_float ? double(float(6.4e6 + 4 * scale)) : 6.4e6 + 4 * scale;
    EXPECT_LE(std::abs(side - (6.4e6 + 4 * scale)), 0.25);
    const query::Sampler sampler = m.sampler();
    for_all_methods([&](const IntegratorSettings& settings) {
      const Vec3d seed{6.4e6 + 1234.5, 6.4e6 + 987.25, 6.4e6 + 3000};
      const Outcome r = trace(sampler, m.mesh.mesh().field("v"), settings, seed, infinity);
      EXPECT_EQ(r.ending, INSITU_END_LEFT);
      EXPECT_EQ(r.p.x.x, side);
      // A rounding of 6.4e6 is 1e-9; some hundred steps at most.
      EXPECT_NEAR(r.p.x.y, seed.y + 0.25 * (side - seed.x), 1e-7);
      EXPECT_NEAR(r.p.time, (side - seed.x) / 10.0, 1e-8);
    });
  }
}

TEST(Hard, ManyDriftersNoneLost) {
  BoxMesh box(8, 0.0, 1.0, 0.2);
  auto values = box.vertex_field();
  const Vec3d v{0.2, -0.1, 0.05};
  box.fill(values, [&](const Vec3d&) { return v; });
  core::Memory memory;
  advect::TracerSettings settings;
  settings.integrator.method = Method::rk4;
  settings.integrator.step = 0.25;
  advect::Tracer tracer(settings, memory);
  const auto seeds = random_points(31, 200'000, -0.1, 1.1);
  tracer.seed(seeds, 0.0);
  std::int64_t alive = 0, left = 0, outside = 0;
  for (const Vec3d& s : seeds) {
    const bool in = in_cube(s, 0.0, 1.0);
    (!in ? outside : in_cube(s + 0.5 * v, 0.0, 1.0) ? alive : left) += 1;
  }
  for (const double t : {0.25, 0.5}) {
    const advect::Advance step =
        tracer.advance(box.sampler(), values.view, nullptr, t - 0.25, t, core::Threads(0));
    EXPECT_EQ(step.counts.sum(), step.counts.seeded);
  }
  const advect::Counts counts = tracer.counts();
  EXPECT_EQ(counts.seeded, 200'000);
  EXPECT_EQ(counts.alive(), alive);
  EXPECT_EQ(counts.by_ending[INSITU_END_LEFT], left);
  EXPECT_EQ(counts.by_ending[INSITU_END_SEED_OUTSIDE], outside);
}

TEST(Hard, TheSameForAnyNumberOfThreads) {
  BoxMesh box(6, -1.0, 1.0, 0.25);
  auto values = box.vertex_field();
  box.fill(values, [](const Vec3d& p) {
    return Vec3d{-p.y + 0.3 * p.z * p.x, p.x, 0.5 * std::sin(5 * p.x)};
  });
  const auto seeds = random_points(41, 100, -1.0, 1.0);
  for_all_methods([&](const IntegratorSettings& integrator) {
    std::vector<Vec3d> first;
    for (const int threads : {1, 3}) {
      core::Memory memory;
      advect::TracerSettings settings;
      settings.integrator = integrator;
      advect::Tracer tracer(settings, memory);
      tracer.seed(seeds, 0.0);
      tracer.advance(box.sampler(), values.view, nullptr, 0.0, 1.0, core::Threads(threads));
      const std::vector<Vec3d> ends(tracer.positions().begin(), tracer.positions().end());
      if (threads == 1)
        first = ends;
      EXPECT_EQ(std::memcmp(ends.data(), first.data(), ends.size() * sizeof(Vec3d)), 0);
    }
  });
}

} // namespace
} // namespace insitu::test
