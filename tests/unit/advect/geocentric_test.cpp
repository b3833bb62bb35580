// Effects on geocentric meshes: level and upright are by the ellipsoid's normal at the particle.
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>

#include "advect/effects/space.h"
#include "advect/lines/streamlines.h"
#include "core/random.h"
#include "earth_flow.h"

namespace insitu::test {
namespace {

using advect::Effects;
using advect::Space;
using advect::Tracer;

double distance(const Vec3d& a, const Vec3d& b) {
  return advect::length_of(a - b);
}

/// The Earth from 2000 km deep to 1000 km high, poles in cells.
Ocean planet(const Ocean::Vector& flow = constant({0, 0, 0}),
             const std::vector<double>& levels = {-2e6, -1e6, 0, 1e6}) {
  return Ocean(fixtures::globe({.subdivisions = 3, .tilt = 0.3, .levels = levels}), flow, {}, {},
               true);
}

Effects on_earth() {
  Effects effects;
  effects.geocentric = true;
  return effects;
}

const std::vector<Vec3d> places{{10, 52, -1e5},   {179.999, -33, -2e5}, {-70, 0, -1e5},
                                {0, 90, -3e5},    {120, -90, -1e5},     {33, 89.999, -1e5},
                                {-120, 45, -3e5}, {90, 1e-7, -5e5}};
std::vector<Vec3d> in_space(const std::vector<Vec3d>& geodetic) {
  std::vector<Vec3d> points;
  for (const Vec3d& p : geodetic)
    points.push_back(Ocean::geocentric_of(p));
  return points;
}

/// The place, straight up from one by `height`: normals are straight lines.
Vec3d above(const Vec3d& place, double height) {
  return Ocean::geocentric_of({place.x, place.y, place.z + height});
}

TEST(Geocentric, WhatSettlesGoesDownTheNormal) {
  Ocean earth = planet();
  earth.settings.integrator.tolerance = 1e-9;
  Effects effects = on_earth();
  effects.drifts.emplace_back();
  effects.drifts[0].constant = {0, 0, -0.1};
  effects.drifts[0].is_local = true;
  const double time = 1e6;
  const Tracer t = earth.run(effects, in_space(places), time, 2);
  for (std::size_t i = 0; i < places.size(); ++i)
    EXPECT_LT(distance(t.positions()[i], above(places[i], -1e5)), 1e-3) << i;
  // By a field, upwards, along streamlines too, there and back.
  Ocean rising(
      fixtures::globe({.subdivisions = 2, .tilt = 0.3, .levels = {-2e6, 1e6}}), constant({0, 0, 0}),
      [](const Vec3d&) { return -0.1; }, {}, true);
  advect::StreamlineSettings lines;
  lines.integrator.tolerance = 1e-9;
  lines.duration = 5e5;
  lines.direction = advect::Direction::both;
  lines.effects = on_earth();
  lines.effects.drifts.emplace_back();
  lines.effects.drifts[0].field = advect::FieldInTime{rising.scalar(), {}};
  lines.effects.drifts[0].direction = {0, 0, -1};
  lines.effects.drifts[0].is_local = true;
  const advect::Streamlines s = advect::trace_streamlines(
      rising.sampler(), rising.flow(), in_space(places), lines, rising.threads, rising.memory);
  for (std::size_t l = 0; l < 2 * places.size(); ++l)
    EXPECT_LT(distance(s.lines.points[std::size_t(s.lines.offsets[l + 1]) - 1],
                       above(places[l / 2], l % 2 ? -5e4 : 5e4)),
              1e-3)
        << l;
}

TEST(Geocentric, ADriftEastGoesAlongItsParallel) {
  Ocean earth = planet();
  earth.settings.integrator.tolerance = 1e-8;
  Effects effects = on_earth();
  effects.drifts.emplace_back();
  effects.drifts[0].constant = {2, 0, 0};
  effects.drifts[0].is_local = true;
  const Vec3d from{170, 52, -1e5};
  const Tracer t = earth.run(effects, in_space({from}), 1e6, 2);
  const double turned = 2e6 / metres_per_degree(52, -1e5).x;
  EXPECT_LT(distance(t.positions()[0], Ocean::geocentric_of({170 + turned, 52, -1e5})), 0.02);
}

TEST(Geocentric, WhatFallsFallsAlongTheNormal) {
  Ocean earth = planet();
  earth.settings.integrator.tolerance = 1e-7;
  Effects effects = on_earth();
  effects.inertia.emplace();
  effects.inertia->acceleration = {0, 0, -9.81};
  effects.inertia->begins = Vec3d{0, 0, 300};
  const double time = 100;
  const Tracer t = earth.run(effects, in_space(places), time, 2);
  for (std::size_t i = 0; i < places.size(); ++i)
    EXPECT_LT(distance(t.positions()[i], above(places[i], 300 * time - 0.5 * 9.81 * time * time)),
              1e-4)
        << i;
  // Without forces straight on in space, as coordinates go.
  effects.inertia->acceleration = {};
  effects.inertia->begins = Vec3d{300, 0, 0};
  const Tracer free = earth.run(effects, in_space(places), time, 2);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const geo::Upright at = geo::upright(in_space(places)[i]);
    EXPECT_LT(distance(free.positions()[i],
                       in_space(places)[i] + geo::from_east_north_up(at.normal, {3e4, 0, 0})),
              1e-4);
  }
}

// Drifters with drag in the same westerly on the same cells, geodetic and geocentric: what turns
// them is the Earth's rotation in both, level and upright. (The metric's u^2 / R, which is the
// straight motion in space, moves them by 1e-7 m/s^2 tau t = 2 m.)
TEST(Geocentric, CoriolisTurnsAsOnAGeodeticMesh) {
  const TestMesh cells = fixtures::lattice({.west = -4,
                                            .south = 48,
                                            .east = 4,
                                            .north = 54,
                                            .across = 40,
                                            .along = 30,
                                            .levels = {-4000, -2000, 0}});
  const auto flow = constant({1, 0.25, 0});
  Ocean chart(cells, flow), globe(cells, flow, {}, {}, true);
  const std::vector<Vec3d> seeds{{-1, 50, -2000}, {0.5, 52.3, -1500}, {2, 53, -2500}};
  Vec3d without[2];
  for (const bool turns : {false, true}) {
    Effects effects;
    effects.inertia.emplace();
    effects.inertia->response_time = 1000;
    if (turns)
      effects.inertia->rotation = {0, 0, 7.292115e-5};
    const Tracer a = chart.run(effects, seeds, 1e4, 2);
    effects.geocentric = true;
    const Tracer b = globe.run(effects, in_space(seeds), 1e4, 2);
    for (std::size_t i = 0; i < seeds.size(); ++i) {
      const Vec3d there = Ocean::geocentric_of(a.positions()[i]);
      EXPECT_LT(distance(b.positions()[i], there), 5.0) << turns << i;
      if (i == 0)
        without[turns] = b.positions()[0];
    }
  }
  EXPECT_GT(distance(without[0], without[1]), 1000.0); // what the rotation does
}

Effects walk(double horizontal, double vertical, double step, std::uint64_t seed = 7) {
  Effects effects = on_earth();
  effects.diffusion.emplace();
  effects.diffusion->horizontal.constant = horizontal;
  effects.diffusion->vertical.constant = vertical;
  effects.diffusion->step = step;
  effects.diffusion->seed = seed;
  return effects;
}

TEST(Geocentric, TheWalkIsThatOfAGeodeticMesh) {
  const TestMesh cells = fixtures::lattice({.west = -4,
                                            .south = 45,
                                            .east = 6,
                                            .north = 55,
                                            .across = 40,
                                            .along = 40,
                                            .levels = {-40000, -20000, 0}});
  const auto grows = [](const Vec3d& p) { return 3000 + 0.05 * p.z + 50 * (p.y - 50); };
  Ocean chart(cells, constant({0, 0, 0}), grows),
      globe(cells, constant({0, 0, 0}), grows, {}, true);
  const std::vector<Vec3d> seeds(60, Vec3d{1, 50, -20000});
  for (const bool varies : {false, true}) {
    Effects effects = walk(2000, 2, 3600);
    effects.geocentric = false;
    if (varies)
      effects.diffusion->horizontal.field = effects.diffusion->vertical.field =
          advect::FieldInTime{chart.scalar(), {}};
    const double time = varies ? 1e4 : 4e5;
    const Tracer a = chart.run(effects, seeds, time, 2);
    effects.geocentric = true;
    if (varies)
      effects.diffusion->horizontal.field = effects.diffusion->vertical.field =
          advect::FieldInTime{globe.scalar(), {}};
    const Tracer b = globe.run(effects, in_space(seeds), time, 2);
    double apart = 0.0, way = 0.0;
    for (std::size_t i = 0; i < seeds.size(); ++i) {
      apart = std::max(apart, distance(b.positions()[i], Ocean::geocentric_of(a.positions()[i])));
      way = std::max(way, distance(b.positions()[i], Ocean::geocentric_of(seeds[i])));
    }
    EXPECT_GT(way, varies ? 5000 : 50000);
    EXPECT_LT(apart, varies ? 0.01 * way : 1e-4); // cells have other values of the field within
  }
}

// With one coefficient K the walk is Brownian motion in space, whatever is level: the mean place is
// the seed, the mean squares are 2 K t. A third of K's drift upwards would move the mean by 3 of
// its deviations.
TEST(Geocentric, AnIsotropicWalkIsBrownianInSpace) {
  Ocean earth = planet(constant({0, 0, 0}), {-5.6e6, -3e6, 0, 3e6, 6e6});
  earth.settings.integrator.method = advect::Method::euler;
  const double k = 5e5, time = 1e6, variance = 2 * k * time; // 1000 km: 0.16 of the radius
  const std::size_t n = 3000;
  for (const Vec3d& seed : {Vec3d{30, 40, 0}, Vec3d{0, 90, 0}}) {
    const Vec3d from = Ocean::geocentric_of(seed);
    const Tracer t = earth.run(walk(k, k, time / 80), std::vector<Vec3d>(n, from), time);
    ASSERT_EQ(t.counts().alive(), std::int64_t(n));
    Vec3d mean;
    double squares[3] = {};
    for (const Vec3d& x : t.positions()) {
      mean += (x - from) / double(n);
      for (int a = 0; a < 3; ++a)
        squares[a] += (x[a] - from[a]) * (x[a] - from[a]) / double(n);
    }
    const double deviation = std::sqrt(variance / double(n));
    for (int a = 0; a < 3; ++a) {
      EXPECT_LT(std::abs(mean[a]), 3.5 * deviation) << a;
      EXPECT_LT(std::abs(squares[a] - variance), 4 * variance * std::sqrt(2 / double(n))) << a;
    }
    EXPECT_GT(variance / advect::length_of(from), 8 * deviation); // the drift of 2 K / R
  }
}

// Upright alone: the distance r from the normals' common centre is Bessel's process of dimension 3,
// for which the mean of r^2 grows by 6 K t (without the drift of 2 K / r, by 2 K t).
TEST(Geocentric, AnUprightWalkIsBesselsProcess) {
  Ocean earth = planet(constant({0, 0, 0}), {-5.6e6, -3e6, 0, 3e6, 6e6});
  earth.settings.integrator.method = advect::Method::euler;
  const double k = 5e5, time = 1e6, variance = 2 * k * time;
  const std::size_t n = 3000;
  const Vec3d seed{30, 40, 0}, from = Ocean::geocentric_of(seed);
  const geo::Upright at = geo::upright(from);
  const geo::Radii radii = geo::radii(at.normal.z);
  // 1/(N + h) + 1/(M + h) is 2 / r to 1e-5 if r is their harmonic mean at the seed.
  const double r0 = 2 / (1 / radii.across + 1 / radii.along);
  const Tracer t = earth.run(walk(0, k, time / 80), std::vector<Vec3d>(n, from), time);
  double grown = 0;
  for (const Vec3d& x : t.positions()) {
    const geo::Upright there = geo::upright(x);
    EXPECT_LT(distance(there.normal, at.normal), 1e-13);
    grown += ((r0 + there.height) * (r0 + there.height) - r0 * r0) / double(n);
  }
  const double deviation = 2 * r0 * std::sqrt(variance / double(n));
  EXPECT_LT(std::abs(grown - 3 * variance), 3.5 * deviation);
  EXPECT_GT(2 * variance, 8 * deviation); // what the drift does
}

TEST(Geocentric, ALevelWalkKeepsItsHeight) {
  Ocean earth = planet();
  earth.settings.integrator.method = advect::Method::euler;
  const double k = 5e5, time = 1e6; // steps of 110 km, which straight on would rise by 1 km each
  for (const Vec3d& seed : {Vec3d{30, 40, -5e4}, Vec3d{0, -90, -5e4}}) {
    const std::vector<Vec3d> seeds(500, Ocean::geocentric_of(seed));
    const Tracer t = earth.run(walk(k, 0, time / 80), seeds, time);
    double squares = 0;
    for (const Vec3d& x : t.positions()) {
      EXPECT_NEAR(geo::upright(x).height, -5e4, 1e-6);
      squares += dot(x - seeds[0], x - seeds[0]) / double(seeds.size());
    }
    // Chords of the sphere: 2 R^2 (1 - exp(-2 K t / R^2)), and the ellipsoid's 0.7 %.
    const double r = advect::length_of(seeds[0]),
                 expected = 2 * r * r * -std::expm1(-2 * k * time / (r * r));
    EXPECT_NEAR(squares, expected, (4 / std::sqrt(500.0) + 0.01) * expected);
  }
}

// Where the coefficient varies with height, and walls reflect, what is even by volume stays so.
TEST(Geocentric, MixedParticlesStayMixed) {
  const TestMesh cells = fixtures::lattice({.west = 10,
                                            .south = -20,
                                            .east = 50,
                                            .north = 20,
                                            .across = 10,
                                            .along = 10,
                                            .levels = {-3e6, -2.5e6, -2e6, -1.5e6, -1e6, -5e5, 0}});
  const auto varies = [](const Vec3d& p) {
    return 1e6 * (0.2 + std::pow(std::sin(p.z / 3e6 * std::numbers::pi), 2));
  };
  Ocean earth(cells, constant({0, 0, 0}), varies, {}, true);
  earth.settings.integrator.method = advect::Method::euler;
  const auto even = [&](std::uint64_t seed, std::size_t n) {
    std::vector<Vec3d> points;
    for (std::uint64_t i = 0; points.size() < n; ++i) {
      Vec3d x;
      for (int a = 0; a < 3; ++a)
        x[a] = 6.4e6 * (core::random_unit(seed, i, std::uint64_t(a)) - (a == 2 ? 0.5 : 0.0));
      if (earth.sampler().locate(x))
        points.push_back(x);
    }
    return points;
  };
  constexpr int bins = 12;
  const auto counts = [&](std::span<const Vec3d> points) {
    std::vector<double> count(bins, 0.0);
    for (const Vec3d& x : points)
      ++count[std::size_t(std::clamp(int(-geo::upright(x).height / 3e6 * bins), 0, bins - 1))];
    return count;
  };
  const std::vector<double> expected = counts(even(5, 60000));
  const auto chi = [&](std::span<const Vec3d> points) {
    const std::vector<double> count = counts(points);
    double sum = 0.0;
    for (int b = 0; b < bins; ++b) {
      const double e = expected[std::size_t(b)] * double(points.size()) / 60000;
      sum += (count[std::size_t(b)] - e) * (count[std::size_t(b)] - e) / e;
    }
    return sum;
  };
  Effects effects = walk(4e5, 0, 2e3);
  effects.diffusion->vertical.field = advect::FieldInTime{earth.scalar(), {}};
  const std::vector<Vec3d> seeds = even(6, 2000);
  EXPECT_LT(chi(seeds), 43.0); // exceeded once in 1e5
  const Tracer t = earth.run(effects, seeds, 6e5, 1);
  EXPECT_EQ(t.counts().alive(), 2000);
  EXPECT_LT(chi(t.positions()), 43.0);
}

TEST(Geocentric, StepsOfTheWalkAreMeasuredInLevelsAndHeights) {
  // Layers of 2000 m at 45 degrees, 22 km wide: a walk that goes upright takes a part of 2000 m,
  // not of the cells' boxes along x, y and z.
  const TestMesh cells = fixtures::lattice({.west = 30,
                                            .south = 44,
                                            .east = 32,
                                            .north = 46,
                                            .across = 10,
                                            .along = 10,
                                            .levels = {-4000, -2000, 0}});
  Ocean earth(cells, constant({0, 0, 0}), {}, {}, true);
  const std::vector<Vec3d> seeds{Ocean::geocentric_of({31.01, 45.01, -1500})};
  Effects effects = walk(0, 1.0, 0);
  earth.run(effects, seeds, 1e7);
  const double expected = 1e7 / (1000.0 * 1000.0 / 2.0);
  EXPECT_NEAR(double(earth.work.walk_steps), expected, 1.0);
}

TEST(Geocentric, TracksAreTheSameForAnyThreads) {
  Ocean earth = planet(towards({1, 2, 3}));
  std::vector<Vec3d> seeds;
  for (int i = 0; i < 100; ++i)
    seeds.push_back(Ocean::geocentric_of({3.6 * i, 89.0 - 1.8 * i, -1e5}));
  Effects effects = walk(1e5, 10, 0);
  effects.drifts.emplace_back();
  effects.drifts[0].constant = {0, 0, -0.1};
  effects.drifts[0].is_local = true;
  const core::Threads one(1), many(4);
  const Tracer a = earth.run(effects, seeds, 3e5, 3, &one),
               b = earth.run(effects, seeds, 3e5, 3, &many);
  EXPECT_EQ(std::memcmp(a.positions().data(), b.positions().data(), seeds.size() * sizeof(Vec3d)),
            0);
  EXPECT_EQ(a.counts().sum(), 100);
}

} // namespace
} // namespace insitu::test
