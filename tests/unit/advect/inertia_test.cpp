// Particles with a velocity of their own.
#include <cmath>

#include "advect/effects/inertia.h"
#include "effects_test.h"

namespace insitu::test {
namespace {

class Inertials : public EffectsTest {
protected:
  advect::Inertia& inertia() {
    if (!effects.inertia)
      effects.inertia.emplace();
    return *effects.inertia;
  }
};

TEST_F(Inertials, PhiFunctionsAgreeWithTheirDefinition) {
  // phi_k(z) = integral of exp((1 - s) z) s^(k-1) / (k-1)!, by Simpson's rule.
  for (const double z : {-1e-9, -0.3, -0.999, -1.001, -7.0, -300.0}) {
    advect::Inertia law;
    law.response_time = -1.0 / z;
    const advect::LinearPart part(law, 1.0);
    double factorial = 1.0;
    for (int k = 1; k < 5; ++k) {
      const int n = 20000;
      double sum = 0.0;
      for (int i = 0; i <= n; ++i) {
        const double s = double(i) / n;
        sum += (i == 0 || i == n ? 1.0
                : i % 2          ? 4.0
                                 : 2.0) *
               std::exp((1.0 - s) * z) * std::pow(s, k - 1) / factorial;
      }
      factorial *= k;
      EXPECT_NEAR(part.phi(k, {1, 0, 0}).x, sum / (3.0 * n), 1e-9) << z << " " << k;
    }
    EXPECT_NEAR(part.phi(0, {1, 0, 0}).x, std::exp(z), 1e-15);
  }
}

TEST_F(Inertials, SettleAsTheClosedFormSays) {
  // From rest: v = v_t (1 - exp(-t / tau)), z = z0 + v_t (t - tau (1 - exp(-t / tau))).
  const BoxMesh mesh(4, 0.0, 10.0);
  for (const double tau : {1e-6, 0.01, 0.5, 20.0}) {
    inertia().response_time = tau;
    const double terminal = -2.0;
    inertia().acceleration = {0, 0, terminal / tau};
    inertia().begins = Vec3d{0, 0, 0};
    const std::vector<Vec3d> seeds{{5.0, 5.0, 9.0}};
    const double time = 1.5;
    const Tracer t = run(mesh, still, seeds, time, 3);
    const double decay = 1.0 - std::exp(-time / tau);
    EXPECT_NEAR(t.positions()[0].z, 9.0 + terminal * (time - tau * decay), 1e-9) << tau;
    EXPECT_NEAR(t.particles().velocities[0].z, terminal * decay, 1e-9) << tau;
  }
}

TEST_F(Inertials, CoriolisPressesThemOntoWallsToo) {
  // Along the ceiling, where -2 rotation x v points out of it: they rest on it, and go with the
  // flow. (Were it left out of what presses, they would meet the wall again at every step.)
  const BoxMesh mesh(4, 0.0, 10.0, 0.0);
  inertia().rotation = {0, 0.05, 0};
  effects.boundary.emplace();
  effects.boundary->response = AtBoundary::slide;
  const auto flow = [](const Vec3d&) { return Vec3d{0.25, 0, 0}; };
  for (const double tau : {5.0, 1e-3}) {
    inertia().response_time = tau;
    inertia().acceleration = {};
    const std::vector<Vec3d> below{{1.0, 5.0, 9.9}, {1.0, 4.0, 10.0}};
    const Tracer t = run(mesh, flow, below, 30.0, 3);
    EXPECT_NEAR(t.positions()[0].z, tau > 1.0 ? 10.0 : 9.9 + tau * 0.025 * 30.0, 1e-5) << tau;
    EXPECT_NEAR(t.positions()[1].z, 10.0, 1e-7);
    EXPECT_NEAR(t.positions()[1].x, 1.0 + 0.25 * 30.0, 1e-6) << tau;
    EXPECT_LT(work.contacts, 400);
    // On the floor, where it lifts them by half of their weight.
    inertia().acceleration = {0, 0, -0.05};
    const std::vector<Vec3d> above{{1.0, 5.0, 0.0}};
    const Tracer f = run(mesh, flow, above, 30.0, 3);
    EXPECT_NEAR(f.positions()[0].z, 0.0, 1e-7) << tau;
    // The first step, of 1, is a fall, since the wall is not known yet: that turns the velocity by
    // 0.1 0.05 / 2, until drag takes it back.
    EXPECT_NEAR(f.positions()[0].x, 1.0 + 0.25 * 30.0, 0.0025 * tau + 1e-6) << tau;
    EXPECT_LT(work.contacts, 400);
  }
}

TEST_F(Inertials, WithAShortResponseTimeFollowTheFlow) {
  const BoxMesh mesh(8, -1.0, 1.0, 0.0);
  const auto turn = [](const Vec3d& x) { return Vec3d{-x.y, x.x, 0.0}; };
  const auto seeds = random_points(31, 20, -0.6, 0.6);
  settings.integrator.tolerance = 1e-5;
  const Tracer tracer = run(mesh, turn, seeds, 1.0);
  double before = 0.0;
  for (const double tau : {1e-2, 1e-3, 1e-4, 1e-9}) {
    inertia().response_time = tau;
    const Tracer t = run(mesh, turn, seeds, 1.0);
    double worst = 0.0;
    for (std::size_t i = 0; i < seeds.size(); ++i)
      worst = std::max(worst, distance(t.positions()[i], tracer.positions()[i]));
    // They drift outwards by tau r t, to first order in tau.
    EXPECT_LT(worst, 0.9 * tau + 1e-5) << tau;
    if (tau == 1e-3) {
      EXPECT_NEAR(before / worst, 10.0, 0.5);
    }
    before = worst;
  }
}

TEST_F(Inertials, SpiralOutOfAVortexAsTheLinearSystemSays) {
  // x'' = (Omega e_z x x - x') / tau, in the complex plane: x ~ exp(mu t) with
  // mu = (-1 + sqrt(1 + 4 i tau Omega)) / (2 tau); the particle begins on that branch.
  const BoxMesh mesh(8, -1.0, 1.0, 0.0);
  const double tau = 0.2;
  const std::complex<double> mu =
      (-1.0 + std::sqrt(std::complex<double>(1.0, 4.0 * tau))) / (2.0 * tau);
  inertia().response_time = tau;
  const std::complex<double> start(0.3, 0.0), v = mu * start;
  inertia().begins = Vec3d{v.real(), v.imag(), 0.0};
  const std::vector<Vec3d> seeds{{0.3, 0.0, 0.0}};
  settings.integrator.tolerance = 1e-6;
  const double time = 4.0;
  const Tracer t = run(
      mesh,
      [](const Vec3d& x) {
        return Vec3d{-x.y, x.x, 0.0};
      },
      seeds, time, 4);
  const std::complex<double> end = start * std::exp(mu * time);
  EXPECT_LT(distance(t.positions()[0], {end.real(), end.imag(), 0.0}), 4e-6); // tolerance * time
}

TEST_F(Inertials, InertialCirclesCloseAfterTwoPiOverF) {
  const BoxMesh mesh(4, -1.0, 1.0);
  const double omega = 0.7; // f = 2 omega
  inertia().rotation = {0, 0, omega};
  inertia().begins = Vec3d{0.5, 0.0, 0.0};
  const std::vector<Vec3d> seeds{{0.0, 0.3, 0.1}};
  const double period = 2.0 * M_PI / (2.0 * omega), radius = 0.5 / (2.0 * omega);
  EXPECT_LT(distance(run(mesh, still, seeds, period, 7).positions()[0], seeds[0]), 1e-12);
  // Half way it is opposite, to the right of its velocity (clockwise in the north).
  const Tracer half = run(mesh, still, seeds, 0.5 * period);
  EXPECT_LT(distance(half.positions()[0], {0.0, 0.3 - 2.0 * radius, 0.1}), 1e-12);
  EXPECT_NEAR(half.particles().velocities[0].x, -0.5, 1e-12);
}

TEST_F(Inertials, NeutralParticlesWithAddedMassStayWithTheFluid) {
  // Density 1: beta = 1, so that v = u solves the equation exactly, whatever the response time.
  const BoxMesh mesh(8, -1.0, 1.0, 0.0);
  inertia().response_time = 0.5;
  inertia().fluid_share = 1.0;
  settings.integrator.tolerance = 1e-5;
  const auto turn = [](const Vec3d& x) { return Vec3d{-x.y, x.x, 0.0}; };
  const auto seeds = random_points(33, 10, -0.6, 0.6);
  const Tracer t = run(mesh, turn, seeds, 2.0 * M_PI, 4);
  for (std::size_t i = 0; i < seeds.size(); ++i)
    EXPECT_LT(distance(t.positions()[i], seeds[i]), 7e-5) << i; // tolerance * time
}

TEST_F(Inertials, BallsBounceToTheirHeight) {
  // Without drag, dropped from 1/2 above the floor: z = z0 - g s^2 / 2 between bounces.
  const BoxMesh mesh(5, 0.0, 1.0);
  inertia().acceleration = {0, 0, -1.0};
  inertia().begins = Vec3d{0, 0, 0};
  effects.boundary.emplace();
  effects.boundary->response = AtBoundary::reflect;
  const std::vector<Vec3d> seeds{{0.5, 0.5, 0.5}};
  const double fall = 1.0; // sqrt(2 z / g)
  EXPECT_NEAR(run(mesh, still, seeds, 2.0 * fall, 3).positions()[0].z, 0.5, 1e-6);
  EXPECT_NEAR(run(mesh, still, seeds, 3.5 * fall, 3).positions()[0].z, 0.5 - 0.125, 1e-6);
  effects.boundary->restitution = 0.5; // a quarter of the height
  EXPECT_NEAR(run(mesh, still, seeds, 1.5 * fall).positions()[0].z, 0.125, 1e-6);
}

TEST_F(Inertials, BallsComeToRestInFiniteTimeWithoutEndlessBounces) {
  const BoxMesh mesh(5, 0.0, 1.0);
  inertia().acceleration = {0.1, 0, -1.0};
  inertia().begins = Vec3d{0, 0, 0};
  effects.boundary.emplace();
  effects.boundary->response = AtBoundary::reflect;
  effects.boundary->restitution = 0.5;
  const std::vector<Vec3d> seeds{{0.1, 0.5, 0.5}};
  const Tracer t = run(mesh, still, seeds, 3.5, 2); // rests from 3 on
  EXPECT_EQ(t.particles().endings[0], INSITU_END_ALIVE);
  EXPECT_NEAR(t.positions()[0].z, 0.0, 1e-6);
  EXPECT_NEAR(t.positions()[0].x, 0.1 + 0.05 * 3.5 * 3.5, 1e-4); // slides without friction
  EXPECT_LT(work.contacts, 500);
}

TEST_F(Inertials, WallsStopThemAndPeriodicSidesLetThemThrough) {
  const BoxMesh mesh(5, 0.0, 1.0);
  inertia().begins = Vec3d{1.0, 0, 0};
  const std::vector<Vec3d> seeds{{0.5, 0.5, 0.5}, {0.5, 0.5, 2.0}};
  EXPECT_EQ(run(mesh, still, seeds, 2.0).particles().endings[0], INSITU_END_LEFT);
  EXPECT_EQ(run(mesh, still, seeds, 2.0).particles().endings[1], INSITU_END_SEED_OUTSIDE);
  effects.boundary.emplace();
  effects.boundary->response = AtBoundary::stop;
  const Tracer stopped = run(mesh, still, seeds, 2.0);
  EXPECT_EQ(stopped.particles().endings[0], INSITU_END_STOPPED);
  EXPECT_NEAR(stopped.positions()[0].x, 1.0, 1e-8);
  effects.boundary->periodic[0] = true;
  const Tracer through = run(mesh, still, seeds, 2.25, 2);
  EXPECT_EQ(through.particles().endings[0], INSITU_END_ALIVE);
  EXPECT_NEAR(through.positions()[0].x, 0.75, 1e-7);
}

} // namespace
} // namespace insitu::test
