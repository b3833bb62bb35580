// Particles that go with the material of a moving mesh.
#include <cmath>

#include "effects_test.h"

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

} // namespace
} // namespace insitu::test
