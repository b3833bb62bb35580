#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <random>
#include <string>

#include "core/status.h"
#include "geo/geodesic.h"
#include "geo/reference_frames.h"

namespace {

using insitu::core::Error;
using insitu::geo::convert;
using insitu::geo::describe;
using insitu::geo::Frame;
using insitu::math::Vec3d;

// WGS84, National Imagery and Mapping Agency TR8350.2 (2000), table 3.1: a and 1/f.
constexpr double a = 6378137.0;
constexpr double f = 1 / 298.257223563;
constexpr double e2 = f * (2 - f);
constexpr double degree = std::numbers::pi / 180;

Vec3d one(const Frame& from, const Frame& to, const Vec3d& p) {
  return convert(from, to, std::vector<Vec3d>{p})[0];
}

double distance(const Vec3d& p, const Vec3d& q) {
  return std::sqrt(dot(p - q, p - q));
}

std::string error_of(const Frame& from, const Frame& to, const std::vector<Vec3d>& points) {
  try {
    convert(from, to, points);
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), INSITU_ERROR_ARGUMENT);
    return error.what();
  }
  return "";
}

#define EXPECT_CONTAINS(text, part)                                                                \
  EXPECT_NE(std::string(text).find(part), std::string::npos)                                       \
      << "'" << (text) << "' lacks '" << part << "'"

/// Geodetic to geocentric by the textbook formula (Heiskanen and Moritz, Physical Geodesy, 1967,
/// section 5-3), in long double.
Vec3d geocentric_by_formula(const Vec3d& p) {
  const long double pi = std::numbers::pi_v<long double>;
  const long double lon = p.x * pi / 180, lat = p.y * pi / 180, h = p.z;
  const long double ff = 1 / 298.257223563L, ee = ff * (2 - ff);
  const long double n = 6378137.0L / std::sqrt(1 - ee * std::sin(lat) * std::sin(lat));
  return {double((n + h) * std::cos(lat) * std::cos(lon)),
          double((n + h) * std::cos(lat) * std::sin(lon)),
          double((n * (1 - ee) + h) * std::sin(lat))};
}

/// Length of the meridian from the equator, by Simpson's rule over the radius of curvature.
double meridian_arc(double latitude) {
  const int n = 2000;
  const double h = latitude * degree / n;
  double sum = 0;
  for (int i = 0; i <= n; ++i) {
    const double s = std::sin(i * h);
    const double radius = a * (1 - e2) / std::pow(1 - e2 * s * s, 1.5);
    sum += radius * (i == 0 || i == n ? 1 : (i % 2 == 1 ? 4 : 2));
  }
  return sum * h / 3;
}

TEST(Geodetic, AxesOfTheEllipsoid) {
  const Frame deg = Frame::geodetic(), xyz = Frame::geocentric();
  const double b = a * (1 - f);
  EXPECT_LT(distance(one(deg, xyz, {0, 0, 0}), {a, 0, 0}), 1e-8);
  EXPECT_LT(distance(one(deg, xyz, {90, 0, 0}), {0, a, 0}), 1e-8);
  EXPECT_LT(distance(one(deg, xyz, {180, 0, 100}), {-a - 100, 0, 0}), 1e-8);
  EXPECT_LT(distance(one(deg, xyz, {17, 90, 0}), {0, 0, b}), 1e-8);
  EXPECT_LT(distance(one(deg, xyz, {-170, -90, -50}), {0, 0, -b + 50}), 1e-8);
}

TEST(Geodetic, AgreesWithTheTextbookFormula) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> lon(-180, 180), lat(-90, 90), height(-11000, 400000);
  for (int i = 0; i < 20000; ++i) {
    const Vec3d p{lon(random), lat(random), height(random)};
    const Vec3d got = one(Frame::geodetic(), Frame::geocentric(), p);
    ASSERT_LT(distance(got, geocentric_by_formula(p)), 1e-8) << p.x << ' ' << p.y << ' ' << p.z;
  }
}

