// Steps that end at faces: orders over kinks and jumps, plain and face-aware side by side.
#include <cmath>
#include <gtest/gtest.h>

#include "advect/field/mesh_velocity.h"
#include "analytic.h"
#include "box_mesh.h"

namespace insitu::test {
namespace {

using advect::IntegratorSettings;
using advect::Method;

constexpr double infinity = std::numeric_limits<double>::infinity();

/// One particle, located anew.
Outcome run_in(const BoxMesh& box, const mesh::FieldView& velocity,
               const IntegratorSettings& settings, const Vec3d& seed, double to) {
  const query::Sampler sampler = box.sampler();
  advect::MeshVelocity field(sampler, velocity, nullptr, 0, 0, INSITU_STANDARD);
  field.begin(-1);
  return run(field, settings, seed, to);
}

/// Where particles are after `to`, with fixed steps (for pairs: no error control).
std::vector<Vec3d> ends(const BoxMesh& box, const mesh::FieldView& velocity, Method method,
                        bool face_aware, double step, std::span<const Vec3d> seeds, double to) {
  IntegratorSettings settings;
  settings.method = method;
  settings.face_aware = face_aware;
  settings.step = step;
  if (advect::is_adaptive(method)) {
    settings.max_step = step;
    settings.min_step = step;
    settings.at_min_step = advect::AtMinStep::take; // whatever the error,
    settings.tolerance = 1e-99; // and no way to a face that is only as good as a tolerance asks
  }
  settings.max_steps = 1000000;
  std::vector<Vec3d> out;
  for (const Vec3d& seed : seeds) {
    const Outcome r = run_in(box, velocity, settings, seed, to);
    EXPECT_EQ(r.ending, INSITU_END_ALIVE);
    out.push_back(r.p.x);
  }
  return out;
}

double rms(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
    sum += dot(a[i] - b[i], a[i] - b[i]);
  return std::sqrt(sum / double(a.size()));
}

/// Seeds whose ways stay in the cube.
std::vector<Vec3d> inner_seeds() {
  return random_points(9, 48, -0.45, 0.45);
}

/// A swirl that stays within; over vertices it becomes a field with kinks.
Vec3d swirl(const Vec3d& p) {
  const double r = dot(p, p);
  return {-p.y * (1 - 0.4 * r) - 0.2 * p.z, p.x * (1 - 0.4 * r) + 0.3 * p.z * p.x,
          0.2 * p.x - 0.3 * p.x * p.y + 0.1 * std::sin(3 * p.x)};
}

/// The order over a quartering of the step.
double order(const BoxMesh& box, const mesh::FieldView& v, Method method, bool face_aware,
             double step, const std::vector<Vec3d>& seeds, const std::vector<Vec3d>& reference,
             double to) {
  const double coarse = rms(ends(box, v, method, face_aware, step, seeds, to), reference);
  const double fine = rms(ends(box, v, method, face_aware, step / 4, seeds, to), reference);
  std::printf("method %d, %-10s errors %.2e, %.2e: order %.2f\n", int(method),
              face_aware ? "face-aware" : "plain", coarse, fine, 0.5 * std::log2(coarse / fine));
  return 0.5 * std::log2(coarse / fine);
}

TEST(FaceAware, KeepsItsOrderOverTheKinksOfInterpolation) {
  BoxMesh box(6, -1.0, 1.0);
  auto values = box.vertex_field();
  box.fill(values, swirl);
  const double to = 2.0;
  const auto seeds = inner_seeds();
  const auto reference = ends(box, values.view, Method::dopri5, true, 0.002, seeds, to);
  // Two ways to the reference, which differ in everything but the cells' fields.
  ASSERT_LT(rms(ends(box, values.view, Method::rk4, true, 0.004, seeds, to), reference), 1e-11);
  ASSERT_LT(rms(ends(box, values.view, Method::rk4, false, 0.0005, seeds, to), reference), 1e-7);

  // Steps that straddle a kink err by h^2 where they do, and so all together by order 2 (a kink is
  // met to / cell size times, whatever the step).
  const double plain = order(box, values.view, Method::rk4, false, 0.04, seeds, reference, to);
  EXPECT_NEAR(plain, 2.0, 0.35);
  EXPECT_NEAR(order(box, values.view, Method::dopri5, false, 0.04, seeds, reference, to), 2.0, 0.4);
  EXPECT_NEAR(order(box, values.view, Method::euler, true, 0.04, seeds, reference, to), 1.0, 0.2);
  EXPECT_GT(order(box, values.view, Method::bs32, true, 0.16, seeds, reference, to), 2.7);
  EXPECT_NEAR(order(box, values.view, Method::rk4, true, 0.16, seeds, reference, to), 4.0, 0.3);
  EXPECT_NEAR(order(box, values.view, Method::dopri5, true, 0.2, seeds, reference, to), 5.0, 0.4);
  // Orders of magnitude at the same step.
  EXPECT_GT(rms(ends(box, values.view, Method::rk4, false, 0.04, seeds, to), reference),
            100 * rms(ends(box, values.view, Method::rk4, true, 0.04, seeds, to), reference));
}

// Where the tolerance allows it dopri5 comes to faces along its continuous extension: one trial a
// step, 6 evaluations and the one in the next cell, and an error that the tolerance still bounds.
TEST(FaceAware, ComesToFacesAlongItsExtensionWithinTheTolerance) {
  BoxMesh box(6, -1.0, 1.0);
  auto values = box.vertex_field();
  box.fill(values, swirl);
  const double to = 2.0;
  const auto seeds = inner_seeds();
  const auto reference = ends(box, values.view, Method::dopri5, true, 0.002, seeds, to);
  double last = 1.0;
  for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10}) {
    IntegratorSettings settings;
    settings.face_aware = true;
    settings.tolerance = tolerance;
    std::vector<Vec3d> found;
    advect::Work work;
    for (const Vec3d& seed : seeds) {
      const Outcome r = run_in(box, values.view, settings, seed, to);
      EXPECT_EQ(r.ending, INSITU_END_ALIVE);
      found.push_back(r.p.x);
      work += r.work;
    }
    const double error = rms(found, reference);
    const double per_step = double(work.evaluations) / double(work.steps);
    std::printf("tolerance %.0e: error %.2e, %.2f evaluations a step\n", tolerance, error,
                per_step);
    EXPECT_LT(error, tolerance * to);
    EXPECT_LT(error, last);
    EXPECT_LT(per_step, 9.0); // with a step of its own to each face: 12
    last = error;
  }
}

