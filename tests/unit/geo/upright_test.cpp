#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "geo/reference_frames.h"
#include "geo/upright.h"

namespace {

using namespace insitu::geo;
using insitu::math::Vec3d;

double norm(const Vec3d& v) {
  return std::sqrt(dot(v, v));
}

/// By GeographicLib.
Vec3d geodetic_of(const Vec3d& x) {
  Vec3d out;
  from_geocentric(Frame::geodetic(), std::span(&x, 1), std::span(&out, 1));
  return out;
}
Vec3d geocentric_of(const Vec3d& p) {
  Vec3d out;
  to_geocentric(Frame::geodetic(), std::span(&p, 1), std::span(&out, 1));
  return out;
}

/// The normal to 1e-14, which is 64 nm on the ground; heights to the rounding of the Earth's
/// radius.
void expect_upright(const Vec3d& x, const Vec3d& normal, double height) {
  const Upright at = upright(x);
  EXPECT_NEAR(norm(at.normal), 1.0, 4e-16);
  EXPECT_LT(norm(at.normal - normal), 1e-14) << x.x << " " << x.y << " " << x.z;
  EXPECT_NEAR(at.height, height, 4e-9) << x.x << " " << x.y << " " << x.z;
  EXPECT_LT(norm(geocentric_point(at) - x), 4e-9 * std::max(1.0, norm(x) / 6.4e6));
}

TEST(Upright, IsWhatGeographicLibSays) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> longitude(-180, 180), sine(-1, 1), part(0, 1);
  for (int i = 0; i < 20000; ++i) {
    const double lat = std::asin(sine(random)) * 180 / M_PI;
    const double height = i % 2 ? -1e4 * part(random) : 1e6 * part(random);
    const Vec3d x = geocentric_of({longitude(random), lat, height});
    const Vec3d back = geodetic_of(x);
    expect_upright(x, normal_of({}, back), back.z);
  }
}

TEST(Upright, AtPolesTheEquatorAndBesideThem) {
  for (const double height : {-1e4, 0.0, 1e-3, 1e6})
    for (const double lat :
         {-90.0, -90 + 1e-9, -45.0, -1e-9, 0.0, 1e-300, 1e-9, 45.0, 90 - 1e-12, 90 - 1e-5, 90.0})
      for (const double lon : {-180.0, -90.0, 0.0, 1e-9, 90.0, 179.999})
        expect_upright(geocentric_of({lon, lat, height}), normal_of({}, {lon, lat, 0}), height);
  const double b = equatorial_radius * (1 - flattening);
  EXPECT_EQ(upright({0, 0, b}).normal, (Vec3d{0, 0, 1}));
  EXPECT_NEAR(upright({0, 0, -b - 3}).height, 3.0, 2e-9);
  EXPECT_EQ(upright({0, 0, -b}).normal, (Vec3d{0, 0, -1}));
  EXPECT_EQ(upright({0, -equatorial_radius, 0}).normal, (Vec3d{0, -1, 0}));
  EXPECT_EQ(upright({equatorial_radius + 5, 0, 0}).height, 5.0);
}

TEST(Upright, DeepInTheEarthAndFarFromIt) {
  for (const double height : {-6e6, -3e6, 1e7, 4e8})
    for (double lat = -90; lat <= 90; lat += 7.5) {
      const Upright at = upright(geocentric_of({30, lat, height}));
      EXPECT_LT(norm(at.normal - normal_of({}, {30, lat, 0})), 1e-11) << height << " " << lat;
      EXPECT_NEAR(at.height, height, 1e-6);
    }
  // No direction is up at the centre, but one is.
  for (const Vec3d& x : {Vec3d{0, 0, 0}, Vec3d{0, 0, -10}, Vec3d{3e4, 0, 0}, Vec3d{0, 1e-300, 0}})
    EXPECT_NEAR(norm(upright(x).normal), 1.0, 1e-15);
}

TEST(Upright, EastNorthAndUp) {
  const Vec3d n = normal_of({}, {37, -52, 0}), v{3, -4, 5};
  const Vec3d w = from_east_north_up(n, v);
  EXPECT_LT(norm(to_east_north_up(n, w) - v), 1e-14);
  EXPECT_NEAR(dot(w, n), 5.0, 1e-14);
  const double lon = 37 * M_PI / 180;
  EXPECT_NEAR(dot(w, Vec3d{-std::sin(lon), std::cos(lon), 0}), 3.0, 1e-14);
}

TEST(Upright, LevelWaysAreAsLongAsTheGroundSays) {
  const Upright at{normal_of({}, {10, 40, 0}), 2000.0};
  for (const Vec3d& v : {Vec3d{1000, 0, 0}, Vec3d{0, 1000, 0}, Vec3d{600, -800, 0}}) {
    const auto there = [&](double part) {
      return geocentric_point({level_way(at, from_east_north_up(at.normal, part * v)), at.height});
    };
    // To both sides, since the radii change by 1e-6 on the way.
    EXPECT_NEAR(norm(there(1) - there(-1)), 2000.0, 1e-4);
    EXPECT_NEAR(geodetic_of(there(1)).z, 2000.0, 4e-9);
  }
  EXPECT_EQ(level_way(at, {}), at.normal);
}

} // namespace
