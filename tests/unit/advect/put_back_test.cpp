// Particles that would leave and are put back to where their step began.
#include <cmath>
#include <cstring>

#include "advect/lines/snapshots.h"
#include "effects_test.h"

namespace insitu::test {
namespace {

class PutBack : public EffectsTest {
protected:
  void SetUp() override {
    effects.boundary.emplace();
    effects.boundary->response = AtBoundary::put_back;
  }
};

TEST_F(PutBack, ToThePositionOfTheCycleBeforeToTheBit) {
  const BoxMesh mesh(5, 0.0, 1.0);
  const auto flow = [](const Vec3d&) { return Vec3d{0.3, 0.1, 0}; };
  const std::vector<Vec3d> seeds{{0.5, 0.3, 0.4}, {0.05, 0.1, 0.1}};
  const Tracer before = run(mesh, flow, seeds, 1.5, 3);
  EXPECT_EQ(work.contacts, 0);
  const Tracer t = run(mesh, flow, seeds, 3.0, 6); // it would leave at 5/3
  EXPECT_EQ(work.contacts, 3);                     // one a cycle
  EXPECT_EQ(t.positions()[0], before.positions()[0]);
  EXPECT_EQ(t.particles().lengths[0], before.particles().lengths[0]);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(t.particles().endings[i], INSITU_END_ALIVE);
    EXPECT_EQ(t.particles().times[i], 3.0);
  }
  EXPECT_LT(distance(t.positions()[1], {0.95, 0.4, 0.1}), 1e-9);
}

TEST_F(PutBack, GoesOnWhenTheFlowTurns) {
  const BoxMesh mesh(5, 0.0, 1.0);
  TestField out = mesh.vertex_field(), in = mesh.vertex_field();
  mesh.fill(out, [](const Vec3d&) { return Vec3d{1, 0, 0}; });
  mesh.fill(in, [](const Vec3d&) { return Vec3d{-1, 0, 0}; });
  Tracer tracer(settings, memory);
  tracer.set_effects(effects);
  const std::vector<Vec3d> seeds{{0.75, 0.5, 0.5}};
  tracer.seed(seeds, 0.0);
  tracer.advance(mesh.sampler(), out.view, nullptr, 0.0, 0.5, threads);
  EXPECT_EQ(tracer.positions()[0], seeds[0]);
  tracer.advance(mesh.sampler(), in.view, nullptr, 0.5, 1.0, threads);
  EXPECT_LT(distance(tracer.positions()[0], {0.25, 0.5, 0.5}), 1e-9);
}

TEST_F(PutBack, WhatIsUndoneIsInNoTrack) {
  const BoxMesh mesh(5, 0.0, 1.0);
  TestField out = mesh.vertex_field();
  mesh.fill(out, [](const Vec3d&) { return Vec3d{1, 0, 0}; });
  Tracer tracer(settings, memory);
  tracer.set_effects(effects);
  const std::vector<Vec3d> seeds{{0.75, 0.5, 0.5}, {0.125, 0.5, 0.5}};
  tracer.seed(seeds, 0.0);
  advect::Snapshots at({0.0, 0.125, 0.5}, memory);
  tracer.advance(mesh.sampler(), out.view, nullptr, 0.0, 0.5, threads, &at);
  for (std::size_t k = 0; k < at.times.size(); ++k) { // the first would be out at 0.25
    ASSERT_TRUE(at.present[at.item(k, 0)]);
    EXPECT_EQ(at.positions[at.item(k, 0)], seeds[0]);
    EXPECT_LT(distance(at.positions[at.item(k, 1)], {0.125 + at.times[k], 0.5, 0.5}), 1e-9);
  }
}

TEST_F(PutBack, PeriodicSidesStillLetThrough) {
  const BoxMesh mesh(5, 0.0, 1.0);
  effects.boundary->periodic[0] = true;
  const std::vector<Vec3d> seeds{{0.5, 0.5, 0.5}};
  const Tracer t = run(
      mesh,
      [](const Vec3d&) {
        return Vec3d{1, 0.3, 0};
      },
      seeds, 2.0, 4);
  EXPECT_EQ(t.particles().endings[0], INSITU_END_ALIVE);
  EXPECT_NEAR(t.positions()[0].x, 0.0, 1e-7); // until 1.5; the last cycle would have left in y
  EXPECT_NEAR(t.positions()[0].y, 0.95, 1e-7);
}

TEST_F(PutBack, MixedParticlesStayMixed) {
  // A walk that does not take steps out is symmetric: what is even stays even.
  const BoxMesh mesh(5, 0.0, 1.0, 0.0);
  effects.diffusion.emplace();
  effects.diffusion->horizontal.constant = effects.diffusion->vertical.constant = 0.05;
  effects.diffusion->step = 0.02;
  settings.integrator.method = advect::Method::euler;
  const std::size_t n = 1500;
  const Tracer t = run(mesh, still, random_points(4, n, 0.0, 1.0), 2.0);
  EXPECT_EQ(t.counts().alive(), std::int64_t(n));
  EXPECT_GT(work.contacts, 1000);
  double bins[3][10] = {}, chi = 0.0;
  for (const Vec3d& x : t.positions())
    for (int a = 0; a < 3; ++a)
      ++bins[a][std::min(int(10 * x[a]), 9)];
  for (const auto& axis : bins)
    for (const double count : axis)
      chi += (count - n / 10.0) * (count - n / 10.0) / (n / 10.0);
  EXPECT_LT(chi, 68.0); // of 27 degrees of freedom: exceeded once in 50,000
}

TEST_F(PutBack, GoesWithTheMaterialOfAMeshThatMoves) {
  // The wall at x = 1 comes to x = 0.5 and pushes the particle, which flows against it: it is put
  // back to its place in the material.
  BoxMesh mesh(4, 0.0, 1.0);
  TestField v = mesh.vertex_field();
  mesh.fill(v, [](const Vec3d&) { return Vec3d{0.2, 0, 0}; });
  mesh.move([](const Vec3d& p) { return Vec3d{0.5 * p.x, p.y, p.z}; });
  Tracer tracer(settings, memory);
  tracer.set_effects(effects);
  const std::vector<Vec3d> seeds{{0.9, 0.5, 0.5}, {0.2, 0.5, 0.5}};
  tracer.seed(seeds, 0.0);
  const auto a = tracer.advance(mesh.sampler(), v.view, nullptr, 0.0, 1.0, threads);
  EXPECT_EQ(a.counts.alive(), 2);
  EXPECT_EQ(a.effects.contacts, 1);
  EXPECT_LT(distance(tracer.positions()[0], {0.45, 0.5, 0.5}), 1e-12);
  EXPECT_NEAR(tracer.positions()[1].x, 0.4, 1e-9);
}

TEST_F(PutBack, WithInertiaTheyGoOnFromRest) {
  const BoxMesh mesh(5, 0.0, 1.0);
  effects.inertia.emplace();
  effects.inertia->acceleration = {0, 0, -1};
  effects.inertia->begins = Vec3d{};
  const std::vector<Vec3d> seeds{{0.5, 0.5, 0.5}};
  const Tracer t = run(mesh, still, seeds, 1.6, 2); // falls for 1 until the floor
  EXPECT_EQ(t.particles().endings[0], INSITU_END_ALIVE);
  EXPECT_NEAR(t.positions()[0].z, 0.5 - 0.32, 1e-9); // after the first cycle, and put back
  EXPECT_EQ(t.particles().velocities[0], Vec3d{});
  EXPECT_EQ(work.contacts, 1);
}

TEST_F(PutBack, IsOneContactAStepHoweverNearTheWall) {
  const BoxMesh mesh(4, 0.0, 1.0);
  const std::vector<Vec3d> seeds{{1.0, 0.5, 0.5}, {1.0 - 1e-15, 1.0, 1.0}, {0.5, 0.5, 0.0}};
  const Tracer t = run(
      mesh,
      [](const Vec3d&) {
        return Vec3d{1e3, 1, -1e-3};
      },
      seeds, 2.0, 5);
  EXPECT_EQ(t.counts().alive(), 3);
  EXPECT_LE(work.contacts, 15);
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_EQ(t.positions()[i], seeds[i]);
}

} // namespace
} // namespace insitu::test
