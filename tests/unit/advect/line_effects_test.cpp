// Effects on streamlines: drifts, walls, periodic sides, inertia and removal along lines of one
// moment.
#include <cmath>
#include <cstring>

#include "advect/lines/streamlines.h"
#include "core/status.h"
#include "effects_test.h"
#include "line_view.h"

namespace insitu::test {
namespace {

using advect::Direction;
using advect::Streamlines;
using advect::StreamlineSettings;

class LineEffects : public ::testing::Test {
protected:
  using Flow = std::function<Vec3d(const Vec3d&)>;
  Streamlines trace(const BoxMesh& mesh, const Flow& flow, const std::vector<Vec3d>& seeds,
                    const core::Threads* with = nullptr) {
    TestField velocity = mesh.vertex_field();
    mesh.fill(velocity, flow);
    return advect::trace_streamlines(mesh.sampler(), velocity.view, seeds, settings,
                                     with ? *with : threads, memory);
  }
  void respond(AtBoundary response) {
    settings.effects.boundary.emplace();
    settings.effects.boundary->response = response;
  }
  void drift(const Vec3d& v) { settings.effects.drifts.push_back({v, {}, 1.0, {}}); }

  core::Memory memory;
  core::Threads threads;
  StreamlineSettings settings;
};

bool same_lines(const Streamlines& a, const Streamlines& b) {
  const auto same = [](const auto& x, const auto& y) {
    return x.size() == y.size() &&
           std::memcmp(x.data(), y.data(), x.size() * sizeof(x.data()[0])) == 0;
  };
  return same(a.lines.points, b.lines.points) && same(a.lines.times, b.lines.times) &&
         same(a.lines.cells, b.lines.cells) && same(a.lines.offsets, b.lines.offsets) &&
         same(a.lines.endings, b.lines.endings);
}

Vec3d turn_at(const Vec3d& x, double t, double rise) {
  const double c = std::cos(t), s = std::sin(t);
  return {c * x.x - s * x.y, s * x.x + c * x.y, x.z + rise * t};
}

TEST_F(LineEffects, SettlingAndWindageAreAddedInBothDirections) {
  const BoxMesh mesh(8, -1.0, 1.0);
  TestField wind = mesh.vertex_field();
  mesh.fill(wind, [](const Vec3d& x) { return Vec3d{-4.0 * x.y, 4.0 * x.x, 0.0}; });
  drift({0, 0, -0.125});
  advect::Drift blown;
  blown.field = advect::FieldInTime{wind.view, {}};
  blown.factor = 0.125; // half a turn more in the same time
  settings.effects.drifts.push_back(blown);
  settings.duration = 2.0;
  settings.direction = Direction::both;
  settings.integrator.tolerance = 1e-9;
  const auto seeds = random_points(101, 20, -0.5, 0.5);
  for (const double even : {0.0, 0.25}) {
    settings.even_time = even;
    const Streamlines s = trace(
        mesh,
        [](const Vec3d& x) {
          return Vec3d{-x.y, x.x, 0.0};
        },
        seeds);
    ASSERT_EQ(s.counts.by_ending[INSITU_END_EXPIRED], 40);
    for (std::size_t l = 0; l < 40; ++l) {
      const LineView of = line(s, l);
      EXPECT_EQ(of.times.back(), l % 2 == 0 ? 2.0 : -2.0);
      if (even > 0.0) {
        EXPECT_EQ(of.points.size(), 9u);
      }
      for (std::size_t v = 0; v < of.points.size(); ++v) {
        const double t = of.times[v];
        const Vec3d turned = turn_at(seeds[l / 2], 1.5 * t, 0.0);
        EXPECT_LT(distance(of.points[v], turned - Vec3d{0, 0, 0.125 * t}), 1e-7);
      }
    }
  }
}

// A condition that never holds: the line that there is without, to the bit.
TEST_F(LineEffects, WhatDoesNothingChangesNoBit) {
  const BoxMesh mesh(6, -1.0, 1.0);
  const auto flow = [](const Vec3d& x) { return Vec3d{0.3 - x.y, x.x, 0.2}; };
  const auto seeds = random_points(102, 50, -1.0, 1.0);
  settings.direction = Direction::both;
  for (const double even : {0.0, 0.05})
    for (const bool face_aware : {false, true}) {
      settings.even_length = even;
      settings.integrator.face_aware = face_aware;
      settings.effects = {};
      const Streamlines plain = trace(mesh, flow, seeds);
      settings.effects.removes = [](const std::vector<double>&, const query::Location&,
                                    const Vec3d&, double) { return false; };
      const Streamlines with = trace(mesh, flow, seeds);
      if (even > 0.0) {
        EXPECT_TRUE(same_lines(plain, with)) << face_aware;
      }
      for (std::size_t l = 0; l < 100; ++l) { // of steps that close in on an exit there are more
        const LineView a = line(plain, l), b = line(with, l);
        EXPECT_EQ(a.ending, b.ending);
        EXPECT_EQ(a.points.empty(), b.points.empty());
        EXPECT_TRUE(a.points.empty() ||
                    (a.points.back() == b.points.back() && a.times.back() == b.times.back()));
        EXPECT_LE(b.points.size(), a.points.size() + 3);
      }
      respond(AtBoundary::leave);
      settings.effects.removes = {};
      const Streamlines left = trace(mesh, flow, seeds);
      EXPECT_EQ(left.counts.by_ending, plain.counts.by_ending);
    }
}

TEST_F(LineEffects, StoppedLinesEndOnTheFaceEitherWay) {
  const BoxMesh mesh(5, 0.0, 1.0);
  respond(AtBoundary::stop);
  settings.direction = Direction::both;
  const Streamlines s = trace(mesh,
                              [](const Vec3d&) {
                                return Vec3d{0.3, 0.03, 0};
                              },
                              {{0.5, 0.3, 0.4}});
  for (std::size_t l = 0; l < 2; ++l) {
    const LineView of = line(s, l);
    EXPECT_EQ(of.ending, INSITU_END_STOPPED);
    EXPECT_EQ(of.points.back().x, l == 0 ? 1.0 : 0.0);
    EXPECT_NEAR(of.points.back().y, l == 0 ? 0.35 : 0.25, 1e-8);
    EXPECT_NEAR(of.times.back(), (l == 0 ? 0.5 : -0.5) / 0.3, 1e-7);
  }
}

TEST_F(LineEffects, SlidingLinesFollowTheWall) {
  // On the floor x' = x, y' = -y: xy is kept; Heun's error is about (0.1 * 0.2)^2 a step. Then
  // along the edge x = 1, towards y = 0 where it comes to rest.
  const BoxMesh mesh(5, 0.0, 1.0);
  respond(AtBoundary::slide);
  for (const double sign : {1.0, -1.0}) {
    settings.direction = sign > 0.0 ? Direction::forward : Direction::backward;
    const Streamlines s = trace(mesh,
                                [sign](const Vec3d& x) {
                                  return sign * Vec3d{x.x, -x.y, -0.5};
                                },
                                {{0.2, 0.8, 0.05}});
    const LineView of = line(s, 0);
    EXPECT_EQ(of.ending, INSITU_END_STAGNATED);
    EXPECT_LT(distance(of.points.back(), {1, 0, 0}), 1e-5);
    EXPECT_LT(s.work.steps, 1000);
    for (std::size_t v = 0; v < of.points.size(); ++v) {
      const double t = sign * of.times[v];
      EXPECT_NEAR(of.points[v].z, std::max(0.0, 0.05 - 0.5 * t), 1e-6);
      if (of.points[v].x < 1.0 - 1e-6) {
        EXPECT_NEAR(of.points[v].x * of.points[v].y, 0.16, 5e-4);
        EXPECT_NEAR(of.points[v].x, 0.2 * std::exp(t), 2e-3);
      }
      if (v > 0) {
        EXPECT_GT(t, sign * of.times[v - 1]);
        EXPECT_LT(distance(of.points[v], of.points[v - 1]), 0.25) << "a cell";
      }
    }
  }
}

TEST_F(LineEffects, LinesPressedIntoACornerComeToRest) {
  const BoxMesh mesh(5, 0.0, 1.0);
  respond(AtBoundary::slide);
  const auto seeds = random_points(103, 30, 0.05, 0.95);
  for (const double even : {0.0, 0.1}) {
    settings.even_length = even;
    const Streamlines s = trace(
        mesh,
        [](const Vec3d&) {
          return Vec3d{1.0, 0.7, -0.9};
        },
        seeds);
    EXPECT_EQ(s.counts.by_ending[INSITU_END_STAGNATED], 30);
    EXPECT_LT(s.work.steps, 30 * 200);
    for (std::size_t l = 0; l < seeds.size(); ++l)
      EXPECT_LT(distance(line(s, l).points.back(), {1, 1, 0}), 1e-6);
  }
}

// Through the sides, with two vertices there, of one time and on both; the distances between
// vertices go on beyond them.
TEST_F(LineEffects, PeriodicSidesContinueLines) {
  const BoxMesh mesh(5, 0.0, 1.0);
  settings.effects.boundary.emplace();
  settings.effects.boundary->periodic[0] = settings.effects.boundary->periodic[1] = true;
  settings.direction = Direction::both;
  settings.duration = 4.0;
  const Vec3d u{0.7, -1.1, 0};
  const double speed = std::hypot(0.7, 1.1);
  const auto seeds = random_points(104, 40, 0.0, 1.0);
  for (const double even : {0.0, 0.15}) {
    settings.even_length = even;
    const Streamlines s = trace(
        mesh, [u](const Vec3d&) { return u; }, seeds);
    ASSERT_EQ(s.counts.by_ending[INSITU_END_EXPIRED], 80);
    for (std::size_t l = 0; l < 80; ++l) {
      const LineView of = line(s, l);
      int sides = 0, evens = 0;
      for (std::size_t v = 0; v < of.points.size(); ++v) {
        const Vec3d want = seeds[l / 2] + of.times[v] * u;
        for (int a = 0; a < 3; ++a) // ten crossings, each placed to 1e-9 of a cell
          EXPECT_NEAR(a < 2 ? std::remainder(of.points[v][a] - want[a], 1.0)
                            : of.points[v].z - want.z,
                      0.0, 1e-7);
        evens += even > 0.0 && std::abs(std::remainder(std::abs(of.times[v]) * speed, even)) < 1e-6;
        if (v == 0 || of.times[v] != of.times[v - 1])
          continue;
        ++sides;
        const Vec3d over = of.points[v] - of.points[v - 1];
        const int a = std::abs(over.x) > 0.5 ? 0 : 1;
        EXPECT_EQ(std::abs(over[a]), 1.0) << "on the sides to the bit";
        EXPECT_LT(std::abs(over[1 - a]), 1e-7);
      }
      const auto crossed = [&](int a) {
        return std::abs(std::floor(seeds[l / 2][a] + of.times.back() * u[a]) -
                        std::floor(seeds[l / 2][a]));
      };
      EXPECT_EQ(sides, int(crossed(0) + crossed(1)));
      if (even > 0.0) {
        EXPECT_GE(evens, int(4.0 * speed / even) + 1);
      }
    }
  }
}

// A line ends where its condition begins to hold, whatever the steps: at x = 0.6, or at an age.
TEST_F(LineEffects, RemovedWhereTheConditionBeginsToHold) {
  const BoxMesh mesh(4, 0.0, 1.0);
  const std::vector<Vec3d> seeds{{0.1, 0.5, 0.5}, {0.7, 0.5, 0.5}, {0.3, 0.2, 0.1}, {2, 0, 0}};
  const auto flow = [](const Vec3d&) { return Vec3d{0.5, 0.0, -0.25}; };
  for (const bool by_age : {false, true})
    for (int kind = 0; kind < 4; ++kind) {
      settings = {};
      settings.even_length = kind == 1 ? 0.03 : 0.0;
      settings.integrator.method = kind == 2 ? advect::Method::rk4 : advect::Method::dopri5;
      respond(AtBoundary::slide);
      if (kind == 3) {
        settings.effects.inertia.emplace();
        settings.effects.inertia->response_time = 1e-3;
        settings.duration = 10.0;
      }
      settings.effects.removes = [by_age](const std::vector<double>&, const query::Location&,
                                          const Vec3d& x,
                                          double age) { return by_age ? age > 0.75 : x.x > 0.6; };
      const Streamlines s = trace(mesh, flow, seeds);
      EXPECT_EQ(s.counts.by_ending[INSITU_END_REMOVED], 3) << kind;
      EXPECT_EQ(s.counts.by_ending[INSITU_END_SEED_OUTSIDE], 1);
      EXPECT_EQ(s.counts.sum(), 4);
      for (const std::size_t l : {0u, 2u}) { // the last one slides along the floor from 0.4 on
        const LineView of = line(s, l);
        if (by_age)
          EXPECT_NEAR(of.times.back(), std::min(0.75, 2.0 * (1.0 - seeds[l].x)), 1e-9) << kind;
        else
          EXPECT_NEAR(of.points.back().x, 0.6, 1e-9) << kind;
        EXPECT_NEAR(of.points.back().z, std::max(0.0, seeds[l].z - 0.25 * of.times.back()), 1e-6);
        for (std::size_t v = 1; v < of.points.size(); ++v)
          EXPECT_GT(of.points[v].x, of.points[v - 1].x);
      }
      EXPECT_EQ(line(s, 1).points.size() == 1, !by_age) << "at its seed";
      EXPECT_EQ(line(s, 3).points.size(), 0u);
    }
}

// dv/dt = (u - v) / tau + g has a closed form; the ball bounces between floor and ceiling.
TEST_F(LineEffects, InertiaFollowsItsOwnLaw) {
  const BoxMesh mesh(5, 0.0, 1.0);
  const Vec3d u{0.2, 0.1, 0.05}, g{0, 0, -0.4}, v0{-0.3, 0.2, 0.6};
  const double tau = 0.4;
  settings.effects.inertia.emplace();
  settings.effects.inertia->response_time = tau;
  settings.effects.inertia->acceleration = g;
  settings.effects.inertia->begins = v0;
  settings.duration = 1.5;
  settings.integrator.tolerance = 1e-9;
  for (const double even : {0.0, 0.05}) {
    settings.even_time = even;
    const Streamlines s = trace(mesh, [u](const Vec3d&) { return u; }, {{0.5, 0.3, 0.3}});
    const LineView of = line(s, 0);
    EXPECT_EQ(of.ending, INSITU_END_EXPIRED);
    for (std::size_t v = 0; v < of.points.size(); ++v) {
      const double t = of.times[v];
      const Vec3d end = u + tau * g;
      const Vec3d want =
          Vec3d{0.5, 0.3, 0.3} + t * end + (tau * (1.0 - std::exp(-t / tau))) * (v0 - end);
      EXPECT_LT(distance(of.points[v], want), 1e-8);
    }
  }
  settings.even_time = 0.0;
  settings.effects.inertia->response_time = std::numeric_limits<double>::infinity();
  settings.effects.inertia->begins = Vec3d{0.1, 0, 0};
  settings.duration = 7.0;
  respond(AtBoundary::reflect);
  const Streamlines s = trace(mesh, still, {{0.1, 0.5, 0.8}});
  const LineView of = line(s, 0);
  EXPECT_EQ(of.ending, INSITU_END_EXPIRED);
  double lowest = 1.0;
  for (std::size_t v = 0; v < of.points.size(); ++v) {
    const double fall = 2.0; // sqrt(2 * 0.8 / 0.4): a parabola from one touch to the next
    const double since = std::remainder(of.times[v], 2.0 * fall);
    EXPECT_NEAR(of.points[v].z, 0.8 - 0.2 * since * since, 1e-6);
    lowest = std::min(lowest, of.points[v].z);
  }
  EXPECT_LT(lowest, 1e-6) << "where it bounces there is a vertex";
}

TEST_F(LineEffects, TheSameForAnyThreadsAndAccountedFor) {
  const BoxMesh mesh(5, 0.0, 1.0);
  const auto flow = [](const Vec3d& x) { return Vec3d{0.8, 0.5 * x.x - 0.2, -0.6}; };
  const auto seeds = random_points(105, 300, -0.1, 1.1);
  const core::Threads one(1), four(4);
  for (int kind = 0; kind < 4; ++kind) {
    settings = {};
    settings.duration = 5.0;
    respond(kind % 2 == 0 ? AtBoundary::slide : AtBoundary::stop);
    settings.effects.boundary->periodic[0] = kind > 1;
    drift({0, 0, 0.1});
    settings.effects.removes = [](const std::vector<double>&, const query::Location&,
                                  const Vec3d& x, double) { return x.y > 0.9; };
    const Streamlines s = trace(mesh, flow, seeds, &one);
    EXPECT_TRUE(same_lines(s, trace(mesh, flow, seeds, &four))) << kind;
    EXPECT_EQ(s.counts.seeded, 300);
    EXPECT_EQ(s.counts.sum(), 300);
    EXPECT_EQ(s.counts.alive(), 0);
    EXPECT_EQ(s.counts.by_ending[INSITU_END_STEP_LIMIT], 0);
  }
}

TEST_F(LineEffects, WhatLinesHaveNotIsRefused) {
  const BoxMesh mesh(2, 0.0, 1.0);
  const auto refused = [&] {
    try {
      trace(mesh, still, {{0.5, 0.5, 0.5}});
    } catch (const core::Error& error) {
      return std::string(error.what());
    }
    return std::string("not refused");
  };
  settings.effects.diffusion.emplace();
  EXPECT_NE(refused().find("random walk"), std::string::npos);
  settings.effects = {};
  respond(AtBoundary::put_back);
  EXPECT_NE(refused().find("put back"), std::string::npos);
  respond(AtBoundary::reflect);
  EXPECT_NE(refused().find("inertia alone"), std::string::npos);
  settings.effects.inertia.emplace();
  EXPECT_NE(refused().find("duration"), std::string::npos);
  settings.duration = 1.0;
  settings.direction = Direction::both;
  EXPECT_NE(refused().find("forward"), std::string::npos);
  settings.direction = Direction::forward;
  EXPECT_EQ(refused(), "not refused");
}

} // namespace
} // namespace insitu::test
