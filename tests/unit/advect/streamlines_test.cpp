// Streamlines through a mesh, by the sampler.
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>

#include "advect/lines/streamlines.h"
#include "analytic.h"
#include "box_mesh.h"
#include "core/status.h"

namespace insitu::test {
namespace {

using advect::Direction;
using advect::Streamlines;
using advect::StreamlineSettings;

Vec3d swirl(const Vec3d& x) {
  return {-x.y, x.x, 0.25 * x.z};
}
Vec3d turn(const Vec3d& x) {
  return {-x.y, x.x, 0.0};
}

Vec3d last_point(const Streamlines& s, std::size_t line) {
  return s.lines.points[std::size_t(s.lines.offsets[line + 1]) - 1];
}

class Streams : public ::testing::Test {
protected:
  Streamlines trace(const BoxMesh& mesh, const TestField& velocity,
                    const std::vector<Vec3d>& seeds) {
    return advect::trace_streamlines(mesh.sampler(), velocity.view, seeds, settings, threads,
                                     memory);
  }
  core::Memory memory;
  core::Threads threads;
  StreamlineSettings settings;
};

TEST_F(Streams, RigidRotationClosesItsOrbits) {
  // Linear velocity, which trilinear cells reproduce: the orbit through all cells must close.
  const BoxMesh mesh(12, -1.0, 1.0);
  TestField velocity = mesh.vertex_field();
  mesh.fill(velocity, turn);
  const auto seeds = random_points(1, 100, -0.65, 0.65);
  settings.duration = 2 * M_PI;
  for (const double tolerance : {1e-5, 1e-8}) {
    settings.integrator.tolerance = tolerance;
    const Streamlines s = trace(mesh, velocity, seeds);
    EXPECT_EQ(s.counts.by_ending[INSITU_END_EXPIRED], 100);
    for (std::size_t l = 0; l < seeds.size(); ++l)
      EXPECT_LT(distance(last_point(s, l), seeds[l]), 2 * M_PI * tolerance);
  }
}

// In rigid rotation with a rise both the time and the length to a vertex are closed. The length of
// the curve is had to quadrature, 1e-9 of a step, and the integrator's error.
TEST_F(Streams, VerticesAtEvenDistancesInTimeAndAlongTheCurve) {
  const BoxMesh mesh(8, -1.0, 1.0);
  TestField velocity = mesh.vertex_field();
  mesh.fill(velocity, [](const Vec3d& x) { return Vec3d{-x.y, x.x, 0.125}; });
  const auto seeds = random_points(81, 20, -0.6, 0.6);
  settings.duration = 2.0;
  settings.integrator.tolerance = 1e-9;
  settings.direction = Direction::both;
  const Streamlines plain = trace(mesh, velocity, seeds);
  for (const bool by_time : {true, false})
    for (const double distance_apart : {0.013, 0.25, 0.3, 5.0}) {
      settings.even_time = by_time ? distance_apart : 0.0;
      settings.even_length = by_time ? 0.0 : distance_apart;
      const Streamlines s = trace(mesh, velocity, seeds);
      ASSERT_EQ(s.lines.line_count(), 40u);
      EXPECT_EQ(s.work.evaluations, plain.work.evaluations);
      for (std::size_t l = 0; l < 40; ++l) {
        const Vec3d seed = seeds[l / 2];
        const double sign = l % 2 == 0 ? 1.0 : -1.0;
        const double speed = std::sqrt(seed.x * seed.x + seed.y * seed.y + 0.125 * 0.125);
        EXPECT_EQ(s.lines.endings[l], plain.lines.endings[l]);
        EXPECT_EQ(last_point(s, l), last_point(plain, l)) << "the end is the end";
        const std::size_t first = std::size_t(s.lines.offsets[l]),
                          end = std::size_t(s.lines.offsets[l + 1]);
        const double whole = std::abs(s.lines.times[end - 1]);
        const double apart = by_time ? distance_apart : distance_apart / speed;
        // All whole steps before the end, the seed, and the end itself.
        EXPECT_EQ(end - first, std::size_t(std::ceil(whole / apart * (1.0 - 1e-7))) + 1);
        for (std::size_t v = first; v < end; ++v) {
          const double t = s.lines.times[v];
          if (v + 1 < end) {
            EXPECT_NEAR(t, sign * double(v - first) * apart, 1e-8);
          }
          const double c = std::cos(t), n = std::sin(t);
          EXPECT_LT(distance(s.lines.points[v], {c * seed.x - n * seed.y, n * seed.x + c * seed.y,
                                                 seed.z + 0.125 * t}),
                    1e-7);
          EXPECT_EQ(s.lines.cells[v], mesh.sampler().locate(s.lines.points[v]).cell);
        }
      }
    }
}

// A line that leaves, one that rests from the start, one seeded outside, and far too many vertices.
TEST_F(Streams, EvenVerticesWhereLinesAreShort) {
  const BoxMesh mesh(4, 0.0, 1.0);
  TestField velocity = mesh.vertex_field();
  mesh.fill(velocity, [](const Vec3d& x) { return Vec3d{x.y > 0.5 ? 0.5 : 0.0, 0, 0}; });
  const std::vector<Vec3d> seeds{{0.1, 0.9, 0.5}, {0.5, 0.1, 0.5}, {2.0, 0.5, 0.5}};
  settings.even_length = 0.25;
  const Streamlines s = trace(mesh, velocity, seeds);
  EXPECT_EQ(s.lines.offsets[1], 5); // 0.1, 0.35, 0.6, 0.85 and 1
  EXPECT_EQ(last_point(s, 0).x, 1.0);
  EXPECT_NEAR(s.lines.points[3].x, 0.85, 1e-9);
  EXPECT_EQ(s.lines.offsets[2], 6);
  EXPECT_EQ(s.lines.offsets[3], 6);
  settings.even_length = 0.0;
  settings.even_time = 1e-12;
  const Streamlines fine = trace(mesh, velocity, {seeds.data(), seeds.data() + 1});
  EXPECT_EQ(fine.lines.vertex_count(), 1'000'001u);
  EXPECT_EQ(last_point(fine, 0).x, 1.0);
}

TEST_F(Streams, BackwardReturns) {
  const BoxMesh mesh(10, -1.0, 1.0);
  TestField velocity = mesh.vertex_field();
  mesh.fill(velocity, swirl);
  const auto seeds = random_points(2, 50, -0.4, 0.4);
  settings.duration = 2.0;
  settings.integrator.tolerance = 1e-9;
  const Streamlines there = trace(mesh, velocity, seeds);
  std::vector<Vec3d> ends;
  for (std::size_t l = 0; l < seeds.size(); ++l)
    ends.push_back(last_point(there, l));
  settings.direction = Direction::backward;
  const Streamlines back = trace(mesh, velocity, ends);
  for (std::size_t l = 0; l < seeds.size(); ++l) {
    EXPECT_LT(distance(last_point(back, l), seeds[l]), 2e-8);
    EXPECT_EQ(back.lines.times[std::size_t(back.lines.offsets[l + 1]) - 1], -2.0);
  }
}

TEST_F(Streams, BothDirectionsAreTwoLines) {
  const BoxMesh mesh(6, -1.0, 1.0);
  TestField velocity = mesh.vertex_field();
  mesh.fill(velocity, swirl);
  const auto seeds = random_points(3, 20, -0.9, 0.9);
  settings.duration = 0.5;
  const Streamlines forward = trace(mesh, velocity, seeds);
  settings.direction = Direction::backward;
  const Streamlines backward = trace(mesh, velocity, seeds);
  settings.direction = Direction::both;
  const Streamlines both = trace(mesh, velocity, seeds);
  ASSERT_EQ(both.lines.line_count(), 40u);
  EXPECT_EQ(both.counts.seeded, 40);
  EXPECT_EQ(both.counts.sum(), 40);
  for (std::size_t l = 0; l < seeds.size(); ++l) {
    EXPECT_EQ(both.lines.particles[2 * l], std::int64_t(l));
    EXPECT_EQ(both.lines.particles[2 * l + 1], std::int64_t(l));
    EXPECT_EQ(last_point(both, 2 * l), last_point(forward, l));
    EXPECT_EQ(last_point(both, 2 * l + 1), last_point(backward, l));
  }
}

TEST_F(Streams, ThousandSeedsAreAccountedForAndLeaveOnTheBoundary) {
  const BoxMesh mesh(10, 0.0, 1.0);
  TestField velocity = mesh.vertex_field();
  // Drift with a little shear: everything leaves.
  mesh.fill(velocity, [](const Vec3d& x) { return Vec3d{1.0 + x.y, 0.5 - x.z, 0.3 + x.x}; });
  const auto seeds = random_points(4, 1000, -0.2, 1.2);
  for (const auto method : {advect::Method::rk4, advect::Method::dopri5}) {
    settings.integrator.method = method;
    const Streamlines s = trace(mesh, velocity, seeds);
    ASSERT_EQ(s.lines.line_count(), 1000u);
    std::int64_t outside = 0, left = 0;
    for (std::size_t l = 0; l < seeds.size(); ++l) {
      const std::int64_t first = s.lines.offsets[l], end = s.lines.offsets[l + 1];
      if (!in_cube(seeds[l], 0.0, 1.0)) {
        EXPECT_EQ(s.lines.endings[l], INSITU_END_SEED_OUTSIDE);
        EXPECT_EQ(end, first);
        ++outside;
        continue;
      }
      EXPECT_EQ(s.lines.endings[l], INSITU_END_LEFT);
      ++left;
      const Vec3d p = last_point(s, l);
      EXPECT_TRUE(in_cube(p, 0.0, 1.0));
      double gap = 1.0;
      for (int a = 0; a < 3; ++a)
        gap = std::min({gap, p[a], 1.0 - p[a]});
      EXPECT_LE(gap, 2.0 * settings.integrator.exit_tolerance * mesh.cell_size());
      // The last vertex is in the cell that it names.
      EXPECT_EQ(s.lines.cells[std::size_t(end) - 1], mesh.sampler().locate(p).cell);
      EXPECT_EQ(s.lines.points[std::size_t(first)], seeds[l]);
    }
    EXPECT_GT(outside, 500);
    EXPECT_GT(left, 300);
    EXPECT_EQ(s.counts.seeded, 1000);
    EXPECT_EQ(s.counts.by_ending[INSITU_END_SEED_OUTSIDE], outside);
    EXPECT_EQ(s.counts.by_ending[INSITU_END_LEFT], left);
    EXPECT_EQ(s.counts.sum(), 1000);
  }
}

TEST_F(Streams, VerticesAreSpaced) {
  const BoxMesh mesh(8, -1.0, 1.0);
  TestField velocity = mesh.vertex_field();
  mesh.fill(velocity, turn);
  settings.duration = 6.0;
  settings.integrator.max_step = 0.01;
  const std::vector<Vec3d> seeds{{0.8, 0.0, 0.1}};
  settings.spacing = 0.0;
  const Streamlines every = trace(mesh, velocity, seeds);
  settings.spacing = 0.5;
  const Streamlines spaced = trace(mesh, velocity, seeds);
  EXPECT_EQ(every.lines.vertex_count(), std::size_t(every.work.steps) + 1);
  EXPECT_EQ(spaced.work.steps, every.work.steps);
  EXPECT_LT(spaced.lines.vertex_count() * 8, every.lines.vertex_count());
  EXPECT_EQ(last_point(spaced, 0), last_point(every, 0));
}

TEST_F(Streams, FieldsAtTheEdgeOfNumbers) {
  const BoxMesh mesh(5, 0.0, 1.0);
  TestField velocity = mesh.vertex_field();
  const auto seeds = random_points(5, 40, 0.1, 0.9);
  const auto all_end = [&](double v, double duration, insitu_ending ending) {
    mesh.fill(velocity, [&](const Vec3d&) { return Vec3d{v, 0, v / 2}; });
    settings.duration = duration;
    const Streamlines s = trace(mesh, velocity, seeds);
    EXPECT_EQ(s.counts.by_ending[ending], 40) << v << " for " << duration;
    EXPECT_EQ(s.counts.sum(), 40);
  };
  const double infinity = std::numeric_limits<double>::infinity();
  all_end(0.0, 1.0, INSITU_END_STAGNATED);
  all_end(0.0, infinity, INSITU_END_STAGNATED);
  all_end(1e-30, 1.0, INSITU_END_STAGNATED);
  all_end(1e-30, infinity, INSITU_END_LEFT);
  all_end(1e30, 1.0, INSITU_END_LEFT);
  all_end(-1e30, infinity, INSITU_END_LEFT);
  all_end(std::numeric_limits<double>::quiet_NaN(), 1.0, INSITU_END_NOT_FINITE);
  all_end(infinity, 1.0, INSITU_END_NOT_FINITE);
}

TEST_F(Streams, CellFieldTurnsAtFaces) {
  // Constant per cell: along x in the left half, along y in the right one.
  const BoxMesh mesh(4, 0.0, 1.0, 0.0);
  TestField velocity = mesh.cell_field();
  for (std::size_t c = 0; c < mesh.cell_count(); ++c)
    velocity.set(c, c % 4 < 2 ? Vec3d{1, 0, 0} : Vec3d{0.1, 1, 0});
  const Streamlines s = trace(mesh, velocity, {{0.1, 0.1, 0.6}});
  EXPECT_EQ(s.lines.endings[0], INSITU_END_LEFT);
  const Vec3d end = last_point(s, 0);
  EXPECT_NEAR(end.x, 0.59, 0.01 * 0.25); // a hundredth of a cell at the one jump
  EXPECT_NEAR(end.y, 1.0, 1e-9);
  EXPECT_LT(s.work.steps, 100);
  settings.integrator.min_step = 1e-7;
  const Streamlines stuck = trace(mesh, velocity, {{0.1, 0.1, 0.6}});
  EXPECT_EQ(stuck.lines.endings[0], INSITU_END_STEP_TOO_SMALL);
  EXPECT_LE(last_point(stuck, 0).x, 0.5);
  EXPECT_NEAR(last_point(stuck, 0).x, 0.5, 1e-7);
  EXPECT_NEAR(last_point(stuck, 0).y, 0.1, 1e-9);
  settings.integrator.at_min_step = advect::AtMinStep::take;
  EXPECT_NEAR(last_point(trace(mesh, velocity, {{0.1, 0.1, 0.6}}), 0).x, 0.59, 1e-6);
}

TEST_F(Streams, NotFiniteCellStopsAtItsFace) {
  const BoxMesh mesh(4, 0.0, 1.0, 0.0);
  TestField velocity = mesh.cell_field();
  for (std::size_t c = 0; c < mesh.cell_count(); ++c)
    velocity.set(c, {c % 4 < 3 ? 1.0 : std::numeric_limits<double>::quiet_NaN(), 0, 0});
  const Streamlines s = trace(mesh, velocity, {{0.1, 0.1, 0.6}});
  EXPECT_EQ(s.lines.endings[0], INSITU_END_NOT_FINITE);
  EXPECT_NEAR(last_point(s, 0).x, 0.75, 1e-9);
}

TEST_F(Streams, LengthLimit) {
  const BoxMesh mesh(8, -1.0, 1.0);
  TestField velocity = mesh.vertex_field();
  mesh.fill(velocity, turn);
  settings.length = 3.0;
  const Streamlines s = trace(mesh, velocity, {{0.5, 0.0, 0.0}});
  EXPECT_EQ(s.lines.endings[0], INSITU_END_EXPIRED);
  const Vec3d end = last_point(s, 0);
  EXPECT_NEAR(std::remainder(std::atan2(end.y, end.x) - 6.0, 2 * M_PI), 0.0, 0.03);
}

TEST_F(Streams, SameBytesForAnyThreadCount) {
  const BoxMesh mesh(10, -1.0, 1.0);
  TestField velocity = mesh.vertex_field();
  mesh.fill(velocity, [](const Vec3d& x) { return abc_flow(3.0 * x, 0.0); });
  const auto seeds = random_points(6, 300, -1.0, 1.0);
  settings.duration = 5.0;
  const auto with = [&](int count) {
    return advect::trace_streamlines(mesh.sampler(), velocity.view, seeds, settings,
                                     core::Threads(count), memory);
  };
  const Streamlines one = with(1);
  ASSERT_GT(one.lines.vertex_count(), 3000u);
  for (const int count : {2, 4}) {
    const Streamlines other = with(count);
    ASSERT_EQ(other.lines.vertex_count(), one.lines.vertex_count());
    EXPECT_EQ(std::memcmp(other.lines.points.data(), one.lines.points.data(),
                          one.lines.vertex_count() * sizeof(Vec3d)),
              0);
    EXPECT_EQ(std::memcmp(other.lines.times.data(), one.lines.times.data(),
                          one.lines.vertex_count() * sizeof(double)),
              0);
    EXPECT_EQ(std::memcmp(other.lines.cells.data(), one.lines.cells.data(),
                          one.lines.vertex_count() * sizeof(std::int64_t)),
              0);
    EXPECT_EQ(other.work.evaluations, one.work.evaluations);
  }
}

TEST_F(Streams, NoSeedsNoLines) {
  const BoxMesh mesh(2, 0.0, 1.0);
  TestField velocity = mesh.vertex_field();
  const Streamlines s = trace(mesh, velocity, {});
  EXPECT_EQ(s.lines.line_count(), 0u);
  EXPECT_EQ(s.lines.offsets.size(), 1u);
  EXPECT_EQ(s.counts.sum(), 0);
}

TEST_F(Streams, RefusesWhatIsNotAVelocity) {
  const BoxMesh mesh(2, 0.0, 1.0);
  const TestField pressure(INSITU_VERTEX, mesh.points.size(), 1);
  try {
    trace(mesh, pressure, {{0.5, 0.5, 0.5}});
    FAIL();
  } catch (const core::Error& e) {
    EXPECT_EQ(e.status(), INSITU_ERROR_FIELD);
    EXPECT_STREQ(e.what(), "tracer: velocity 'velocity' needs 3 components, it has 1");
  }
  const TestField velocity = mesh.vertex_field();
  settings.integrator.tolerance = -1.0;
  EXPECT_THROW(trace(mesh, velocity, {{0.5, 0.5, 0.5}}), core::Error);
}

TEST_F(Streams, MemoryIsCountedAndGivenBack) {
  const BoxMesh mesh(4, 0.0, 1.0);
  TestField velocity = mesh.vertex_field();
  mesh.fill(velocity, [](const Vec3d&) { return Vec3d{1, 0, 0}; });
  {
    const Streamlines s = trace(mesh, velocity, random_points(7, 20, 0.0, 1.0));
    EXPECT_GE(memory.current(INSITU_MEMORY_TRACER),
              std::int64_t(s.lines.vertex_count() * (sizeof(Vec3d) + 16)));
  }
  EXPECT_EQ(memory.current(), 0);
}

} // namespace
} // namespace insitu::test
