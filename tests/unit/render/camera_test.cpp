#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "core/random.h"
#include "core/status.h"
#include "render/camera/camera.h"

namespace insitu::render {
namespace {

using math::Vec3d;

double distance(const Vec3d& a, const Vec3d& b) {
  return std::sqrt(dot(a - b, a - b));
}

/// Where the ray passes the plane through look_at across the view.
Vec3d on_plane(const Ray& ray, const Camera& c) {
  const Vec3d n = c.look_at - c.position;
  const double t = dot(c.look_at - ray.origin, n) / dot(ray.direction, n);
  return ray.origin + t * ray.direction;
}

TEST(Camera, PixelCentresOfAPerspectiveImage) {
  Camera c;
  c.position = {0, 0, 5};
  c.look_at = {0, 0, 0};
  c.up = {0, 3, 0};
  c.fov = 90; // 10 high at the origin
  const RayGenerator rays(c, 20, 10);
  const Vec3d first = on_plane(rays(0, 0), c); // upper left: pixels are 1 x 1
  EXPECT_NEAR(first.x, -9.5, 1e-12);
  EXPECT_NEAR(first.y, 4.5, 1e-12);
  const Vec3d last = on_plane(rays(19, 9), c);
  EXPECT_NEAR(last.x, 9.5, 1e-12);
  EXPECT_NEAR(last.y, -4.5, 1e-12);
  for (const int x : {0, 7, 19})
    EXPECT_NEAR(dot(rays(x, 3).direction, rays(x, 3).direction), 1.0, 1e-14);
}

TEST(Camera, OrthographicRaysAreParallel) {
  Camera c;
  c.position = {5, 0, 0};
  c.look_at = {0, 0, 0};
  c.up = {0, 0, 1};
  c.orthographic_height = 4;
  const RayGenerator rays(c, 4, 4);
  const Ray corner = rays(0, 0), other = rays(3, 3);
  EXPECT_EQ(corner.direction, other.direction);
  EXPECT_NEAR(distance(corner.origin, {5, -1.5, 1.5}), 0, 1e-12); // +y is to the right
  EXPECT_NEAR(distance(other.origin, {5, 1.5, -1.5}), 0, 1e-12);
}

TEST(Camera, AroundABoxShowsAllOfIt) {
  const Vec3d low{-1, 2, 3}, high{2, 4, 9};
  for (const double aspect : {0.5, 1.0, 2.0})
    for (const double elevation : {-90.0, -30.0, 0.0, 20.0, 89.0, 90.0})
      for (const double azimuth : {0.0, 30.0, 200.0}) {
        const Camera c = Camera::around(low, high, azimuth, elevation, 1, 30, aspect);
        const int height = 200, width = int(height * aspect);
        const RayGenerator rays(c, width, height);
        const Vec3d forward = (c.look_at - c.position) / distance(c.look_at, c.position);
        const Ray centre = rays(width / 2, height / 2), left = rays(0, height / 2),
                  top = rays(width / 2, 0);
        EXPECT_NEAR(dot(centre.direction, forward), 1.0, 1e-4);
        for (int corner = 0; corner < 8; ++corner) {
          const Vec3d p{corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y,
                        corner & 4 ? high.z : low.z};
          const Vec3d d = (p - c.position) / distance(p, c.position);
          // Within the cone that touches the nearer border (half a pixel more).
          const double limit = std::max(dot(left.direction, forward), dot(top.direction, forward));
          EXPECT_GT(dot(d, forward), limit - 0.004);
        }
      }
}

TEST(Camera, AzimuthElevationZoomOrbit) {
  const Vec3d low{0, 0, 0}, high{2, 2, 2}, middle{1, 1, 1};
  const Camera x = Camera::around(low, high, 0, 0);
  EXPECT_GT(x.position.x, 1);
  EXPECT_NEAR(x.position.y, 1, 1e-12);
  EXPECT_NEAR(x.position.z, 1, 1e-12);
  const Camera y = Camera::around(low, high, 90, 30, 2);
  EXPECT_NEAR(y.position.x, 1, 1e-12);
  EXPECT_NEAR(2 * distance(y.position, middle), distance(x.position, middle), 1e-12);
  EXPECT_NEAR((y.position.z - 1) / distance(y.position, middle), 0.5, 1e-12);
  const Camera turned = x.orbited(90);
  const Camera expected = Camera::around(low, high, 90, 0);
  EXPECT_NEAR(distance(turned.position, expected.position), 0, 1e-12);
}

TEST(Camera, RefusesWhatHasNoDirection) {
  Camera c;
  c.look_at = c.position;
  EXPECT_THROW(RayGenerator(c, 4, 4), core::Error);
  c.look_at = {0, 5, 1};
  EXPECT_THROW(RayGenerator(c, 4, 4), core::Error); // up along the view
  c.look_at = {0, 0, 0};
  EXPECT_NO_THROW(RayGenerator(c, 4, 4));
  EXPECT_THROW(RayGenerator(c, 0, 4), core::Error);
  c.fov = 180;
  EXPECT_THROW(RayGenerator(c, 4, 4), core::Error);
}

Vec3d corner_of(const Vec3d& low, const Vec3d& high, int corner) {
  return {corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y, corner & 4 ? high.z : low.z};
}

TEST(Camera, ProjectsToWhereTheRaysCameFrom) {
  for (const double height : {0.0, 3.0}) {
    Camera c;
    c.position = {3, -2, 1.5};
    c.look_at = {0.2, 0.3, 0.1};
    c.up = {0, 0.1, 1};
    c.orthographic_height = height;
    const RayGenerator rays(c, 31, 17);
    for (const int x : {0, 7, 30})
      for (const int y : {0, 9, 16}) {
        const Ray ray = rays(x, y);
        const auto at = rays.project(ray.origin + 2.5 * ray.direction);
        ASSERT_TRUE(at);
        EXPECT_NEAR((*at)[0], x + 0.5, 1e-10);
        EXPECT_NEAR((*at)[1], y + 0.5, 1e-10);
        EXPECT_FALSE(rays.project(ray.origin - 2.5 * ray.direction));
      }
  }
}

/// The box's picture touches the margin on both sides of one direction, and is centred in both.
TEST(Camera, FitsABoxExactly) {
  const Vec3d boxes[][2] = {{{-1, 2, 3}, {2, 4, 9}},
                            {{0, 0, 0}, {100, 1, 1}},
                            {{-1, -1, 0}, {1, 1, 0}}, // without thickness
                            {{6.4e6, -6.4e6, 6.4e6}, {6.4e6 + 3, -6.4e6 + 1, 6.4e6 + 2}}};
  for (const auto& [low, high] : boxes)
    for (const double aspect : {0.1, 1.0, 8.0})
      for (const double elevation : {-90.0, -30.0, 20.0, 90.0})
        for (const double azimuth : {10.0, 200.0})
          for (const bool orthographic : {false, true}) {
            Camera c = Camera::around(low, high, azimuth, elevation, 1, 40, aspect);
            const CameraAxes before(c);
            c.orthographic_height = orthographic ? 1 : 0;
            c = c.fitted(low, high, aspect, 1, 0.1);
            EXPECT_NEAR(distance(before.forward, CameraAxes(c).forward), 0, 1e-8); // not turned
            const int height = 1000, width = int(1000 * aspect);
            const RayGenerator rays(c, width, height);
            double least[2] = {HUGE_VAL, HUGE_VAL}, most[2] = {-HUGE_VAL, -HUGE_VAL};
            for (int corner = 0; corner < 8; ++corner) {
              const auto at = rays.project(corner_of(low, high, corner));
              ASSERT_TRUE(at);
              for (std::size_t a = 0; a < 2; ++a) {
                const double part = (*at)[a] / (a == 0 ? width : height) * 2 - 1;
                least[a] = std::min(least[a], part);
                most[a] = std::max(most[a], part);
              }
            }
            // 1e-5: at offsets of 6.4e6 a unit in the last place is 1e-9 of a mesh of size 3.
            EXPECT_NEAR(std::max(most[0], most[1]), 0.9, 1e-5)
                << aspect << " " << elevation << " " << azimuth << " " << orthographic;
            EXPECT_NEAR(std::min(least[0], least[1]), -0.9, 1e-5);
            EXPECT_NEAR(least[0] + most[0], 0, 1e-5);
            EXPECT_NEAR(least[1] + most[1], 0, 1e-5);
          }
}

/// Any points: all of them are within the margin, and both sides of a direction touch it.
TEST(Camera, FitsPointsExactly) {
  for (std::uint64_t i = 0; i < 100; ++i) {
    std::vector<Vec3d> points;
    for (std::uint64_t p = 0; p < 4 + i % 5; ++p)
      points.push_back({core::random_unit(4, i, 3 * p), 3 * core::random_unit(4, i, 3 * p + 1),
                        0.3 * core::random_unit(4, i, 3 * p + 2)});
    Camera c = Camera::around({0, 0, 0}, {1, 3, 0.3}, 37.0 * double(i), 20, 1, 40, 1.5);
    c.orthographic_height = i % 2 ? 1 : 0;
    c = c.fitted(points, 1.5, 1, 0.1);
    const RayGenerator rays(c, 600, 400);
    double least[2] = {HUGE_VAL, HUGE_VAL}, most[2] = {-HUGE_VAL, -HUGE_VAL};
    for (const Vec3d& p : points) {
      const auto at = rays.project(p);
      ASSERT_TRUE(at);
      for (std::size_t a = 0; a < 2; ++a) {
        const double part = (*at)[a] / (a == 0 ? 600 : 400) * 2 - 1;
        least[a] = std::min(least[a], part);
        most[a] = std::max(most[a], part);
      }
    }
    EXPECT_NEAR(std::max(most[0], most[1]), 0.9, 1e-9) << i;
    EXPECT_NEAR(std::min(least[0], least[1]), -0.9, 1e-9) << i;
    for (std::size_t a = 0; a < 2; ++a)
      EXPECT_NEAR(most[a], -least[a], 1e-9) << i; // centred
  }
}

TEST(Camera, FitsWhatHasNoExtent) {
  Camera c = Camera::around({0, 0, 0}, {2, 0, 0}, 0, 0); // a line seen end on
  const Camera line = c.fitted({0, 0, 0}, {2, 0, 0}, 1);
  EXPECT_GT(line.position.x, 2);
  const Camera point = Camera::around({1, 1, 1}, {1, 1, 1}, 30, 20).fitted({1, 1, 1}, {1, 1, 1}, 1);
  EXPECT_TRUE(RayGenerator(point, 4, 4).project({1, 1, 1}));
  c.orthographic_height = 1;
  EXPECT_EQ(c.fitted({1, 1, 1}, {1, 1, 1}, 1).orthographic_height, 1);
}

TEST(Camera, HeightForShowsTheSphereFromEverySide) {
  const Vec3d low{-1, 2, 3}, high{2, 4, 9};
  const double diagonal = distance(low, high);
  for (const double azimuth : {0.0, 33.0, 171.0}) {
    const Camera c = Camera::around(low, high, azimuth, 20);
    EXPECT_NEAR(c.height_for(low, high, Fit::sphere, 1), diagonal, 1e-12);
    EXPECT_NEAR(c.height_for(low, high, Fit::sphere, 0.25), 4 * diagonal, 1e-12);
    EXPECT_LT(c.height_for(low, high, Fit::box, 1), diagonal * 1.03);
  }
}

TEST(Camera, FindsAnotherUp) {
  Camera c;
  c.position = {0, 0, 5};
  c.up = {0, 0, -2};
  EXPECT_THROW(RayGenerator(c, 4, 4), core::Error);
  EXPECT_NO_THROW(RayGenerator(c.with_valid_up(), 4, 4));
  c.up = {0, 0, 0};
  EXPECT_NO_THROW(RayGenerator(c.with_valid_up(), 4, 4));
  c.up = {0, 1, 5}; // all but along the view, and good
  EXPECT_EQ(c.with_valid_up().up, c.up);
}

} // namespace
} // namespace insitu::render
