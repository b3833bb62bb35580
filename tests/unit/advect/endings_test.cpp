// Every way in which a particle ends, and where.
#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "analytic.h"

namespace insitu::test {
namespace {

using advect::IntegratorSettings;
using advect::Method;

constexpr double infinity = std::numeric_limits<double>::infinity();

class BothMethods : public ::testing::TestWithParam<Method> {
protected:
  BothMethods() { settings.method = GetParam(); }
  IntegratorSettings settings;
};
INSTANTIATE_TEST_SUITE_P(Endings, BothMethods, ::testing::Values(Method::rk4, Method::dopri5),
                         [](const auto& method) {
                           return method.param == Method::rk4 ? "rk4" : "dopri5";
                         });

TEST_P(BothMethods, LeavesOnTheFace) {
  // A circle about the cube's corner (0, 0): leaves through x = 0 at a known point and time.
  auto field = in_unit_cube(rotation);
  const Outcome r = run(field, settings, {0.6, 0.1, 0.5}, infinity);
  const double radius = std::hypot(0.6, 0.1);
  EXPECT_EQ(r.ending, INSITU_END_LEFT);
  EXPECT_GE(r.p.x.x, 0.0);
  EXPECT_LE(r.p.x.x, settings.exit_tolerance * 0.1);
  EXPECT_NEAR(r.p.x.y, radius, GetParam() == Method::rk4 ? 1e-6 : 1e-7);
  EXPECT_NEAR(r.p.time, M_PI / 2 - std::atan2(0.1, 0.6), 3e-6);
}

TEST_P(BothMethods, LeavesOnTheFaceWhateverTheSpeed) {
  for (const double speed : {1e-30, 1e-3, 1.0, 1e3, 1e30, 1e300}) {
    const auto oblique = [&](const Vec3d&, double) {
      return Vec3d{speed, 0.25 * speed, -0.5 * speed};
    };
    auto field = in_unit_cube(oblique);
    const Outcome r = run(field, settings, {0.35, 0.5, 0.95}, infinity);
    EXPECT_EQ(r.ending, INSITU_END_LEFT) << speed;
    EXPECT_LE(r.p.x.x, 1.0);
    EXPECT_NEAR(r.p.x.x, 1.0, settings.exit_tolerance * 0.1) << speed;
    EXPECT_NEAR(r.p.x.y, 0.6625, 1e-9) << speed;
    EXPECT_NEAR(r.p.time * speed, 0.65, 1e-9) << speed;
    EXPECT_LT(r.work.evaluations, 1500) << speed;
  }
}

TEST_P(BothMethods, FarFromTheOriginExitsEndToo) {
  // Coordinates of 6e6 with cells of a metre: rounding is coarser than exit_tolerance.
  Analytic field{[](const Vec3d&, double) {
                   return Vec3d{1.0, 0.3, 0.1};
                 },
                 {6e6, 6e6, 6e6},
                 {6e6 + 10, 6e6 + 10, 6e6 + 10},
                 {1, 1, 1}};
  const Outcome r = run(field, settings, {6e6 + 5.1, 6e6 + 5, 6e6 + 5}, infinity);
  EXPECT_EQ(r.ending, INSITU_END_LEFT);
  EXPECT_NEAR(r.p.x.x, 6e6 + 10, 2e-9);
}

TEST_P(BothMethods, GrazingStagesDoNotEndAParticle) {
  // Straight stages overshoot the circle's wall at y = 1, the path only touches it.
  auto arc = in_unit_cube([](const Vec3d& x, double) { return Vec3d{x.y - 0.5, 0.5 - x.x, 0.0}; });
  arc.high = {1, 0.9 + 1e-4,
              1}; // clockwise, radius 0.4 about the centre: passes 1e-4 below the wall
  arc.cell = {0.3, 0.3, 0.3};
  const Outcome r =
      run(arc, settings, {0.5 - 0.4 * std::sin(1.0), 0.5 + 0.4 * std::cos(1.0), 0.5}, 2.0);
  EXPECT_EQ(r.ending, INSITU_END_ALIVE);
  EXPECT_NEAR(r.p.x.x, 0.5 + 0.4 * std::sin(1.0), 1e-4);
  EXPECT_NEAR(r.p.x.y, 0.5 + 0.4 * std::cos(1.0), 1e-4);
}

TEST_P(BothMethods, SeedOutside) {
  auto field = in_unit_cube(rotation);
  const Outcome r = run(field, settings, {1.5, 0.5, 0.5}, 1.0);
  EXPECT_EQ(r.ending, INSITU_END_SEED_OUTSIDE);
  EXPECT_EQ(r.work.evaluations, 1);
  EXPECT_EQ(r.p.x, (Vec3d{1.5, 0.5, 0.5}));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(run(field, settings, {nan, 0.5, 0.5}, 1.0).ending, INSITU_END_SEED_OUTSIDE);
}

TEST_P(BothMethods, AParticleThatWasInsideHasLeftInstead) {
  auto field = in_unit_cube(rotation);
  advect::State p;
  p.x = {1.5, 0.5, 0.5};
  p.fresh = false;
  advect::Work work;
  EXPECT_EQ(advect::integrate(field, settings, 1.0, infinity, p, work, [](const auto&) {}),
            INSITU_END_LEFT);
}

TEST_P(BothMethods, ZeroVelocity) {
  auto still = in_unit_cube([](const Vec3d&, double) { return Vec3d{}; });
  const Vec3d seed{0.5, 0.5, 0.5};
  // Unsteady: it rests and lives.
  const Outcome waits = run(still, settings, seed, 1.0);
  EXPECT_EQ(waits.ending, INSITU_END_ALIVE);
  EXPECT_EQ(waits.p.x, seed);
  EXPECT_EQ(waits.p.time, 1.0);
  // Steady: it will never move.
  settings.ends_at_rest = true;
  EXPECT_EQ(run(still, settings, seed, 1.0).ending, INSITU_END_STAGNATED);
  EXPECT_EQ(run(still, settings, seed, infinity).ending, INSITU_END_STAGNATED);
}

TEST_P(BothMethods, AParticleAtRestStartsWithTheFlow) {
  // Still until t = 0.5, then 0.4 along x.
  auto field = in_unit_cube([](const Vec3d&, double t) {
    return Vec3d{t < 0.5 ? 0.0 : 0.4, 0, 0};
  });
  settings.max_step = 0.01;
  const Outcome r = run(field, settings, {0.5, 0.5, 0.5}, 1.0);
  EXPECT_EQ(r.ending, INSITU_END_ALIVE);
  EXPECT_NEAR(r.p.x.x, 0.7, 0.4 * 0.01);
}

TEST_P(BothMethods, VelocityThatGrowsWithinTheStepDoesNotJumpCells) {
  // At rest at t = 0, 1000 at t = 1; the wall with the gap is 0.1 away.
  auto field = in_unit_cube([](const Vec3d&, double t) { return Vec3d{1000.0 * t, 0, 0}; });
  settings.tolerance = 1e9;
  double longest = 0.0, last = 0.05;
  advect::State p;
  p.x = {0.05, 0.5, 0.5};
  advect::Work work;
  EXPECT_EQ(advect::integrate(field, settings, 1.0, infinity, p, work,
                              [&](const advect::State& s) {
                                longest = std::max(longest, s.x.x - last);
                                last = s.x.x;
                              }),
            INSITU_END_LEFT);
  EXPECT_LE(longest, 0.2);
}

TEST_P(BothMethods, TinyVelocity) {
  auto field = in_unit_cube([](const Vec3d&, double) { return Vec3d{1e-30, 0, 0}; });
  const Vec3d seed{0.5, 0.5, 0.5};
  EXPECT_EQ(run(field, settings, seed, 1.0).ending, INSITU_END_ALIVE);
  settings.ends_at_rest = true;
  EXPECT_EQ(run(field, settings, seed, 1.0).ending, INSITU_END_STAGNATED);
  EXPECT_EQ(run(field, settings, seed, infinity).ending, INSITU_END_LEFT);
}

TEST_P(BothMethods, SinkStagnates) {
  auto field = in_unit_cube([](const Vec3d& x, double) { return Vec3d{0.5, 0.5, 0.5} - x; });
  settings.ends_at_rest = true;
  const Outcome r = run(field, settings, {0.9, 0.2, 0.6}, infinity);
  EXPECT_EQ(r.ending, INSITU_END_STAGNATED);
  EXPECT_LT(distance(r.p.x, {0.5, 0.5, 0.5}), 1e-8);
  EXPECT_LT(r.work.steps, 500);
}

TEST_P(BothMethods, NotFiniteAtTheSeed) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), infinity, -infinity}) {
    auto field = in_unit_cube([&](const Vec3d&, double) { return Vec3d{0.1, bad, 0.0}; });
    const Outcome r = run(field, settings, {0.5, 0.5, 0.5}, 1.0);
    EXPECT_EQ(r.ending, INSITU_END_NOT_FINITE);
    EXPECT_EQ(r.p.x, (Vec3d{0.5, 0.5, 0.5}));
  }
}

