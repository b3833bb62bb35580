// Coasts, floors and surfaces of meshes in longitude and latitude, which are straight in degrees
// and stop, let slide, reflect or put back what moves by metres.
#include <cstring>
#include <gtest/gtest.h>

#include "advect/effects/walls.h"
#include "advect/integrate/integrators.h"
#include "core/random.h"
#include "core/status.h"
#include "earth_flow.h"

namespace insitu::test {
namespace {

using advect::AtBoundary;
using advect::Effects;
using advect::length_of;
using advect::Moved;
using advect::Space;
using advect::Spot;
using advect::Tracer;
using advect::Walls;

/// 10 to 20 degrees east, 55 to 65 north, its coasts leaning east by `lean` degrees a degree of
/// latitude, its floor rising eastwards by `rise` metres a degree from 1000 m below.
TestMesh basin(double lean = 0.0, double rise = 0.0) {
  TestMesh mesh = fixtures::lattice({.west = 10,
                                     .south = 55,
                                     .east = 20,
                                     .north = 65,
                                     .across = 10,
                                     .along = 10,
                                     .levels = {-1000, -500, 0}});
  for (Vec3d& p : mesh.vertices) {
    p.z += -p.z / 1000 * rise * (p.x - 10);
    p.x += lean * (p.y - 60);
  }
  return mesh;
}

TEST(GeodeticWalls, StopAtTheCoastToTheBit) {
  Ocean sea(basin(), constant({1.0, 0, 0}));
  const std::vector<Vec3d> seeds{{19.5, 60, -50}, {12, 57.3, 0}};
  const Tracer t = sea.run(boundary(AtBoundary::stop), seeds, 1e6, 4);
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    EXPECT_EQ(t.particles().endings[i], INSITU_END_STOPPED);
    EXPECT_EQ(t.positions()[i].x, 20.0);
    EXPECT_EQ(t.positions()[i].z, seeds[i].z);
    const double way =
        (20 - seeds[i].x) * metres_per_degree(seeds[i].y, seeds[i].z).x; // along the parallel
    EXPECT_NEAR(t.positions()[i].y, seeds[i].y, 1e-12);
    EXPECT_NEAR(t.particles().times[i], way, 1e-6 * way);
    EXPECT_NEAR(t.particles().lengths[i], way, 1e-6 * way);
  }
}

TEST(GeodeticWalls, SlideAlongLeaningCoastsAsMetresSay) {
  // The coast is lon = 20 + a (lat - 60). A velocity (u, v) along it: with the tangent
  // T = (a Nc, M) by latitude, dlat/dt = (u a Nc + v M) / |T|^2.
  const double a = 1.5;
  const Vec3d wind{0.8, -0.1, 0};
  Ocean sea(basin(a), constant(wind));
  const double from = 58, time = 4e5;
  const std::vector<Vec3d> seeds{{20 + a * (from - 60) - 1e-6, from, -50}};
  const Tracer t = sea.run(boundary(AtBoundary::slide), seeds, time, 3);
  ASSERT_EQ(t.particles().endings[0], INSITU_END_ALIVE);
  const auto end = [&](bool in_metres) {
    double lat = from; // Euler's method in steps far smaller than the tolerance needs
    for (int i = 0; i < 100000; ++i) {
      const Vec3d m = metres_per_degree(lat, -50), s = in_metres ? m : Vec3d{1, 1, 1};
      const Vec3d rate{wind.x / m.x, wind.y / m.y, 0}; // degrees
      lat += time / 100000 * (rate.x * s.x * s.x * a + rate.y * s.y * s.y) /
             (s.x * s.x * a * a + s.y * s.y);
    }
    return lat;
  };
  // Heun in steps of a tenth of a cell, over 3 degrees: 1e-5; a coast that turned vectors in
  // degrees would be half a degree off.
  EXPECT_NEAR(t.positions()[0].y, end(true), 1e-4);
  EXPECT_GT(std::abs(end(false) - end(true)), 0.3);
  EXPECT_NEAR(t.positions()[0].x, 20 + a * (t.positions()[0].y - 60), 1e-7);
  EXPECT_LE(t.positions()[0].x, 20 + a * (t.positions()[0].y - 60) + 1e-12);
  EXPECT_EQ(t.positions()[0].z, -50);
  EXPECT_EQ(sea.work.pinned, 0);
}

TEST(GeodeticWalls, ReflectAsAPlaneMirrorsInMetres) {
  // Over 2 km the Earth is flat to 2 km / 6400 km.
  const double a = 1.5;
  Ocean sea(basin(a), constant({0, 0, 0}));
  const query::Sampler images = sea.sampler().among_images();
  advect::EffectWork work;
  const Space space(sea.sampler().chart());
  const advect::Sides none;
  Walls walls(images, INSITU_STANDARD, space, none, work);
  const Vec3d per_degree = metres_per_degree(60, -100);
  const Vec3d tangent{a * per_degree.x, per_degree.y, 0};
  const Vec3d n = Vec3d{tangent.y, -tangent.x, 0} / std::hypot(tangent.x, tangent.y);
  for (int i = 0; i < 20; ++i) {
    const double angle = 1.4 * (2 * core::random_unit(5, std::uint64_t(i), 0) - 1);
    const double out = 1000 * std::cos(angle), along = 1000 * std::sin(angle);
    const Vec3d u = tangent / std::hypot(tangent.x, tangent.y);
    const Vec3d m = 2.0 * (out * n + along * u); // twice the way to the wall
    const Vec3d start{20 - out * n.x / per_degree.x, 60 - out * n.y / per_degree.y, -100};
    Spot at{start, images.locate(start).cell};
    ASSERT_GE(at.cell, 0);
    double length = 0;
    Vec3d carried = m;
    advect::BoundaryEffect response;
    response.response = AtBoundary::reflect;
    EXPECT_EQ(walls.move(at, {m.x / per_degree.x, m.y / per_degree.y, 0}, response, 1.0, length,
                         &carried),
              Moved::inside);
    const Vec3d d{(at.x.x - start.x) * per_degree.x, (at.x.y - start.y) * per_degree.y, 0};
    const Vec3d want = m - 2 * out * n; // back as far as it came
    EXPECT_LT(length_of(d - want), 2.0) << angle;
    EXPECT_LT(length_of(carried - (m - 4 * out * n)), 4.0) << angle;
    EXPECT_NEAR(length, length_of(m), 2.0);
    EXPECT_LT(length_of(walls.wall() - n), 1e-3);
  }
}

TEST(GeodeticWalls, SinkingParticlesSlideDownSlopingFloors) {
  // The floor rises by s metres a metre eastwards: the part of the velocity (0, 0, -w) along it is
  // -w s / (1 + s^2) eastwards.
  const double rise = 40, w = 0.05, time = 2e7;
  Ocean sea(basin(0, rise), constant({0, 0, -w}));
  const std::vector<Vec3d> seeds{{17, 60, -1000 + rise * 7 + 0.5}};
  const Tracer t = sea.run(boundary(AtBoundary::slide), seeds, time, 3);
  ASSERT_EQ(t.particles().endings[0], INSITU_END_ALIVE);
  const Vec3d at = t.positions()[0];
  const double east = metres_per_degree(60, -850).x, s = rise / east;
  const double want = -w * s / (1 + s * s) * (time - 0.5 / w) / east;
  EXPECT_LT(want, -0.01);
  EXPECT_NEAR(at.x - 17, want, 1e-3 * -want); // N + h changes by 1e-5 on the way
  EXPECT_NEAR(at.z, -1000 + rise * (at.x - 10), 1e-5);
  EXPECT_NEAR(at.y, 60, 1e-9);
}

TEST(GeodeticWalls, TheSurfaceHoldsWhatRises) {
  for (const bool other : {false, true}) {
    const geo::ChartUnits units{.radians = other, .kilometres = other, .down = other};
    TestMesh mesh = basin();
    for (Vec3d& p : mesh.vertices)
      p = fixtures::in_units(units, p);
    Ocean sea(mesh, constant({0.5, 0, 0.01}), {}, units);
    const std::vector<Vec3d> seeds{fixtures::in_units(units, {11, 60, -30}),
                                   fixtures::in_units(units, {11, 58, 0})};
    const Tracer t = sea.run(boundary(AtBoundary::slide), seeds, 2e5, 2);
    for (std::size_t i = 0; i < 2; ++i) {
      ASSERT_EQ(t.particles().endings[i], INSITU_END_ALIVE);
      const Vec3d at = t.positions()[i];
      EXPECT_LT(std::abs(at.z * units.up_per_unit()), 1e-5); // 1e-9 of its layer, a few times
      EXPECT_GE(at.z * (other ? 1 : -1), 0.0);
      const double want = 11 + 1e5 / metres_per_degree(seeds[i].y * (other ? 1 / degree : 1)).x;
      EXPECT_NEAR(at.x * (other ? 1 / degree : 1), want, 1e-5);
    }
    EXPECT_EQ(sea.run(boundary(AtBoundary::stop), seeds, 2e5).positions()[0].z, 0.0);
  }
}

TEST(GeodeticWalls, CoastsGoOnOverTheDateLine) {
  // Around the Earth between 10 degrees south and north, pressed onto the northern coast.
  const double east = 5, time = 8e5;
  for (const bool wraps : {false, true})
    for (const double west : {-180.0, -177.5, 0.0, 178.0}) {
      Ocean sea(tropics(west, wraps), constant({east, 0.5, 0}));
      const std::vector<Vec3d> seeds{{170, 9.99, -10}, {-5, 9.99, 0}, {179.9999999, 9.99, 0}};
      for (const AtBoundary response : {AtBoundary::slide, AtBoundary::reflect}) {
        const Tracer t = sea.run(boundary(response), seeds, time, 3);
        for (std::size_t i = 0; i < seeds.size(); ++i) {
          const Vec3d at = t.positions()[i];
          ASSERT_EQ(t.particles().endings[i], INSITU_END_ALIVE) << west << wraps;
          EXPECT_TRUE(bool(sea.sampler().locate(at)));
          if (response == AtBoundary::slide) {
            EXPECT_NEAR(at.y, 10, 1e-7);
            EXPECT_LE(at.y, 10);
            // Below the coast for 0.01 degrees, where a degree is longer by tan(10) 0.01 degrees.
            const double want = seeds[i].x + east * time / metres_per_degree(10, at.z).x;
            EXPECT_NEAR(std::remainder(at.x - want, 360), 0, 1e-4) << west << wraps;
          } else {
            EXPECT_GT(at.y, 9.4); // back by a tenth of a cell
          }
        }
        EXPECT_EQ(sea.work.pinned, 0);
      }
    }
}

/// Half of a cap: the coast goes along the meridians 0 and 180 over the pole.
TestMesh half_cap() {
  return fixtures::lattice({.west = 0,
                            .south = 60,
                            .east = 180,
                            .north = 90,
                            .across = 36,
                            .along = 12,
                            .levels = {-4000, -100, 0}});
}

TEST(GeodeticWalls, CoastsOverThePole) {
  // Pressed onto the coast and taken along it, from one side of the pole to the other.
  Ocean sea(half_cap(), towards({-10, -2, 0}));
  const std::vector<Vec3d> seeds{{0.5, 80, -10}, {3, 87, 0}, {90, 89.9, -50}, {60, 89.99, -2000}};
  const Tracer t = sea.run(boundary(AtBoundary::slide), seeds, 3e5, 3);
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    const Vec3d at = t.positions()[i];
    ASSERT_EQ(t.particles().endings[i], INSITU_END_ALIVE) << i;
    EXPECT_TRUE(bool(sea.sampler().locate(at))) << i;
    EXPECT_GT(at.x, 90) << i;
    EXPECT_LT(at.y, 88) << i;
    EXPECT_EQ(at.z, seeds[i].z);
  }
  // At 10 cos(beyond) metres per second along a great circle: sin(d / R) grows as tanh does. The
  // first begins 10 degrees before the pole; v = 10 cos(angle), so gd^-1(angle) = 10 t / R.
  const double from = -10 * degree, r = geo::radii(0.98).along;
  const double to = std::atan(std::sinh(std::asinh(std::tan(from)) + 10 * 3e5 / r));
  EXPECT_NEAR(90 - t.positions()[0].y, to / degree,
              0.1); // of 27 degrees, in a velocity interpolated over 5
  EXPECT_EQ(sea.work.pinned, 0);
}