TEST(Frames, RoundTripsAreWithinTenNanometres) {
  const Frame frames[] = {Frame::geodetic(), Frame::geodetic(true), Frame::enu(11.5, 48.1, 520),
                          Frame::enu(-180, -89.5, 0)};
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> lon(-180, 180), lat(-90, 90), height(-11000, 400000);
  for (int i = 0; i < 5000; ++i) {
    const Vec3d p = geocentric_by_formula({lon(random), lat(random), height(random)});
    for (const Frame& frame : frames) {
      const Vec3d there = one(Frame::geocentric(), frame, p);
      ASSERT_LT(distance(one(frame, Frame::geocentric(), there), p), 1e-8) << describe(frame);
    }
  }
}

TEST(Utm, RoundTripsAreWithinTenNanometres) {
  std::mt19937_64 random(13);
  std::uniform_real_distribution<double> lon(-12, 12), lat(-80, 84), height(-6000, 9000);
  std::uniform_int_distribution<int> zone(1, 60);
  for (int i = 0; i < 20000; ++i) {
    const int z = zone(random);
    const Frame utm = Frame::utm(z, i % 2 == 0);
    const Vec3d degrees{std::remainder(6.0 * z - 183 + lon(random), 360.0), lat(random),
                        height(random)};
    const Vec3d xyz = geocentric_by_formula(degrees);
    const Vec3d there = one(Frame::geodetic(), utm, degrees);
    ASSERT_LT(distance(one(utm, Frame::geocentric(), there), xyz), 1e-8) << describe(utm);
    ASSERT_LT(distance(one(Frame::geocentric(), utm, xyz), there), 2e-8) << describe(utm);
  }
}

TEST(Utm, MeridianAndEquator) {
  const Frame north = Frame::utm("33N"), south = Frame::utm("33S");
  EXPECT_EQ(one(Frame::geodetic(), north, {15, 0, 7}), (Vec3d{500000, 0, 7}));
  EXPECT_EQ(one(Frame::geodetic(), south, {15, 0, -7}), (Vec3d{500000, 10000000, -7}));
  for (const double latitude : {1.0, 23.5, 45.0, 60.0, 84.0, 90.0}) {
    const Vec3d up = one(Frame::geodetic(), north, {15, latitude, 0});
    EXPECT_NEAR(up.x, 500000, 1e-8);
    EXPECT_NEAR(up.y, 0.9996 * meridian_arc(latitude), 1e-6) << latitude;
    const Vec3d down = one(Frame::geodetic(), south, {15, -latitude, 0});
    EXPECT_NEAR(down.y, 10000000 - 0.9996 * meridian_arc(latitude), 1e-6) << latitude;
  }
}

TEST(Utm, IsConformal) {
  // Short steps east and north stay perpendicular and are stretched alike.
  const Frame utm = Frame::utm(32, true);
  const Vec3d at{12.3, 51.7, 0};
  const double s = std::sin(at.y * degree);
  const double n = a / std::sqrt(1 - e2 * s * s), m = n * (1 - e2) / (1 - e2 * s * s);
  const double step = 10; // metres
  const double dlon = step / (n * std::cos(at.y * degree)) / degree, dlat = step / m / degree;
  const auto difference = [&](double lon, double lat) {
    return 0.5 / step *
           (one(Frame::geodetic(), utm, {at.x + lon, at.y + lat, 0}) -
            one(Frame::geodetic(), utm, {at.x - lon, at.y - lat, 0}));
  };
  const Vec3d east = difference(dlon, 0), north = difference(0, dlat);
  EXPECT_NEAR(dot(east, north), 0, 1e-8);
  EXPECT_NEAR(dot(east, east), dot(north, north), 1e-8);
  EXPECT_GT(std::sqrt(dot(east, east)), 0.9996); // smallest on the central meridian
}

