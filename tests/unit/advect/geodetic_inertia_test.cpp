// Particles with a velocity of their own on meshes in longitude and latitude.
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>

#include "core/random.h"
#include "earth_flow.h"

namespace insitu::test {
namespace {

using advect::AtBoundary;
using advect::Effects;
using advect::Tracer;

Effects inertial(double response_time, const Vec3d& acceleration, const Vec3d& begins) {
  Effects effects;
  effects.inertia.emplace();
  effects.inertia->response_time = response_time;
  effects.inertia->acceleration = acceleration;
  effects.inertia->begins = begins;
  return effects;
}

fixtures::Lattice lattice_of(const geo::ChartUnits& units = {}) {
  return {.units = units, .across = 36, .along = 18, .levels = {-4000, -2000, 0}};
}

TEST(GeodeticInertia, GravityPointsDown) {
  // From rest: v = v_t (1 - exp(-t / tau)), z = z0 + v_t (t - tau (1 - exp(-t / tau))).
  for (const bool other : {false, true}) {
    const geo::ChartUnits units{.radians = other, .kilometres = other, .down = other};
    Ocean sea(fixtures::lattice(lattice_of(units)), constant({0, 0, 0}), {}, units);
    std::vector<Vec3d> seeds;
    for (const Vec3d& p : {Vec3d{20, 60, -10}, Vec3d{179.99, -30, -1995}, Vec3d{40, 89.99, -10}})
      seeds.push_back(fixtures::in_units(units, p));
    for (const double tau : {1e-6, 30.0, 5000.0}) {
      const double fall = -0.5, time = 1000, decay = 1 - std::exp(-time / tau);
      const Tracer t = sea.run(inertial(tau, {0, 0, fall / tau}, {0, 0, 0}), seeds, time, 3);
      for (std::size_t i = 0; i < seeds.size(); ++i) {
        const double moved = (t.positions()[i].z - seeds[i].z) * units.up_per_unit();
        EXPECT_NEAR(moved, fall * (time - tau * decay), 1e-8) << tau << " " << i;
        EXPECT_NEAR(t.particles().velocities[i].z, fall * decay, 1e-9) << tau;
        const Vec3d n = geo::normal_of(units, t.positions()[i]) - geo::normal_of(units, seeds[i]);
        EXPECT_LT(std::sqrt(dot(n, n)), 1e-14);
      }
    }
  }
}

/// A free particle by the equations in the Earth's axes: n' = east/(N + h) e + north/(M + h) n, the
/// acceleration -2 omega x v, and what keeps a velocity level level. Returns its normal.
struct Free {
  Vec3d normal, level; ///< velocity along the surface, in the Earth's axes
  double height, up;
};
Free fly_free(Free s, const Vec3d& omega, double time) {
  const auto rate = [&](const Free& f) {
    const geo::EastNorth axes = geo::east_north(f.normal);
    const geo::Radii r = geo::radii(f.normal.z);
    const Vec3d turns = (dot(f.level, axes.east) / (r.across + f.height)) * axes.east +
                        (dot(f.level, axes.north) / (r.along + f.height)) * axes.north;
    const Vec3d a = -2.0 * cross(omega, f.level + f.up * f.normal);
    const double rises = dot(a, f.normal);
    return Free{turns, a - rises * f.normal - dot(f.level, turns) * f.normal, f.up, rises};
  };
  const auto add = [](const Free& f, double h, const Free& d) {
    return Free{f.normal + h * d.normal, f.level + h * d.level, f.height + h * d.height,
                f.up + h * d.up};
  };
  const int n = 20000;
  const double h = time / n;
  for (int i = 0; i < n; ++i) { // Runge and Kutta's method
    const Free a = rate(s), b = rate(add(s, h / 2, a)), c = rate(add(s, h / 2, b)),
               d = rate(add(s, h, c));
    s = add(add(add(add(s, h / 6, a), h / 3, b), h / 3, c), h / 6, d);
    s.normal = s.normal / std::sqrt(dot(s.normal, s.normal));
  }
  return s;
}

TEST(GeodeticInertia, FreeParticlesAndInertialCirclesWhereverThePoleIs) {
  // Without a rotation along great circles; with the Earth's in inertial circles, of 160 km at 60
  // degrees, over the date line and around and over the poles. On lattices and on turned charts.
  const double infinity = std::numeric_limits<double>::infinity();
  const std::vector<double> levels{-1e6, 0, 1e6}; // without gravity the rotation lifts them
  const TestMesh meshes[] = {fixtures::lattice({.across = 36, .along = 18, .levels = levels}),
                             fixtures::globe({.subdivisions = 3, .tilt = 0.3, .levels = levels})};
  const std::vector<Vec3d> seeds{{20, 60, -2500},
                                 {179.9, -50, -2500},
                                 {30, 88.5, -2500},
                                 {-100, -89.9, -2500},
                                 {10, 5, -2500}};
  const Vec3d begins{12, 16, 0};
  for (const TestMesh& mesh : meshes) {
    Ocean sea(mesh, constant({0, 0, 0}));
    sea.settings.integrator.tolerance = 1e-6;
    for (const double omega : {0.0, 7.292115e-5}) {
      Effects effects = inertial(infinity, {0, 0, 0}, begins);
      effects.inertia->rotation = {0, 0, omega};
      const double time = 50000;
      const Tracer t = sea.run(effects, seeds, time, 3);
      for (std::size_t i = 0; i < seeds.size(); ++i) {
        ASSERT_EQ(t.particles().endings[i], INSITU_END_ALIVE);
        const geo::ChartPlace at = geo::place_of({}, geo::Pole::none, seeds[i]);
        const Free want =
            fly_free({at.normal, begins.x * at.east + begins.y * at.north, seeds[i].z, 0.0},
                     {0, 0, omega}, time);
        const Vec3d n = geo::normal_of({}, t.positions()[i]), away = n - want.normal;
        // Of a way of 1000 km: steps of a cell at most; the rotation changes on the way.
        EXPECT_LT(std::sqrt(dot(away, away)) * 6.4e6, 300) << omega << " " << i;
        EXPECT_NEAR(t.positions()[i].z, want.height, 1e-3 * std::abs(want.height + 2500) + 1e-6);
        const geo::EastNorth axes = geo::east_north(n);
        const Vec3d v = t.particles().velocities[i];
        const Vec3d level = v.x * axes.east + v.y * axes.north - want.level;
        EXPECT_LT(std::sqrt(dot(level, level)), 2e-3) << omega << " " << i;
      }
    }
  }
}

TEST(GeodeticInertia, WithAShortResponseTimeFollowTheFlow) {
  // Over both poles of a globe whose cells there are on turned charts.
  const Vec3d omega = 2e-6 * Vec3d{0.6, 0.64, 0.48};
  Ocean sea(fixtures::globe({.subdivisions = 3, .tilt = 0.3, .levels = {-4000, -2000, 0}}),
            [&](const Vec3d& at) {
              const geo::ChartPlace place = geo::place_of({}, geo::Pole::none, at);
              const Vec3d v = 6.4e6 * cross(omega, place.normal);
              return Vec3d{dot(v, place.east), dot(v, place.north), 0};
            });
  sea.settings.integrator.tolerance = 1e-3;
  std::vector<Vec3d> seeds;
  for (std::uint64_t i = 0; i < 30; ++i)
    seeds.push_back({core::random_unit(3, i, 0) * 360 - 180,
                     i % 3 ? std::copysign(70 + 20 * core::random_unit(3, i, 1), i % 2 ? 1 : -1)
                           : 120 * core::random_unit(3, i, 1) - 60,
                     -10 - 3000 * core::random_unit(3, i, 2)});
  const Tracer tracer = sea.run({}, seeds, 5e5, 3);
  Effects effects;
  effects.inertia.emplace();
  effects.inertia->response_time = 1.0;
  const core::Threads one(1), many(4);
  const Tracer t = sea.run(effects, seeds, 5e5, 3, &many);
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    EXPECT_EQ(t.particles().endings[i], INSITU_END_ALIVE);
    const Vec3d away =
        geo::normal_of({}, t.positions()[i]) - geo::normal_of({}, tracer.positions()[i]);
    // Both err by 1e-3 m/s times the time; at kinks of the interpolation by some more.
    EXPECT_LT(std::sqrt(dot(away, away)) * 6.4e6, 5000) << i;
    EXPECT_NEAR(t.positions()[i].z, seeds[i].z, 1e-6);
  }
  const Tracer again = sea.run(effects, seeds, 5e5, 3, &one);
  EXPECT_EQ(
      std::memcmp(t.positions().data(), again.positions().data(), seeds.size() * sizeof(Vec3d)), 0);
}

TEST(GeodeticInertia, BallsBounceOnTheFloorAndComeToRestThere) {
  for (const bool other : {false, true}) {
    const geo::ChartUnits units{.radians = other, .kilometres = other, .down = other};
    Ocean sea(fixtures::lattice(lattice_of(units)), constant({0, 0, 0}), {}, units);
    Effects effects = inertial(std::numeric_limits<double>::infinity(), {0, 0, -2}, {0, 0, 0});
    effects.boundary.emplace();
    effects.boundary->response = AtBoundary::reflect;
    const std::vector<Vec3d> seeds{fixtures::in_units(units, {20, 60, -3900}),
                                   fixtures::in_units(units, {-170, -89.5, -3900})};
    const double fall = 10; // sqrt(2 z / g)
    const auto height = [&](const Tracer& t, std::size_t i) {
      return t.positions()[i].z * units.up_per_unit() + 4000;
    };
    for (std::size_t i = 0; i < 2; ++i) {
      effects.boundary->restitution = 1.0;
      EXPECT_NEAR(height(sea.run(effects, seeds, 2 * fall, 3), i), 100, 1e-3);
      EXPECT_NEAR(height(sea.run(effects, seeds, 3.5 * fall, 3), i), 75, 1e-3);
      effects.boundary->restitution = 0.5;
      EXPECT_NEAR(height(sea.run(effects, seeds, 1.5 * fall), i), 25, 1e-3);
      const Tracer t = sea.run(effects, seeds, 3.5 * fall, 2); // rests from 3 falls on
      EXPECT_EQ(t.particles().endings[i], INSITU_END_ALIVE);
      EXPECT_NEAR(height(t, i), 0, 5e-3);
      EXPECT_LT(sea.work.contacts, 1000);
    }
  }
}

} // namespace
} // namespace insitu::test
