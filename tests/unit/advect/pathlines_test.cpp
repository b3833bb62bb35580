// Particles from commit to commit, on meshes that rest and meshes that move.
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <memory>

#include "advect/pathlines.h"
#include "analytic.h"
#include "box_mesh.h"
#include "core/status.h"

namespace insitu::test {
namespace {

using advect::Advance;
using advect::Tracer;
using advect::TracerSettings;

class Paths : public ::testing::Test {
protected:
  core::Memory memory;
  core::Threads threads;
  TracerSettings settings;
};

TEST_F(Paths, RigidRotationOverManyCyclesReturns) {
  const BoxMesh mesh(10, -1.0, 1.0);
  TestField velocity = mesh.vertex_field();
  mesh.fill(velocity, turn);
  settings.integrator.tolerance = 1e-9;
  Tracer tracer(settings, memory);
  const auto seeds = random_points(21, 60, -0.65, 0.65);
  tracer.seed(seeds, 0.0);
  const double dt = 2 * M_PI / 32; // times are exact multiples
  for (int cycle = 0; cycle < 32; ++cycle) {
    const Advance a = tracer.advance(mesh.sampler(), velocity.view, &velocity.view, dt * cycle,
                                     dt * (cycle + 1), threads);
    EXPECT_EQ(a.counts.alive(), 60);
    EXPECT_TRUE(a.blended_velocity);
    EXPECT_FALSE(a.blended_geometry);
  }
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    EXPECT_LT(distance(tracer.positions()[i], seeds[i]), 2e-8);
    EXPECT_EQ(tracer.particles().times[i], 2 * M_PI);
    EXPECT_NEAR(tracer.particles().lengths[i], 2 * M_PI * std::hypot(seeds[i].x, seeds[i].y), 0.05);
  }
}

TEST_F(Paths, VelocityIsBlendedInTime) {
  const BoxMesh mesh(5, 0.0, 1.0);
  TestField now = mesh.vertex_field(), earlier = mesh.vertex_field();
  mesh.fill(now, [](const Vec3d&) { return Vec3d{0.3, 0, 0}; });
  mesh.fill(earlier, [](const Vec3d&) { return Vec3d{0, 0.1, 0}; });
  const std::vector<Vec3d> seed{{0.2, 0.2, 0.2}};
  {
    Tracer tracer(settings, memory);
    tracer.seed(seed, 1.0);
    EXPECT_TRUE(tracer.advance(mesh.sampler(), now.view, &earlier.view, 1.0, 3.0, threads)
                    .blended_velocity);
    EXPECT_LT(distance(tracer.positions()[0], {0.5, 0.3, 0.2}), 1e-12);
  }
  { // Halfway: (1 - s) and s integrate to 1/2 - 1/8 and 1/8 of the step... from s = 1/2 on: 1/8,
    // 3/8.
    Tracer tracer(settings, memory);
    tracer.seed(seed, 2.0);
    tracer.advance(mesh.sampler(), now.view, &earlier.view, 1.0, 3.0, threads);
    EXPECT_LT(distance(tracer.positions()[0], {0.2 + 0.3 * 0.75, 0.2 + 0.1 * 0.25, 0.2}), 1e-12);
  }
  { // The earlier step is not known: the current velocity throughout, and it is said.
    Tracer tracer(settings, memory);
    tracer.seed(seed, 1.0);
    EXPECT_FALSE(
        tracer.advance(mesh.sampler(), now.view, nullptr, 1.0, 3.0, threads).blended_velocity);
    EXPECT_LT(distance(tracer.positions()[0], {0.8, 0.2, 0.2}), 1e-12);
  }
}

/// Cell and parametric coordinates of each particle in the mesh as it is now.
std::vector<query::Location> places(const BoxMesh& mesh, std::span<const Vec3d> points) {
  std::vector<query::Location> places;
  for (const Vec3d& p : points)
    places.push_back(mesh.sampler().locate(p));
  return places;
}

TEST_F(Paths, MaterialParticlesKeepTheirPlaceInTheCell) {
  // Vertices move along straight lines at the velocity that they carry: so does all inside.
  BoxMesh mesh(6, 0.0, 1.0);
  settings.integrator.tolerance = 1e-10;
  Tracer tracer(settings, memory);
  const auto seeds = random_points(22, 200, 0.0, 1.0);
  tracer.seed(seeds, 0.0);
  const auto before = places(mesh, seeds);
  TestField velocity = mesh.vertex_field();
  const auto motion = [](const Vec3d& x) {
    return Vec3d{1.1 * x.x + 0.15 * x.y + 0.5, 0.9 * x.y - 0.1 * x.x * x.z, x.z + 0.2 * x.x * x.y};
  };
  double time = 0.0;
  for (int cycle = 0; cycle < 5; ++cycle) {
    const double dt = 0.1 * (cycle + 1);
    mesh.move(motion);
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
      velocity.set(v, (mesh.points[v] - mesh.earlier()[v]) / dt);
    const Advance a =
        tracer.advance(mesh.sampler(), velocity.view, &velocity.view, time, time + dt, threads);
    EXPECT_TRUE(a.blended_geometry);
    ASSERT_EQ(a.counts.alive(), 200);
    time += dt;
  }
  const auto after = places(mesh, tracer.positions());
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    EXPECT_EQ(after[i].cell, before[i].cell);
    EXPECT_LT(distance(after[i].parametric, before[i].parametric), 1e-9);
    EXPECT_EQ(tracer.particles().cells[i], before[i].cell);
  }
}

