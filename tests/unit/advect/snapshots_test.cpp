// Where particles are at times within an advance, by dense output.
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <vector>

#include "advect/pathlines.h"
#include "analytic.h"
#include "box_mesh.h"
#include "query/walk/attached.h"

namespace insitu::test {
namespace {

using advect::Method;
using advect::Snapshots;
using advect::Tracer;
using advect::TracerSettings;

class AtTimes : public ::testing::Test {
protected:
  core::Memory memory;
  core::Threads threads;
  TracerSettings settings;

  Snapshots at(std::vector<double> times) { return Snapshots(std::move(times), memory); }
  /// One advance from 0 to `end` in a steady flow.
  template <class Flow>
  Tracer go(const BoxMesh& mesh, Flow flow, const std::vector<Vec3d>& seeds, double end,
            Snapshots* snapshots, const advect::Effects* effects = nullptr) {
    TestField velocity = mesh.vertex_field();
    mesh.fill(velocity, flow);
    Tracer tracer(settings, memory);
    if (effects)
      tracer.set_effects(*effects);
    tracer.seed(seeds, 0.0);
    tracer.advance(mesh.sampler(), velocity.view, &velocity.view, 0.0, end, threads, snapshots);
    return tracer;
  }
};

bool same_particles(const Tracer& a, const Tracer& b) {
  const auto same = [](const auto& x, const auto& y) {
    return x.size() == y.size() &&
           std::memcmp(x.data(), y.data(), x.size() * sizeof(x.data()[0])) == 0;
  };
  const advect::Particles &p = a.particles(), &q = b.particles();
  return same(p.positions, q.positions) && same(p.times, q.times) && same(p.cells, q.cells) &&
         same(p.steps, q.steps) && same(p.lengths, q.lengths) && same(p.endings, q.endings);
}

// Tolerances: Euler and RK4 by steps of 1e-3 (orders 1 and 4; between steps Hermite's cubic), the
// pairs by a bound on the error per unit time of 1e-9, of which dense output loses some.
TEST_F(AtTimes, RigidRotationAtAskedTimesByEveryMethod) {
  const BoxMesh mesh(6, -1.0, 1.0);
  const auto seeds = random_points(71, 40, -0.65, 0.65);
  std::vector<double> times;
  for (int k = 0; k <= 50; ++k)
    times.push_back(0.03 * k);
  struct Case {
    Method method;
    double step, tolerance;
  };
  for (const auto& [method, step, tolerance] :
       {Case{Method::euler, 1e-3, 2e-3}, Case{Method::rk4, 1e-2, 1e-9},
        Case{Method::bs32, 0.0, 1e-7}, Case{Method::dopri5, 0.0, 1e-7}})
    for (const bool face_aware : {false, true}) {
      settings.integrator = {};
      settings.integrator.method = method;
      settings.integrator.step = step;
      settings.integrator.tolerance = 1e-9;
      settings.integrator.face_aware = face_aware;
      Snapshots snapshots = at(times);
      const Tracer with = go(mesh, turn, seeds, 1.5, &snapshots);
      const Tracer without = go(mesh, turn, seeds, 1.5, nullptr);
      EXPECT_TRUE(same_particles(with, without)) << int(method);
      double worst = 0.0;
      for (std::size_t k = 0; k < times.size(); ++k)
        for (std::size_t i = 0; i < seeds.size(); ++i) {
          const std::size_t item = snapshots.item(k, i);
          ASSERT_EQ(snapshots.present[item], 1) << k;
          const Vec3d x = snapshots.positions[item];
          worst = std::max(worst, distance(x, turned(seeds[i], times[k])));
          const query::Location here = mesh.sampler().locate(x);
          ASSERT_EQ(snapshots.places[item].cell, here.cell);
        }
      EXPECT_LT(worst, tolerance) << int(method) << (face_aware ? " face-aware" : "");
      for (std::size_t i = 0; i < seeds.size(); ++i) { // to the bit at both ends
        EXPECT_EQ(snapshots.positions[snapshots.item(0, i)], seeds[i]);
        EXPECT_EQ(snapshots.positions[snapshots.item(50, i)], with.positions()[i]);
      }
    }
}

// Over several advances each time is had once: at its end, not again at the next one's beginning.
TEST_F(AtTimes, EachTimeOnceFromTheSeedToTheEnd) {
  const BoxMesh mesh(4, 0.0, 1.0);
  TestField velocity = mesh.vertex_field();
  mesh.fill(velocity, [](const Vec3d&) { return Vec3d{0.25, 0, 0}; });
  settings.duration = 2.0;
  Tracer tracer(settings, memory);
  // It lives from 0.5 to 2.5; it leaves at 2.9; outside; it begins with the last advance's end.
  tracer.seed(std::vector<Vec3d>{{0.125, 0.5, 0.5}}, 0.5);
  tracer.seed(std::vector<Vec3d>{{0.65, 0.5, 0.5}, {2.0, 0.5, 0.5}}, 1.5);
  tracer.seed(std::vector<Vec3d>{{0.5, 0.5, 0.5}}, 4.0);
  std::vector<std::vector<double>> seen(4);
  for (int cycle = 0; cycle < 4; ++cycle) {
    std::vector<double> times;
    for (double t = cycle; t <= cycle + 1; t += 0.25)
      times.push_back(t);
    Snapshots snapshots = at(times);
    tracer.advance(mesh.sampler(), velocity.view, nullptr, cycle, cycle + 1, threads, &snapshots);
    for (std::size_t k = 0; k < times.size(); ++k)
      for (std::size_t i = 0; i < 4; ++i)
        if (snapshots.present[snapshots.item(k, i)]) {
          seen[i].push_back(times[k]);
          const double begin = i == 0 ? 0.5 : i == 1 ? 1.5 : 4.0;
          const double from = i == 0 ? 0.125 : i == 1 ? 0.65 : 0.5;
          EXPECT_NEAR(snapshots.positions[snapshots.item(k, i)].x, from + 0.25 * (times[k] - begin),
                      1e-12);
        }
  }
  EXPECT_EQ(seen[0], (std::vector<double>{0.5, 0.75, 1, 1.25, 1.5, 1.75, 2, 2.25}));
  EXPECT_EQ(seen[1], (std::vector<double>{1.5, 1.75, 2, 2.25, 2.5, 2.75}));
  EXPECT_EQ(seen[2], std::vector<double>{});
  EXPECT_EQ(seen[3], std::vector<double>{4});
  EXPECT_EQ(tracer.counts().by_ending[INSITU_END_EXPIRED], 1);
  EXPECT_EQ(tracer.counts().by_ending[INSITU_END_LEFT], 1);
}

TEST_F(AtTimes, MaterialParticlesKeepTheirCellInBetween) {
  BoxMesh mesh(5, 0.0, 1.0);
  const auto seeds = random_points(72, 60, 0.0, 1.0);
  std::vector<query::Location> before;
  for (const Vec3d& x : seeds)
    before.push_back(mesh.sampler().locate(x));
  TestField velocity = mesh.vertex_field();
  mesh.move([](const Vec3d& x) { return Vec3d{1.2 * x.x + 0.1 * x.y, x.y + 0.3, x.z * 0.9}; });
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
    velocity.set(v, mesh.points[v] - mesh.earlier()[v]);
  settings.integrator.tolerance = 1e-10;
  for (const bool attached : {false, true}) {
    settings.attached = attached;
    Tracer tracer(settings, memory);
    tracer.seed(seeds, 0.0);
    if (attached) { // at first where the mesh was
      const BoxMesh still(5, 0.0, 1.0);
      tracer.follow(still.sampler(), true, 0.0, 0.0, threads);
    }
    Snapshots snapshots = at({0.25, 0.5, 1.0});
    if (attached)
      tracer.follow(mesh.sampler(), true, 0.0, 1.0, threads, &snapshots);
    else
      tracer.advance(mesh.sampler(), velocity.view, &velocity.view, 0.0, 1.0, threads, &snapshots);
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t i = 0; i < seeds.size(); ++i) {
        const std::size_t item = snapshots.item(k, i);
        ASSERT_EQ(snapshots.present[item], 1);
        EXPECT_EQ(snapshots.places[item].cell, before[i].cell);
        EXPECT_LT(distance(snapshots.places[item].parametric, before[i].parametric), 1e-8);
        const Vec3d way = tracer.positions()[i] - seeds[i]; // straight, and even in time
        EXPECT_LT(distance(snapshots.positions[item], seeds[i] + snapshots.times[k] * way), 1e-8);
      }
  }
}

// Without drag a particle flies along a parabola, which Hermite's cubic is.
TEST_F(AtTimes, FlightsWithInertia) {
  const BoxMesh mesh(4, 0.0, 1.0);
  advect::Effects effects;
  effects.inertia.emplace();
  effects.inertia->acceleration = {0.0, 0.0, -0.5};
  effects.inertia->begins = Vec3d{0.1, 0.2, 0.3};
  const std::vector<Vec3d> seeds{{0.25, 0.25, 0.5}, {0.3, 0.1, 0.4}};
  const auto still = [](const Vec3d&) { return Vec3d{}; };
  Snapshots snapshots = at({0.0, 0.1, 0.33, 0.7, 1.0});
  const Tracer with = go(mesh, still, seeds, 1.0, &snapshots, &effects);
  EXPECT_TRUE(same_particles(with, go(mesh, still, seeds, 1.0, nullptr, &effects)));
  for (std::size_t k = 0; k < 5; ++k)
    for (std::size_t i = 0; i < 2; ++i) {
      const double t = snapshots.times[k];
      ASSERT_EQ(snapshots.present[snapshots.item(k, i)], 1) << t;
      EXPECT_LT(distance(snapshots.positions[snapshots.item(k, i)],
                         seeds[i] + t * Vec3d{0.1, 0.2, 0.3} + (0.5 * t * t) * Vec3d{0, 0, -0.5}),
                1e-12);
    }
}

// Under walls, walks and periodic sides: the same ways, everybody there at every time and inside,
// and at the end where the particle is.
// A velocity that grows with time takes a particle along a wall on a parabola, which steps there
// and what lies between them meet exactly. Chords of these steps, of 0.04, would err by 8e-5.
TEST_F(AtTimes, AlongAWallByTheStepsOwnFormula) {
  const BoxMesh mesh(5, 0.0, 1.0);
  TestField now = mesh.vertex_field(), before = mesh.vertex_field();
  mesh.fill(before, [](const Vec3d&) { return Vec3d{0.5, 0, 0}; });
  mesh.fill(now, [](const Vec3d&) { return Vec3d{0.5, 0.4, -0.2}; });
  advect::Effects effects;
  effects.boundary.emplace();
  effects.boundary->response = advect::AtBoundary::slide;
  Tracer tracer(settings, memory);
  tracer.set_effects(effects);
  const std::vector<Vec3d> seeds{{0.9, 0.3, 0.6}, {0.7, 0.5, 0.4}};
  tracer.seed(seeds, 0.0);
  std::vector<double> times;
  for (int k = 0; k <= 97; ++k)
    times.push_back(k / 97.0);
  Snapshots snapshots = at(times);
  tracer.advance(mesh.sampler(), now.view, &before.view, 0.0, 1.0, threads, &snapshots);
  for (std::size_t i = 0; i < seeds.size(); ++i)
    for (std::size_t k = 0; k < times.size(); ++k) {
      const double t = times[k];
      const std::size_t item = snapshots.item(k, i);
      ASSERT_EQ(snapshots.present[item], 1);
      EXPECT_LT(
          distance(snapshots.positions[item], {std::min(seeds[i].x + 0.5 * t, 1.0),
                                               seeds[i].y + 0.2 * t * t, seeds[i].z - 0.1 * t * t}),
          1e-8)
          << t;
      EXPECT_TRUE(bool(snapshots.places[item])) << t;
    }
}

TEST_F(AtTimes, UnderEffectsThatDisplace) {
  const BoxMesh mesh(5, 0.0, 1.0);
  const auto flow = [](const Vec3d& x) { return Vec3d{0.8, 0.5 * x.x - 0.2, -0.6}; };
  const auto seeds = random_points(73, 60, 0.05, 0.95);
  std::vector<double> times;
  for (int k = 0; k <= 40; ++k)
    times.push_back(k / 20.0);
  for (int kind = 0; kind < 6; ++kind) {
    advect::Effects effects;
    effects.boundary.emplace();
    effects.boundary->response =
        kind % 2 == 0 ? advect::AtBoundary::slide : advect::AtBoundary::reflect;
    if (kind == 2 || kind == 3)
      effects.diffusion = advect::Diffusion{{0.01, {}}, {0.01, {}}, 0.0, 5};
    if (kind == 4) {
      effects.inertia.emplace();
      effects.inertia->response_time = 0.1;
    }
    if (kind == 5)
      effects.boundary->periodic[0] = effects.boundary->periodic[2] = true;
    Snapshots snapshots = at(times);
    const Tracer with = go(mesh, flow, seeds, 2.0, &snapshots, &effects);
    EXPECT_TRUE(same_particles(with, go(mesh, flow, seeds, 2.0, nullptr, &effects))) << kind;
    ASSERT_EQ(with.counts().alive(), 60) << kind;
    for (std::size_t i = 0; i < seeds.size(); ++i) {
      double longest = 0.0;
      for (std::size_t k = 0; k < times.size(); ++k) {
        const std::size_t item = snapshots.item(k, i);
        ASSERT_EQ(snapshots.present[item], 1) << kind << " at " << times[k];
        const Vec3d x = snapshots.positions[item];
        EXPECT_TRUE(in_cube(x, -1e-6, 1.0 + 1e-6)) << kind;
        if (k > 0 && kind < 2)
          longest = std::max(longest, distance(x, snapshots.positions[snapshots.item(k - 1, i)]));
      }
      EXPECT_LT(longest, 0.08) << "a speed of 1.1 at most, for 0.05; and a contact step";
      EXPECT_EQ(snapshots.positions[snapshots.item(0, i)], seeds[i]) << kind;
      EXPECT_EQ(snapshots.positions[snapshots.item(40, i)], with.positions()[i]) << kind;
    }
    if (kind == 5) { // through the sides, not back across the cube
      for (std::size_t i = 0; i < seeds.size(); ++i)
        for (std::size_t k = 0; k < times.size(); ++k) {
          const double x = seeds[i].x + 0.8 * times[k];
          const double here = snapshots.positions[snapshots.item(k, i)].x;
          EXPECT_NEAR(std::abs(std::remainder(here - x, 1.0)), 0.0, 1e-5);
        }
    }
  }
}

} // namespace
} // namespace insitu::test
