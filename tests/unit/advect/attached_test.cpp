// Particles that go with the material of a moving mesh.
#include <cmath>

#include "core/status.h"
#include "effects_test.h"
#include "query/walk/attached.h"

namespace insitu::test {
namespace {

class Attached : public EffectsTest {};

Vec3d bend(const Vec3d& x) {
  return {1.1 * x.x + 0.15 * x.y + 0.5, 0.9 * x.y - 0.1 * x.x * x.z, x.z + 0.2 * x.x * x.y};
}

TEST_F(Attached, ParticlesKeepCellAndCoordinatesExactly) {
  BoxMesh mesh(5, 0.0, 1.0);
  settings.attached = true;
  Tracer tracer(settings, memory);
  const auto seeds = random_points(41, 200, 0.0, 1.0);
  tracer.seed(seeds, 0.0);
  tracer.follow(mesh.sampler(), false, 0.0, 0.0, threads);
  std::vector<query::Location> before;
  for (const Vec3d& x : seeds)
    before.push_back(mesh.sampler().locate(x));
  for (int cycle = 0; cycle < 4; ++cycle) {
    mesh.move(bend);
    tracer.follow(mesh.sampler(), true, cycle, cycle + 1, threads);
  }
  const advect::Particles& p = tracer.particles();
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    EXPECT_EQ(p.endings[i], INSITU_END_ALIVE);
    EXPECT_EQ(p.times[i], 4.0);
    EXPECT_EQ(p.cells[i], before[i].cell);
    EXPECT_EQ(p.parametric[i], before[i].parametric); // to the bit
    const query::Location now = mesh.sampler().locate(p.positions[i], before[i].cell);
    ASSERT_TRUE(bool(now));
    if (now.cell == before[i].cell) {
      EXPECT_LT(distance(now.parametric, before[i].parametric), 1e-9);
    }
  }
}

TEST_F(Attached, OnOtherCellsTheyAreLocatedWhereTheyAre) {
  BoxMesh mesh(5, 0.0, 1.0);
  const BoxMesh finer(9, 0.0, 1.0), smaller(4, 0.0, 0.5);
  settings.attached = true;
  settings.duration = 2.5;
  Tracer tracer(settings, memory);
  const std::vector<Vec3d> seeds{{0.2, 0.3, 0.4}, {0.8, 0.8, 0.8}, {2.0, 0.0, 0.0}};
  tracer.seed(seeds, 0.0);
  tracer.follow(mesh.sampler(), false, 0.0, 0.0, threads);
  EXPECT_EQ(tracer.particles().endings[2], INSITU_END_SEED_OUTSIDE);
  tracer.follow(finer.sampler(), false, 0.0, 1.0, threads);
  EXPECT_EQ(tracer.positions()[0], seeds[0]);
  EXPECT_EQ(tracer.particles().cells[0], finer.sampler().locate(seeds[0]).cell);
  tracer.follow(smaller.sampler(), false, 1.0, 2.0, threads);
  EXPECT_EQ(tracer.particles().endings[0], INSITU_END_ALIVE);
  EXPECT_EQ(tracer.particles().endings[1], INSITU_END_LEFT);
  tracer.follow(smaller.sampler(), true, 2.0, 3.0, threads);
  EXPECT_EQ(tracer.particles().endings[0], INSITU_END_EXPIRED);
  EXPECT_EQ(tracer.particles().times[0], 2.5);
  EXPECT_EQ(tracer.counts().sum(), 3);
}

// What ends them is asked with the place in the material, also at the first cycle.
TEST_F(Attached, AreRemovedWhereAConditionHolds) {
  const auto run = [&](int count) {
    BoxMesh mesh(5, 0.0, 1.0);
    const core::Threads with(count);
    settings.attached = true;
    settings.duration = 2.5;
    Tracer tracer(settings, memory);
    const auto seeds = random_points(42, 300, 0.0, 1.0);
    tracer.seed(seeds, 0.0);
    effects.removes = [&](const std::vector<double>&, const query::Location& at, const Vec3d& x,
                          double age) {
      EXPECT_TRUE(bool(at));
      EXPECT_LT(distance(query::position(mesh.sampler(), at), x), 1e-14);
      return x.x > 0.9 + 0.1 * age;
    };
    tracer.set_effects(effects);
    std::vector<std::int64_t> removed_at(seeds.size(), -1);
    for (int cycle = 0; cycle < 4; ++cycle) {
      if (cycle > 0)
        mesh.move([](const Vec3d& x) { return Vec3d{1.2 * x.x, x.y, x.z}; });
      const advect::Counts counts =
          tracer.follow(mesh.sampler(), cycle > 0, std::max(0, cycle - 1), cycle, with);
      EXPECT_EQ(counts.sum(), 300);
      for (std::size_t i = 0; i < seeds.size(); ++i)
        if (removed_at[i] < 0 && tracer.particles().endings[i] == INSITU_END_REMOVED)
          removed_at[i] = cycle;
    }
    for (std::size_t i = 0; i < seeds.size(); ++i) { // the material of x is at 1.2^cycle x
      std::int64_t expected = -1;
      for (int cycle = 2; cycle >= 0; --cycle)
        if (std::pow(1.2, cycle) * seeds[i].x > 0.9 + 0.1 * cycle)
          expected = cycle;
      EXPECT_EQ(removed_at[i], expected) << i;
      EXPECT_EQ(tracer.particles().endings[i],
                expected < 0 ? INSITU_END_EXPIRED : INSITU_END_REMOVED);
      EXPECT_EQ(tracer.particles().times[i], expected < 0 ? 2.5 : double(expected));
    }
    return std::vector<Vec3d>(tracer.positions().begin(), tracer.positions().end());
  };
  EXPECT_EQ(run(1), run(3));
}

TEST_F(Attached, NothingElseMovesThem) {
  settings.attached = true;
  Tracer tracer(settings, memory);
  effects.drifts.push_back({{0, 0, -1}, {}, 1.0, {}});
  EXPECT_THROW(tracer.set_effects(effects), core::Error);
  effects = {};
  effects.boundary.emplace();
  EXPECT_THROW(tracer.set_effects(effects), core::Error);
}

} // namespace
} // namespace insitu::test
