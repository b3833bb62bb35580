#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <random>

#include "geo/chart.h"
#include "geo/reference_frames.h"

namespace {

using namespace insitu::geo;
using insitu::math::Vec3d;

constexpr ChartUnits degrees{};
constexpr ChartUnits radians{.radians = true, .kilometres = true, .down = true};
constexpr double degree = std::numbers::pi / 180;
constexpr Pole poles[] = {Pole::none, Pole::north, Pole::south};

double norm(const Vec3d& v) {
  return std::sqrt(dot(v, v));
}

/// By GeographicLib.
Vec3d earth(const Vec3d& p) {
  Vec3d out;
  to_geocentric(Frame::geodetic(), std::span(&p, 1), std::span(&out, 1));
  return out;
}

TEST(Chart, SinesAreExactAtRightAngles) {
  for (int k = -8; k <= 8; ++k) {
    const SinCos at = sin_cos(degrees, 90.0 * k);
    EXPECT_EQ(at.sin, double(std::lround(std::sin(k * std::numbers::pi / 2)))) << k;
    EXPECT_EQ(at.cos, double(std::lround(std::cos(k * std::numbers::pi / 2)))) << k;
  }
  for (const double y : {-1.0, 0.0, 1.0})
    for (const double x : {-1.0, 0.0, 1.0}) {
      const double angle = angle_of(degrees, y, x);
      EXPECT_NEAR(angle, std::atan2(y, x) / degree, 1e-13);
      EXPECT_EQ(std::fmod(angle, 45.0), 0.0) << y << " " << x;
    }
}

TEST(Chart, PointsGoAroundByAllChartsToNanometres) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> part(-1, 1);
  for (const ChartUnits& units : {degrees, radians})
    for (int i = 0; i < 2000; ++i) {
      // Evenly over the sphere, and towards the poles.
      const double lat =
          i % 2 ? std::asin(part(random)) / std::numbers::pi * 2
                : std::copysign(1 - std::pow(10.0, -12 * std::abs(part(random))), part(random));
      const Vec3d p{part(random) * units.turn() / 2, lat * units.quarter(), part(random)};
      const Vec3d n = normal_of(units, p);
      for (const Pole from : poles)
        for (const Pole to : poles) {
          const Vec3d a = between_charts(units, Pole::none, from, p);
          const Vec3d b = between_charts(units, from, to, a);
          const Vec3d back = between_charts(units, to, Pole::none, b);
          EXPECT_EQ(back.z, p.z);
          // Three roundings of a normal, in parts of the radius.
          EXPECT_LT(norm(normal_of(units, back) - n), 2e-15) << p.x << " " << p.y;
        }
    }
}

TEST(Chart, APoleLiesAtTheOriginOfItsChart) {
  for (const double lon : {-180.0, -17.3, 0.0, 90.0, 359.0}) {
    EXPECT_EQ(between_charts(degrees, Pole::none, Pole::north, {lon, 90, 5}), (Vec3d{0, 0, 5}));
    EXPECT_EQ(between_charts(degrees, Pole::none, Pole::south, {lon, -90, 5}), (Vec3d{0, 0, 5}));
  }
}

/// The rate at which the chart's numbers change along a straight line through space, by
/// GeographicLib and central differences.
Vec3d measured_rate(Pole pole, const Vec3d& p, const Vec3d& velocity, double dt) {
  const Vec3d n = normal_of(degrees, p);
  const EastNorth axes = east_north(n);
  const Vec3d x = earth(p), v = velocity.x * axes.east + velocity.y * axes.north + velocity.z * n;
  Vec3d at[2] = {x - dt * v, x + dt * v};
  from_geocentric(Frame::geodetic(), at, at);
  for (Vec3d& q : at)
    q = between_charts(degrees, Pole::none, pole, q);
  return (at[1] - at[0]) / (2 * dt);
}

TEST(Chart, RatesAreThoseOfAStraightLineThroughSpace) {
  const Vec3d velocity{3, -2, 0.5}; // metres per second, true east, north, up
  for (const double lat : {-89.0, -60.0, 0.0, 35.0, 88.0, 89.99})
    for (const Pole pole : {Pole::none, lat < 0 ? Pole::south : Pole::north}) {
      if (pole != Pole::none && std::abs(lat) < 30)
        continue; // on its equator a turned chart is singular
      const Vec3d p{23.0, lat, -1200.0};
      const Vec3d q = between_charts(degrees, Pole::none, pole, p);
      const ChartPlace place = place_of(degrees, pole, q);
      const EastNorth axes = east_north(normal_of(degrees, p));
      const Vec3d v = velocity.x * axes.east + velocity.y * axes.north;
      const Vec3d rate =
          chart_rates(degrees, pole, q, {dot(v, place.east), dot(v, place.north), velocity.z});
      const Vec3d measured = measured_rate(pole, p, velocity, 1.0);
      // GeographicLib's 5 nm over two seconds, in degrees; and the difference's third order, where
      // meridians are a kilometre from meeting.
      const double error =
          5e-9 / 111e3 / std::cos(lat * degree) * 4 + 1e-5 * std::abs(measured.x) * (lat > 89.9);
      EXPECT_NEAR(rate.x, measured.x, error) << lat;
      EXPECT_NEAR(rate.y, measured.y, error) << lat;
      EXPECT_NEAR(rate.z, measured.z, 2e-6) << lat; // the line leaves the ellipsoid
      const Vec3d metres = chart_metres(degrees, pole, q, rate);
      EXPECT_NEAR(norm(metres), norm(velocity), 1e-14);
    }
}

