// Particles that go with the material of meshes in longitude and latitude that move: over the seam
// and about the poles, where cells are copies on other charts.
#include <cmath>
#include <gtest/gtest.h>

#include "advect/lines/snapshots.h"
#include "analytic.h"
#include "earth_flow.h"

namespace insitu::test {
namespace {

/// The same place but for turns, and a pole's longitude, which says nothing.
void expect_place(const geo::ChartUnits& units, const Vec3d& found, const Vec3d& want) {
  EXPECT_LT(distance(geo::normal_of(units, found), geo::normal_of(units, want)), 1e-13)
      << found.x << " " << found.y << ", not " << want.x << " " << want.y;
  EXPECT_NEAR(found.z, want.z, 1e-12 * std::abs(want.z));
}

std::vector<Vec3d> places(const geo::ChartUnits& units) {
  std::vector<Vec3d> at;
  for (const double lon : {-179.999, -37.0, 0.0, 3.7, 90.0, 179.999})
    for (const double lat : {-90.0, -89.99, -82.0, -14.5, 0.0, 61.0, 80.0, 88.8, 90.0})
      at.push_back(fixtures::in_units(units, {lon, lat, -300 - (lat + 90) - lon}));
  return at;
}

TEST(GeodeticAttached, KeepTheirCellsOverTheSeamAndAtThePoles) {
  using Units = geo::ChartUnits;
  for (const Units& units : {Units{}, Units{.radians = true, .kilometres = true, .down = true}})
    for (const TestMesh& from :
         {fixtures::globe({.units = units, .tilt = 0.3}),
          fixtures::globe({.units = units, .pole_longitude = 77}),
          fixtures::lattice({.units = units, .west = -185, .east = 175, .wraps = true})}) {
      Ocean ocean(from, constant({}), {}, units);
      const std::vector<double> before = ocean.arrays.points;
      advect::TracerSettings settings;
      settings.attached = true;
      advect::Tracer tracer(settings, ocean.memory);
      const std::vector<Vec3d> seeds = places(units);
      tracer.seed(seeds, 0.0);
      tracer.follow(ocean.sampler(), false, 0.0, 0.0, ocean.threads);
      ASSERT_EQ(tracer.counts().alive(), std::int64_t(seeds.size()));
      const std::vector<std::int64_t> cells(tracer.particles().cells.begin(),
                                            tracer.particles().cells.end());
      for (int step = 1; step <= 3; ++step) { // layers that move
        const double factor = 1 + 0.05 * step;
        for (std::size_t i = 2; i < before.size(); i += 3)
          ocean.arrays.points[i] = factor * before[i];
        ocean.commit(INSITU_CHANGED_GEOMETRY);
        core::Memory memory;
        advect::Snapshots half({step - 0.5}, memory);
        tracer.follow(ocean.sampler(), true, step - 1, step, ocean.threads, &half);
        for (std::size_t i = 0; i < seeds.size(); ++i) {
          Vec3d want = seeds[i];
          want.z *= factor;
          expect_place(units, tracer.positions()[i], want);
          EXPECT_EQ(tracer.particles().cells[i], cells[i]);
          EXPECT_GE(tracer.positions()[i].x, ocean.sampler().chart()->west);
          EXPECT_LT(tracer.positions()[i].x, ocean.sampler().chart()->west + units.turn());
          ASSERT_TRUE(half.present[half.item(0, i)]);
          want.z = seeds[i].z * (factor - 0.025);
          expect_place(units, half.positions[half.item(0, i)], want);
          const double up = std::abs(seeds[i].z * (factor - 1) * units.up_per_unit());
          EXPECT_NEAR(tracer.particles().lengths[i], up, 1e-6) << "metres";
        }
      }
    }
}

// A mesh that turns with the Earth through its seam: the way is along the parallel, in metres.
TEST(GeodeticAttached, GoTheShortWayOverTheSeam) {
  const TestMesh from = fixtures::lattice(
      {.west = 170, .south = -10, .east = 200, .north = 10, .across = 10, .along = 4});
  Ocean ocean(from, constant({}));
  advect::TracerSettings settings;
  settings.attached = true;
  advect::Tracer tracer(settings, ocean.memory);
  tracer.seed(std::vector<Vec3d>{{-179.5, 0, -50}, {179.25, 2, -50}}, 0.0);
  tracer.follow(ocean.sampler(), false, 0.0, 0.0, ocean.threads);
  EXPECT_EQ(tracer.positions()[0].x, 180.5) << "with the mesh's longitudes, from the release on";
  for (std::size_t i = 0; i < ocean.arrays.points.size(); i += 3)
    ocean.arrays.points[i] -= 180; // named by other longitudes, half of the way round
  ocean.commit(INSITU_CHANGED_GEOMETRY);
  tracer.follow(ocean.sampler(), true, 0.0, 1.0, ocean.threads);
  EXPECT_NEAR(tracer.positions()[0].x, 0.5, 1e-12);
  for (std::size_t i = 0; i < ocean.arrays.points.size(); i += 3)
    ocean.arrays.points[i] += 361; // a degree on, under a name a turn further
  ocean.commit(INSITU_CHANGED_GEOMETRY);
  core::Memory memory;
  const double before = tracer.particles().lengths[0];
  advect::Snapshots half({1.5}, memory);
  tracer.follow(ocean.sampler(), true, 1.0, 2.0, ocean.threads, &half);
  EXPECT_NEAR(tracer.positions()[0].x, 361.5, 1e-12);
  EXPECT_NEAR(half.positions[0].x, 361, 1e-12);
  EXPECT_NEAR(half.positions[0].z, -50, 1e-12);
  const double radius = geo::equatorial_radius - 50;
  EXPECT_NEAR(tracer.particles().lengths[0] - before, 2 * radius * std::sin(0.5 * degree), 1e-6);
}

} // namespace
} // namespace insitu::test