/// A globe of wedges without the cells for which `gone` holds of their middle's normal.
TestMesh continent(const std::function<bool(const Vec3d&)>& gone, double tilt) {
  TestMesh mesh = fixtures::globe({.subdivisions = 4, .tilt = tilt, .pole_longitude = 40});
  std::erase_if(mesh.cells, [&](const auto& cell) {
    Vec3d sum;
    for (int v = 0; v < mesh::vertex_count(cell.shape); ++v)
      sum += geo::normal_of({}, mesh.vertices[std::size_t(cell.vertices[std::size_t(v)])]);
    return gone(sum / std::sqrt(dot(sum, sum)));
  });
  return mesh;
}

TEST(GeodeticWalls, RuggedCoastsOnTurnedChartsKeepAllParticles) {
  for (const double tilt : {0.0, 0.3}) {
    // A continent around the pole's neighbourhood: its coast passes 3 degrees from it.
    Ocean sea(continent([](const Vec3d& n) { return n.z > 0 && n.x < -0.05; }, tilt),
              towards({-8, 3, 1}));
    std::vector<Vec3d> seeds;
    for (int i = 0; seeds.size() < 40; ++i) {
      const Vec3d p{core::random_unit(8, std::uint64_t(i), 0) * 360 - 180,
                    90 - 25 * core::random_unit(8, std::uint64_t(i), 1), i % 3 ? -50.0 : 0.0};
      if (sea.sampler().locate(p))
        seeds.push_back(p);
    }
    const core::Threads one(1), many(4);
    for (const AtBoundary response :
         {AtBoundary::stop, AtBoundary::slide, AtBoundary::reflect, AtBoundary::put_back}) {
      const Tracer t = sea.run(boundary(response), seeds, 4e5, 4, &many);
      const advect::EffectWork work = sea.work;
      int ended = 0;
      for (std::size_t i = 0; i < seeds.size(); ++i) {
        EXPECT_TRUE(bool(sea.sampler().locate(t.positions()[i]))) << tilt << " " << i;
        EXPECT_EQ(t.positions()[i].z, seeds[i].z);
        ended += t.particles().endings[i] != INSITU_END_ALIVE;
        if (response == AtBoundary::stop && t.particles().endings[i] != INSITU_END_ALIVE) {
          EXPECT_EQ(t.particles().endings[i], INSITU_END_STOPPED);
        }
      }
      EXPECT_EQ(ended > 15, response == AtBoundary::stop);
      EXPECT_GT(work.contacts, 20);
      EXPECT_LT(work.contacts, 40 * 1000);
      const Tracer again = sea.run(boundary(response), seeds, 4e5, 4, &one);
      EXPECT_EQ(
          std::memcmp(t.positions().data(), again.positions().data(), seeds.size() * sizeof(Vec3d)),
          0);
    }
  }
}

