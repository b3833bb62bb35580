// Particles that leave end on the boundary's face, on the mesh, at the right time.
#include <cmath>
#include <gtest/gtest.h>

#include "advect/field/mesh_velocity.h"
#include "advect/pathlines.h"
#include "analytic.h"
#include "box_mesh.h"

namespace insitu::test {
namespace {

using advect::IntegratorSettings;
using advect::Method;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr Method all_methods[] = {Method::euler, Method::rk4, Method::bs32, Method::dopri5};

/// A particle that left through a side of the cube [low, high]: on it, owned, the normal outwards.
void expect_on_side(const BoxMesh& box, const advect::MeshVelocity& field, const Outcome& r,
                    double low, double high) {
  ASSERT_EQ(r.ending, INSITU_END_LEFT);
  int sides = 0;
  for (int a = 0; a < 3; ++a) {
    const bool at_low = r.p.x[a] == low, at_high = r.p.x[a] == high;
    sides += at_low || at_high;
    if (std::abs(r.p.exit_normal[a]) > 0.5) {
      EXPECT_TRUE(r.p.exit_normal[a] > 0 ? at_high : at_low) << r.p.x[a];
      EXPECT_NEAR(std::abs(r.p.exit_normal[a]), 1.0, 1e-12);
    }
  }
  EXPECT_GE(sides, 1);
  EXPECT_GE(r.p.exit_face, 0);
  const query::Location at = box.sampler().locate(r.p.x);
  ASSERT_TRUE(at);
  EXPECT_EQ(at.cell, field.cell());
}

TEST(Exit, LiesOnTheSideOfTheBox) {
  for (const double offset : {0.0, 6.4e6})
    for (const Method method : all_methods) {
      const double low = offset - 1.0, high = offset + 1.0;
      BoxMesh box(6, low, high);
      auto values = box.vertex_field();
      box.fill(values, [&](const Vec3d& p) {
        return Vec3d{1.0, 0.3 + 0.5 * (p.x - offset), -0.7 + 0.2 * (p.y - offset)};
      });
      IntegratorSettings settings;
      settings.method = method;
      for (const Vec3d& seed : random_points(3, 40, low, high))
        for (const double to : {infinity, -infinity}) {
          const query::Sampler sampler = box.sampler();
          advect::MeshVelocity field(sampler, values.view, nullptr, 0, 0, INSITU_STANDARD);
          field.begin(-1);
          const Outcome r = run(field, settings, seed, to);
          expect_on_side(box, field, r, low, high);
        }
    }
}

TEST(Exit, TimesAndPlacesAreExactInAUniformFlow) {
  BoxMesh box(5, 0.0, 1.0);
  auto values = box.vertex_field();
  for (const double speed : {1e-30, 1.0, 1e30}) {
    box.fill(values, [&](const Vec3d&) { return speed * Vec3d{1.0, 0.25, -0.125}; });
    for (const Method method : all_methods)
      for (const bool face_aware : {false, true}) {
        IntegratorSettings settings;
        settings.method = method;
        settings.face_aware = face_aware;
        const query::Sampler sampler = box.sampler();
        advect::MeshVelocity field(sampler, values.view, nullptr, 0, 0, INSITU_STANDARD);
        field.begin(-1);
        const Outcome r = run(field, settings, {0.3, 0.2, 0.8}, infinity);
        expect_on_side(box, field, r, 0.0, 1.0);
        EXPECT_NEAR(r.p.time * speed, 0.7, 1e-14); // sums of some fifty steps
        EXPECT_NEAR(r.p.x.y, 0.375, 1e-14);
        EXPECT_NEAR(r.p.x.z, 0.7125, 1e-14);
        EXPECT_NEAR(r.p.length, 0.7 * std::hypot(1.0, 0.25, 0.125), 1e-14);
      }
  }
}

TEST(Exit, FollowsAWallThatMoves) {
  // The cube's sides go out from 1 to 1.5 in a unit of time, faster than slow particles; or in.
  for (const double to : {1.5, 0.5}) {
    BoxMesh box(4, 0.0, 1.0, 0.0);
    box.move([&](const Vec3d& p) { return to * p; });
    auto values = box.vertex_field();
    for (const Method method : all_methods) {
      IntegratorSettings settings;
      settings.method = method;
      for (const double speed : {0.0, 0.2, 1.0}) {
        box.fill(values, [&](const Vec3d&) { return Vec3d{speed, 0.0, 0.0}; });
        const query::Sampler sampler = box.sampler();
        advect::MeshVelocity field(sampler, values.view, &values.view, 0, 1, INSITU_STANDARD);
        field.begin(-1);
        const Outcome r = run(field, settings, {0.75, 0.25, 0.25}, 1.0);
        // 0.75 + speed t = 1 + (to - 1) t
        const double t = 0.25 / (speed - (to - 1.0));
        if (t < 0.0 || t > 1.0) {
          EXPECT_EQ(r.ending, INSITU_END_ALIVE) << to << ", speed " << speed;
          continue;
        }
        ASSERT_EQ(r.ending, INSITU_END_LEFT) << to << ", speed " << speed;
        const double wall = 1.0 + (to - 1.0) * r.p.time;
        EXPECT_NEAR(r.p.x.x, wall, 4e-15) << to << ", speed " << speed; // rounding: 16 epsilons
        // A wall faster than the particle is met to exit_tolerance of the interval.
        EXPECT_NEAR(r.p.time, t, speed > std::abs(to - 1.0) ? 1e-14 : 1e-9)
            << to << ", speed " << speed;
        EXPECT_TRUE(box.sampler().locate(r.p.x, -1, {INSITU_STANDARD, r.p.time}));
      }
    }
  }
}

} // namespace
} // namespace insitu::test
