// The random walk: how far particles spread, that mixed particles stay mixed, and that nothing but
// seed, id and step number decides.
#include <cmath>
#include <cstring>
#include <numeric>

#include "core/random.h"
#include "effects_test.h"

namespace insitu::test {
namespace {

class RandomWalks : public EffectsTest {
protected:
  void diffuse(double horizontal, double vertical, std::uint64_t seed = 1) {
    effects.diffusion.emplace();
    effects.diffusion->horizontal.constant = horizontal;
    effects.diffusion->vertical.constant = vertical;
    effects.diffusion->seed = seed;
  }
};

TEST_F(RandomWalks, TheVarianceGrowsByTwoKT) {
  const BoxMesh mesh(20, -10.0, 10.0);
  const std::size_t n = 8000;
  const std::vector<Vec3d> seeds(n, Vec3d{0.0, 0.0, 0.0});
  diffuse(0.5, 0.02);
  const double time = 2.0;
  const Tracer t = run(
      mesh,
      [](const Vec3d&) {
        return Vec3d{0.5, 0, 0};
      },
      seeds, time, 4);
  const Vec3d mean{0.5 * time, 0, 0};
  for (int a = 0; a < 3; ++a) {
    const double expected = 2.0 * (a < 2 ? 0.5 : 0.02) * time;
    double sum = 0.0, squares = 0.0;
    for (const Vec3d& x : t.positions()) {
      sum += x[a] - mean[a];
      squares += (x[a] - mean[a]) * (x[a] - mean[a]);
    }
    // Of n normal numbers of variance s: the mean has the deviation sqrt(s / n), the mean square
    // s sqrt(2 / n). Six tests at 4 deviations fail once in 2600 seeds.
    EXPECT_LT(std::abs(sum / double(n)), 4.0 * std::sqrt(expected / double(n))) << a;
    EXPECT_LT(std::abs(squares / double(n) - expected), 4.0 * expected * std::sqrt(2.0 / double(n)))
        << a;
  }
  EXPECT_EQ(t.counts().alive(), std::int64_t(n));
}

/// Chi-square of the particles over 20 slabs along x, 19 degrees of freedom.
double chi_square(std::span<const Vec3d> points) {
  const int bins = 20;
  std::vector<double> count(bins, 0.0);
  for (const Vec3d& x : points)
    ++count[std::size_t(std::min(int(x.x * bins), bins - 1))];
  const double expected = double(points.size()) / bins;
  double sum = 0.0;
  for (const double c : count)
    sum += (c - expected) * (c - expected) / expected;
  return sum;
}
/// Exceeded once in 10^5 by chi-square of 19 degrees of freedom.
constexpr double chi_limit = 58.0;

TEST_F(RandomWalks, MixedParticlesStayMixedBetweenReflectingWalls) {
  const BoxMesh mesh(10, 0.0, 1.0, 0.0);
  TestField k(INSITU_VERTEX, mesh.points.size(), 1);
  fill_scalar(mesh, k, [](const Vec3d& x) { return 0.02 + 0.2 * x.x * (1.0 - x.x); });
  diffuse(0.0, 0.0, 7);
  effects.diffusion->horizontal.field = advect::FieldInTime{k.view, {}};
  effects.diffusion->step = 0.004;
  settings.integrator.method = advect::Method::euler; // nothing flows
  const auto seeds = random_points(3, 1000, 0.0, 1.0);
  const Tracer t = run(mesh, still, seeds, 2.0);
  EXPECT_EQ(t.counts().alive(), 1000);
  EXPECT_LT(chi_square(t.positions()), chi_limit);
  for (const Vec3d& x : t.positions())
    EXPECT_TRUE(in_cube(x, 0.0, 1.0));
}

TEST_F(RandomWalks, MixedParticlesStayMixedWhereTheCoefficientJumps) {
  const BoxMesh mesh(10, 0.0, 1.0, 0.0);
  TestField k(INSITU_CELL, mesh.cell_count(), 1);
  for (std::size_t c = 0; c < mesh.cell_count(); ++c)
    k.values[c] = c % 10 < 5 ? 0.01 : 0.1;
  diffuse(0.0, 0.0, 8);
  effects.diffusion->horizontal.field = advect::FieldInTime{k.view, {}};
  effects.diffusion->step = 0.002;
  settings.integrator.method = advect::Method::euler;
  const auto seeds = random_points(4, 800, 0.0, 1.0);
  const Tracer t = run(mesh, still, seeds, 1.0);
  EXPECT_LT(chi_square(t.positions()), chi_limit);
}

TEST_F(RandomWalks, WithoutTheGradientTheyWouldGather) {
  // The same test tells: a walk by the coefficient alone, made here.
  std::vector<Vec3d> points = random_points(3, 1000, 0.0, 1.0);
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::uint64_t step = 0; step < 500; ++step) {
      double& x = points[i].x;
      const double k = 0.02 + 0.2 * x * (1.0 - x);
      const double u = std::sqrt(12.0) * (core::random_unit(9, i * 500 + step, 0) - 0.5);
      x += std::sqrt(2.0 * k * 0.004) * u;
      x = x < 0.0 ? -x : x > 1.0 ? 2.0 - x : x;
    }
  EXPECT_GT(chi_square(points), 2.0 * chi_limit);
}

TEST_F(RandomWalks, TracksAreTheSameForAnyThreadsAndWhateverElseThereIs) {
  const BoxMesh mesh(6, -1.0, 1.0);
  const auto turn = [](const Vec3d& x) { return Vec3d{-x.y, x.x, 0.0}; };
  const auto seeds = random_points(6, 300, -0.9, 0.9);
  diffuse(0.05, 0.01, 42);
  const core::Threads one(1), many(4);
  const Tracer a = run(mesh, turn, seeds, 1.0, 3, &one), b = run(mesh, turn, seeds, 1.0, 3, &many);
  ASSERT_EQ(a.positions().size(), b.positions().size());
  EXPECT_EQ(std::memcmp(a.positions().data(), b.positions().data(), seeds.size() * sizeof(Vec3d)),
            0);
  // A particle walks its own way, whoever else does.
  const Tracer few = run(mesh, turn, std::span(seeds).first(10), 1.0, 3);
  for (std::size_t i = 0; i < 10; ++i)
    EXPECT_EQ(a.positions()[i], few.positions()[i]);
  diffuse(0.05, 0.01, 43);
  EXPECT_FALSE(run(mesh, turn, seeds, 1.0, 3).positions()[0] == a.positions()[0]);
}

TEST_F(RandomWalks, ACoefficientThatIsNotFiniteEndsTheParticle) {
  const BoxMesh mesh(4, 0.0, 1.0);
  TestField k(INSITU_VERTEX, mesh.points.size(), 1);
  fill_scalar(mesh, k, [](const Vec3d& x) { return x.x > 0.6 ? std::nan("") : 0.001; });
  diffuse(0.0, 0.0);
  effects.diffusion->horizontal.field = advect::FieldInTime{k.view, {}};
  const std::vector<Vec3d> seeds{{0.1, 0.5, 0.5}, {0.9, 0.5, 0.5}};
  const Tracer t = run(mesh, still, seeds, 0.1);
  EXPECT_EQ(t.particles().endings[0], INSITU_END_ALIVE);
  EXPECT_EQ(t.particles().endings[1], INSITU_END_NOT_FINITE);
}

TEST_F(RandomWalks, StepsOfTheWalkAreBounded) {
  const BoxMesh mesh(4, 0.0, 1.0);
  diffuse(1e9, 1e9);
  settings.integrator.max_steps = 100;
  const std::vector<Vec3d> seeds{{0.5, 0.5, 0.5}};
  const Tracer t = run(mesh, still, seeds, 1.0);
  EXPECT_EQ(t.particles().endings[0], INSITU_END_STEP_LIMIT);
  EXPECT_LE(work.walk_steps, 100);
}

} // namespace
} // namespace insitu::test