// Faces along which a particle goes, of the boundary or between cells, are no ends of its steps:
// it goes as it would in the cells' midst, in a field that is the same at all heights.
TEST(FaceAware, GoesAlongFacesAsThroughCells) {
  BoxMesh box(8, -1.0, 1.0, 0.0);
  auto values = box.vertex_field();
  box.fill(values, [](const Vec3d& p) { return Vec3d{-p.y * (1 + p.x * p.x), p.x, 0.0}; });
  for (const Method method : {Method::rk4, Method::dopri5}) {
    Outcome within;
    for (const double z : {-0.9, -1.0, 0.0, 0.25, 1.0}) {
      SCOPED_TRACE("height " + std::to_string(z));
      IntegratorSettings settings;
      settings.method = method;
      settings.face_aware = true;
      const Outcome r = run_in(box, values.view, settings, {0.3, 0.111, z}, 6.0);
      EXPECT_EQ(r.ending, INSITU_END_ALIVE);
      EXPECT_EQ(r.p.x.z, z);
      if (z == -0.9)
        within = r;
      EXPECT_EQ(r.work.steps, within.work.steps);
      EXPECT_EQ(r.work.evaluations, within.work.evaluations);
      // A way to a face is known to a tenth of 1e-9 of a cell.
      EXPECT_NEAR(r.p.x.x, within.p.x.x, 1e-10);
      EXPECT_NEAR(r.p.x.y, within.p.x.y, 1e-10);
    }
  }
}

// Along a face at first, and away from it later, to either side.
TEST(FaceAware, LeavesAFaceThatItWentAlong) {
  BoxMesh box(8, -1.0, 1.0, 0.0);
  auto values = box.vertex_field();
  for (const double up : {0.4, -0.4}) {
    box.fill(values, [&](const Vec3d& p) {
      return Vec3d{0.5, 0.1 + 0.2 * p.x * p.x, up * (p.x + 0.7) + 0.2 * p.z * p.z};
    });
    const std::vector<Vec3d> seed{{-0.7, 0.111, 0.0}};
    const Vec3d exact = ends(box, values.view, Method::dopri5, false, 1e-4, seed, 2.0)[0];
    ASSERT_GT(std::abs(exact.z), 0.1);
    for (const Method method : {Method::bs32, Method::rk4, Method::dopri5}) {
      const Vec3d end = ends(box, values.view, method, true, 0.02, seed, 2.0)[0];
      EXPECT_LT(distance(end, exact), 2e-7) << int(method) << ' ' << up;
    }
  }
}

TEST(FaceAware, ChangesNothingInASmoothField) {
  // Rotation is linear, so interpolation gives it back: both keep the method's order.
  BoxMesh box(6, -1.0, 1.0);
  auto values = box.vertex_field();
  box.fill(values, [](const Vec3d& p) { return rotation(p, 0); });
  const double to = 3.0;
  const auto seeds = inner_seeds();
  std::vector<Vec3d> truth;
  for (const Vec3d& p : seeds)
    truth.push_back(
        {std::cos(to) * p.x - std::sin(to) * p.y, std::sin(to) * p.x + std::cos(to) * p.y, p.z});
  EXPECT_NEAR(order(box, values.view, Method::euler, false, 0.02, seeds, truth, to), 1.0, 0.2);
  EXPECT_NEAR(order(box, values.view, Method::bs32, false, 0.2, seeds, truth, to), 3.0, 0.3);
  EXPECT_NEAR(order(box, values.view, Method::rk4, false, 0.2, seeds, truth, to), 4.0, 0.3);
  EXPECT_NEAR(order(box, values.view, Method::dopri5, false, 0.3, seeds, truth, to), 5.0, 0.4);
  EXPECT_GT(order(box, values.view, Method::rk4, true, 0.2, seeds, truth, to), 3.6);
}

