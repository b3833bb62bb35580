// Periodic sides of basins and channels in longitude and latitude.
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>

#include "advect/lines/streamlines.h"
#include "core/random.h"
#include "core/status.h"
#include "earth_flow.h"
#include "line_view.h"

namespace insitu::test {
namespace {

using advect::AtBoundary;
using advect::Effects;
using advect::Snapshots;
using advect::Tracer;

/// A channel between two latitudes, from a longitude on for so many degrees. jump: of 360 degrees
/// less for longitudes beyond 180.
TestMesh channel(double west, double width, double jump = 0.0, const geo::ChartUnits& units = {}) {
  return fixtures::lattice({.units = units,
                            .west = west,
                            .south = 55,
                            .east = west + width,
                            .north = 65,
                            .across = 10,
                            .along = 10,
                            .levels = {-1000, -500, 0},
                            .jump = jump});
}

Effects periodic(AtBoundary other) {
  Effects effects = boundary(other);
  effects.boundary->periodic[0] = true;
  return effects;
}

/// East of `west`, from 0 to below a turn.
double east_of(double west, double longitude) {
  const double d = std::fmod(longitude - west, 360.0);
  return d < 0.0 ? d + 360.0 : d;
}

// Along a parallel: after any time at the longitude that the length of a degree says, modulo the
// channel's width, wherever it lies to the date line, in whatever names of its longitudes and
// units; depth to the bit, latitude to rounding.
TEST(GeodeticSides, TakeParticlesAcrossWhereverTheChannelLies) {
  struct Case {
    double west, width, jump;
  };
  for (const bool other : {false, true})
    for (const Case& c :
         {Case{10, 20, 0}, Case{170, 20, 0}, Case{170, 20, -360}, Case{175, 13, -360},
          Case{-180, 20, 0}, Case{20, 300, 0}, Case{100, 200, -360}}) {
      const geo::ChartUnits units{.radians = other, .kilometres = other, .down = other};
      const double degrees = units.radians ? degree : 1.0;
      std::vector<Vec3d> seeds;
      for (const Vec3d& p : {Vec3d{c.west + 0.3 * c.width, 60, -50},
                             Vec3d{c.west + c.width - 1e-9, 57.3, 0}, Vec3d{c.west, 64, -700}})
        seeds.push_back(fixtures::in_units(units, p));
      for (const double speed : {1.0, -1.0}) {
        Ocean flow(channel(c.west, c.width, c.jump, units), constant({2.0 * speed, 0, 0}), {},
                   units);
        const double end = 3.3 * c.width * metres_per_degree(60).x / 2.0;
        const Tracer t = flow.run(periodic(AtBoundary::leave), seeds, end, 3);
        for (std::size_t i = 0; i < seeds.size(); ++i) {
          ASSERT_EQ(t.particles().endings[i], INSITU_END_ALIVE)
              << c.west << " " << c.width << " " << c.jump << " " << i;
          const Vec3d at = t.positions()[i];
          EXPECT_TRUE(bool(flow.sampler().locate(at)));
          EXPECT_EQ(at.z, seeds[i].z);
          EXPECT_NEAR(at.y, seeds[i].y, 1e-11);
          const double m =
              metres_per_degree(seeds[i].y / degrees, seeds[i].z * units.up_per_unit()).x;
          const double want = seeds[i].x / degrees + speed * 2.0 * end / m;
          const double in = std::fmod(want - c.west, c.width);
          const double place = in < 0 ? in + c.width : in;
          EXPECT_NEAR(std::remainder(east_of(c.west, at.x / degrees) - place, c.width), 0.0,
                      1e-8 * c.width)
              << c.west << " " << c.width << " " << c.jump << " " << i;
          EXPECT_NEAR(t.particles().lengths[i], 2.0 * end, 1e-6 * end);
        }
        EXPECT_GE(flow.work.contacts, 9);
        EXPECT_EQ(flow.work.pinned, 0);
      }
    }
}

// What slides along the northern coast goes through the side; each time between steps is there.
TEST(GeodeticSides, CoastsAndTimesGoOnBehindThem) {
  const double end = 2e6, east = 2.0;
  for (const auto& [west, width] : {std::pair(10.0, 20.0), {172.0, 20.0}, {20.0, 300.0}}) {
    Ocean sea(channel(west, width), constant({east, 0.3, 0}));
    const std::vector<Vec3d> seeds{{west + 0.6 * width, 64.9999, -50},
                                   {west + 0.97 * width, 64.9999, 0}};
    std::vector<double> times;
    for (int k = 0; k <= 100; ++k)
      times.push_back(end * k / 100);
    Tracer t(sea.settings, sea.memory), plain(sea.settings, sea.memory);
    const mesh::FieldView v = sea.flow();
    Snapshots at(times, sea.memory);
    for (Tracer* tracer : {&t, &plain}) {
      tracer->set_effects(periodic(AtBoundary::slide));
      tracer->seed(seeds, 0.0);
      tracer->advance(sea.sampler(), v, &v, 0, end, sea.threads, tracer == &t ? &at : nullptr);
    }
    for (std::size_t i = 0; i < seeds.size(); ++i) {
      EXPECT_EQ(t.positions()[i], plain.positions()[i]);
      for (std::size_t k = 0; k < times.size(); ++k) {
        ASSERT_EQ(at.present[at.item(k, i)], 1);
        EXPECT_TRUE(bool(at.places[at.item(k, i)])) << k;
        const Vec3d x = at.positions[at.item(k, i)];
        const double want = seeds[i].x + east * times[k] / metres_per_degree(65, x.z).x;
        EXPECT_NEAR(std::remainder(east_of(west, x.x) - (want - west), width), 0.0, 1e-4)
            << west << " " << k;
        EXPECT_NEAR(x.y, 65, 1.1e-4);
        EXPECT_EQ(x.z, seeds[i].z);
      }
    }
  }
}

// A third of the Earth with periodic sides is as good as the whole with the flow three times
// around: the same latitudes, depths and longitudes within the third, of whatever moves.
TEST(GeodeticSides, ASectorIsAsGoodAsTheWholeEarth) {
  const auto flow = [](const Vec3d& at) {
    const double a = 3 * at.x * degree;
    return Vec3d{1.0 + 0.5 * std::cos(a), 0.7 * std::sin(a), 0.001 * std::cos(a)};
  };
  const auto mesh = [](double west, double east, int across) {
    return fixtures::lattice({.west = west,
                              .south = 40,
                              .east = east,
                              .north = 70,
                              .across = across,
                              .along = 10,
                              .levels = {-1000, -500, 0}});
  };
  const auto level = [&](const Vec3d& at) {
    Vec3d v = flow(at);
    v.z = 0.0;
    return v;
  };
  std::vector<Vec3d> seeds;
  for (std::uint64_t i = 0; i < 10; ++i)
    seeds.push_back({120 + 119 * core::random_unit(7, i, 0), 41 + 28 * core::random_unit(7, i, 1),
                     -990 * core::random_unit(7, i, 2)});
  for (int kind = 0; kind < 3; ++kind) {
    const AtBoundary other = kind == 1 ? AtBoundary::reflect : AtBoundary::slide;
    Ocean third(mesh(120, 240, 24), kind == 2 ? Ocean::Vector(level) : Ocean::Vector(flow));
    Ocean whole(mesh(-180, 180, 72), kind == 2 ? Ocean::Vector(level) : Ocean::Vector(flow));
    Effects on_third = periodic(other), on_whole = boundary(other);
    for (Effects* e : {&on_third, &on_whole})
      if (kind == 2) {
        e->inertia.emplace();
        e->inertia->response_time = 2e4;
      }
    const Tracer a = third.run(on_third, seeds, 6e6, 4), b = whole.run(on_whole, seeds, 6e6, 4);
    int through = 0;
    for (std::size_t i = 0; i < seeds.size(); ++i) {
      ASSERT_EQ(a.particles().endings[i], b.particles().endings[i]) << kind << " " << i;
      const Vec3d x = a.positions()[i], y = b.positions()[i];
      // Steps differ at the sides; tolerances of 1e-6 m/s over 6e6 s, and walls' steps of 0.1
      // cells.
      EXPECT_NEAR(std::remainder(x.x - y.x, 120), 0.0, 2e-2) << kind << " " << i;
      EXPECT_NEAR(x.y, y.y, 2e-2) << kind << " " << i;
      EXPECT_NEAR(x.z, y.z, 2.0) << kind << " " << i;
      EXPECT_GE(east_of(120, x.x), 0.0);
      EXPECT_LE(east_of(120, x.x), 120.0);
      through += std::abs(std::remainder(x.x - y.x, 360)) > 1.0;
    }
    EXPECT_GE(through, 5) << kind;
  }
}

// The walk is mixed through the sides: what begins beside one comes to the whole basin, and evenly
// mixed particles stay so, by volume.
TEST(GeodeticSides, TheWalkGoesThroughAndStaysMixed) {
  Ocean sea(fixtures::lattice({.west = 0,
                               .south = 40,
                               .east = 8,
                               .north = 60,
                               .across = 8,
                               .along = 20,
                               .levels = {-1000, 0}}),
            constant({0, 0, 0}));
  Effects effects = periodic(AtBoundary::reflect);
  effects.diffusion = advect::Diffusion{{5e4, {}}, {0.0, {}}, 0.0, 3};
  const std::size_t n = 600;
  std::vector<Vec3d> seeds;
  for (std::uint64_t i = 0; i < n; ++i) { // by area of the sphere of normals, near enough
    const double s = std::sin(40 * degree) +
                     (std::sin(60 * degree) - std::sin(40 * degree)) * core::random_unit(9, i, 0);
    seeds.push_back({7.99, std::asin(s) / degree, -500});
  }
  const Tracer t = sea.run(effects, seeds, 5e6, 2); // sqrt(2 K t) = 700 km, of 8 degrees: 450 km
  int west = 0, south = 0;
  for (std::size_t i = 0; i < n; ++i) {
    ASSERT_EQ(t.particles().endings[i], INSITU_END_ALIVE);
    west += t.positions()[i].x < 4;
    south += std::sin(t.positions()[i].y * degree) <
             0.5 * (std::sin(40 * degree) + std::sin(60 * degree));
  }
  // Halves, by five deviations of sqrt(n) / 2 (the ellipsoid's area differs by less than 1e-3).
  EXPECT_NEAR(west, n / 2, 61);
  EXPECT_NEAR(south, n / 2, 61);
}

TEST(GeodeticSides, StreamlinesGoOnBehindThem) {
  const double west = 172, width = 20;
  Ocean sea(channel(west, width), constant({1.5, 0, 0}));
  core::Memory memory;
  advect::StreamlineSettings settings;
  settings.effects = periodic(AtBoundary::stop);
  settings.direction = advect::Direction::both;
  settings.duration = 2.5 * width * metres_per_degree(60).x / 1.5;
  const std::vector<Vec3d> seeds{{175, 60, -100}};
  for (const double even : {0.0, 2e4}) {
    settings.even_length = even;
    const advect::Streamlines s =
        advect::trace_streamlines(sea.sampler(), sea.flow(), seeds, settings, sea.threads, memory);
    for (std::size_t l = 0; l < 2; ++l) {
      int sides = 0;
      const LineView of = line(s, l);
      for (std::size_t v = 0; v < of.points.size(); ++v) {
        const Vec3d x = of.points[v];
        const double want = 3 + 1.5 * of.times[v] / metres_per_degree(60, -100).x;
        EXPECT_NEAR(std::remainder(east_of(west, x.x) - want, width), 0.0, 1e-6);
        EXPECT_GE(of.cells[v], 0);
        if (v == 0 || of.times[v] != of.times[v - 1])
          continue;
        ++sides;
        const Vec3d y = of.points[v - 1];
        EXPECT_EQ(east_of(west, x.x), l == 0 ? 0.0 : 20.0) << "to the bit";
        EXPECT_EQ(east_of(west, y.x), l == 0 ? 20.0 : 0.0);
      }
      EXPECT_EQ(sides, l == 0 ? 2 : 3);
      EXPECT_EQ(of.ending, INSITU_END_EXPIRED);
    }
  }
}

TEST(GeodeticSides, OnlyMeridiansServeAndNoPole) {
  const auto refused = [](Ocean& sea, const Effects& effects) {
    const std::vector<Vec3d> seeds{{15, 60, -50}};
    try {
      sea.run(effects, seeds, 1.0);
    } catch (const core::Error& error) {
      EXPECT_EQ(error.status(), INSITU_ERROR_UNSUPPORTED);
      return std::string(error.what());
    }
    return std::string("not refused");
  };
  Ocean sea(channel(10, 20), constant({1.0, 0, 0}));
  for (const int axis : {1, 2}) {
    Effects effects = boundary(AtBoundary::slide);
    effects.boundary->periodic[axis] = true;
    EXPECT_NE(refused(sea, effects).find("western and eastern"), std::string::npos);
  }
  Ocean cap(fixtures::globe({.subdivisions = 3, .tilt = 0.3}), constant({1.0, 0, 0}));
  EXPECT_NE(refused(cap, periodic(AtBoundary::slide)).find("at a pole"), std::string::npos);
  // One that goes around the Earth has no sides.
  Ocean around(fixtures::lattice({.west = -180, .south = -60, .east = 180, .north = 60}),
               constant({200.0, 0, 0}));
  const std::vector<Vec3d> seeds{{170, 0, -50}};
  const Tracer t = around.run(periodic(AtBoundary::stop), seeds, 1e4);
  EXPECT_EQ(t.particles().endings[0], INSITU_END_ALIVE);
  EXPECT_EQ(around.work.contacts, 0);
  EXPECT_LT(t.positions()[0].x, 0);
}

} // namespace
} // namespace insitu::test