TEST_F(Paths, RigidlyTurningMeshKeepsParticlesInPlace) {
  // True velocities on vertices that move along chords: at every time between, the blend of a
  // linear field is the field where the blended mesh is. One radian in all.
  BoxMesh mesh(6, -1.0, 1.0);
  settings.integrator.tolerance = 1e-10;
  Tracer tracer(settings, memory);
  const auto seeds = random_points(23, 100, -0.95, 0.95);
  const auto before = places(mesh, seeds);
  tracer.seed(seeds, 0.0);
  TestField now = mesh.vertex_field(), earlier = mesh.vertex_field();
  const double dt = 1.0 / 8;
  for (int cycle = 0; cycle < 8; ++cycle) {
    mesh.fill(earlier, turn);
    mesh.move([&](const Vec3d& x) { return turned(x, dt); });
    mesh.fill(now, turn);
    tracer.advance(mesh.sampler(), now.view, &earlier.view, cycle * dt, (cycle + 1) * dt, threads);
  }
  ASSERT_EQ(tracer.counts().alive(), 100);
  const auto after = places(mesh, tracer.positions());
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    EXPECT_LT(distance(tracer.positions()[i], turned(seeds[i], 1.0)), 1e-9);
    EXPECT_EQ(after[i].cell, before[i].cell);
    EXPECT_LT(distance(after[i].parametric, before[i].parametric), 1e-8);
  }
}

TEST_F(Paths, LinearBlendInTimeIsOfSecondOrder) {
  const BoxMesh mesh(4, 0.0, 1.0);
  double previous = 0.0;
  for (const int cycles : {10, 20, 40}) {
    Tracer tracer(settings, memory);
    tracer.seed(random_points(29, 10, 0.4, 0.6), 0.0);
    const std::vector<Vec3d> seeds(tracer.positions().begin(), tracer.positions().end());
    TestField now = mesh.vertex_field(), earlier = mesh.vertex_field();
    const double dt = 2.0 / cycles;
    for (int cycle = 0; cycle < cycles; ++cycle) {
      const auto flow = [&](double t) {
        return [t](const Vec3d&) { return Vec3d{0.3 * std::cos(2 * t), 0, 0}; };
      };
      mesh.fill(earlier, flow(cycle * dt));
      mesh.fill(now, flow((cycle + 1) * dt));
      tracer.advance(mesh.sampler(), now.view, &earlier.view, cycle * dt, (cycle + 1) * dt,
                     threads);
    }
    double error = 0.0;
    for (std::size_t i = 0; i < seeds.size(); ++i)
      error =
          std::max(error, std::abs(tracer.positions()[i].x - seeds[i].x - 0.15 * std::sin(4.0)));
    if (previous > 0.0) {
      EXPECT_NEAR(std::log2(previous / error), 2.0, 0.1);
    }
    previous = error;
  }
}

