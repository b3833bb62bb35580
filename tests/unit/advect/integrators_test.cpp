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

template <class F>
advect::Trial step(Method method, F& field, const Vec3d& x, double t, double h, const Vec3d& v) {
  switch (method) {
  case Method::euler:
    return advect::trial_of<advect::Euler>(field, x, t, h, v);
  case Method::rk4:
    return advect::trial_of<advect::Rk4>(field, x, t, h, v);
  case Method::bs32:
    return advect::trial_of<advect::Bs32>(field, x, t, h, v);
  default:
    return advect::trial_of<advect::Dopri5>(field, x, t, h, v);
  }
}

/// n equal steps over [0, to] with one of the methods, without error control.
template <class F>
Vec3d march(Method method, F f, Vec3d x, double to, int n) {
  auto field = unbounded(f);
  Vec3d v;
  field(x, 0.0, v);
  const double h = to / n;
  for (int i = 0; i < n; ++i) {
    const advect::Trial trial = step(method, field, x, i * h, h, v);
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
  expect_order(Method::euler, rotation, end, 3.0, 128, 1.0);
  expect_order(Method::rk4, rotation, end, 3.0, 16, 4.0);
  expect_order(Method::bs32, rotation, end, 3.0, 16, 3.0);
  expect_order(Method::dopri5, rotation, end, 3.0, 16, 5.0);
}

TEST(Order, UnsteadyAbcFlow) {
  const auto end = [](const Vec3d& x) { return march(Method::dopri5, abc_flow, x, 2.0, 2000); };
  // The reference does not rest on the method under test alone.
  const Vec3d seed{0.3, 1.1, -0.4};
  ASSERT_LT(distance(march(Method::rk4, abc_flow, seed, 2.0, 5000), end(seed)), 1e-13);
  expect_order(Method::euler, abc_flow, end, 2.0, 1280, 1.0);
  expect_order(Method::rk4, abc_flow, end, 2.0, 80, 4.0);
  expect_order(Method::bs32, abc_flow, end, 2.0, 160, 3.0);
  expect_order(Method::dopri5, abc_flow, end, 2.0, 40, 5.0);
}

TEST(Order, TimeAloneIsIntegratedExactlyUpToTheOrder) {
  // Quadrature of t^3 (rk4) and t^4 (dopri5): wrong stage times would show at once.
  const auto cubic = [](const Vec3d&, double t) { return Vec3d{t * t * t, 0, 0}; };
  const auto quartic = [](const Vec3d&, double t) { return Vec3d{t * t * t * t, 0, 0}; };
  EXPECT_NEAR(march(Method::rk4, cubic, {0, 0, 0}, 2.0, 1).x, 4.0, 1e-14);
  EXPECT_NEAR(march(Method::dopri5, quartic, {0, 0, 0}, 2.0, 1).x, 6.4, 1e-14);
  const auto square = [](const Vec3d&, double t) { return Vec3d{t * t, 0, 0}; };
  EXPECT_NEAR(march(Method::bs32, square, {0, 0, 0}, 2.0, 1).x, 8.0 / 3, 1e-14);
}

/// Stream function of Hill's spherical vortex of radius 1 in polar coordinates (Lamb, section 165),
/// inside: psi = 3/4 r^2 (1 - r^2 - z^2); u = psi_r / r along z, -psi_z / r outwards.
double hill_stream(const Vec3d& x) {
  const double r2 = x.x * x.x + x.y * x.y;
  return 0.75 * r2 * (1 - r2 - x.z * x.z);
}
Vec3d hill_vortex(const Vec3d& x, double) {
  const double r2 = x.x * x.x + x.y * x.y;
  return {1.5 * x.z * x.x, 1.5 * x.z * x.y, 1.5 * (1 - 2 * r2 - x.z * x.z)};
}

TEST(Order, HillsVortexKeepsItsStreamFunction) {
  const Vec3d seed{0.6, 0.2, 0.1};
  const struct {
    Method method;
    int n;
    double order;
  } cases[] = {{Method::euler, 4000, 1},
               {Method::bs32, 200, 3},
               {Method::rk4, 100, 4},
               {Method::dopri5, 60, 5}};
  for (const auto& c : cases) {
    double errors[3];
    for (int i = 0; i < 3; ++i)
      errors[i] = std::abs(hill_stream(march(c.method, hill_vortex, seed, 8.0, c.n << i)) -
                           hill_stream(seed));
    EXPECT_GT(errors[2], 1e-14);
    // Constants of motion can do better than the order, by one at most here.
    EXPECT_GT(0.5 * std::log2(errors[0] / errors[2]), c.order - 0.3) << int(c.method);
  }
  // With error control: to the tolerance times the length in time.
  auto field = unbounded(hill_vortex);
  for (const Method method : {Method::bs32, Method::dopri5}) {
    IntegratorSettings settings;
    settings.method = method;
    settings.tolerance = method == Method::bs32 ? 1e-6 : 1e-9;
    settings.max_steps = 100000;
    const Outcome r = run(field, settings, seed, 20.0);
    EXPECT_EQ(r.ending, INSITU_END_ALIVE);
    EXPECT_NEAR(hill_stream(r.p.x), hill_stream(seed), 20 * settings.tolerance);
  }
}

TEST(Dense, OrdersOfTheInterpolants) {
  // The largest error over a step in a circle, against the chord's exact motion; of order one more
  // than the interpolant's, since a single step's.
  const struct {
    Method method;
    double order;
    bool quintic;
  } cases[] = {{Method::euler, 2, false},
               {Method::bs32, 4, false},
               {Method::rk4, 4, false},
               {Method::dopri5, 5, true}};
  for (const auto& c : cases) {
    double errors[2] = {};
    for (int i = 0; i < 2; ++i) {
      const double h = i == 0 ? 0.2 : 0.1;
      auto field = unbounded(rotation);
      const Vec3d x{1, 0, 0}, v{0, 1, 0};
      const advect::DenseStep path(x, 0.0, h, v, step(c.method, field, x, 0.0, h, v), c.quintic);
      for (double theta = 0.0; theta <= 1.0; theta += 1.0 / 64)
        errors[i] = std::max(
            errors[i], distance(path.at(theta), {std::cos(theta * h), std::sin(theta * h), 0}));
      EXPECT_EQ(distance(path.at(0.0), x), 0.0);
      EXPECT_EQ(path.at_time(0.5 * h), path.at(0.5));
    }
    EXPECT_NEAR(std::log2(errors[0] / errors[1]), c.order, 0.3) << int(c.method);
  }
}

TEST(Dense, APartIsTheSamePath) {
  auto field = unbounded(rotation);
  const Vec3d x{1, 0, 0}, v{0, 1, 0};
  const double h = -0.4;
  for (const auto& [method, quintic] : {std::pair(Method::rk4, false), {Method::dopri5, true}}) {
    const advect::DenseStep path(x, 2.0, h, v, step(method, field, x, 2.0, h, v), quintic);
    for (const double theta : {0.01, 0.3, 0.77, 1.0}) {
      const advect::DenseStep part = path.until(theta);
      EXPECT_EQ(part.start(), 2.0);
      EXPECT_EQ(part.step(), theta * h);
      for (double at = 0.0; at <= 1.0; at += 1.0 / 16) {
        EXPECT_LT(distance(part.at(at), path.at(theta * at)), 1e-15);
        EXPECT_LT(distance(part.rate(at), theta * path.rate(theta * at)), 1e-15);
      }
    }
  }
}

TEST(Dense, AskedTimesAreMetAlongTheWay) {
  for (const double to : {2.0, -2.0}) {
    auto field = unbounded(rotation);
    IntegratorSettings settings;
    settings.tolerance = 1e-9;
    advect::State p;
    p.x = {1, 0, 0};
    advect::Work work;
    int asked = 0, starts = 0;
    struct Visitor {
      int &asked, &starts;
      double to;
      void operator()(const advect::State&) { ++starts; }
      void operator()(const advect::State& s, const advect::DenseStep& step) {
        EXPECT_NEAR(step.start() + step.step(), s.time, 1e-15);
        EXPECT_EQ(distance(step.at(1.0), s.x), 0.0);
        for (; asked < 100 && std::abs(to * asked / 100) <= std::abs(s.time); ++asked) {
          const double t = to * asked / 100;
          EXPECT_LT(distance(step.at_time(t), {std::cos(t), std::sin(t), 0}), 1e-8);
        }
      }
    };
    advect::integrate(field, settings, to, 1e9, p, work, Visitor{asked, starts, to});
    EXPECT_EQ(asked, 100);
    EXPECT_EQ(starts, 1);
  }
}

TEST(Measure, AFieldMayHaveItsOwnLengths) {
  // Coordinates in thousandths: the same way, lengths and errors in units.
  struct Scaled {
    Sampled operator()(const Vec3d& x, double, Vec3d& v) {
      v = rotation(x, 0);
      return Sampled::inside;
    }
    void accepted() {}
    Vec3d extent() const { return {INFINITY, INFINITY, INFINITY}; }
    double length(const Vec3d&, const Vec3d& d) const { return 1e-3 * advect::length_of(d); }
  } scaled;
  auto plain = unbounded(rotation);
  for (const Method method : {Method::euler, Method::rk4, Method::bs32, Method::dopri5}) {
    IntegratorSettings settings;
    settings.method = method;
    const Outcome a = run(scaled, settings, {1000, 0, 0}, 1.0);
    const Outcome b = run(plain, settings, {1, 0, 0}, 1.0);
    EXPECT_NEAR(a.p.length, b.p.length, 1e-12);
    EXPECT_LT(distance(1e-3 * a.p.x, b.p.x), 1e-12);
    EXPECT_EQ(a.work.steps, b.work.steps);
    EXPECT_EQ(run(scaled, settings, {1000, 0, 0}, 9.0, 0.5).ending, INSITU_END_EXPIRED);
  }
}

TEST(Order, ErrorEstimateIsOfOrderFourPerUnitTime) {
  auto field = unbounded(abc_flow);
  const Vec3d seed{0.3, 1.1, -0.4};
  Vec3d v;
  field(seed, 0.0, v);
  const double coarse =
      advect::length_of(advect::trial_of<advect::Dopri5>(field, seed, 0.0, 0.1, v).error);
  const double fine =
      advect::length_of(advect::trial_of<advect::Dopri5>(field, seed, 0.0, 0.05, v).error);
  EXPECT_NEAR(std::log2(coarse / fine), 4.0, 0.5);
}

TEST(Order, EvaluationsPerStep) {
  auto field = unbounded(rotation);
  Vec3d v;
  field({1, 0, 0}, 0.0, v);
  field.asked = 0;
  advect::trial_of<advect::Rk4>(field, {1, 0, 0}, 0.0, 0.1, v);
  EXPECT_EQ(field.asked, 4);
  advect::trial_of<advect::Dopri5>(field, {1, 0, 0}, 0.0, 0.1, v);
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
    const advect::Trial trial = advect::trial_of<advect::Rk4>(field, x, 0.0, h, v);
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

// Where they are to be taken, steps that no error control passes are, at the smallest size, and
// counted; what is left ends at the limit of steps.
TEST(ErrorControl, StepsAreNoSmallerThanTheSmallest) {
  for (const Method method : {Method::bs32, Method::dopri5}) {
    // It turns 1000 times a unit of time, which steps of 1/64 cannot follow.
    auto field = unbounded([](const Vec3d&, double t) {
      return Vec3d{std::cos(6283 * t), std::sin(6283 * t), 1.0};
    });
    IntegratorSettings settings;
    settings.method = method;
    settings.tolerance = 1e-9;
    settings.step = settings.min_step = settings.max_step = 1.0 / 64;
    settings.at_min_step = advect::AtMinStep::take;
    const Outcome r = run(field, settings, {0, 0, 0}, 1.0);
    EXPECT_EQ(r.ending, INSITU_END_ALIVE);
    EXPECT_EQ(r.work.steps, 64);
    EXPECT_GT(r.work.forced, 60);
    EXPECT_EQ(r.work.rejected, 0);
    EXPECT_NEAR(r.p.x.z, 1.0, 1e-14);
    settings.max_steps = 10;
    const Outcome stuck = run(field, settings, {0, 0, 0}, 1.0);
    EXPECT_EQ(stuck.ending, INSITU_END_STEP_LIMIT);
    EXPECT_NEAR(stuck.p.time, 10.0 / 64, 1e-15);
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
