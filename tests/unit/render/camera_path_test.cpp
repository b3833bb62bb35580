#include <cmath>
#include <gtest/gtest.h>

#include "core/status.h"
#include "render/camera/camera_path.h"

namespace insitu::render {
namespace {

using math::Vec3d;

double distance(const Vec3d& a, const Vec3d& b) {
  return std::sqrt(dot(a - b, a - b));
}

Camera camera(const Vec3d& position, const Vec3d& look_at, double fov = 30) {
  Camera c;
  c.position = position;
  c.look_at = look_at;
  c.up = {0, 0, 1};
  c.fov = fov;
  return c;
}

/// What an image shows of two cameras is the same.
void expect_same(const Camera& a, const Camera& b, double tolerance) {
  const CameraAxes x(a), y(b);
  EXPECT_NEAR(distance(a.position, b.position), 0, tolerance);
  EXPECT_NEAR(distance(x.forward, y.forward), 0, tolerance);
  EXPECT_NEAR(distance(x.right, y.right), 0, tolerance);
  EXPECT_NEAR(a.fov, b.fov, tolerance);
}

CameraPath flight() {
  return CameraPath({{0, camera({5, 0, 1}, {0, 0, 0}, 30)},
                     {10, camera({0, 6, 2}, {0, 1, 0}, 50)},
                     {40, camera({-4, 0, 0.5}, {-9, 0, 0}, 20)}, // turned by more than 180 in all
                     {50, camera({0, -5, 1}, {0, 0, 3}, 25)}});
}

TEST(CameraPath, PassesThroughItsKeysAndStaysBeyondTheEnds) {
  const CameraPath path = flight();
  expect_same(path.at(10), camera({0, 6, 2}, {0, 1, 0}, 50), 0);
  expect_same(path.at(40), camera({-4, 0, 0.5}, {-9, 0, 0}, 20), 0);
  for (const double before : {-1e300, -1.0, 0.0})
    expect_same(path.at(before), camera({5, 0, 1}, {0, 0, 0}, 30), 0);
  for (const double after : {50.0, 51.0, 1e300})
    expect_same(path.at(after), camera({0, -5, 1}, {0, 0, 3}, 25), 0);
  // From both sides, without a jump.
  for (const double key : {0.0, 10.0, 40.0, 50.0})
    for (const double step : {-1e-7, 1e-7})
      expect_same(path.at(key + step), path.at(key), 1e-6);
}

TEST(CameraPath, HasNoJumpOfSpeedAtItsKeys) {
  const CameraPath path = flight();
  const double h = 1e-5;
  for (const double key : {10.0, 40.0}) {
    const Camera before = path.at(key - h), at = path.at(key), after = path.at(key + h);
    const double speed = distance(after.position, at.position) / h;
    EXPECT_NEAR(distance(after.position - at.position, at.position - before.position) / h, 0,
                1e-3 * (1 + speed));
    const CameraAxes a(before), b(at), c(after);
    const double turning = distance(c.forward, b.forward) / h;
    EXPECT_NEAR(distance(c.forward - b.forward, b.forward - a.forward) / h, 0,
                1e-3 * (1 + turning));
    EXPECT_NEAR((after.fov - at.fov) / h, (at.fov - before.fov) / h, 1e-2);
  }
}

TEST(CameraPath, TwoKeysMakeAStraightLineAndAnEvenTurn) {
  const CameraPath path({{2, camera({1, 0, 0}, {1, 5, 0})}, {6, camera({9, 4, 0}, {14, 4, 0})}});
  for (const double u : {0.1, 0.5, 0.75}) {
    const Camera c = path.at(2 + 4 * u);
    EXPECT_NEAR(distance(c.position, {1 + 8 * u, 4 * u, 0}), 0, 1e-12);
    const double angle = (1 - u) * 1.5707963267948966; // from +y to +x
    EXPECT_NEAR(distance(CameraAxes(c).forward, {std::cos(angle), std::sin(angle), 0}), 0, 1e-12);
    EXPECT_NEAR(distance(CameraAxes(c).down, {0, 0, -1}), 0, 1e-12);
    EXPECT_NEAR(distance(c.position, c.look_at), 5, 1e-12);
  }
}

TEST(CameraPath, LooksAtWhatAllKeysLookAt) {
  const Vec3d aim{0.3, -0.2, 0.1};
  const CameraPath path(
      {{0, camera({5, 0, 1}, aim)}, {1, camera({0, 6, 2}, aim)}, {3, camera({-4, 0, 9}, aim)}});
  for (double at = 0; at < 3; at += 0.17)
    EXPECT_EQ(path.at(at).look_at, aim);
}

TEST(CameraPath, RestsBetweenEqualKeys) {
  const Camera still = camera({5, 0, 1}, {0, 0, 0}), gone = camera({0, 6, 2}, {0, 0, 4}, 40);
  const CameraPath path({{0, gone}, {10, still}, {20, still}, {21, gone}});
  for (double at = 10; at <= 20; at += 0.7)
    expect_same(path.at(at), still, 1e-14);
}

TEST(CameraPath, NeverLeavesTheRangeOfAMonotoneRun) {
  // Speeds of 1000 and 1 side by side: a plain Catmull-Rom spline would run far beyond.
  const std::vector<double> at{0, 1, 2, 3, 4, 5}, values{0, 1000, 1001, 1001, 1002, 5000};
  double last = -1;
  for (double place = -1; place < 6; place += 0.001) {
    const double value = smooth(at, values, place);
    EXPECT_GE(value, last - 1e-9) << place;
    last = value;
  }
  EXPECT_EQ(last, 5000);
}

TEST(CameraPath, TurnsOnTheSpotAndLooksBack) {
  // Half a turn: every direction between is a direction, none is nought.
  const CameraPath path({{0, camera({0, 0, 0}, {0, 0, 0.5})}, {1, camera({0, 0, 0}, {0, 0, -2})}});
  for (double at = 0; at <= 1; at += 0.1) {
    const Camera c = path.at(at);
    EXPECT_NO_THROW(RayGenerator(c, 2, 2));
    EXPECT_NEAR(CameraAxes(c).forward.z, std::cos(at * 3.14159265358979323846), 1e-9);
  }
}

TEST(CameraPath, OrthographicHeightsGrowEvenly) {
  Camera a = camera({5, 0, 0}, {0, 0, 0}), b = a;
  a.orthographic_height = 1;
  b.orthographic_height = 100;
  EXPECT_NEAR(CameraPath({{0, a}, {2, b}}).at(1).orthographic_height, 10, 1e-12);
}

TEST(CameraPath, RefusesWhatIsNoPath) {
  const Camera c = camera({5, 0, 1}, {0, 0, 0});
  Camera flat = c;
  flat.orthographic_height = 1;
  Camera none = c;
  none.look_at = none.position;
  EXPECT_THROW(CameraPath({}), core::Error);
  EXPECT_THROW(CameraPath({{1, c}, {1, c}}), core::Error);
  EXPECT_THROW(CameraPath({{1, c}, {std::nan(""), c}}), core::Error);
  EXPECT_THROW(CameraPath({{1, c}, {2, flat}}), core::Error);
  EXPECT_THROW(CameraPath({{1, c}, {2, none}}), core::Error);
  EXPECT_NO_THROW(CameraPath({{1, c}}));
}

} // namespace
} // namespace insitu::render