TEST(GeodeticWalls, PutBackGoesOnFromTheLastPositionInside) {
  Ocean sea(basin(), constant({1.0, 0, 0}));
  const std::vector<Vec3d> seeds{{19.5, 60, -50}, {11, 57.3, 0}};
  const double cycle = 1e4; // 0.18 degrees at 60 north
  const Tracer before = sea.run(boundary(AtBoundary::put_back), seeds, 2 * cycle, 2);
  EXPECT_EQ(sea.work.contacts, 0);
  const Tracer t = sea.run(boundary(AtBoundary::put_back), seeds, 10 * cycle, 10);
  EXPECT_EQ(sea.work.contacts, 8);
  EXPECT_EQ(t.positions()[0], before.positions()[0]);
  EXPECT_EQ(t.particles().times[0], 10 * cycle);
  EXPECT_EQ(t.particles().lengths[0], before.particles().lengths[0]);
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_EQ(t.particles().endings[i], INSITU_END_ALIVE);
  EXPECT_NEAR(t.positions()[1].x, 11 + 10 * cycle / metres_per_degree(57.3).x, 1e-6);
}

TEST(GeodeticWalls, SurfacesThatSinkTakeParticlesAlong) {
  // The surface sinks by 20 m. Cells that wrap around and ones on turned charts are copies.
  for (const TestMesh& from : {fixtures::lattice({.west = 0, .east = 360, .wraps = true}),
                               fixtures::globe({.subdivisions = 3, .tilt = 0.3})})
    for (const AtBoundary response :
         {AtBoundary::stop, AtBoundary::slide, AtBoundary::reflect, AtBoundary::put_back}) {
      Ocean sea(from, towards({0.1, 0.05, 0}));
      sea.mesh.mesh().keep_earlier({{"v", 1}}, sea.threads);
      for (std::size_t v = 0; v < from.vertices.size(); ++v)
        sea.arrays.points[3 * v + 2] = from.vertices[v].z * (3980.0 / 4000) - 20;
      ASSERT_EQ(sea.commit(INSITU_CHANGED_GEOMETRY).action, INSITU_REFIT);
      sea.mesh.show_earlier(sea.threads);
      ASSERT_NE(sea.mesh.mesh().view().earlier_points, nullptr);
      const std::vector<Vec3d> seeds{
          {20, 60, -10}, {359.999, 40, -10}, {20, 89, 0}, {50, -90, -5}, {20, 20, -50}};
      advect::Tracer t(sea.settings, sea.memory);
      t.set_effects(boundary(response));
      t.seed(seeds, 0.0);
      const mesh::FieldView v = sea.flow();
      const auto a = t.advance(sea.sampler(), v, &v, 0, 1000, sea.threads);
      sea.mesh.hide_earlier();
      EXPECT_TRUE(a.blended_geometry);
      for (std::size_t i = 0; i < seeds.size(); ++i) {
        if (response == AtBoundary::stop && i != 4) {
          EXPECT_EQ(t.particles().endings[i], INSITU_END_STOPPED) << i;
          EXPECT_EQ(t.positions()[i].z, seeds[i].z);
          EXPECT_NEAR(t.particles().times[i], -50 * seeds[i].z, 1e-3);
          continue;
        }
        EXPECT_EQ(t.particles().endings[i], INSITU_END_ALIVE) << int(response) << " " << i;
        EXPECT_TRUE(bool(sea.sampler().locate(t.positions()[i]))) << int(response) << " " << i;
        const double z = t.positions()[i].z;
        if (response == AtBoundary::reflect && i != 4) {
          EXPECT_LE(z, -20.0);
          EXPECT_GE(z, -40.1); // as far below as it would be above
          continue;
        }
        const double want = i == 4                             ? -50
                            : response == AtBoundary::put_back ? seeds[i].z * 0.995 - 20
                                                               : -20;
        EXPECT_NEAR(z, want, 1e-5);
      }
    }
}