TEST_P(BothMethods, NotFiniteOnTheWayEndsWhereItBegins) {
  auto field = in_unit_cube([&](const Vec3d& x, double) {
    return Vec3d{x.x > 0.7 ? std::numeric_limits<double>::quiet_NaN() : 1.0, 0.0, 0.0};
  });
  const Outcome r = run(field, settings, {0.05, 0.5, 0.5}, 10.0);
  EXPECT_EQ(r.ending, INSITU_END_NOT_FINITE);
  EXPECT_LE(r.p.x.x, 0.7);
  EXPECT_NEAR(r.p.x.x, 0.7, 1e-10);
}

TEST_P(BothMethods, SpeedThatOverflowsIsNotFinite) {
  const double huge = std::numeric_limits<double>::max();
  auto field = in_unit_cube([&](const Vec3d&, double) { return Vec3d{huge, huge, huge} * 0.99; });
  EXPECT_EQ(run(field, settings, {0.5, 0.5, 0.5}, 1.0, 3.0).ending, INSITU_END_NOT_FINITE);
}

TEST_P(BothMethods, StepLimit) {
  auto field = in_unit_cube([](const Vec3d& x, double) {
    return rotation(x - Vec3d{0.5, 0.5, 0}, 0);
  });
  settings.max_steps = 37;
  const Outcome r = run(field, settings, {0.7, 0.5, 0.5}, infinity);
  EXPECT_EQ(r.ending, INSITU_END_STEP_LIMIT);
  EXPECT_EQ(r.work.steps, 37);
}