TEST_F(Paths, AMeshThatMovesAwayLeavesTheParticle) {
  BoxMesh mesh(4, 0.0, 1.0);
  TestField still = mesh.vertex_field();
  Tracer tracer(settings, memory);
  tracer.seed(std::vector<Vec3d>{{0.25, 0.5, 0.5}, {0.75, 0.5, 0.5}}, 0.0);
  mesh.move([](const Vec3d& x) { return x + Vec3d{0.5, 0, 0}; });
  const Advance a = tracer.advance(mesh.sampler(), still.view, nullptr, 0.0, 2.0, threads);
  EXPECT_EQ(a.counts.by_ending[INSITU_END_LEFT], 1);
  EXPECT_EQ(a.counts.alive(), 1);
  EXPECT_NEAR(tracer.particles().times[0], 1.0, 1e-7); // the wall passes 0.25 at half the step
  EXPECT_EQ(tracer.particles().endings[0], INSITU_END_LEFT);
}

TEST_F(Paths, ThousandSeedsAreAccountedForAtEveryCycle) {
  const BoxMesh mesh(8, 0.0, 1.0);
  TestField velocity = mesh.vertex_field();
  mesh.fill(velocity, [](const Vec3d& x) { return Vec3d{0.4 + x.y, 0.2 - x.z, 0.1 * x.x}; });
  for (const auto method : {advect::Method::rk4, advect::Method::dopri5}) {
    settings.integrator.method = method;
    settings.duration = 1.05;
    Tracer tracer(settings, memory);
    const auto seeds = random_points(24, 1000, -0.2, 1.2);
    tracer.seed(seeds, 0.0);
    std::int64_t outside = 0;
    for (const Vec3d& p : seeds)
      outside += !in_cube(p, 0.0, 1.0);
    std::int64_t ended = 0;
    for (int cycle = 0; cycle < 12; ++cycle) {
      const Advance a = tracer.advance(mesh.sampler(), velocity.view, &velocity.view, 0.1 * cycle,
                                       0.1 * (cycle + 1), threads);
      EXPECT_EQ(a.counts.seeded, 1000);
      EXPECT_EQ(a.counts.sum(), 1000);
      EXPECT_EQ(a.counts.by_ending[INSITU_END_SEED_OUTSIDE], outside);
      EXPECT_GE(a.counts.sum() - a.counts.alive(), ended);
      ended = a.counts.sum() - a.counts.alive();
      if (cycle == 6)
        tracer.drop_ended();
    }
    const advect::Counts c = tracer.counts();
    EXPECT_EQ(c.sum(), 1000);
    EXPECT_GT(c.by_ending[INSITU_END_LEFT], 200);
    EXPECT_GT(c.by_ending[INSITU_END_EXPIRED], 10);
    EXPECT_EQ(c.alive(), 0);
  }
}

TEST_F(Paths, ZeroVelocityWaitsAndFinishKills) {
  const BoxMesh mesh(3, 0.0, 1.0);
  TestField still = mesh.vertex_field();
  Tracer tracer(settings, memory);
  const auto seeds = random_points(25, 10, 0.0, 1.0);
  tracer.seed(seeds, 0.0);
  EXPECT_EQ(
      tracer.advance(mesh.sampler(), still.view, &still.view, 0.0, 1.0, threads).counts.alive(),
      10);
  for (std::size_t i = 0; i < 10; ++i)
    EXPECT_EQ(tracer.positions()[i], seeds[i]);
  tracer.finish();
  EXPECT_EQ(tracer.counts().by_ending[INSITU_END_KILLED], 10);
  EXPECT_EQ(tracer.counts().alive(), 0);
}

