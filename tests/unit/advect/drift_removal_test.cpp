// Velocities that are added to the flow's, and conditions that remove particles.
#include <cmath>

#include "core/status.h"
#include "effects_test.h"

namespace insitu::test {
namespace {

class Drifts : public EffectsTest {};

TEST_F(Drifts, AConstantVelocityIsAdded) {
  const BoxMesh mesh(4, 0.0, 1.0);
  effects.drifts.push_back({{0.0, 0.0, -0.2}, {}, 1.0, {}});
  const std::vector<Vec3d> seeds{{0.2, 0.5, 0.9}};
  const Tracer t = run(
      mesh,
      [](const Vec3d&) {
        return Vec3d{0.1, 0, 0};
      },
      seeds, 3.0, 3);
  EXPECT_LT(distance(t.positions()[0], {0.5, 0.5, 0.3}), 1e-12);
}

TEST_F(Drifts, ASecondFieldHasItsFactorAndIsBlendedInTime) {
  const BoxMesh mesh(4, 0.0, 1.0);
  TestField wind = mesh.vertex_field(), calm = mesh.vertex_field();
  mesh.fill(wind, [](const Vec3d&) { return Vec3d{10.0, 20.0, 0.0}; });
  mesh.fill(calm, still);
  effects.drifts.push_back({{}, advect::FieldInTime{wind.view, {calm.view}}, 0.03, {}});
  const std::vector<Vec3d> seeds{{0.2, 0.2, 0.5}};
  const Tracer t = run(mesh, still, seeds, 1.0);
  EXPECT_LT(distance(t.positions()[0], {0.2 + 0.15, 0.2 + 0.3, 0.5}), 1e-12);
}

TEST_F(Drifts, ASpeedThatVariesIsIntegratedAsAccuratelyAsTheFlow) {
  // dz/dt = -z: z(t) = z0 exp(-t); the speed is a field, down is -z.
  const BoxMesh mesh(4, 0.0, 1.0);
  TestField speed(INSITU_VERTEX, mesh.points.size(), 1);
  fill_scalar(mesh, speed, [](const Vec3d& x) { return x.z; });
  effects.drifts.push_back({{}, advect::FieldInTime{speed.view, {}}, 1.0, {0, 0, -1}});
  settings.integrator.tolerance = 1e-10;
  const std::vector<Vec3d> seeds{{0.3, 0.3, 0.8}};
  const Tracer t = run(mesh, still, seeds, 2.0);
  // Trilinear in jittered cells: z itself is in their span, so only the integrator errs.
  EXPECT_LT(distance(t.positions()[0], {0.3, 0.3, 0.8 * std::exp(-2.0)}), 1e-9);
}

TEST_F(Drifts, WithoutEffectsTracksAreTheSameToTheBit) {
  const BoxMesh mesh(6, -1.0, 1.0);
  const auto turn = [](const Vec3d& x) { return Vec3d{-x.y, x.x, 0.1 * x.x * x.y}; };
  const auto seeds = random_points(5, 100, -0.6, 0.6);
  const Tracer plain = run(mesh, turn, seeds, 2.0, 4);
  effects.drifts.push_back({}); // an effect that adds nothing goes the other way
  const Tracer with = run(mesh, turn, seeds, 2.0, 4);
  for (std::size_t i = 0; i < seeds.size(); ++i)
    EXPECT_EQ(plain.positions()[i], with.positions()[i]);
}

TEST_F(Drifts, FieldsOfTheWrongShapeAreRefused) {
  const BoxMesh mesh(2, 0.0, 1.0);
  TestField two(INSITU_VERTEX, mesh.points.size(), 2), three = mesh.vertex_field();
  Tracer tracer(settings, memory);
  effects.drifts.push_back({{}, advect::FieldInTime{two.view, {}}, 1.0, {}});
  EXPECT_THROW(tracer.set_effects(effects), core::Error);
  effects.drifts.clear();
  effects.diffusion.emplace();
  effects.diffusion->horizontal.field = advect::FieldInTime{three.view, {}};
  EXPECT_THROW(tracer.set_effects(effects), core::Error);
  effects.diffusion->horizontal = {-1.0, {}};
  EXPECT_THROW(tracer.set_effects(effects), core::Error);
  effects.diffusion->horizontal = {1.0, {}};
  effects.inertia.emplace();
  EXPECT_NO_THROW(tracer.set_effects(effects));
  effects.inertia->response_time = std::nan("");
  EXPECT_THROW(tracer.set_effects(effects), core::Error);
}

class Removal : public EffectsTest {};

TEST_F(Removal, EndsParticlesWhereTheConditionHolds) {
  const BoxMesh mesh(4, 0.0, 1.0);
  effects.removes = [](const std::vector<double>&, const query::Location& at, const Vec3d& x,
                       double age) { return at.cell >= 0 && (x.x > 0.7 || age > 2.5); };
  const std::vector<Vec3d> seeds{{0.1, 0.5, 0.5}, {0.65, 0.5, 0.5}, {0.1, 0.2, 5.0}};
  const Tracer t = run(
      mesh,
      [](const Vec3d&) {
        return Vec3d{0.1, 0, 0};
      },
      seeds, 3.0, 3);
  EXPECT_EQ(t.particles().endings[0], INSITU_END_REMOVED);
  EXPECT_EQ(t.particles().times[0], 3.0);
  EXPECT_EQ(t.particles().endings[1], INSITU_END_REMOVED);
  EXPECT_EQ(t.particles().times[1], 1.0); // asked for once in each advance, at its end
  EXPECT_NEAR(t.positions()[1].x, 0.75, 1e-12);
  EXPECT_EQ(t.particles().endings[2], INSITU_END_SEED_OUTSIDE);
  EXPECT_EQ(t.counts().sum(), 3);
}

} // namespace
} // namespace insitu::test
