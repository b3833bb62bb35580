// Orders of convergence and the error control, on flows with known answers.
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "analytic.h"
#include "core/random.h"

namespace insitu::test {
namespace {

using advect::IntegratorSettings;
using advect::Method;

/// n equal steps over [0, to] with one of the two methods, without error control.
template <class F>
Vec3d march(Method method, F f, Vec3d x, double to, int n) {
  auto field = unbounded(f);
  Vec3d v;
  field(x, 0.0, v);
  const double h = to / n;
  for (int i = 0; i < n; ++i) {
    const advect::Trial trial = method == Method::rk4 ? advect::rk4_step(field, x, i * h, h, v)
                                                      : advect::dopri5_step(field, x, i * h, h, v);
    x = trial.x;
    v = trial.v;
  }
  return x;
}

/// The order seen in the root mean square error over seeds when the step is halved, from n steps
/// on; it must hold twice in a row. end(seed) is the reference.
template <class F, class End>
void expect_order(Method method, F f, End end, double to, int n, double order) {
  double errors[3] = {};
  for (int s = 0; s < 16; ++s) {
    Vec3d seed;
    for (int a = 0; a < 3; ++a)
      seed[a] = 2.0 * core::random_unit(42, std::uint64_t(s), std::uint64_t(a)) - 1.0;
    const Vec3d reference = end(seed);
    for (int i = 0; i < 3; ++i) {
      const double error = distance(march(method, f, seed, to, n << i), reference);
      errors[i] += error * error / 16;
    }
  }
  EXPECT_GT(std::sqrt(errors[2]), 1e-13) << "rounding hides the order";
  for (int i = 0; i < 2; ++i)
    EXPECT_NEAR(0.5 * std::log2(errors[i] / errors[i + 1]), order, 0.35)
        << "errors " << std::sqrt(errors[i]) << ", " << std::sqrt(errors[i + 1]);
}

TEST(Order, RigidRotation) {
  const auto end = [](const Vec3d& x) {
    return Vec3d{std::cos(3.0) * x.x - std::sin(3.0) * x.y,
                 std::sin(3.0) * x.x + std::cos(3.0) * x.y, x.z};
  };
  expect_order(Method::rk4, rotation, end, 3.0, 16, 4.0);
  expect_order(Method::dopri5, rotation, end, 3.0, 16, 5.0);
}

TEST(Order, UnsteadyAbcFlow) {
  const auto end = [](const Vec3d& x) { return march(Method::dopri5, abc_flow, x, 2.0, 2000); };
  // The reference does not rest on the method under test alone.
  const Vec3d seed{0.3, 1.1, -0.4};
  ASSERT_LT(distance(march(Method::rk4, abc_flow, seed, 2.0, 5000), end(seed)), 1e-12);
  expect_order(Method::rk4, abc_flow, end, 2.0, 80, 4.0);
  expect_order(Method::dopri5, abc_flow, end, 2.0, 40, 5.0);
}

TEST(Order, TimeAloneIsIntegratedExactlyUpToTheOrder) {
  // Quadrature of t^3 (rk4) and t^4 (dopri5): wrong stage times would show at once.
  const auto cubic = [](const Vec3d&, double t) { return Vec3d{t * t * t, 0, 0}; };
  const auto quartic = [](const Vec3d&, double t) { return Vec3d{t * t * t * t, 0, 0}; };
  EXPECT_NEAR(march(Method::rk4, cubic, {0, 0, 0}, 2.0, 1).x, 4.0, 1e-14);
  EXPECT_NEAR(march(Method::dopri5, quartic, {0, 0, 0}, 2.0, 1).x, 6.4, 1e-14);
}

TEST(Order, ErrorEstimateIsOfOrderFourPerUnitTime) {
  auto field = unbounded(abc_flow);
  const Vec3d seed{0.3, 1.1, -0.4};
  Vec3d v;
  field(seed, 0.0, v);
  const double coarse = advect::length_of(advect::dopri5_step(field, seed, 0.0, 0.1, v).error);
  const double fine = advect::length_of(advect::dopri5_step(field, seed, 0.0, 0.05, v).error);
  EXPECT_NEAR(std::log2(coarse / fine), 4.0, 0.5);
}

TEST(Order, EvaluationsPerStep) {
  auto field = unbounded(rotation);
  Vec3d v;
  field({1, 0, 0}, 0.0, v);
  field.asked = 0;
  advect::rk4_step(field, {1, 0, 0}, 0.0, 0.1, v);
  EXPECT_EQ(field.asked, 4);
  advect::dopri5_step(field, {1, 0, 0}, 0.0, 0.1, v);
  EXPECT_EQ(field.asked, 10);
}

TEST(ErrorControl, ErrorFollowsTheTolerance) {
  const Vec3d seed{0.3, 1.1, -0.4};
  const double to = 2.0;
  const Vec3d end = march(Method::dopri5, abc_flow, seed, to, 2000);
  double previous_evaluations = 0.0;
  for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10}) {
    IntegratorSettings settings;
    settings.tolerance = tolerance;
    auto field = unbounded(abc_flow);
    const Outcome r = run(field, settings, seed, to);
    ASSERT_EQ(r.ending, INSITU_END_ALIVE);
    EXPECT_EQ(r.p.time, to);
    EXPECT_EQ(r.work.forced, 0);
    EXPECT_EQ(r.work.evaluations, field.asked);
    // The flow stretches errors by exp(L t) at most, L about 2; local extrapolation gains the rest.
    EXPECT_LT(distance(r.p.x, end), 50.0 * tolerance);
    EXPECT_GT(distance(r.p.x, end), 1e-5 * tolerance);
    // Fourth order per unit time: a hundredth of the tolerance costs about 100^(1/4) = 3.2 times.
    if (previous_evaluations > 0.0) {
      EXPECT_LT(double(field.asked) / previous_evaluations, 4.5);
      EXPECT_GT(double(field.asked) / previous_evaluations, 1.5);
    }
    previous_evaluations = double(field.asked);
  }
}

