#include <GeographicLib/Geodesic.hpp>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

#include "core/status.h"
#include "geo/geodesic.h"

namespace {

using insitu::core::Error;
using insitu::geo::geodesic_path;
using insitu::geo::Path;
using insitu::geo::separation;
using insitu::geo::Separation;
using insitu::math::Vec3d;

// WGS84, National Imagery and Mapping Agency TR8350.2 (2000), table 3.1.
constexpr double equatorial_radius = 6378137.0;
constexpr double degree = std::numbers::pi / 180;

double metres(const Vec3d& a, const Vec3d& b) {
  double s;
  GeographicLib::Geodesic::WGS84().Inverse(a.y, a.x, b.y, b.x, s);
  return s;
}

std::string error_of(const std::vector<Vec3d>& through) {
  try {
    geodesic_path(through, 3);
  } catch (const Error& e) {
    EXPECT_EQ(e.status(), INSITU_ERROR_ARGUMENT);
    return e.what();
  }
  return "no error";
}

/// Neighbours on one leg are a step apart; where a corner lies between them they are nearer.
void expect_even(const Path& path, const std::vector<Vec3d>& through, std::int64_t count) {
  ASSERT_EQ(path.places.size(), std::size_t(count));
  ASSERT_EQ(path.distances.size(), std::size_t(count));
  std::vector<double> corners{0.0};
  for (std::size_t i = 0; i + 1 < through.size(); ++i)
    corners.push_back(corners.back() + metres(through[i], through[i + 1]));
  const double step = corners.back() / double(count - 1);
  std::size_t leg = 0;
  for (std::size_t i = 0; i < path.places.size(); ++i) {
    const double s = step * double(i);
    ASSERT_NEAR(path.distances[i], s, 1e-6) << i;
    while (leg + 2 < through.size() && s >= corners[leg + 1])
      ++leg;
    // From the leg's begin, by the inverse problem: to GeographicLib's 15 nm and what s has lost.
    ASSERT_NEAR(metres(through[leg], path.places[i]), s - corners[leg], 1e-6) << i;
    if (i > 0 && s - step >= corners[leg]) {
      ASSERT_NEAR(metres(path.places[i - 1], path.places[i]), step, 1e-6) << i;
    }
  }
  EXPECT_EQ(path.places.front().x, through.front().x);
  EXPECT_EQ(path.places.back().y, through.back().y);
}

TEST(GeodesicPath, StepsAreEqualToAMicrometre) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> longitude(-180, 180), latitude(-90, 90);
  for (int round = 0; round < 200; ++round) {
    SCOPED_TRACE(round);
    std::vector<Vec3d> through;
    for (int i = 0; i < 2 + round % 4; ++i)
      through.push_back({longitude(random), latitude(random), 0});
    expect_even(geodesic_path(through, 57), through, 57);
  }
}

TEST(GeodesicPath, AcrossTheDateLineAndOverThePole) {
  // Along the equator a degree is 2 pi a / 360, and the way over the date line is the short one.
  const std::vector<Vec3d> equator{{175, 0, 0}, {-175, 0, 0}};
  const Path across = geodesic_path(equator, 11);
  EXPECT_NEAR(across.distances.back(), 10 * degree * equatorial_radius, 1e-6);
  for (int i = 0; i <= 10; ++i) {
    EXPECT_NEAR(std::remainder(across.places[std::size_t(i)].x - (175 + i), 360), 0, 1e-12);
    EXPECT_NEAR(across.places[std::size_t(i)].y, 0, 1e-12);
  }
  expect_even(across, equator, 11);
  // Over the pole: up one meridian and down the other one.
  const std::vector<Vec3d> pole{{30, 80, 0}, {-150, 85, 0}};
  const Path over = geodesic_path(pole, 16);
  expect_even(over, pole, 16);
  EXPECT_NEAR(over.distances.back(), metres(pole[0], {0, 90, 0}) + metres(pole[1], {0, 90, 0}),
              1e-6);
  for (const Vec3d& p : over.places) {
    EXPECT_GE(p.y, 80 - 1e-12);
    if (p.y < 90 - 1e-9) {
      EXPECT_NEAR(std::remainder(p.x - 30, 180), 0, 1e-6); // a meridian: metres by 1 / cos
    }
  }
  // A place to go through on the pole itself, and there and back.
  const std::vector<Vec3d> turn{{0, 89, 0}, {77, 90, 0}, {90, 89, 0}, {0, 89, 0}};
  expect_even(geodesic_path(turn, 31), turn, 31);
  // South, through a place that is written beyond 180 degrees.
  const std::vector<Vec3d> far{{178, -70, 0}, {183, -71, 0}, {-170, -69, 0}};
  expect_even(geodesic_path(far, 12), far, 12);
}

TEST(GeodesicPath, WhatIsNoPathIsRefused) {
  EXPECT_EQ(error_of({{0, 0, 0}, {0, 91, 0}}), "curtain: latitude 91.000000, -90 to 90 expected");
  EXPECT_EQ(error_of({{180, 10, 0}, {-180, 10, 0}}), "curtain: the path has no length");
}

TEST(Separation, OnMeridiansAndTheEquator) {
  // East and west along the equator, also across the date line.
  for (const double to : {1.0, 90.0, -40.0}) {
    const Separation s = separation({170, 0, 0}, {170 + to, 0, 0});
    EXPECT_NEAR(s.distance, std::fabs(to) * degree * equatorial_radius, 1e-6);
    EXPECT_EQ(s.bearing, to > 0 ? 90.0 : 270.0);
  }
  EXPECT_EQ(separation({179, 0, 0}, {-179, 0, 0}).bearing, 90.0);
  // A quarter of a meridian (10,001,965.729 m on WGS84: Karney 2013, section 2), and either way.
  EXPECT_NEAR(separation({12, 0, 0}, {12, 90, 0}).distance, 10001965.729, 1e-3);
  EXPECT_EQ(separation({12, 0, 0}, {12, 5, 0}).bearing, 0.0);
  EXPECT_EQ(separation({12, 5, 0}, {12, 0, 0}).bearing, 180.0);
  // Over the pole.
  EXPECT_NEAR(separation({12, 89, 0}, {-168, 89, 0}).distance,
              2 * separation({12, 89, 0}, {12, 90, 0}).distance, 1e-6);
  EXPECT_EQ(separation({12, 89, 0}, {-168, 89, 0}).bearing, 0.0);
}

TEST(Separation, BearingsGoOnceAround) {
  EXPECT_TRUE(std::isnan(separation({5, 5, 0}, {5, 5, 0}).bearing));
  EXPECT_EQ(separation({5, 5, 0}, {365, 5, 0}).distance, 0.0);
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> longitude(-180, 180), latitude(-90, 90);
  for (int i = 0; i < 1000; ++i) {
    const Vec3d a{longitude(random), latitude(random), 0},
        b{longitude(random), latitude(random), 0};
    const Separation s = separation(a, b);
    EXPECT_GE(s.bearing, 0.0);
    EXPECT_LT(s.bearing, 360.0);
    double lat, lon; // the direct problem leads there
    GeographicLib::Geodesic::WGS84().Direct(a.y, a.x, s.bearing, s.distance, lat, lon);
    EXPECT_LT(metres(b, {lon, lat, 0}), 1e-6);
  }
  // A hair west of north is nearly 360, never 360.
  const double bearing = separation({0, 0, 0}, {-1e-300, 1, 0}).bearing;
  EXPECT_TRUE(bearing >= 0 && bearing < 360) << bearing;
}

} // namespace