TEST(FaceAware, CrossesAJumpOfTheVelocityExactly) {
  // A velocity of each cell: straight lines with corners at faces, which plain steps cut.
  BoxMesh box(4, 0.0, 1.0, 0.0);
  auto values = box.cell_field();
  for (std::size_t c = 0; c < box.cell_count(); ++c) // a refraction at x = 0.5
    values.set(c, c % 4 < 2 ? Vec3d{1.0, 0.5, 0.0} : Vec3d{0.25, -0.5, 0.25});
  for (const Method method : {Method::euler, Method::rk4, Method::bs32, Method::dopri5}) {
    const std::vector<Vec3d> seed{{0.21, 0.3, 0.4}};
    const Vec3d end = ends(box, values.view, method, true, 0.1, seed, 1.0)[0];
    const double after = 1.0 - 0.29;
    EXPECT_NEAR(end.x, 0.5 + 0.25 * after, 1e-8); // faces are met to 1e-9 of a cell
    EXPECT_NEAR(end.y, 0.3 + 0.5 * 0.29 - 0.5 * after, 1e-8);
    EXPECT_NEAR(end.z, 0.4 + 0.25 * after, 1e-8);
  }
}

TEST(FaceAware, ShearOverOneFace) {
  // The speed along x grows from y = 0.5 on: a kink in one plane, crossed aslant; the way is a
  // parabola behind it.
  BoxMesh box(2, 0.0, 1.0, 0.0);
  auto values = box.vertex_field();
  box.fill(values, [](const Vec3d& p) {
    return Vec3d{p.y > 0.5 ? 0.8 * (p.y - 0.5) : 0.0, 0.5, 0.0};
  });
  const std::vector<Vec3d> seed{{0.2, 0.3, 0.3}};
  const Vec3d truth{0.2 + 0.8 * 0.5 * 0.5 * 0.8 * 0.8, 0.3 + 0.6, 0.3}; // 0.8 of time behind it
  const double to = 1.2;
  EXPECT_LT(rms(ends(box, values.view, Method::rk4, true, 0.13, seed, to), {truth}), 1e-14);
  EXPECT_GT(rms(ends(box, values.view, Method::rk4, false, 0.13, seed, to), {truth}), 1e-6);
}

TEST(FaceAware, NeverEndless) {
  // Velocities along faces, edges and through vertices, onto a face from both sides, and round an
  // edge: the particle moves as the flow says, or stays where it pushes, but always ends.
  BoxMesh box(4, 0.0, 1.0, 0.0);
  auto along = box.vertex_field();
  for (const Method method : {Method::euler, Method::rk4, Method::bs32, Method::dopri5})
    for (const Vec3d& v : {Vec3d{1, 0, 0}, Vec3d{1, 1, 0}, Vec3d{1, 1, 1}, Vec3d{1, 1e-9, 0},
                           Vec3d{1, 1e-13, 1e-11}}) {
      box.fill(along, [&](const Vec3d&) { return v; });
      for (const Vec3d& seed : {Vec3d{0, 0, 0}, Vec3d{0.25, 0.25, 0.25}, Vec3d{0.1, 0.5, 0.5},
                                Vec3d{0.1, 0.5, 0.3}, Vec3d{0.0, 0.3, 0.3}}) {
        const Vec3d end =
            ends(box, along.view, method, true, 0.03, std::vector<Vec3d>{seed}, 0.45)[0];
        EXPECT_LT(distance(end, seed + 0.45 * v), 1e-12);
      }
    }
  // Onto x = 0.5 from both sides, and on along y: it slides.
  auto pushed = box.cell_field();
  for (std::size_t c = 0; c < box.cell_count(); ++c)
    pushed.set(c, {c % 4 < 2 ? 1.0 : -1.0, 0.25, 0.0});
  for (const Method method : {Method::euler, Method::rk4, Method::bs32, Method::dopri5}) {
    IntegratorSettings settings;
    settings.method = method;
    settings.face_aware = true;
    settings.max_steps = 3000;
    const Outcome r = run_in(box, pushed.view, settings, {0.3, 0.3, 0.3}, 1.0);
    EXPECT_TRUE(r.ending == INSITU_END_ALIVE || r.ending == INSITU_END_STEP_LIMIT);
    EXPECT_LT(r.work.evaluations, 400000);
    EXPECT_NEAR(r.p.x.x, 0.5, 0.07); // a quarter of a cell at most
  }
}

TEST(FaceAware, TheSameWayBack) {
  BoxMesh box(6, -1.0, 1.0);
  auto values = box.vertex_field();
  box.fill(values, swirl);
  const auto seeds = inner_seeds();
  const auto there = ends(box, values.view, Method::dopri5, true, 0.02, seeds, 2.0);
  const auto back = ends(box, values.view, Method::dopri5, true, 0.02, there, -2.0);
  EXPECT_GT(rms(there, seeds), 0.3);
  EXPECT_LT(rms(back, seeds), 1e-9); // each way errs by some 1e-11
}

} // namespace
} // namespace insitu::test