TEST(GeodeticWalls, ParticlesAtTheSurfaceGoOverThePole) {
  // What rises goes along the surface as what floats there does.
  for (const TestMesh& from : {fixtures::lattice({.across = 72, .along = 36}),
                               fixtures::globe({.subdivisions = 4, .tilt = 0.3})}) {
    const Vec3d wind{7, 4, 3};
    const auto rising = [&](const Vec3d& at) { return towards(wind)(at) + Vec3d{0, 0, 0.1}; };
    Ocean floats(from, towards(wind)), rises(from, rising);
    std::vector<Vec3d> seeds{{-150, 90, 0}, {-150.26, 75, 0}};
    for (std::uint64_t i = 0; i < 10; ++i)
      seeds.push_back(
          {-120 - 60 * core::random_unit(4, i, 0), 75 + 12 * core::random_unit(4, i, 1), 0});
    const Tracer a = floats.run({}, seeds, 3e5, 3);
    const Tracer b = rises.run(boundary(AtBoundary::slide), seeds, 3e5, 3);
    for (std::size_t i = 0; i < seeds.size(); ++i) {
      ASSERT_EQ(b.particles().endings[i], INSITU_END_ALIVE) << i;
      const Vec3d away =
          geo::normal_of({}, a.positions()[i]) - geo::normal_of({}, b.positions()[i]);
      // Of 2400 km; where the velocity is interpolated over 5 degrees of directions.
      EXPECT_LT(std::sqrt(dot(away, away)) * 6.4e6, 5000) << i;
      EXPECT_NEAR(b.positions()[i].z, 0, 1e-5);
    }
    EXPECT_EQ(rises.work.pinned, 0);
  }
}

} // namespace
} // namespace insitu::test
