// Particles that go from a step to the next one on other cells.
#include <array>
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>

#include "advect/pathlines.h"
#include "analytic.h"
#include "box_mesh.h"
#include "core/status.h"
#include "remeshed.h"

namespace insitu::test {
namespace {

using advect::Advance;
using advect::Tracer;
using advect::TracerSettings;

/// Meshes that have nothing in common but the cube.
const std::array<std::pair<MeshKind, int>, 6> makes = {{{MeshKind::hexahedra, 5},
                                                        {MeshKind::tetrahedra, 4},
                                                        {MeshKind::mixed, 4},
                                                        {MeshKind::wedges, 6},
                                                        {MeshKind::pyramids, 3},
                                                        {MeshKind::hexahedra, 9}}};

TestMesh cube_of(std::size_t step) {
  const auto& [kind, size] = makes[step % makes.size()];
  return Remeshed::cube(kind, size, 100 + step);
}

/// Where a flow takes a particle, to rounding.
Vec3d exact(const Flow& flow, const Vec3d& seed, double from, double to) {
  auto field = unbounded(flow);
  advect::IntegratorSettings settings;
  settings.tolerance = 1e-13;
  advect::State p;
  p.x = seed;
  p.time = from;
  advect::Work work;
  advect::integrate(field, settings, to, Analytic<Flow>::inf, p, work, [](const advect::State&) {});
  return p.x;
}

double largest_error(const Tracer& tracer, const Flow& flow, std::span<const Vec3d> seeds,
                     double end) {
  double largest = 0.0;
  for (std::size_t i = 0; i < seeds.size(); ++i)
    largest = std::max(largest, distance(tracer.positions()[i], exact(flow, seeds[i], 0.0, end)));
  return largest;
}

class Crossing : public ::testing::Test {
protected:
  core::Memory memory;
  core::Threads threads;
  TracerSettings settings;

