// Particles on the Earth that go from a step to the next one on other cells, of other charts.
#include <array>
#include <cmath>
#include <gtest/gtest.h>

#include "earth_flow.h"
#include "remeshed.h"

namespace insitu::test {
namespace {

using advect::Advance;
using advect::Tracer;
using advect::TracerSettings;
using geo::Pole;

/// Metres per second where the normal of the ellipsoid turns as a rigid body by omega radians per
/// time.
Vec3d rotation(const Vec3d& at, const Vec3d& omega) {
  const geo::ChartPlace place = geo::place_of({}, Pole::none, at);
  const geo::Radii r = geo::radii(place.normal.z);
  const Vec3d dn = cross(omega, place.normal);
  return {(r.across + at.z) * dot(dn, place.east), (r.along + at.z) * dot(dn, place.north), 0.0};
}

/// A normal turned about an axis.
Vec3d turned(const Vec3d& n, const Vec3d& axis, double angle) {
  return std::cos(angle) * n + std::sin(angle) * cross(axis, n) +
         ((1 - std::cos(angle)) * dot(axis, n)) * axis;
}

double metres_apart(const Vec3d& normal, const Vec3d& p) {
  const Vec3d d = geo::normal_of({}, p) - normal;
  return std::sqrt(dot(d, d)) * geo::radii(1.0).across;
}

class GeodeticCrossing : public ::testing::Test {
protected:
  core::Memory memory;
  core::Threads threads;
  TracerSettings settings;
  advect::Effects effects;