TEST_P(BothMethods, LengthLimit) {
  // Round and round, at a speed that depends on the angle.
  auto field = in_unit_cube([](const Vec3d& x, double) {
    const Vec3d d = x - Vec3d{0.5, 0.5, 0.5};
    return rotation(d, 0) * (2.0 + d.x / 0.3);
  });
  settings.tolerance = 1e-8;
  for (const double length : {1e-3, 0.1, 5.0}) {
    const Outcome r = run(field, settings, {0.8, 0.5, 0.5}, infinity, length);
    EXPECT_EQ(r.ending, INSITU_END_EXPIRED);
    EXPECT_NEAR(r.p.length, length, 1e-9 * length);
    const double angle = std::atan2(r.p.x.y - 0.5, r.p.x.x - 0.5);
    // Chords are shorter than the arc, by (step/radius)^2/24 of it.
    EXPECT_NEAR(std::remainder(angle - length / 0.3, 2 * M_PI), 0.0, 0.01 * length / 0.3);
  }
}

TEST_P(BothMethods, MovingWallMeetsAParticleAtRest) {
  // The mesh recedes past the particle at t = 0.625.
  struct Receding {
    Sampled operator()(const Vec3d& x, double t, Vec3d& v) {
      v = {};
      return x.x >= t ? Sampled::inside : Sampled::outside;
    }
    void accepted() {}
    Vec3d extent() const { return {0.1, 0.1, 0.1}; }
  } field;
  const Outcome r = run(field, settings, {0.625, 0.5, 0.5}, 1.0);
  EXPECT_EQ(r.ending, INSITU_END_LEFT);
  EXPECT_NEAR(r.p.time, 0.625, 1e-8);
}

TEST_P(BothMethods, NeverEndless) {
  // A field that is different at every question: whatever comes out, it comes out.
  struct Noise {
    std::uint64_t state = 7;
    double next() {
      state = state * 6364136223846793005ull + 1442695040888963407ull;
      return double(std::int64_t(state)) * 0x1p-63;
    }
    Sampled operator()(const Vec3d&, double, Vec3d& v) {
      const double kind = next();
      v = Vec3d{next(), next(), next()} * std::pow(10.0, 300.0 * next());
      return kind > 0.9 ? Sampled::outside : kind > 0.8 ? Sampled::not_finite : Sampled::inside;
    }
    void accepted() {}
    Vec3d extent() const { return {0.1, 0.1, 0.1}; }
  } field;
  settings.max_steps = 1000;
  std::int64_t evaluations = 0;
  for (int i = 0; i < 200; ++i)
    evaluations += run(field, settings, {0.5, 0.5, 0.5}, i % 2 ? 1.0 : infinity).work.evaluations;
  EXPECT_LT(evaluations, 200 * 1000 * 100);
}

} // namespace
} // namespace insitu::test