TEST_F(Paths, FieldsAtTheEdgeOfNumbers) {
  const BoxMesh mesh(4, 0.0, 1.0);
  const auto ending = [&](double v) {
    TestField velocity = mesh.vertex_field();
    mesh.fill(velocity, [&](const Vec3d&) { return Vec3d{v, 0, v / 2}; });
    Tracer tracer(settings, memory);
    tracer.seed(random_points(26, 20, 0.1, 0.9), 1e3);
    const Advance a =
        tracer.advance(mesh.sampler(), velocity.view, &velocity.view, 1e3, 1e3 + 1, threads);
    for (int e = 0; e < INSITU_END_COUNT; ++e)
      if (a.counts.by_ending[std::size_t(e)] == 20)
        return insitu_ending(e);
    return INSITU_END_COUNT;
  };
  EXPECT_EQ(ending(1e30), INSITU_END_LEFT); // although time cannot show it
  EXPECT_EQ(ending(1e300), INSITU_END_LEFT);
  EXPECT_EQ(ending(1e-30), INSITU_END_ALIVE);
  EXPECT_EQ(ending(1e-300), INSITU_END_ALIVE);
  EXPECT_EQ(ending(std::numeric_limits<double>::quiet_NaN()), INSITU_END_NOT_FINITE);
}

TEST_F(Paths, StreaklinesAreSeededAtAnyTime) {
  const BoxMesh mesh(4, 0.0, 1.0);
  TestField velocity = mesh.vertex_field();
  mesh.fill(velocity, [](const Vec3d&) { return Vec3d{0.1, 0, 0}; });
  Tracer tracer(settings, memory);
  const Vec3d nozzle{0.1, 0.5, 0.5};
  for (const double time : {0.0, 0.5, 1.0, 1.5, 3.0})
    tracer.seed({&nozzle, 1}, time);
  tracer.advance(mesh.sampler(), velocity.view, nullptr, 0.0, 1.0, threads);
  tracer.advance(mesh.sampler(), velocity.view, nullptr, 1.0, 2.0, threads);
  const double travelled[5] = {2.0, 1.5, 1.0, 0.5, 0.0};
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_NEAR(tracer.positions()[i].x, 0.1 + 0.1 * travelled[i], 1e-12);
  EXPECT_EQ(tracer.particles().times[4], 3.0);
  EXPECT_EQ(tracer.counts().alive(), 5);
}

TEST_F(Paths, AgeAndLengthExpire) {
  const BoxMesh mesh(4, 0.0, 1.0);
  TestField velocity = mesh.vertex_field();
  mesh.fill(velocity, [](const Vec3d&) { return Vec3d{0.1, 0, 0}; });
  const std::vector<Vec3d> seed{{0.1, 0.5, 0.5}};
  settings.duration = 2.5;
  Tracer by_age(settings, memory);
  by_age.seed(seed, 0.0);
  settings.duration = std::numeric_limits<double>::infinity();
  settings.length = 0.35;
  Tracer by_length(settings, memory);
  by_length.seed(seed, 0.0);
  for (int cycle = 0; cycle < 5; ++cycle)
    for (Tracer* tracer : {&by_age, &by_length})
      tracer->advance(mesh.sampler(), velocity.view, nullptr, cycle, cycle + 1, threads);
  EXPECT_EQ(by_age.counts().by_ending[INSITU_END_EXPIRED], 1);
  EXPECT_EQ(by_age.particles().times[0], 2.5);
  EXPECT_NEAR(by_age.positions()[0].x, 0.35, 1e-12);
  EXPECT_EQ(by_length.counts().by_ending[INSITU_END_EXPIRED], 1);
  EXPECT_NEAR(by_length.positions()[0].x, 0.45, 1e-9);
}

TEST_F(Paths, SmallerMeshAfterAChangeOfTopology) {
  const BoxMesh fine(8, 0.0, 1.0), coarse(2, 0.0, 0.9);
  TestField velocity = fine.vertex_field(), velocity_coarse = coarse.vertex_field();
  fine.fill(velocity, [](const Vec3d&) { return Vec3d{0.01, 0, 0}; });
  coarse.fill(velocity_coarse, [](const Vec3d&) { return Vec3d{0.01, 0, 0}; });
  Tracer tracer(settings, memory);
  tracer.seed(std::vector<Vec3d>{{0.5, 0.5, 0.5}, {0.85, 0.85, 0.85}, {0.95, 0.95, 0.95}}, 0.0);
  EXPECT_EQ(
      tracer.advance(fine.sampler(), velocity.view, nullptr, 0.0, 1.0, threads).counts.alive(), 3);
  ASSERT_GT(tracer.particles().cells[1], 8); // no cell of the next mesh
  const Advance a =
      tracer.advance(coarse.sampler(), velocity_coarse.view, nullptr, 1.0, 2.0, threads);
  EXPECT_EQ(a.counts.alive(), 2);
  EXPECT_EQ(a.counts.by_ending[INSITU_END_LEFT], 1);
  EXPECT_NEAR(tracer.positions()[1].x, 0.87, 1e-12);
}

