// Velocities between committed steps: what is exact, what order is reached, and what happens where
// steps are missing.
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "advect/integrate/in_time.h"
#include "advect/pathlines.h"
#include "analytic.h"
#include "box_mesh.h"

namespace insitu::test {
namespace {

using advect::EarlierSteps;
using advect::FieldInTime;
using advect::StepTimes;
using advect::TimeInterpolation;
using advect::Tracer;
using advect::TracerSettings;

constexpr TimeInterpolation all_kinds[] = {TimeInterpolation::linear, TimeInterpolation::quadratic,
                                           TimeInterpolation::cubic};

/// The interpolant of u, known at times[0] > times[1] > ..., and its rate.
template <class U>
double interpolated(const std::vector<double>& times, std::size_t steps, double t, U u,
                    double* rate = nullptr) {
  const StepTimes s(times[1], times[0], std::span(times).subspan(2));
  EXPECT_EQ(s.usable(steps), int(steps));
  double w[advect::most_steps], r[advect::most_steps], sum = 0.0;
  s.weights(t, int(steps), w);
  s.rates(t, int(steps), r);
  if (rate)
    *rate = 0.0;
  for (std::size_t k = 0; k < steps; ++k) {
    sum += w[k] * u(times[k]);
    if (rate)
      *rate += r[k] * u(times[k]);
  }
  return sum;
}

TEST(StepTimes, InterpolantsAreExactForTheirPolynomialsAtAnyDistances) {
  const std::vector<double> times{3.0, 2.3, 2.1, 0.6};
  const auto line = [](double t) { return 2.0 - 3.0 * t; };
  const auto parabola = [](double t) { return 1.0 - 2.0 * t + 5.0 * t * t; };
  for (double t = 2.3; t <= 3.0; t += 0.07) {
    double rate;
    EXPECT_NEAR(interpolated(times, 2, t, line, &rate), line(t), 1e-13);
    EXPECT_NEAR(rate, -3.0, 1e-12);
    for (const std::size_t steps : {3, 4}) {
      EXPECT_NEAR(interpolated(times, steps, t, parabola, &rate), parabola(t), 1e-12);
      EXPECT_NEAR(rate, -2.0 + 10.0 * t, 1e-11);
    }
  }
}

TEST(StepTimes, AtAStepItIsThatStepToTheBitAndTheCubicsSlopeGoesOn) {
  const std::vector<double> times{3.0, 2.3, 2.1, 0.6, 0.1};
  const auto u = [](double t) { return std::sin(2.0 * t) + 0.1; };
  for (const std::size_t steps : {2, 3, 4}) {
    EXPECT_EQ(interpolated(times, steps, 3.0, u), u(3.0));
    EXPECT_EQ(interpolated(times, steps, 2.3, u), u(2.3));
    EXPECT_EQ(interpolated(times, steps, 3.5, u), u(3.0)) << "later than all: as then";
  }
  double before, after;
  interpolated({2.3, 2.1, 0.6, 0.1}, 4, 2.3, u, &before);
  interpolated(times, 4, 2.3, u, &after);
  EXPECT_NEAR(before, after, 1e-13);
}

// A step right after another would tell the slope by rounding; two of one time by nothing.
TEST(StepTimes, StepsThatCannotTellASlopeDoNotServe) {
  const auto usable = [](double t0, double t1, std::vector<double> before) {
    return StepTimes(t0, t1, before).usable(4);
  };
  EXPECT_EQ(usable(2.0, 3.0, {1.0, 0.0}), 4);
  EXPECT_EQ(usable(2.0, 3.0, {1.0}), 3);
  EXPECT_EQ(usable(2.0, 3.0, {2.0, 1.0}), 2);
  EXPECT_EQ(usable(2.0, 3.0, {2.0 - 1e-9, 1.0}), 2);
  EXPECT_EQ(usable(2.0, 3.0, {1.0, 1.0}), 3);
  EXPECT_EQ(usable(2.0, 3.0, {2.5, 1.0}), 2) << "time went back";
  EXPECT_EQ(usable(2.0, 3.0, {std::nan(""), 1.0}), 2);
  EXPECT_EQ(usable(2.0, 2.0, {1.0, 0.0}), 1) << "no time between the steps";
}

class InTime : public ::testing::Test {
protected:
  core::Memory memory;
  core::Threads threads;
  TracerSettings settings;
};

/// A flow that turns about z at a rate that swings: the angle at time t is closed.
double rate(double t) {
  return 1.0 + 0.8 * std::sin(3.0 * t);
}
double angle(double t) {
  return t - 0.8 / 3.0 * (std::cos(3.0 * t) - 1.0);
}

/// The largest error of particles that go through the flow, which is linear in space so that only
/// time is interpolated, from 0 to 1.5 in `count` intervals; uneven: every other one is twice as
/// long. Steps before time 0 are known, so that no interval lacks one.
double error_after(TracerSettings settings, TimeInterpolation kind, int count, bool uneven,
                   core::Memory& memory, const core::Threads& threads) {
  const BoxMesh mesh(3, -1.0, 1.0);
  const auto time_of = [&](int k) {
    const double pairs = std::floor(k / 2.0);
    return 1.5 / count * (uneven ? 2.0 * pairs + (k % 2 != 0 ? 2.0 / 3.0 : 0.0) : double(k));
  };
  settings.time_interpolation = kind;
  Tracer tracer(settings, memory);
  const auto seeds = random_points(61, 20, -0.6, 0.6);
  tracer.seed(seeds, 0.0);
  std::vector<std::unique_ptr<TestField>> steps; // the latest first
  for (int k = -3; k <= count; ++k) {
    steps.insert(steps.begin(), std::make_unique<TestField>(INSITU_VERTEX, mesh.points.size()));
    mesh.fill(*steps.front(), [&](const Vec3d& x) {
      return rate(time_of(k)) * Vec3d{-x.y, x.x, 0.0};
    });
    if (k <= 0)
      continue;
    std::vector<mesh::FieldView> earlier;
    for (std::size_t s = 1; s < 4; ++s)
      earlier.push_back(steps[s]->view);
    const double before[] = {time_of(k - 2), time_of(k - 3)};
    const auto a = tracer.advance(mesh.sampler(), steps.front()->view, {earlier, before},
                                  time_of(k - 1), time_of(k), threads);
    EXPECT_EQ(a.velocity_steps, advect::steps_of(kind));
    EXPECT_EQ(a.counts.alive(), 20);
  }
  double error = 0.0;
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    const double c = std::cos(angle(1.5)), s = std::sin(angle(1.5));
    const Vec3d x = seeds[i], end{c * x.x - s * x.y, s * x.x + c * x.y, x.z};
    error = std::max(error, distance(tracer.positions()[i], end));
  }
  return error;
}

// The integrator's own error is 1e-11 a unit of time, far below. Orders by halving the intervals
// from 20 to 40 and 80; a tenth is what they are short of the limit.
TEST_F(InTime, OrdersInTheTimeBetweenSteps) {
  settings.integrator.tolerance = 1e-11;
  for (const bool uneven : {false, true})
    for (const TimeInterpolation kind : all_kinds) {
      double errors[3];
      for (int i = 0; i < 3; ++i)
        errors[i] = error_after(settings, kind, 20 << i, uneven, memory, threads);
      const double order = std::log2(errors[1] / errors[2]);
      const double expected = kind == TimeInterpolation::linear                ? 2.0
                              : kind == TimeInterpolation::quadratic || uneven ? 3.0
                                                                               : 4.0;
      std::printf("%s steps, through %d: errors %.2e, %.2e, %.2e: order %.2f\n",
                  uneven ? "uneven" : "even", advect::steps_of(kind), errors[0], errors[1],
                  errors[2], order);
      EXPECT_GT(order, expected - 0.1);
      EXPECT_LT(order, expected + 0.4);
      EXPECT_GT(errors[2], 1e-10) << "not by rounding";
    }
}

/// A uniform velocity 3 t^2 along x at times 0, 0.1, 0.3, 0.6: the way is t^3, to be found exactly
/// from 0.3 to 0.6.
TEST_F(InTime, AParabolaIsFollowedByVertexAndCellFieldsAndDrifts) {
  const BoxMesh mesh(4, 0.0, 1.0);
  const double times[] = {0.6, 0.3, 0.1, 0.0};
  const auto u = [](double t) { return Vec3d{3.0 * t * t, 0.0, 0.0}; };
  settings.integrator.tolerance = 1e-12;
  const std::vector<Vec3d> seed{{0.2, 0.4, 0.6}};
  for (const auto association : {INSITU_VERTEX, INSITU_CELL})
    for (const TimeInterpolation kind : all_kinds)
      for (const bool drifts : {false, true}) {
        const std::size_t items =
            association == INSITU_CELL ? mesh.cell_count() : mesh.points.size();
        std::vector<std::unique_ptr<TestField>> flow;
        for (const double t : times) {
          flow.push_back(std::make_unique<TestField>(association, items));
          for (std::size_t i = 0; i < items; ++i)
            flow.back()->set(i, u(t));
        }
        const TestField still(association, items);
        std::vector<mesh::FieldView> earlier;
        for (std::size_t s = 1; s < 4; ++s)
          earlier.push_back(drifts ? still.view : flow[s]->view);
        settings.time_interpolation = kind;
        Tracer tracer(settings, memory);
        if (drifts) {
          advect::Effects effects;
          FieldInTime wind{flow[0]->view, {}};
          for (int s = 1; s < advect::steps_of(kind); ++s)
            wind.earlier.push_back(flow[std::size_t(s)]->view);
          effects.drifts.push_back({{}, wind, 1.0, {}});
          tracer.set_effects(effects);
        }
        tracer.seed(seed, 0.3);
        tracer.advance(mesh.sampler(), drifts ? still.view : flow[0]->view,
                       {earlier, std::span(times).subspan(2)}, 0.3, 0.6, threads);
        const double way = tracer.positions()[0].x - 0.2;
        if (kind == TimeInterpolation::linear)
          EXPECT_NEAR(way, 0.3 * 1.5 * (0.36 + 0.09), 1e-12); // the trapezoid
        else
          EXPECT_NEAR(way, 0.216 - 0.027, 1e-12);
      }
}

TEST_F(InTime, WithoutOlderStepsItIsTheStraightLineToTheBit) {
  const BoxMesh mesh(5, -1.0, 1.0);
  TestField now = mesh.vertex_field(), earlier = mesh.vertex_field();
  mesh.fill(now, [](const Vec3d& x) { return abc_flow(3.0 * x, 0.3); });
  mesh.fill(earlier, [](const Vec3d& x) { return abc_flow(3.0 * x, 0.0); });
  std::vector<std::vector<Vec3d>> ends;
  for (const TimeInterpolation kind : all_kinds) {
    settings.time_interpolation = kind;
    Tracer tracer(settings, memory);
    tracer.seed(random_points(62, 50, -0.9, 0.9), 0.0);
    const auto a = tracer.advance(mesh.sampler(), now.view, &earlier.view, 0.0, 0.1, threads);
    EXPECT_EQ(a.velocity_steps, 2);
    ends.emplace_back(tracer.positions().begin(), tracer.positions().end());
  }
  EXPECT_EQ(ends[0], ends[1]);
  EXPECT_EQ(ends[0], ends[2]);
}

} // namespace
} // namespace insitu::test