TEST(Utm, PolesAndZoneNames) {
  for (const int zone : {1, 33, 60}) {
    const Vec3d pole = one(Frame::geocentric(), Frame::utm(zone, true), {0, 0, a * (1 - f)});
    EXPECT_NEAR(pole.x, 500000, 1e-6) << zone;
    EXPECT_NEAR(pole.y, 0.9996 * meridian_arc(90), 1e-6) << zone;
    EXPECT_NEAR(one(Frame::utm(zone, true), Frame::geodetic(), pole).y, 90, 1e-9);
  }
  EXPECT_EQ(Frame::utm("7 s"), Frame::utm(7, false));
  EXPECT_EQ(describe(Frame::utm("60N")), "utm 60N");
  for (const char* bad : {"", "N", "33", "0N", "61S", "33U", "33NN", "33.5N", "-3N"}) {
    EXPECT_THROW((void)Frame::utm(std::string_view(bad)), Error) << bad;
  }
}

TEST(Enu, AxesPointEastNorthUp) {
  const Frame enu = Frame::enu(30, 0, 10);
  const double r = a + 10, c = std::cos(30 * degree), s = std::sin(30 * degree);
  const Frame xyz = Frame::geocentric();
  EXPECT_LT(distance(one(enu, xyz, {0, 0, 0}), {r * c, r * s, 0}), 1e-8);
  EXPECT_LT(distance(one(enu, xyz, {5, 0, 0}), {r * c - 5 * s, r * s + 5 * c, 0}), 1e-8);
  EXPECT_LT(distance(one(enu, xyz, {0, 5, 0}), {r * c, r * s, 5}), 1e-8);
  EXPECT_LT(distance(one(enu, xyz, {0, 0, 5}), {(r + 5) * c, (r + 5) * s, 0}), 1e-8);
  // At any origin, up is the direction of growing height and a level step is level at first.
  const Frame tilted = Frame::enu(-71, 42, 100);
  const Vec3d above = one(tilted, Frame::geodetic(), {0, 0, 1000});
  EXPECT_NEAR(above.x, -71, 1e-13);
  EXPECT_NEAR(above.y, 42, 1e-13);
  EXPECT_NEAR(above.z, 1100, 1e-8);
  EXPECT_GT(one(tilted, Frame::geodetic(), {10, 0, 0}).x, -71);
  EXPECT_GT(one(tilted, Frame::geodetic(), {0, 10, 0}).y, 42);
}

TEST(Geodetic, DepthIsMinusHeight) {
  const Vec3d p{12.25, -33.5, 250};
  EXPECT_EQ(one(Frame::geodetic(true), Frame::geodetic(), p), (Vec3d{12.25, -33.5, -250}));
  EXPECT_LT(distance(one(Frame::geodetic(true), Frame::geocentric(), p),
                     geocentric_by_formula({12.25, -33.5, -250})),
            1e-8);
  EXPECT_EQ(one(Frame::geodetic(), Frame::utm(33, true, true), {15, 0, 9}).z, -9);
}

TEST(Geodetic, DateLineIsNoBorder) {
  const Frame deg = Frame::geodetic(), xyz = Frame::geocentric();
  EXPECT_LT(distance(one(deg, xyz, {180, 10, 0}), one(deg, xyz, {-180, 10, 0})), 1e-8);
  EXPECT_LT(distance(one(deg, xyz, {190, 10, 0}), one(deg, xyz, {-170, 10, 0})), 1e-8);
  EXPECT_LT(distance(one(deg, xyz, {359.5, 10, 0}), one(deg, xyz, {-0.5, 10, 0})), 1e-8);
  // Two millimetres across the line are two millimetres.
  const double turn = 1e-3 / (a * degree);
  EXPECT_NEAR(distance(one(deg, xyz, {180 - turn, 0, 0}), one(deg, xyz, {-180 + turn, 0, 0})), 2e-3,
              1e-8);
  EXPECT_EQ(one(Frame::geodetic(true), deg, {190, 10, 0}).x, -170);
  // Zone 1 begins at the line: a point west of it, one degree away in longitude.
  const Vec3d near = one(deg, Frame::utm(1, true), {179.5, 10, 0});
  EXPECT_GT(near.x, 100000);
  EXPECT_LT(near.x, 500000);
}