  /// Particles through `steps` steps to `end`, each on other cells than the one before.
  Tracer through(const Flow& flow, std::span<const Vec3d> seeds, double end, int steps,
                 bool whole) {
    Remeshed solver;
    Tracer tracer(settings, memory);
    tracer.seed(seeds, 0.0);
    const Advance a = solver.carry(tracer, cube_of, flow, end, steps, whole);
    EXPECT_EQ(a.counts.alive(), std::int64_t(seeds.size()));
    return tracer;
  }
};

Vec3d linear_in_space_and_time(const Vec3d& x, double t) {
  return {0.1 - 0.3 * x.y + t * (0.2 * x.z - 0.05), 0.3 * x.x - 0.15 + 0.1 * t * x.y,
          0.05 - 0.1 * x.z + t * (0.1 * x.x - 0.02)};
}

// What is linear in space is what each mesh says, whatever its cells, and what is linear in time is
// what lies between the two.
TEST_F(Crossing, ExactForFlowsLinearInSpaceAndTime) {
  const Flow flow = linear_in_space_and_time;
  settings.integrator.tolerance = 1e-11;
  const auto seeds = random_points(61, 40, 0.3, 0.7);
  // Two steps: the time of each is long, and all that blends is right or wrong at once.
  EXPECT_LT(largest_error(through(flow, seeds, 0.8, 1, true), flow, seeds, 0.8), 1e-10);
  EXPECT_LT(largest_error(through(flow, seeds, 0.8, 6, true), flow, seeds, 0.8), 1e-10);
  EXPECT_GT(largest_error(through(flow, seeds, 0.8, 6, false), flow, seeds, 0.8), 1e-3);
  settings.integrator.method = advect::Method::rk4;
  settings.integrator.step = 0.01;
  EXPECT_LT(largest_error(through(flow, seeds, 0.8, 6, true), flow, seeds, 0.8), 1e-9);
}

// With the current velocity throughout, it is of order 1.
TEST_F(Crossing, OrderTwoInTheTimeBetweenSteps) {
  const Flow flow = [](const Vec3d& x, double t) {
    const double rate = 1.0 + std::sin(3.0 * t);
    return Vec3d{-rate * (x.y - 0.5), rate * (x.x - 0.5), 0.2 * std::cos(4.0 * t) * (x.z - 0.5)};
  };
  settings.integrator.tolerance = 1e-9;
  const auto seeds = random_points(62, 12, 0.3, 0.7);
  double before[2] = {};
  for (const int steps : {12, 24, 48}) {
    const double error[2] = {
        largest_error(through(flow, seeds, 1.5, steps, true), flow, seeds, 1.5),
        largest_error(through(flow, seeds, 1.5, steps, false), flow, seeds, 1.5)};
    if (steps > 12) {
      const double order = std::log2(before[0] / error[0]), once = std::log2(before[1] / error[1]);
      RecordProperty("whole_" + std::to_string(steps), std::to_string(order));
      RecordProperty("current_" + std::to_string(steps), std::to_string(once));
      std::printf("%d steps: order %.2f (error %.1e); by the current velocity %.2f (%.1e)\n", steps,
                  order, error[0], once, error[1]);
      EXPECT_NEAR(order, 2.0, 0.15);
      EXPECT_NEAR(once, 1.0, 0.2);
    }
    before[0] = error[0];
    before[1] = error[1];
  }
}

// A box that goes with the flow, meshed anew at every step: where the new one has no cells yet at
// the beginning, the earlier step's velocity serves, and no particle is lost.
TEST_F(Crossing, ADomainThatMovesKeepsItsParticles) {
  const Flow flow = [](const Vec3d&, double) { return Vec3d{0.3, 0, 0}; };
  const auto box = [](std::size_t step) {
    const auto& [kind, size] = makes[step % makes.size()];
    return Remeshed::cube(kind, size, step, [&](const Vec3d& x) {
      return x + Vec3d{0.3 * double(step), 0, 0};
    });
  };
  for (const auto& [whole, walls] : {std::pair{true, false}, {true, true}, {false, false}}) {
    Remeshed solver;
    Tracer tracer(settings, memory);
    if (walls) {
      advect::Effects effects;
      effects.boundary.emplace();
      effects.boundary->response = advect::AtBoundary::slide;
      tracer.set_effects(effects);
    }
    const auto seeds = random_points(63, 300, 0.001, 0.999);
    tracer.seed(seeds, 0.0);
    solver.remesh(box(0), flow, 0.0);
    tracer.advance(solver.mesh.sampler(), solver.velocity(), nullptr, 0.0, 0.0, threads);
    for (std::size_t s = 1; s <= 6; ++s) {
      solver.keep();
      solver.remesh(box(s), flow, double(s));
      const auto before = solver.before();
      const Advance a =
          tracer.advance(solver.mesh.sampler(), solver.velocity(), nullptr, double(s - 1),
                         double(s), threads, nullptr, whole ? &*before : nullptr);
      EXPECT_EQ(a.counts.sum(), 300);
    }
    if (whole) {
      ASSERT_EQ(tracer.counts().alive(), 300);
      for (std::size_t i = 0; i < seeds.size(); ++i)
        EXPECT_LT(distance(tracer.positions()[i], seeds[i] + Vec3d{1.8, 0, 0}), 1e-12);
    } else {
      EXPECT_LT(tracer.counts().alive(), 250);
    }
  }
}

// A particle that ends up where there are no cells any more has left, at the end of the interval; a
// seed there never began.
TEST_F(Crossing, WhereCellsAreNoMoreParticlesHaveLeft) {
  const Flow still = [](const Vec3d&, double) { return Vec3d{}; };
  Remeshed solver;
  Tracer tracer(settings, memory);
  tracer.seed(std::vector<Vec3d>{{0.25, 0.5, 0.5}, {0.75, 0.5, 0.5}, {2, 2, 2}}, 0.0);
  solver.remesh(cube_of(0), still, 0.0);
  tracer.advance(solver.mesh.sampler(), solver.velocity(), nullptr, 0.0, 0.0, threads);
  solver.keep();
  solver.remesh(Remeshed::cube(MeshKind::tetrahedra, 3, 5,
                               [](const Vec3d& x) {
                                 return x + Vec3d{0.5, 0, 0};
                               }),
                still, 1.0);
  tracer.seed(std::vector<Vec3d>{{0.3, 0.4, 0.5}, {1.3, 0.4, 0.5}}, 1.0);
  tracer.seed(std::vector<Vec3d>{{1.4, 0.4, 0.5}}, 0.5); // new cells serve as soon as they may
  const auto before = solver.before();
  const Advance a = tracer.advance(solver.mesh.sampler(), solver.velocity(), nullptr, 0.0, 1.0,
                                   threads, nullptr, &*before);
  EXPECT_EQ(a.counts.sum(), 6);
  const insitu_ending expected[6] = {INSITU_END_LEFT,         INSITU_END_ALIVE,
                                     INSITU_END_SEED_OUTSIDE, INSITU_END_SEED_OUTSIDE,
                                     INSITU_END_ALIVE,        INSITU_END_ALIVE};
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_EQ(tracer.particles().endings[i], expected[i]) << i;
  EXPECT_EQ(tracer.particles().times[0], 1.0);
  EXPECT_EQ(tracer.particles().cells[0], -1);
}

// Both meshes end at x = 1: exits lie on that face, as on one mesh.
TEST_F(Crossing, ExitsLieOnTheFace) {
  const Flow flow = [](const Vec3d& x, double t) {
    return Vec3d{0.4 + 0.3 * x.y * t, 0.05 * std::sin(x.x), 0.0};
  };
  Remeshed solver;
  Tracer tracer(settings, memory);
  tracer.seed(random_points(64, 200, 0.2, 0.95), 0.0);
  solver.remesh(cube_of(0), flow, 0.0);
  tracer.advance(solver.mesh.sampler(), solver.velocity(), nullptr, 0.0, 0.0, threads);
  solver.keep();
  solver.remesh(cube_of(1), flow, 1.0);
  const auto before = solver.before();
  const Advance a = tracer.advance(solver.mesh.sampler(), solver.velocity(), nullptr, 0.0, 1.0,
                                   threads, nullptr, &*before);
  EXPECT_EQ(a.counts.sum(), 200);
  EXPECT_GT(a.counts.by_ending[INSITU_END_LEFT], 30);
  EXPECT_EQ(a.counts.sum(), a.counts.alive() + a.counts.by_ending[INSITU_END_LEFT]);
  for (std::size_t i = 0; i < 200; ++i)
    if (tracer.particles().endings[i] == INSITU_END_LEFT) {
      EXPECT_EQ(tracer.positions()[i].x, 1.0);
      EXPECT_LT(tracer.particles().times[i], 1.0);
    }
}

// Vertices that moved between the last execution and the change do not count: the step is where the
// particles are.
TEST_F(Crossing, TheEarlierStepIsWhereItWasKept) {
  const Flow flow = [](const Vec3d& x, double) { return Vec3d{0.2 * x.y, 0.1, -0.1 * x.x}; };
  Remeshed solver;
  solver.remesh(cube_of(0), flow, 0.0);
  const auto points = random_points(65, 50, 0.01, 0.99);
  const auto sampled = [&](const query::Sampler& sampler, const mesh::FieldView& velocity) {
    std::vector<Vec3d> values;
    for (const Vec3d& x : points) {
      const query::Location at = sampler.locate(x);
      double v[3] = {1e9, 1e9, 1e9};
      if (at)
        sampler.interpolate(velocity, at, v);
      values.push_back({v[0], v[1], v[2]});
    }
    return values;
  };
  const auto truth = sampled(solver.mesh.sampler(), solver.velocity());
  solver.keep();
  solver.move([](const Vec3d& x) { return 0.5 * x + Vec3d{0.4, 0.5, 0.5}; }, flow, 0.5);
  solver.remesh(cube_of(1), flow, 1.0);
  solver.remesh(cube_of(2), flow, 1.0); // once more, without an execution between
  ASSERT_TRUE(solver.before());
  EXPECT_EQ(sampled(solver.before()->sampler, solver.before()->velocity), truth);
}

TEST_F(Crossing, SameBytesForAnyThreadCount) {
  const Flow flow = [](const Vec3d& x, double t) { return 0.5 * abc_flow(5.0 * x, t); };
  const auto run = [&](int count) {
    Remeshed solver(count);
    auto tracer = std::make_unique<Tracer>(settings, memory);
    tracer->seed(random_points(66, 400, -0.05, 1.05), 0.0);
    solver.remesh(cube_of(0), flow, 0.0);
    tracer->advance(solver.mesh.sampler(), solver.velocity(), nullptr, 0.0, 0.0, solver.threads);
    for (int s = 1; s <= 4; ++s) {
      solver.keep();
      solver.remesh(cube_of(std::size_t(s)), flow, 0.1 * s);
      const auto before = solver.before();
      tracer->advance(solver.mesh.sampler(), solver.velocity(), nullptr, 0.1 * (s - 1), 0.1 * s,
                      solver.threads, nullptr, &*before);
      EXPECT_EQ(tracer->counts().sum(), 400);
    }
    return tracer;
  };
  const auto one = run(1);
  EXPECT_GT(one->counts().alive(), 50);
  EXPECT_GT(one->counts().by_ending[INSITU_END_LEFT], 50);
  for (const int count : {2, 5}) {
    const auto other = run(count);
    const auto same = [](const auto& a, const auto& b) {
      return a.size() == b.size() &&
             std::memcmp(a.data(), b.data(), a.size() * sizeof(a.data()[0])) == 0;
    };
    EXPECT_TRUE(same(one->particles().positions, other->particles().positions));
    EXPECT_TRUE(same(one->particles().cells, other->particles().cells));
    EXPECT_TRUE(same(one->particles().times, other->particles().times));
    EXPECT_TRUE(same(one->particles().endings, other->particles().endings));
  }
}

// Under walls the current mesh alone says what is inside, and drifts are blended like the velocity.
TEST_F(Crossing, EffectsGoAlong) {
  const Flow flow = [](const Vec3d&, double t) { return Vec3d{0.6 * t, 0.1, 0}; };
  for (const bool walls : {false, true}) {
    Remeshed solver;
    Tracer tracer(settings, memory);
    tracer.seed(std::vector<Vec3d>{{0.2, 0.5, 0.5}, {0.8, 0.5, 0.5}}, 0.0);
    solver.remesh(cube_of(0), flow, 0.0);
    const auto effects_by = [&](const mesh::FieldView& wind) {
      advect::Effects effects;
      advect::Drift drift;
      drift.field = advect::FieldInTime{wind, {}};
      drift.factor = 0.5;
      effects.drifts = {drift};
      if (walls) {
        effects.boundary.emplace();
        effects.boundary->response = advect::AtBoundary::slide;
      }
      return effects;
    };
    tracer.set_effects(effects_by(solver.velocity()));
    tracer.advance(solver.mesh.sampler(), solver.velocity(), nullptr, 0.0, 0.0, threads);
    solver.keep();
    solver.remesh(cube_of(1), flow, 1.0);
    auto before = solver.before();
    before->drifts = effects_by(before->velocity).drifts;
    tracer.set_effects(effects_by(solver.velocity()));
    const Advance a = tracer.advance(solver.mesh.sampler(), solver.velocity(), nullptr, 0.0, 1.0,
                                     threads, nullptr, &*before);
    EXPECT_TRUE(a.blended_velocity);
    // 1.5 times the integral of 0.6 t and 0.1
    EXPECT_LT(distance(tracer.positions()[0], {0.2 + 0.45, 0.65, 0.5}), 1e-9);
    EXPECT_EQ(tracer.particles().endings[1], walls ? INSITU_END_ALIVE : INSITU_END_LEFT);
    if (walls) {
      EXPECT_LT(distance(tracer.positions()[1], {1.0, 0.65, 0.5}), 1e-6);
    }
  }
}

// Particles as dense as the fluid, with its added mass, go with it, whatever their response time,
// if Du/Dt is right: the change from one mesh to the other, and the blended gradient.
TEST_F(Crossing, InertiaFeelsTheChangeFromOneMeshToTheOther) {
  const Flow flow = linear_in_space_and_time;
  settings.integrator.tolerance = 1e-11;
  const auto seeds = random_points(67, 20, 0.3, 0.7);
  advect::Effects effects;
  effects.inertia.emplace();
  effects.inertia->response_time = 2.0;
  effects.inertia->fluid_share = 1.0;
  for (const bool whole : {true, false}) {
    Remeshed solver;
    Tracer tracer(settings, memory);
    tracer.set_effects(effects);
    tracer.seed(seeds, 0.0);
    solver.remesh(cube_of(0), flow, 0.0);
    tracer.advance(solver.mesh.sampler(), solver.velocity(), nullptr, 0.0, 0.0, threads);
    for (int s = 1; s <= 4; ++s) {
      solver.keep();
      solver.remesh(cube_of(std::size_t(s)), flow, 0.2 * s);
      const auto before = solver.before();
      tracer.advance(solver.mesh.sampler(), solver.velocity(), nullptr, 0.2 * (s - 1), 0.2 * s,
                     threads, nullptr, whole ? &*before : nullptr);
    }
    ASSERT_EQ(tracer.counts().alive(), 20);
    const double error = largest_error(tracer, flow, seeds, 0.8);
    EXPECT_EQ(error < 1e-9, whole) << error;
    EXPECT_EQ(error > 1e-4, !whole) << error;
  }
}

TEST_F(Crossing, IsReleasedAndCostsNothingUnlessAsked) {
  const Flow flow = [](const Vec3d& x, double) { return x; };
  Remeshed solver;
  const auto earlier = [&] { return solver.memory.current(INSITU_MEMORY_EARLIER); };
  const auto tree = [&] { return solver.memory.current(INSITU_MEMORY_TREE); };
  const TestMesh coarse = Remeshed::cube(MeshKind::hexahedra, 8, 3),
                 fine = Remeshed::cube(MeshKind::tetrahedra, 6, 4);
  const auto steps = [](const TestMesh& m) { return 48 * std::int64_t(m.vertices.size()); };
  solver.remesh(coarse, flow, 0.0);
  const std::int64_t one_tree = tree();
  solver.keep(false);
  EXPECT_EQ(earlier(), steps(coarse));
  solver.keep();
  EXPECT_EQ(earlier(), steps(coarse) + 8 * 4 * 512);
  EXPECT_EQ(earlier(), steps(coarse) + solver.mesh.earlier_cells_bytes(threads));
  solver.remesh(fine, flow, 1.0);
  ASSERT_TRUE(solver.mesh.earlier_mesh());
  EXPECT_EQ(earlier(), steps(coarse) + 8 * 4 * 512) << "until particles have crossed";
  const std::int64_t both = tree();
  solver.keep();
  EXPECT_FALSE(solver.mesh.earlier_mesh());
  EXPECT_EQ(earlier(), steps(fine) + solver.mesh.earlier_cells_bytes(threads));
  EXPECT_LE(tree(), both - one_tree);
  solver.mesh.release_earlier();
  EXPECT_EQ(earlier(), 0);
  solver.remesh(coarse, flow, 2.0);
  EXPECT_FALSE(solver.mesh.earlier_mesh());
}

} // namespace
} // namespace insitu::test