TEST(Chart, ATurnedChartIsRegularAtItsPole) {
  // 1 m/s along every meridian: 1/M radians per second, whichever way.
  const double m = radii(1.0).along;
  EXPECT_NEAR(m, radii(-1.0).across, 1e-8);
  for (const Pole pole : {Pole::north, Pole::south})
    for (int k = 0; k < 12; ++k) {
      const double angle = k * 30 * degree;
      const Vec3d rate =
          chart_rates(degrees, pole, {0, 0, 0}, {std::cos(angle), std::sin(angle), 0});
      EXPECT_NEAR(rate.x, std::cos(angle) / m / degree, 1e-20);
      EXPECT_NEAR(rate.y, std::sin(angle) / m / degree, 1e-20);
    }
}

TEST(Chart, UnitsChangeNothingButNumbers) {
  for (const Pole pole : poles) {
    const Vec3d p{0.3, 0.2, 4.0}; // radians, kilometres of depth
    const Vec3d q{p.x / degree, p.y / degree, -4000.0};
    const Vec3d v{1, 2, 3};
    const Vec3d a = chart_rates(radians, pole, p, v), b = chart_rates(degrees, pole, q, v);
    EXPECT_NEAR(a.x / degree, b.x, 1e-14 * std::abs(b.x));
    EXPECT_NEAR(a.y / degree, b.y, 1e-14 * std::abs(b.y));
    EXPECT_EQ(a.z, -0.003);
    EXPECT_EQ(b.z, 3.0);
  }
}

TEST(Chart, LongitudesComeIntoTheRangeAndStayAsTheyAreWithin) {
  const double below = std::nextafter(180.0, 0.0);
  EXPECT_EQ(longitude_from(-180, degrees, -180.0), -180.0);
  EXPECT_EQ(longitude_from(-180, degrees, 180.0), -180.0);
  EXPECT_EQ(longitude_from(-180, degrees, below), below);
  EXPECT_EQ(longitude_from(0, degrees, 360.0), 0.0);
  EXPECT_EQ(longitude_from(0, degrees, -1e-300), 0.0);
  EXPECT_EQ(longitude_from(0, degrees, -0.5), 359.5);
  EXPECT_EQ(longitude_from(170, degrees, -175.0), 185.0);
  EXPECT_EQ(longitude_from(170, degrees, 190.0), 190.0);
  EXPECT_NEAR(longitude_from(-180, degrees, 179.999 + 3600), 179.999, 1e-12);
  EXPECT_TRUE(std::isnan(longitude_from(0, degrees, std::numeric_limits<double>::infinity())));
  EXPECT_TRUE(std::isnan(longitude_from(0, degrees, std::nan(""))));
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> any(-1500, 1500);
  for (const ChartUnits& units : {degrees, radians})
    for (int i = 0; i < 100000; ++i) {
      const double west = any(random), lon = any(random), got = longitude_from(west, units, lon);
      EXPECT_GE(got, west);
      EXPECT_LT(got, west + units.turn());
      const double turns = (got - lon) / units.turn();
      EXPECT_NEAR(turns, std::round(turns), 1e-12);
    }
}

TEST(Chart, AStraightEdgeOfADegreeSags242Metres) {
  // In space, halfway along an edge of a degree in longitude and in latitude. That is the reason
  // why a geodetic mesh is not located geocentric.
  const auto sag = [](const Vec3d& a, const Vec3d& b) {
    Vec3d middle = 0.5 * (earth(a) + earth(b));
    from_geocentric(Frame::geodetic(), std::span(&middle, 1), std::span(&middle, 1));
    return -middle.z;
  };
  EXPECT_NEAR(sag({10, 0, 0}, {11, 0, 0}), 242.8, 0.1);
  EXPECT_NEAR(sag({10, 45, 0}, {10, 46, 0}), 242.5, 0.5);
}

} // namespace
