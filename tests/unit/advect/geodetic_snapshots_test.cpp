// Where particles are at times between steps on meshes in longitude and latitude, under effects
// that displace them.
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>

#include "core/random.h"
#include "earth_flow.h"

namespace insitu::test {
namespace {

using advect::AtBoundary;
using advect::Effects;
using advect::Snapshots;
using advect::Tracer;

class GeodeticAtTimes : public ::testing::Test {
protected:
  /// Particles after one advance to `end`, and where they were at the times in between.
  Tracer run(Ocean& sea, const Effects& effects, const std::vector<Vec3d>& seeds, double end,
             Snapshots* snapshots) {
    Tracer tracer(sea.settings, sea.memory);
    tracer.set_effects(effects);
    tracer.seed(seeds, 0.0);
    const mesh::FieldView v = sea.flow();
    tracer.advance(sea.sampler(), v, &v, 0.0, end, sea.threads, snapshots);
    return tracer;
  }
  static std::vector<double> evenly(double end, int count) {
    std::vector<double> times;
    for (int k = 0; k <= count; ++k)
      times.push_back(end * k / count);
    return times;
  }
  static bool same_particles(const Tracer& a, const Tracer& b) {
    const auto same = [](const auto& x, const auto& y) {
      return x.size() == y.size() &&
             std::memcmp(x.data(), y.data(), x.size() * sizeof(x.data()[0])) == 0;
    };
    const advect::Particles &p = a.particles(), &q = b.particles();
    return same(p.positions, q.positions) && same(p.times, q.times) && same(p.cells, q.cells) &&
           same(p.lengths, q.lengths) && same(p.endings, q.endings);
  }
  static double metres_apart(const Vec3d& a, const Vec3d& b) {
    const Vec3d n = geo::normal_of({}, a) - geo::normal_of({}, b);
    return std::hypot(std::sqrt(dot(n, n)) * 6.4e6, a.z - b.z);
  }
};

// Along a coast at 10 degrees north all around the Earth: at each time so far east, also where the
// way goes over the date line and the mesh's seam, which may lie within a cell.
TEST_F(GeodeticAtTimes, AlongACoastOverTheDateLine) {
  const double east = 5, end = 8e5;
  const auto times = evenly(end, 40);
  for (const bool wraps : {false, true})
    for (const double west : {-180.0, -177.5, 178.0}) {
      Ocean sea(tropics(west, wraps), constant({east, 0.5, 0}));
      const std::vector<Vec3d> seeds{{170, 9.9999, -10}, {179.9999999, 9.9999, 0}};
      Snapshots at(times, sea.memory);
      const Tracer t = run(sea, boundary(AtBoundary::slide), seeds, end, &at);
      EXPECT_TRUE(same_particles(t, run(sea, boundary(AtBoundary::slide), seeds, end, nullptr)));
      for (std::size_t i = 0; i < seeds.size(); ++i)
        for (std::size_t k = 0; k < times.size(); ++k) {
          const std::size_t item = at.item(k, i);
          ASSERT_EQ(at.present[item], 1);
          const Vec3d x = at.positions[item];
          EXPECT_TRUE(bool(at.places[item])) << west << wraps << k;
          EXPECT_EQ(x.z, seeds[i].z);
          EXPECT_LE(x.y, 10);
          EXPECT_GE(x.x, west);
          EXPECT_LT(x.x, west + 360);
          // As in GeodeticWalls.CoastsGoOnOverTheDateLine.
          const double want = seeds[i].x + east * times[k] / metres_per_degree(10, x.z).x;
          EXPECT_NEAR(std::remainder(x.x - want, 360), 0, 1e-4) << west << wraps << k;
        }
    }
}

// Whatever moves them: the same ways with and without, everybody at each time, in a cell, where a
// run that ends at that time has it.
TEST_F(GeodeticAtTimes, WhereARunToThatTimeEnds) {
  const TestMesh half_cap = fixtures::lattice({.west = 0,
                                               .south = 60,
                                               .east = 180,
                                               .north = 90,
                                               .across = 36,
                                               .along = 12,
                                               .levels = {-4000, -100, 0}});
  const TestMesh turned = fixtures::globe({.subdivisions = 4, .tilt = 0.3});
  std::vector<Vec3d> seeds;
  for (std::uint64_t i = 0; i < 8; ++i)
    seeds.push_back({5 + 170 * core::random_unit(6, i, 0), 72 + 17 * core::random_unit(6, i, 1),
                     i % 3 == 0 ? 0.0 : -90.0});
  const double end = 2e5;
  const auto times = evenly(end, 5);
  for (const TestMesh* mesh : {&half_cap, &turned})
    for (int kind = 0; kind < 4; ++kind) {
      Ocean sea(*mesh, towards({-8, -2, 3}));
      sea.settings.integrator.tolerance = 1e-4;
      Effects effects = boundary(kind == 1 ? AtBoundary::stop : AtBoundary::slide);
      effects.drifts.push_back({{0, 0, 1e-4}, {}, 1.0, {}}); // onto the surface
      if (kind == 2) {
        effects = boundary(AtBoundary::reflect);
        effects.inertia.emplace();
        effects.inertia->response_time = 2e4;
        effects.inertia->begins = Vec3d{6, 3, 0};
        effects.inertia->rotation = {0, 0, 1e-5};
      }
      if (kind == 3)
        effects.diffusion = advect::Diffusion{{500.0, {}}, {1e-3, {}}, 2e4, 5};
      Snapshots at(times, sea.memory);
      const Tracer t = run(sea, effects, seeds, end, &at);
      EXPECT_TRUE(same_particles(t, run(sea, effects, seeds, end, nullptr))) << kind;
      EXPECT_EQ(t.counts().sum(), 8);
      for (std::size_t k = 1; k < times.size(); ++k) {
        const Tracer there = run(sea, effects, seeds, times[k], nullptr);
        for (std::size_t i = 0; i < seeds.size(); ++i) {
          const std::size_t item = at.item(k, i);
          const bool lives = there.particles().endings[i] == INSITU_END_ALIVE;
          ASSERT_EQ(at.present[item] == 1, lives) << kind << " " << k << " " << i;
          if (!lives)
            continue;
          EXPECT_TRUE(bool(at.places[item])) << kind << " " << k << " " << i;
          EXPECT_EQ(at.places[item].cell, sea.sampler().locate(at.positions[item]).cell);
          // Along walls and the surface they go straight for a tenth of a cell, 28 km, in which
          // the velocity changes by a tenth: an eighth of that is 350 m. Elsewhere as in time.
          EXPECT_LT(metres_apart(at.positions[item], there.positions()[i]), 400.0)
              << kind << " " << k << " " << i;
        }
      }
    }
}

TEST_F(GeodeticAtTimes, FromWhereAStepWasUndone) {
  // Towards the coast by one step, which is undone: at its place until the end.
  Ocean sea(fixtures::lattice({.west = 10,
                               .south = 80,
                               .east = 20,
                               .north = 84,
                               .across = 10,
                               .along = 4,
                               .levels = {-100, 0}}),
            constant({1.0, 0, 0}));
  const std::vector<Vec3d> seeds{{19.5, 82, -50}, {11, 81.3, 0}};
  const double end = 2e4;
  Snapshots at(evenly(end, 5), sea.memory);
  const Tracer t = run(sea, boundary(AtBoundary::put_back), seeds, end, &at);
  EXPECT_TRUE(same_particles(t, run(sea, boundary(AtBoundary::put_back), seeds, end, nullptr)));
  for (std::size_t k = 0; k <= 5; ++k) {
    EXPECT_LT(metres_apart(at.positions[at.item(k, 0)], seeds[0]), 1e-6);
    const double want = 11 + at.times[k] / metres_per_degree(81.3).x;
    EXPECT_NEAR(at.positions[at.item(k, 1)].x, want, 1e-7);
    EXPECT_EQ(at.positions[at.item(k, 1)].z, 0.0);
  }
}

// Without drag and forces along a great circle (of the sphere of normals), over the pole and from
// sheet to sheet: at even times at even distances.
TEST_F(GeodeticAtTimes, FlightsOverThePole) {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const TestMesh& mesh : {fixtures::lattice({.across = 36, .along = 18}),
                               fixtures::globe({.subdivisions = 3, .tilt = 0.3})}) {
    Ocean sea(mesh, constant({0, 0, 0}));
    Effects effects;
    effects.inertia.emplace();
    effects.inertia->response_time = infinity;
    effects.inertia->begins = Vec3d{3, 20, 0};
    const std::vector<Vec3d> seeds{{20, 70, -50}, {179, 85, -2000}};
    const double end = 2e5;
    Snapshots at(evenly(end, 80), sea.memory);
    const Tracer t = run(sea, effects, seeds, end, &at);
    EXPECT_TRUE(same_particles(t, run(sea, effects, seeds, end, nullptr)));
    for (std::size_t i = 0; i < seeds.size(); ++i) {
      const auto normal = [&](std::size_t k) {
        return geo::normal_of({}, at.positions[at.item(k, i)]);
      };
      const Vec3d plane = cross(normal(0), normal(1));
      for (std::size_t k = 0; k <= 80; ++k) {
        ASSERT_EQ(at.present[at.item(k, i)], 1);
        EXPECT_EQ(at.positions[at.item(k, i)].z, seeds[i].z);
        // The ellipsoid bends a great circle of normals a little: 1e-4 over 4000 km.
        EXPECT_NEAR(dot(normal(k), plane) / std::sqrt(dot(plane, plane)), 0.0, 2e-3);
        if (k > 0) {
          const Vec3d step = normal(k) - normal(k - 1);
          EXPECT_NEAR(std::sqrt(dot(step, step)) * 6.39e6, std::hypot(3, 20) * end / 80, 150.0);
        }
      }
    }
  }
}

} // namespace
} // namespace insitu::test