TEST_F(Paths, SameBytesForAnyThreadCount) {
  const auto run_with = [&](int count) {
    BoxMesh mesh(8, -1.0, 1.0);
    TestField now = mesh.vertex_field(), earlier = mesh.vertex_field();
    const core::Threads some(count);
    auto tracer = std::make_unique<Tracer>(settings, memory);
    tracer->seed(random_points(27, 500, -1.1, 1.1), 0.0);
    for (int cycle = 0; cycle < 4; ++cycle) {
      const auto flow = [&](const Vec3d& x) { return 0.3 * abc_flow(3.0 * x, 0.25 * cycle); };
      mesh.fill(earlier, flow);
      mesh.move([](const Vec3d& x) { return turned(x, 0.02); });
      mesh.fill(now, flow);
      tracer->advance(mesh.sampler(), now.view, &earlier.view, 0.25 * cycle, 0.25 * (cycle + 1),
                      some);
    }
    return tracer;
  };
  const auto one = run_with(1);
  EXPECT_GT(one->counts().alive(), 100);
  EXPECT_GT(one->counts().by_ending[INSITU_END_LEFT], 10);
  for (const int count : {2, 4}) {
    const auto other = run_with(count);
    const auto same = [&](const auto& a, const auto& b) {
      return a.size() == b.size() &&
             std::memcmp(a.data(), b.data(), a.size() * sizeof(a.data()[0])) == 0;
    };
    EXPECT_TRUE(same(one->particles().positions, other->particles().positions));
    EXPECT_TRUE(same(one->particles().cells, other->particles().cells));
    EXPECT_TRUE(same(one->particles().times, other->particles().times));
    EXPECT_TRUE(same(one->particles().steps, other->particles().steps));
    EXPECT_TRUE(same(one->particles().endings, other->particles().endings));
  }
}

TEST_F(Paths, Refusals) {
  const BoxMesh mesh(2, 0.0, 1.0);
  const TestField velocity = mesh.vertex_field();
  const TestField scalar(INSITU_VERTEX, mesh.points.size(), 1);
  Tracer tracer(settings, memory);
  tracer.seed(random_points(28, 3, 0.0, 1.0), 0.0);
  const auto status = [&](const TestField& now, const TestField* earlier, double t0, double t1) {
    try {
      tracer.advance(mesh.sampler(), now.view, earlier ? &earlier->view : nullptr, t0, t1, threads);
    } catch (const core::Error& e) {
      return e.status();
    }
    return INSITU_OK;
  };
  EXPECT_EQ(status(scalar, nullptr, 0, 1), INSITU_ERROR_FIELD);
  EXPECT_EQ(status(velocity, &scalar, 0, 1), INSITU_ERROR_FIELD);
  EXPECT_EQ(status(velocity, nullptr, 1, 0), INSITU_ERROR_ARGUMENT);
  EXPECT_EQ(status(velocity, nullptr, std::nan(""), 0), INSITU_ERROR_ARGUMENT);
  EXPECT_EQ(tracer.counts().alive(), 3);
  EXPECT_EQ(status(velocity, nullptr, 0, 0), INSITU_OK);
  for (auto change :
       {+[](advect::IntegratorSettings& s) { s.tolerance = 0.0; },
        +[](advect::IntegratorSettings& s) { s.step = -1.0; },
        +[](advect::IntegratorSettings& s) { s.max_steps = 0; },
        +[](advect::IntegratorSettings& s) { s.min_step = 2 * (s.max_step = 1.0); }}) {
    TracerSettings bad;
    change(bad.integrator);
    EXPECT_THROW(Tracer(bad, memory), core::Error);
  }
}

} // namespace
} // namespace insitu::test
