// Particles that go back through the steps by which others came.
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <vector>

#include "advect/pathlines.h"
#include "analytic.h"
#include "box_mesh.h"
#include "core/status.h"
#include "remeshed.h"

namespace insitu::test {
namespace {

using advect::Effects;
using advect::Tracer;
using advect::TracerSettings;

class Backward : public ::testing::Test {
protected:
  core::Memory memory;
  core::Threads threads;
  TracerSettings settings;

  TracerSettings back() const {
    TracerSettings s = settings;
    s.backward = true;
    return s;
  }
};

/// A rotation whose rate swings, about an axis that goes along.
Vec3d swinging(const Vec3d& x, double t) {
  const double rate = 1.0 + 0.5 * std::sin(3.0 * t);
  return {-rate * (x.y - 0.5), rate * (x.x - 0.5), 0.1 * std::cos(2.0 * t)};
}

// Between two steps both ways see one velocity, so they are each other's inverse: to the tolerance,
// 1e-10 a unit of time, over a time of 2.
TEST_F(Backward, ForwardAndBackReturnsToTheSeeds) {
  const BoxMesh mesh(8, 0.0, 1.0);
  constexpr int steps = 20;
  constexpr double dt = 0.1;
  std::vector<std::unique_ptr<TestField>> at;
  for (int s = 0; s <= steps; ++s) {
    at.push_back(std::make_unique<TestField>(INSITU_VERTEX, mesh.points.size()));
    mesh.fill(*at.back(), [&](const Vec3d& x) { return swinging(x, s * dt); });
  }
  settings.integrator.tolerance = 1e-10;
  for (const bool face_aware : {false, true}) {
    settings.integrator.face_aware = face_aware;
    const auto seeds = random_points(81, 80, 0.3, 0.6);
    Tracer there(settings, memory);
    there.seed(seeds, 0.0);
    for (int s = 1; s <= steps; ++s)
      there.advance(mesh.sampler(), at[s]->view, &at[s - 1]->view, dt * (s - 1), dt * s, threads);
    ASSERT_EQ(there.counts().alive(), 80);
    Tracer back_again(back(), memory);
    back_again.seed(there.positions(), dt * steps);
    for (int s = steps - 1; s >= 0; --s) {
      const advect::Advance a = back_again.advance(mesh.sampler(), at[s]->view, &at[s + 1]->view,
                                                   dt * (s + 1), dt * s, threads);
      EXPECT_TRUE(a.blended_velocity);
      EXPECT_EQ(a.counts.sum(), 80);
    }
    ASSERT_EQ(back_again.counts().alive(), 80);
    double farthest = 0.0;
    for (std::size_t i = 0; i < seeds.size(); ++i) {
      farthest = std::max(farthest, distance(there.positions()[i], seeds[i]));
      EXPECT_LT(distance(back_again.positions()[i], seeds[i]), 2e-9);
      EXPECT_EQ(back_again.particles().times[i], 0.0);
      EXPECT_NEAR(back_again.particles().lengths[i], there.particles().lengths[i], 1e-3);
    }
    EXPECT_GT(farthest, 0.1);
  }
}

// Against the closed form, by every interpolation in time: going back, it looks back on later
// steps.
TEST_F(Backward, TheOrderInTheTimeBetweenStepsIsTheSame) {
  const BoxMesh mesh(4, 0.0, 1.0);
  const auto spun = [](double t) { return t - std::cos(3.0 * t) / 6.0; };
  settings.integrator.tolerance = 1e-12;
  for (const auto& [interpolation, order] : {std::pair{advect::TimeInterpolation::linear, 2.0},
                                             {advect::TimeInterpolation::quadratic, 3.0},
                                             {advect::TimeInterpolation::cubic, 4.0}}) {
    settings.time_interpolation = interpolation;
    double before = 0.0;
    for (const int steps : {32, 64}) {
      const double dt = 1.7 / steps;
      std::vector<std::unique_ptr<TestField>> at;
      for (int s = 0; s <= steps + 3; ++s) {
        at.push_back(std::make_unique<TestField>(INSITU_VERTEX, mesh.points.size()));
        mesh.fill(*at.back(), [&](const Vec3d& x) {
          const Vec3d v = swinging(x, s * dt);
          return Vec3d{v.x, v.y, 0.0};
        });
      }
      Tracer tracer(back(), memory);
      const Vec3d seed{0.7, 0.5, 0.5};
      tracer.seed({&seed, 1}, dt * steps);
      for (int s = steps - 1; s >= 0; --s) {
        const mesh::FieldView fields[] = {at[s + 1]->view, at[s + 2]->view, at[s + 3]->view};
        const double times[] = {dt * (s + 2), dt * (s + 3)};
        tracer.advance(mesh.sampler(), at[s]->view, {fields, times}, dt * (s + 1), dt * s, threads);
      }
      const double angle = spun(0.0) - spun(dt * steps);
      const Vec3d truth{0.5 + 0.2 * std::cos(angle), 0.5 + 0.2 * std::sin(angle), 0.5};
      const double error = distance(tracer.positions()[0], truth);
      if (before > 0.0) {
        EXPECT_NEAR(std::log2(before / error), order, 0.35) << order;
      }
      before = error;
    }
  }
}

TEST_F(Backward, StepTimesAreMirrored) {
  const double before[] = {-0.4, -0.9}, after[] = {0.4, 0.9};
  const advect::StepTimes there(0.0, 0.7, before), back_again(0.0, -0.7, after);
  for (int steps = 2; steps <= 4; ++steps) {
    ASSERT_EQ(there.usable(std::size_t(steps)), steps);
    ASSERT_EQ(back_again.usable(std::size_t(steps)), steps);
    for (const double t : {0.0, 0.1, 0.35, 0.7}) {
      double w[4], m[4];
      there.weights(t, steps, w);
      back_again.weights(-t, steps, m);
      for (int k = 0; k < steps; ++k)
        EXPECT_DOUBLE_EQ(w[k], m[k]);
      there.rates(t, steps, w);
      back_again.rates(-t, steps, m);
      for (int k = 0; k < steps; ++k)
        EXPECT_DOUBLE_EQ(w[k], -m[k]);
    }
  }
}

// Vertices go back the straight ways on which they came.
TEST_F(Backward, OnAMeshThatMoves) {
  BoxMesh mesh(6, 0.0, 1.0);
  const std::vector<Vec3d> first = mesh.points;
  std::vector<std::vector<Vec3d>> points{first};
  constexpr int steps = 5;
  constexpr double dt = 0.2;
  const auto flow = [](const Vec3d& x, double t) {
    return Vec3d{0.2 + 0.1 * x.y * t, 0.1 * x.x, -0.1 * t};
  };
  settings.integrator.tolerance = 1e-10;
  const auto seeds = random_points(82, 100, 0.2, 0.8);
  Tracer there(settings, memory);
  there.seed(seeds, 0.0);
  TestField now = mesh.vertex_field(), before = mesh.vertex_field();
  const auto go = [&](Tracer& tracer, const std::vector<Vec3d>& to, double t0, double t1) {
    mesh.fill(before, [&](const Vec3d& x) { return flow(x, t0); });
    std::size_t v = 0;
    mesh.move([&](const Vec3d&) { return to[v++]; });
    mesh.fill(now, [&](const Vec3d& x) { return flow(x, t1); });
    const advect::Advance a =
        tracer.advance(mesh.sampler(), now.view, &before.view, t0, t1, threads);
    EXPECT_TRUE(a.blended_geometry);
  };
  for (int s = 0; s < steps; ++s) {
    std::vector<Vec3d> to = points.back();
    for (Vec3d& x : to)
      x = Vec3d{1.02 * x.x + 0.02, 0.98 * x.y + 0.01 * x.z, x.z - 0.01 * x.x};
    points.push_back(to);
    go(there, to, s * dt, (s + 1) * dt);
  }
  ASSERT_EQ(there.counts().alive(), 100);
  Tracer back_again(back(), memory);
  back_again.seed(there.positions(), steps * dt);
  for (int s = steps - 1; s >= 0; --s)
    go(back_again, points[std::size_t(s)], (s + 1) * dt, s * dt);
  ASSERT_EQ(back_again.counts().alive(), 100);
  for (std::size_t i = 0; i < seeds.size(); ++i)
    EXPECT_LT(distance(back_again.positions()[i], seeds[i]), 1e-8);
}

TEST_F(Backward, OverChangesOfTopology) {
  const auto cube = [](int step) {
    return Remeshed::cube(step % 2 ? MeshKind::tetrahedra : MeshKind::hexahedra, 4 + step,
                          std::uint64_t(step));
  };
  constexpr int steps = 5;
  constexpr double dt = 0.2;
  settings.integrator.tolerance = 1e-10;
  const auto seeds = random_points(83, 40, 0.3, 0.6);
  std::vector<Vec3d> ends;
  Remeshed solver;
  solver.remesh(cube(0), swinging, 0.0);
  const auto run = [&](const TracerSettings& with, std::span<const Vec3d> from, int first,
                       int last) {
    Tracer tracer(with, memory);
    tracer.seed(from, first * dt);
    const int way = last > first ? 1 : -1;
    for (int s = first + way; s != last + way; s += way) {
      solver.keep();
      solver.remesh(cube(s), swinging, s * dt);
      const auto before = solver.before();
      tracer.advance(solver.mesh.sampler(), solver.velocity(), nullptr, (s - way) * dt, s * dt,
                     threads, nullptr, &*before);
    }
    EXPECT_EQ(tracer.counts().alive(), 40);
    return std::vector<Vec3d>(tracer.positions().begin(), tracer.positions().end());
  };
  ends = run(settings, seeds, 0, steps);
  const std::vector<Vec3d> returned = run(back(), ends, steps, 0);
  for (std::size_t i = 0; i < seeds.size(); ++i)
    EXPECT_LT(distance(returned[i], seeds[i]), 2e-9);
}

// Seeds begin on the way, wait for a later advance, expire at an age; a path's length counts on.
TEST_F(Backward, SeedsAndAges) {
  const BoxMesh mesh(4, 0.0, 1.0);
  TestField velocity = mesh.vertex_field();
  mesh.fill(velocity, [](const Vec3d&) { return Vec3d{0.1, 0, 0}; });
  settings.duration = 2.5;
  Tracer tracer(back(), memory);
  const Vec3d nozzle{0.9, 0.5, 0.5};
  for (const double time : {5.0, 4.5, 4.0, 3.5, 2.0})
    tracer.seed({&nozzle, 1}, time);
  tracer.advance(mesh.sampler(), velocity.view, nullptr, 5.0, 4.0, threads);
  const double first[] = {0.8, 0.85, 0.9, 0.9, 0.9};
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_NEAR(tracer.positions()[i].x, first[i], 1e-12) << i;
  tracer.advance(mesh.sampler(), velocity.view, nullptr, 4.0, 2.25, threads);
  const double then[] = {0.65, 0.675, 0.725, 0.775, 0.9};
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_NEAR(tracer.positions()[i].x, then[i], 1e-12) << i;
  EXPECT_EQ(tracer.particles().endings[0], INSITU_END_EXPIRED);
  EXPECT_EQ(tracer.particles().times[0], 2.5);
  EXPECT_EQ(tracer.counts().alive(), 4);
  EXPECT_EQ(tracer.counts().sum(), 5);
}

// A particle is at asked times where one that goes forward through them has it.
TEST_F(Backward, AtTimesBetweenSteps) {
  const BoxMesh mesh(5, -1.0, 1.0);
  TestField velocity = mesh.vertex_field();
  mesh.fill(velocity, turn);
  settings.integrator.tolerance = 1e-9;
  Tracer tracer(back(), memory), plain(back(), memory);
  const auto seeds = random_points(84, 30, -0.6, 0.6);
  for (Tracer* t : {&tracer, &plain})
    t->seed(seeds, 2.0);
  const std::vector<double> times{2.0, 1.9, 1.25, 1.0};
  advect::Snapshots at(times, memory);
  tracer.advance(mesh.sampler(), velocity.view, &velocity.view, 2.0, 1.0, threads, &at);
  plain.advance(mesh.sampler(), velocity.view, &velocity.view, 2.0, 1.0, threads);
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    EXPECT_EQ(tracer.positions()[i], plain.positions()[i]);
    for (std::size_t k = 0; k < times.size(); ++k) {
      ASSERT_TRUE(at.present[at.item(k, i)]) << times[k];
      EXPECT_LT(distance(at.positions[at.item(k, i)], turned(seeds[i], times[k] - 2.0)), 1e-7);
    }
  }
}

// A wall meets the velocity turned round; drifts go back as well.
TEST_F(Backward, WallsAndDrifts) {
  const BoxMesh mesh(5, 0.0, 1.0);
  TestField velocity = mesh.vertex_field();
  mesh.fill(velocity, [](const Vec3d&) { return Vec3d{-0.3, 0.1, 0}; });
  Effects effects;
  effects.boundary.emplace();
  effects.boundary->response = advect::AtBoundary::slide;
  advect::Drift drift;
  drift.constant = {0, 0, 0.05};
  effects.drifts = {drift};
  Tracer tracer(back(), memory);
  tracer.set_effects(effects);
  const std::vector<Vec3d> seeds{{0.8, 0.8, 0.5}, {0.3, 0.9, 0.9}};
  tracer.seed(seeds, 3.0);
  tracer.advance(mesh.sampler(), velocity.view, &velocity.view, 3.0, 1.0, threads);
  EXPECT_EQ(tracer.counts().alive(), 2);
  EXPECT_LT(distance(tracer.positions()[0], {1.0, 0.6, 0.4}), 1e-6);
  EXPECT_LT(distance(tracer.positions()[1], {0.9, 0.7, 0.8}), 1e-12);
}

TEST_F(Backward, WhatHasNoWayBackIsRefused) {
  const BoxMesh mesh(2, 0.0, 1.0);
  const TestField velocity = mesh.vertex_field();
  Tracer tracer(back(), memory);
  tracer.seed(random_points(85, 3, 0.1, 0.9), 1.0);
  const auto why = [](auto&& act) {
    try {
      act();
    } catch (const core::Error& e) {
      EXPECT_EQ(e.status(), INSITU_ERROR_ARGUMENT);
      return std::string(e.what());
    }
    return std::string();
  };
  const auto advance = [&](double t0, double t1) {
    return why(
        [&] { tracer.advance(mesh.sampler(), velocity.view, &velocity.view, t0, t1, threads); });
  };
  EXPECT_NE(advance(1.0, 2.0).find("from time 1.000000 on to 2.000000"), std::string::npos);
  EXPECT_NE(advance(1.0, std::nan("")), "");
  EXPECT_EQ(advance(1.0, 1.0), "");
  EXPECT_EQ(advance(1.0, 0.5), "");
  Effects walk, heavy;
  walk.diffusion.emplace();
  heavy.inertia.emplace();
  EXPECT_NE(why([&] { tracer.set_effects(walk); }).find("random walk"), std::string::npos);
  EXPECT_NE(why([&] { tracer.set_effects(heavy); }).find("inertia"), std::string::npos);
  TracerSettings attached = back();
  attached.attached = true;
  EXPECT_NE(why([&] { Tracer(attached, memory); }), "");
  EXPECT_EQ(tracer.counts().alive(), 3);
}

} // namespace
} // namespace insitu::test
