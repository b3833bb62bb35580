// A smallest step that is given: where error control wants a smaller one, particles end.
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <vector>

#include "advect/lines/streamlines.h"
#include "earth_flow.h"
#include "effects_test.h"

namespace insitu::test {
namespace {

using advect::AtMinStep;
using advect::IntegratorSettings;
using advect::Method;

/// Piecewise constant, as a cell field: no step over the jump at x = 0.55 keeps the tolerance.
Vec3d jump(const Vec3d& x, double) {
  return x.x < 0.55 ? Vec3d{1.0, 0.0, 0.0} : Vec3d{0.5, 0.25, 0.0};
}

TEST(MinStep, EndsWhereAStepWasRefused) {
  constexpr double m = 1e-4;
  for (const Method method : {Method::bs32, Method::dopri5})
    for (const bool backward : {false, true}) {
      SCOPED_TRACE(std::to_string(int(method)) + (backward ? " backward" : " forward"));
      auto field = in_unit_cube(jump);
      IntegratorSettings settings;
      settings.method = method;
      settings.min_step = m;
      advect::State p, last;
      p.x = {backward ? 0.95 : 0.05, 0.5, 0.5};
      const Vec3d seed = p.x, v = jump(seed, 0.0);
      advect::Work work;
      const insitu_ending ending =
          advect::integrate(field, settings, backward ? -1.0 : 1.0, 1e9, p, work,
                            [&](const advect::State& s) { last = s; });
      EXPECT_EQ(ending, INSITU_END_STEP_TOO_SMALL);
      // A step of m from there would come over the jump; the one that came there did not.
      const double way = (backward ? -1.0 : 1.0) * (0.55 - p.x.x);
      EXPECT_GE(way, 0.0);
      EXPECT_LE(way, m * v.x);
      EXPECT_LT(distance(p.x, seed + p.time * v), 1e-14);
      EXPECT_EQ(p.x, last.x); // what was refused has left no trace
      EXPECT_EQ(p.time, last.time);
      EXPECT_EQ(p.length, last.length);
      EXPECT_EQ(work.forced, 0);
      EXPECT_GT(work.rejected, 0);
      EXPECT_EQ(work.evaluations, field.asked);

      settings.at_min_step = AtMinStep::take;
      const Outcome taken = run(field, settings, seed, backward ? -1.0 : 1.0);
      EXPECT_EQ(taken.ending, INSITU_END_ALIVE);
      EXPECT_GT(taken.work.forced, 0);
      EXPECT_NEAR(taken.p.x.x, backward ? 0.35 : 0.80, 2 * m);
    }
}

TEST(MinStep, StepsCutShortDoNotCount) {
  // Each of the steps is shorter than the smallest: by the end of its interval, the face of its
  // cell, the exit, and the length that is left. All keep the tolerance.
  const BoxMesh mesh(10, -1.0, 1.0);
  TestField velocity = mesh.vertex_field();
  mesh.fill(velocity, [](const Vec3d& x) { return Vec3d{-x.y, x.x, 0.5 * x.z}; });
  const query::Sampler sampler = mesh.sampler();
  for (const bool face_aware : {false, true}) {
    IntegratorSettings settings;
    settings.face_aware = face_aware;
    settings.tolerance = 1e-3;
    settings.min_step = 0.2;
    settings.max_step = 0.2;
    std::int64_t shorter = 0;
    insitu_ending ending = INSITU_END_ALIVE;
    double last = 0.0;
    advect::State p;
    p.x = {0.3, 0.2, 0.5};
    advect::Work work;
    for (int i = 1; i <= 40 && ending == INSITU_END_ALIVE; ++i) {
      advect::MeshVelocity field(sampler, velocity.view, nullptr, 0, 0, INSITU_STANDARD);
      field.begin(-1);
      ending =
          advect::integrate(field, settings, 0.05 * i, 1e9, p, work, [&](const advect::State& s) {
            shorter += s.time > last && s.time - last < 0.1;
            last = s.time;
          });
    }
    EXPECT_EQ(ending, INSITU_END_LEFT); // through z = 1, after 2 ln 2
    EXPECT_NEAR(p.time, 2.0 * std::log(2.0), 1e-3);
    EXPECT_GT(shorter, 25);
    EXPECT_EQ(work.forced, 0);
    advect::MeshVelocity field(sampler, velocity.view, nullptr, 0, 0, INSITU_STANDARD);
    field.begin(-1);
    EXPECT_EQ(run(field, settings, {0.3, 0.2, 0.0}, 10.0, 0.02).ending, INSITU_END_EXPIRED);
  }
}

TEST(MinStep, ATrialBeyondItsFaceIsNotRefused) {
  // Steep up to x = 1 and constant behind it: a step of the smallest size from 0.9 is too long for
  // the cell's own field, which goes on beyond it; the way to the face is not.
  const BoxMesh mesh(2, 0.0, 2.0, 0.0);
  TestField velocity = mesh.vertex_field();
  mesh.fill(velocity, [](const Vec3d& x) { return Vec3d{x.x < 0.5 ? 1.0 : 5.0, 0, 0}; });
  const query::Sampler sampler = mesh.sampler();
  const auto follow = [&](bool face_aware, double to) {
    IntegratorSettings settings;
    settings.face_aware = face_aware;
    settings.min_step = settings.step = 0.1;
    settings.tolerance = 1e-6;
    advect::MeshVelocity field(sampler, velocity.view, nullptr, 0, 0, INSITU_STANDARD);
    field.begin(-1);
    return run(field, settings, {0.9, 0.5, 0.5}, to);
  };
  const double to_face = std::log(5.0 / 4.6) / 4.0;
  const Outcome aware = follow(true, 0.15);
  EXPECT_EQ(aware.ending, INSITU_END_ALIVE);
  EXPECT_EQ(aware.work.forced, 0);
  EXPECT_NEAR(aware.p.x.x, 1.0 + 5.0 * (0.15 - to_face), 1e-6);
  const Outcome plain = follow(false, 0.15);
  EXPECT_EQ(plain.ending, INSITU_END_STEP_TOO_SMALL);
  EXPECT_EQ(plain.p.x, (Vec3d{0.9, 0.5, 0.5}));
}

/// Of a mesh of 4 x 4 x 4 cells: one velocity up to x = 0.5, another behind.
void jump_in_the_middle(const BoxMesh& mesh, TestField& cells, const Vec3d& left,
                        const Vec3d& right) {
  for (std::size_t c = 0; c < mesh.cell_count(); ++c)
    cells.set(c, c % 4 < 2 ? left : right);
}

class MinSteps : public EffectsTest {
protected:
  MinSteps() { settings.integrator.min_step = 0.02; }
};

TEST_F(MinSteps, InertialParticlesEndThereToo) {
  const BoxMesh mesh(4, 0.0, 1.0, 0.0);
  TestField velocity = mesh.cell_field();
  jump_in_the_middle(mesh, velocity, {1, 0, 0}, {1, 1, 0});
  effects.inertia.emplace();
  effects.inertia->response_time = 0.1;
  const auto fly = [&] {
    Tracer t(settings, memory);
    t.set_effects(effects);
    t.seed(std::vector<Vec3d>{{0.1, 0.3, 0.6}, {0.93, 0.3, 0.6}}, 0.0);
    advect::Work cost;
    for (int c = 0; c < 3; ++c)
      cost +=
          t.advance(mesh.sampler(), velocity.view, nullptr, 0.2 * c, 0.2 * (c + 1), threads).work;
    EXPECT_EQ(t.counts().sum(), 2);
    EXPECT_EQ(t.particles().endings[1], INSITU_END_LEFT);
    EXPECT_EQ(cost.forced > 0, settings.integrator.at_min_step == AtMinStep::take);
    return t;
  };
  const Tracer t = fly();
  EXPECT_EQ(t.particles().endings[0], INSITU_END_STEP_TOO_SMALL);
  const Vec3d x = t.positions()[0];
  EXPECT_LE(x.x, 0.5);
  EXPECT_GE(x.x, 0.5 - 0.02);
  EXPECT_NEAR(x.y, 0.3, 1e-12);
  EXPECT_NEAR(t.particles().times[0], x.x - 0.1, 1e-12);
  settings.integrator.at_min_step = AtMinStep::take;
  const Tracer taken = fly();
  EXPECT_EQ(taken.particles().endings[0], INSITU_END_ALIVE);
  EXPECT_NEAR(taken.positions()[0].x, 0.7, 1e-12);
  // y'' = (1 - y') / 0.1 from x = 0.5 on, which the steps meet to their own length.
  EXPECT_NEAR(taken.positions()[0].y, 0.3 + 0.2 - 0.1 * (1.0 - std::exp(-2.0)), 0.02);
}

TEST_F(MinSteps, StreamlinesEndThereBothWays) {
  const BoxMesh mesh(4, 0.0, 1.0, 0.0);
  TestField velocity = mesh.cell_field();
  jump_in_the_middle(mesh, velocity, {1, 0, 0}, {0.5, 0.25, 0});
  advect::StreamlineSettings lines;
  lines.integrator.min_step = 1e-3;
  const auto trace = [&](const std::vector<Vec3d>& seeds) {
    return advect::trace_streamlines(mesh.sampler(), velocity.view, seeds, lines, threads, memory);
  };
  const auto end = [](const advect::Streamlines& s, std::size_t line) {
    return s.lines.points[std::size_t(s.lines.offsets[line + 1]) - 1];
  };
  for (const bool walls : {false, true}) { // in lanes, and by a Mover
    lines.direction = advect::Direction::both;
    if (walls)
      lines.effects.boundary.emplace();
    const advect::Streamlines s = trace({{0.2, 0.3, 0.6}, {0.8, 0.5, 0.6}});
    EXPECT_EQ(s.counts.by_ending[INSITU_END_STEP_TOO_SMALL], 2);
    EXPECT_EQ(s.counts.by_ending[INSITU_END_LEFT], 2);
    EXPECT_EQ(s.counts.sum(), 4);
    EXPECT_EQ(s.lines.endings[0], INSITU_END_STEP_TOO_SMALL); // forward from the left
    EXPECT_LE(end(s, 0).x, 0.5);
    EXPECT_GE(end(s, 0).x, 0.5 - 1e-3);
    EXPECT_EQ(s.lines.endings[3], INSITU_END_STEP_TOO_SMALL); // backward from the right
    EXPECT_GE(end(s, 3).x, 0.5);
    EXPECT_LE(end(s, 3).x, 0.5 + 0.5e-3);
    EXPECT_NEAR(end(s, 3).y, 0.5 - 0.5 * (0.8 - end(s, 3).x), 1e-12);
  }
  lines.direction = advect::Direction::forward;
  lines.duration = 1.0;
  lines.effects.inertia.emplace();
  lines.effects.inertia->response_time = 0.1;
  const advect::Streamlines s = trace({{0.2, 0.3, 0.6}});
  EXPECT_EQ(s.lines.endings[0], INSITU_END_STEP_TOO_SMALL);
  EXPECT_LE(end(s, 0).x, 0.5);
  EXPECT_GE(end(s, 0).x, 0.5 - 1e-3);
}

TEST_F(MinSteps, OnGeodeticMeshesToo) {
  // A jump at the date line, met at 10 m/s from the west, to a metre of a step's 1000 m.
  Ocean sea(fixtures::lattice({.west = 178,
                               .south = -2,
                               .east = 182,
                               .north = 2,
                               .across = 4,
                               .along = 4,
                               .levels = {-4000, 0},
                               .jump = -360}),
            constant({0, 0, 0}));
  std::vector<double> jumps;
  for (int c = 0; c < 16; ++c)
    jumps.insert(jumps.end(), {c % 4 < 2 ? 10.0 : 5.0, c % 4 < 2 ? 0.0 : 2.0, 0.0});
  const insitu_array a = insitu_array_of(jumps.data(), INSITU_FLOAT64, 16, 3);
  sea.mesh.mesh().set_field(0, "jumps", INSITU_CELL, &a, 1);
  sea.commit();
  const mesh::FieldView velocity = sea.mesh.mesh().field("jumps");
  settings.integrator.min_step = 100.0;
  const Vec3d per_degree = metres_per_degree(0.0);
  for (const bool walls : {false, true}) {
    if (walls)
      effects = boundary(AtBoundary::slide);
    Tracer t(settings, memory);
    t.set_effects(effects);
    t.seed(std::vector<Vec3d>{{179.5, 0.0, 0.0}, {-179.5, 0.0, 0.0}}, 0.0);
    for (int c = 0; c < 2; ++c)
      t.advance(sea.sampler(), velocity, nullptr, 5000.0 * c, 5000.0 * (c + 1), threads);
    EXPECT_EQ(t.particles().endings[0], INSITU_END_STEP_TOO_SMALL);
    EXPECT_EQ(t.particles().endings[1], INSITU_END_ALIVE);
    EXPECT_EQ(t.counts().sum(), 2);
    const double way = (180.0 - t.positions()[0].x) * per_degree.x;
    EXPECT_GE(way, -1e-6);
    EXPECT_LE(way, 1001.0);
    EXPECT_NEAR(t.particles().times[0], (t.positions()[0].x - 179.5) * per_degree.x / 10.0, 1e-3);
    advect::StreamlineSettings lines;
    lines.integrator = settings.integrator;
    lines.effects = effects;
    lines.direction = advect::Direction::backward;
    const advect::Streamlines s = advect::trace_streamlines(
        sea.sampler(), velocity, std::vector<Vec3d>{{180.5, 0.0, -10.0}}, lines, threads, memory);
    EXPECT_EQ(s.lines.endings[0], INSITU_END_STEP_TOO_SMALL);
    const Vec3d end = s.lines.points[std::size_t(s.lines.offsets[1]) - 1];
    EXPECT_LE((end.x - 180.0) * per_degree.x, 501.0);
    EXPECT_GE((end.x - 180.0) * per_degree.x, -1e-6);
  }
}

TEST_F(MinSteps, SumsHoldAndThreadsDoNotMatter) {
  // A swirl of each cell, whose faces are jumps: some particles come to one.
  const BoxMesh mesh(6, 0.0, 1.0);
  TestField velocity = mesh.cell_field();
  for (std::size_t c = 0; c < mesh.cell_count(); ++c)
    velocity.set(c, {0.1 * double(c % 6) - 0.25, 0.1 * double(c / 6 % 6) - 0.25, 0.02});
  const auto seeds = random_points(91, 400, 0.2, 0.8);
  settings.integrator.min_step = 1e-3;
  const auto carry = [&](int count, bool walk) {
    effects = {};
    if (walk) {
      effects.diffusion.emplace();
      effects.diffusion->horizontal.constant = effects.diffusion->vertical.constant = 1e-6;
    }
    Tracer tracer(settings, memory);
    tracer.set_effects(effects);
    tracer.seed(seeds, 0.0);
    const core::Threads with(count);
    std::int64_t ended = 0;
    for (int c = 0; c < 3; ++c) {
      const auto before = std::vector<Vec3d>(tracer.positions().begin(), tracer.positions().end());
      const auto endings = std::vector<std::uint8_t>(tracer.particles().endings.begin(),
                                                     tracer.particles().endings.end());
      const advect::Counts counts =
          tracer.advance(mesh.sampler(), velocity.view, nullptr, 0.2 * c, 0.2 * (c + 1), with)
              .counts;
      EXPECT_EQ(counts.sum(), 400);
      EXPECT_GE(counts.by_ending[INSITU_END_STEP_TOO_SMALL], ended);
      ended = counts.by_ending[INSITU_END_STEP_TOO_SMALL];
      for (std::size_t i = 0; i < seeds.size(); ++i)
        if (endings[i] == INSITU_END_STEP_TOO_SMALL) {
          EXPECT_EQ(tracer.positions()[i], before[i]);
          EXPECT_EQ(tracer.particles().endings[i], INSITU_END_STEP_TOO_SMALL);
        }
    }
    EXPECT_GT(ended, 50);
    EXPECT_LT(ended, 400);
    return tracer;
  };
  for (const bool walk : {false, true}) {
    Tracer one = carry(1, walk);
    const Tracer three = carry(3, walk);
    EXPECT_EQ(
        std::memcmp(one.positions().data(), three.positions().data(), seeds.size() * sizeof(Vec3d)),
        0);
    EXPECT_EQ(
        std::memcmp(one.particles().endings.data(), three.particles().endings.data(), seeds.size()),
        0);
    const advect::Counts counts = one.counts();
    one.drop_ended();
    EXPECT_EQ(one.counts().by_ending, counts.by_ending);
  }
}

} // namespace
} // namespace insitu::test