TEST(Geodetic, PolesComeBack) {
  for (const double sign : {1.0, -1.0}) {
    const Vec3d pole =
        one(Frame::geocentric(), Frame::geodetic(), {0, 0, sign * (a * (1 - f) + 3)});
    EXPECT_EQ(pole.y, sign * 90);
    EXPECT_NEAR(pole.z, 3, 1e-8);
    const Vec3d off = one(Frame::geocentric(), Frame::geodetic(), {-1e-3, 0, sign * a * (1 - f)});
    EXPECT_EQ(std::abs(off.x), 180);
    EXPECT_NEAR((90 - std::abs(off.y)) * degree * a * a / (a * (1 - f)), 1e-3, 1e-8);
  }
}

TEST(Errors, NameValueAndIndex) {
  const Frame deg = Frame::geodetic(), xyz = Frame::geocentric();
  const std::string latitude = error_of(deg, xyz, {{0, 0, 0}, {48.1, 111.5, 0}});
  EXPECT_CONTAINS(latitude, "point 1");
  EXPECT_CONTAINS(latitude, "latitude 111.5");
  EXPECT_CONTAINS(error_of(deg, xyz, {{1e6, 0, 0}}), "longitude 1e+06");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_CONTAINS(error_of(deg, xyz, {{0, 0, nan}}), "height nan is not finite");
  EXPECT_CONTAINS(error_of(xyz, deg, {{0, 0, 0}, {nan, 0, 0}}), "geocentric point 1: x nan");
  EXPECT_CONTAINS(error_of(Frame::enu(0, 0), deg, {{0, nan, 0}}), "north nan");
  EXPECT_CONTAINS(error_of(deg, Frame::utm(33, true), {{15, 0, 0}, {120, 5, 0}}), "point 1");
  EXPECT_CONTAINS(error_of(Frame::utm(33, true), deg, {{5e6, 0, 0}}), "easting 5e+06");
  EXPECT_CONTAINS(error_of(Frame::utm(33, true), deg, {{5e5, 1.2e7, 0}}), "beyond a pole");
  EXPECT_THROW((void)Frame::utm(0, true), Error);
  EXPECT_THROW((void)Frame::enu(0, 91), Error);
  EXPECT_THROW((void)Frame::enu(0, nan), Error);
}

TEST(Errors, CartesianHasNoPlaceOnEarth) {
  const std::string text = error_of(Frame::cartesian(), Frame::geodetic(), {{0, 0, 0}});
  EXPECT_CONTAINS(text, "cartesian");
  EXPECT_CONTAINS(text, "no place on Earth");
  EXPECT_FALSE(error_of(Frame::utm(33, true), Frame::cartesian(), {{0, 0, 0}}).empty());
  const Vec3d p{1, 2, 3};
  EXPECT_EQ(one(Frame::cartesian(), Frame::cartesian(), p), p);
}

TEST(Frames, ConvertInPlace) {
  std::vector<Vec3d> points{{0, 0, 0}, {90, 0, 0}};
  convert(Frame::geodetic(), Frame::geocentric(), points, points);
  EXPECT_LT(distance(points[1], {0, a, 0}), 1e-8);
  std::vector<Vec3d> small(1);
  EXPECT_THROW(convert(Frame::geodetic(), Frame::geocentric(), points, small), Error);
}

} // namespace

TEST(Geodesic, StepsAreEqualAndMeridiansAreMeridians) {
  // From the equator to 60 N and past the pole would be shorter over it: (0, 80) to (180, 80)
  // crosses it.
  const auto over = insitu::geo::geodesic({0, 80, 0}, {180, 80, -100}, 3);
  ASSERT_EQ(over.size(), 3u);
  EXPECT_NEAR(over[1].y, 90.0, 1e-9);
  EXPECT_NEAR(over[1].z, -50.0, 1e-12);
  // Along the equator: equal steps of longitude, across the date line.
  const auto equator = insitu::geo::geodesic({170, 0, 0}, {-170, 0, 0}, 5);
  EXPECT_NEAR(equator[1].x, 175.0, 1e-9);
  EXPECT_NEAR(std::fabs(equator[2].x), 180.0, 1e-9);
  EXPECT_NEAR(equator[3].x, -175.0, 1e-9);
  EXPECT_THROW(insitu::geo::geodesic({0, 91, 0}, {0, 0, 0}, 2), insitu::core::Error);
}