  /// Particles through `steps` steps to `end`; step s has the cells mesh_of(s).
  Tracer through(const std::function<const TestMesh&(std::size_t)>& mesh_of, const Flow& flow,
                 std::span<const Vec3d> seeds, double end, int steps, bool whole = true) {
    Remeshed solver;
    solver.mesh.reference_frame = fixtures::frame_of({});
    Tracer tracer(settings, memory);
    tracer.set_effects(effects);
    tracer.seed(seeds, 0.0);
    solver.carry(tracer, mesh_of, flow, end, steps, whole);
    return tracer;
  }
};

/// Rings about the Earth between 20 degrees south and north, with vertices on every fourth of these
/// degrees: seams at other meridians, within cells and between them.
TestMesh ring(std::size_t step) {
  struct Make {
    double west;
    int across, along;
    bool wraps;
  };
  constexpr std::array<Make, 4> makes{
      {{-180, 72, 10, false}, {178.5, 60, 20, true}, {0, 90, 10, true}, {-177, 40, 20, false}}};
  const Make& m = makes[step % makes.size()];
  return fixtures::lattice({.west = m.west,
                            .south = -20,
                            .east = m.west + 360,
                            .north = 20,
                            .across = m.across,
                            .along = m.along,
                            .levels = {-4000, step % 2 ? -1000.0 : -100.0, 0},
                            .wraps = m.wraps});
}

// On a parallel on which all meshes have vertices, the velocity of a rotation is what they say, and
// one that grows evenly is what lies between two steps.
TEST_F(GeodeticCrossing, ExactAlongParallelsOverTheDateLine) {
  const auto rate = [](double t) { return (30.0 + 40.0 * t) * degree; };
  const Flow flow = [&](const Vec3d& at, double t) { return rotation(at, {0, 0, rate(t)}); };
  std::vector<TestMesh> meshes;
  for (std::size_t s = 0; s < 4; ++s)
    meshes.push_back(ring(s));
  std::vector<Vec3d> seeds;
  for (const double latitude : {-16.0, 0.0, 12.0})
    for (const double longitude : {179.999, -179.999, 0.0, 33.3})
      for (const double z : {0.0, -50.0, -3000.0})
        seeds.push_back({longitude, latitude, z});
  settings.integrator.tolerance = 1e-6; // of 3e6 metres per time
  for (const bool whole : {true, false}) {
    const Tracer t = through([&](std::size_t s) -> const TestMesh& { return meshes[s % 4]; }, flow,
                             seeds, 4.0, 8, whole);
    ASSERT_EQ(t.counts().alive(), std::int64_t(seeds.size()));
    double largest = 0.0;
    for (std::size_t i = 0; i < seeds.size(); ++i) {
      const Vec3d& x = t.positions()[i];
      EXPECT_EQ(x.z, seeds[i].z); // at depth 0 too
      EXPECT_NEAR(x.y, seeds[i].y, 1e-9);
      largest =
          std::max(largest, std::abs(std::remainder(x.x - seeds[i].x - (120.0 + 320.0), 360)));
    }
    EXPECT_EQ(largest < 1e-9, whole) << largest;
    EXPECT_EQ(largest > 1.0, !whole) << largest;
  }
}

// A rotation to and fro about a tilted axis, so that particles go over the date line, by the north
// pole and over it, on meshes with a vertex there, with a cell, and with a ring of cells; and on
// one that ends before it, which then has no cells on its chart, by turns with one that has. With
// the current velocity alone it is of order 1.
TEST_F(GeodeticCrossing, OrderTwoOverTheDateLineAndNearThePole) {
  const double end = std::numbers::pi / 3;
  const auto angle = [](double t) {
    return 0.6 * t + 0.4 * (std::cos(0.5) - std::cos(9 * t + 0.5));
  };
  const auto rate = [](double t) { return 0.6 + 3.6 * std::sin(9 * t + 0.5); };
  const std::array<TestMesh, 3> globes = {
      fixtures::globe({.subdivisions = 5, .levels = {-100, 0}}),
      fixtures::globe({.subdivisions = 5, .tilt = 0.3, .first = 0, .levels = {-100, 0}}),
      fixtures::lattice({.west = 179,
                         .south = -85,
                         .east = 539,
                         .across = 240,
                         .along = 120,
                         .levels = {-100, -30, 0},
                         .wraps = true})};
  const std::array<TestMesh, 2> with_a_ring = {
      fixtures::lattice({.south = 30, .north = 86, .across = 360, .along = 60, .levels = {-90, 0}}),
      globes[0]};
  struct Case {
    std::span<const TestMesh> meshes;
    Vec3d axis;
    std::vector<Vec3d> seeds;
  };
  const Case cases[] = {{globes,
                         {0.8, 0, 0.6},
                         {{179.999, 40, 0},
                          {-179.9, 70, -10},
                          {-90, 85, 0},
                          {-90, 65, -100},
                          {90, 88, 0},
                          {20, 89.99, -40},
                          {0, 90, 0}}},
                        {with_a_ring,
                         {std::sin(10 * degree), 0, std::cos(10 * degree)},
                         {{-170, 72, 0}, {180, 65, -20}, {100, 50, 0}}}};
  settings.integrator.tolerance = 1.0; // of 2e7 metres per time
  for (const Case& c : cases) {
    const Flow flow = [&](const Vec3d& at, double t) { return rotation(at, rate(t) * c.axis); };
    double before[2] = {};
    for (const int steps : {12, 24}) {
      double error[2] = {};
      for (const bool whole : {true, false}) {
        const Tracer t =
            through([&](std::size_t s) -> const TestMesh& { return c.meshes[s % c.meshes.size()]; },
                    flow, c.seeds, end, steps, whole);
        ASSERT_EQ(t.counts().alive(), std::int64_t(c.seeds.size()));
        for (std::size_t i = 0; i < c.seeds.size(); ++i) {
          EXPECT_EQ(t.positions()[i].z, c.seeds[i].z);
          const Vec3d want = turned(geo::normal_of({}, c.seeds[i]), c.axis, angle(end));
          error[!whole] = std::max(error[!whole], metres_apart(want, t.positions()[i]));
        }
      }
      if (steps > 12) {
        const double order = std::log2(before[0] / error[0]),
                     once = std::log2(before[1] / error[1]);
        std::printf("%d steps: order %.2f (error %.0f m); by the current velocity %.2f (%.0f m)\n",
                    steps, order, error[0], once, error[1]);
        EXPECT_NEAR(order, 2.0, 0.2);
        EXPECT_NEAR(once, 1.0, 0.2);
      }
      before[0] = error[0];
      before[1] = error[1];
    }
  }
}

// Under walls the current cells say what is inside; windage is blended like the velocity.
TEST_F(GeodeticCrossing, SlidesAlongACoastOverTheDateLine) {
  const double end = 4e4;
  const Flow flow = [&](const Vec3d&, double t) { return Vec3d{20.0 + 40.0 * t / end, 30.0, 0}; };
  std::vector<TestMesh> meshes;
  for (std::size_t s = 0; s < 4; ++s)
    meshes.push_back(ring(s));
  const std::vector<Vec3d> seeds{{179, 19.999999, 0}, {179.99, 20, -200}, {-181, 20, 0}};
  effects = boundary(advect::AtBoundary::slide);
  const Tracer t =
      through([&](std::size_t s) -> const TestMesh& { return meshes[s % 4]; }, flow, seeds, end, 6);
  ASSERT_EQ(t.counts().alive(), std::int64_t(seeds.size()));
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    const Vec3d& x = t.positions()[i];
    EXPECT_EQ(x.z, seeds[i].z);
    EXPECT_NEAR(x.y, 20, 1e-6);
    EXPECT_LE(x.y, 20);
    const double want = seeds[i].x + 40.0 * end / metres_per_degree(20, x.z).x;
    EXPECT_NEAR(std::remainder(x.x - want, 360), 0, 1e-5) << i;
  }
}

// Du/Dt and the turning of the axes as well: what is as dense as water goes with it.
TEST_F(GeodeticCrossing, InertiaFeelsTheChange) {
  const double end = 1000.0;
  const Flow flow = [&](const Vec3d& at, double t) {
    return rotation(at, {0, 0, (1.0 + t / end) * 1e-5});
  };
  std::vector<TestMesh> meshes;
  for (std::size_t s = 0; s < 4; ++s)
    meshes.push_back(ring(s));
  const std::vector<Vec3d> seeds{{179.9, 0, 0}, {-179.99, 0, -50}};
  effects.inertia.emplace();
  effects.inertia->response_time = 500.0;
  effects.inertia->fluid_share = 1.0;
  settings.integrator.tolerance = 1e-9;
  for (const bool whole : {true, false}) {
    const Tracer t = through([&](std::size_t s) -> const TestMesh& { return meshes[s % 4]; }, flow,
                             seeds, end, 4, whole);
    ASSERT_EQ(t.counts().alive(), 2);
    for (std::size_t i = 0; i < seeds.size(); ++i) {
      const double way = std::remainder(t.positions()[i].x - seeds[i].x, 360);
      EXPECT_EQ(std::abs(way * degree - 1.5e-2) < 1e-9, whole) << way * degree - 1.5e-2;
    }
  }
}

// What has inertia moves among the cells' own coordinates, whose axes the meshes may have on other
// charts: with drag that acts at once it goes with the water, over the pole too.
TEST_F(GeodeticCrossing, InertiaGoesOverThePoleOnOtherCharts) {
  const Flow flow = [](const Vec3d& at, double t) { return rotation(at, {0.3 + t, 0, 0}); };
  const std::array<TestMesh, 2> meshes = {
      fixtures::globe({.subdivisions = 4, .tilt = 0.3, .first = 0, .levels = {-100, 0}}),
      fixtures::lattice({.west = 179, .east = 539, .across = 120, .along = 60, .wraps = true})};
  const std::vector<Vec3d> seeds{{-90, 70, 0}, {-95, 84, -10}, {-60, 60, -90}};
  const auto run = [&] {
    return through([&](std::size_t s) -> const TestMesh& { return meshes[s % 2]; }, flow, seeds,
                   0.8, 5);
  };
  settings.integrator.tolerance = 1.0;
  const Tracer plain = run();
  effects.inertia.emplace();
  effects.inertia->response_time = 1e-5;
  const Tracer heavy = run();
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    const Vec3d n = geo::normal_of({}, plain.positions()[i]);
    EXPECT_GT(metres_apart(geo::normal_of({}, seeds[i]), plain.positions()[i]), 2.5e6);
    EXPECT_LT(metres_apart(n, heavy.positions()[i]), 300.0); // the drag's lag: 64 m
  }
}

// A frame that counts otherwise is another place: the step before then serves no more.
TEST_F(GeodeticCrossing, OtherUnitsAreOtherCells) {
  const Flow flow = [](const Vec3d&, double) { return Vec3d{1, 0, 0}; };
  Remeshed solver;
  solver.mesh.reference_frame = fixtures::frame_of({});
  solver.remesh(ring(0), flow, 0.0);
  solver.keep();
  TestMesh radians = ring(1);
  for (Vec3d& p : radians.vertices)
    p = fixtures::in_units({.radians = true}, p);
  solver.mesh.reference_frame = fixtures::frame_of({.radians = true});
  solver.remesh(radians, flow, 1.0);
  EXPECT_FALSE(solver.mesh.earlier_mesh());
  solver.keep();
  solver.remesh(radians, flow, 2.0);
  EXPECT_TRUE(solver.mesh.earlier_mesh());
}

} // namespace
} // namespace insitu::test