TEST(ErrorControl, FixedStepsAreFixed) {
  IntegratorSettings settings;
  settings.method = Method::rk4;
  settings.step = 0.3;
  auto field = unbounded(rotation);
  const Outcome r = run(field, settings, {1, 0, 0}, 1.0);
  EXPECT_EQ(r.ending, INSITU_END_ALIVE);
  EXPECT_EQ(r.p.time, 1.0);
  EXPECT_EQ(r.work.steps, 4); // 0.3 + 0.3 + 0.3 + 0.1
  Vec3d x{1, 0, 0}, v{0, 1, 0};
  for (const double h : {0.3, 0.3, 0.3, 0.1}) {
    const advect::Trial trial = advect::rk4_step(field, x, 0.0, h, v);
    x = trial.x;
    v = trial.v;
  }
  EXPECT_LT(distance(r.p.x, x), 1e-15);
}

TEST(ErrorControl, StepsAreAtMostOneCellAndMaxStep) {
  const auto shear = [](const Vec3d& x, double) { return Vec3d{1.0 + x.y, 0, 0}; };
  for (const double max_step : {0.0, 0.01}) {
    auto field = in_unit_cube(shear);
    IntegratorSettings settings;
    settings.max_step = max_step;
    settings.tolerance = 1.0; // never the limit
    advect::State p;
    p.x = {0.0, 0.5, 0.5};
    advect::Work work;
    double last = 0.0, longest = 0.0;
    advect::integrate(field, settings, 0.5, 1e9, p, work, [&](const advect::State& s) {
      longest = std::max(longest, s.x.x - last);
      last = s.x.x;
    });
    EXPECT_NEAR(longest, max_step == 0.0 ? 0.1 : 0.015, 1e-12);
  }
}

TEST(ErrorControl, BackwardReturns) {
  for (const Method method : {Method::rk4, Method::dopri5}) {
    IntegratorSettings settings;
    settings.method = method;
    settings.step = method == Method::rk4 ? 1e-3 : 0.0;
    settings.tolerance = 1e-10;
    auto field = unbounded(abc_flow);
    const Vec3d seed{0.3, 1.1, -0.4};
    const Outcome there = run(field, settings, seed, 1.5);
    const Outcome back = run(field, settings, there.p.x, 0.0, 1e9, 1.5);
    EXPECT_EQ(back.ending, INSITU_END_ALIVE);
    EXPECT_EQ(back.p.time, 0.0);
    EXPECT_GT(distance(there.p.x, seed), 1.0);
    EXPECT_LT(distance(back.p.x, seed), 1e-9);
  }
}

TEST(ErrorControl, JumpsOfTheVelocityAreForced) {
  // Piecewise constant, as a cell field: no step across the jump can meet the tolerance.
  const auto jump = [](const Vec3d& x, double) {
    return x.x < 0.55 ? Vec3d{1.0, 0.0, 0.0} : Vec3d{0.5, 0.25, 0.0};
  };
  auto field = in_unit_cube(jump);
  const Outcome r = run(field, IntegratorSettings{}, {0.05, 0.5, 0.5}, 1.0);
  EXPECT_EQ(r.ending, INSITU_END_ALIVE);
  EXPECT_GT(r.work.forced, 0);
  EXPECT_LT(r.work.steps, 200);
  EXPECT_NEAR(r.p.x.x, 0.80, 1e-6); // a millionth of a cell at the jump
  EXPECT_NEAR(r.p.x.y, 0.625, 1e-6);
}

} // namespace
} // namespace insitu::test
