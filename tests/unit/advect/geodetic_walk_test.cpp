// The random walk in metres on meshes in longitude and latitude.
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>

#include "advect/effects/space.h"
#include "core/random.h"
#include "earth_flow.h"

namespace insitu::test {
namespace {

using advect::AtBoundary;
using advect::Effects;
using advect::Space;
using advect::Tracer;

Effects diffusion(double horizontal, double vertical, std::uint64_t seed = 1) {
  Effects effects;
  effects.diffusion.emplace();
  effects.diffusion->horizontal.constant = horizontal;
  effects.diffusion->vertical.constant = vertical;
  effects.diffusion->seed = seed;
  return effects;
}

TEST(GeodeticWalk, TheVarianceGrowsByTwoKTInMetres) {
  // Seeds at 60 degrees, on the date line, beside a pole, at it, and at one on a turned chart.
  struct Case {
    TestMesh mesh;
    Vec3d seed;
  };
  const fixtures::Lattice lattice{.across = 72, .along = 36, .levels = {-4000, -2000, 0}};
  const Case cases[] = {
      {fixtures::lattice(lattice), {20, 60, -2000}},
      {fixtures::lattice(lattice), {179.99, 60, -2000}},
      {fixtures::lattice(lattice), {30, 89.9, -2000}},
      {fixtures::lattice(lattice), {30, 90, -2000}},
      {fixtures::globe({.subdivisions = 4, .tilt = 0.3, .levels = {-4000, -2000, 0}}),
       {30, -90, -2000}}};
  const double kh = 2000, kv = 0.02, time = 1e6;
  for (const Case& c : cases) {
    Ocean sea(c.mesh, constant({0, 0, 0}));
    sea.settings.integrator.method = advect::Method::euler;
    const std::size_t n = 1000;
    const Tracer t = sea.run(diffusion(kh, kv), std::vector<Vec3d>(n, c.seed), time, 2);
    ASSERT_EQ(t.counts().alive(), std::int64_t(n));
    EXPECT_EQ(sea.work.pinned, 0);
    const geo::ChartPlace at = geo::place_of({}, geo::Pole::none, c.seed);
    const geo::Radii r = geo::radii(at.normal.z);
    double sum[3] = {}, squares[3] = {};
    for (const Vec3d& x : t.positions()) {
      const Vec3d d = geo::normal_of({}, x) - at.normal;
      const double m[3] = {dot(d, at.east) * (r.across - 2000), dot(d, at.north) * (r.along - 2000),
                           x.z + 2000};
      for (int a = 0; a < 3; ++a) {
        sum[a] += m[a] / double(n);
        squares[a] += m[a] * m[a] / double(n);
      }
    }
    for (int a = 0; a < 3; ++a) {
      // The mean has the deviation sqrt(s / n), the mean square s sqrt(2 / n). Thirty tests at 4
      // deviations fail once in 500 seeds. (The sphere's curvature counts (0.01)^2.)
      const double s = 2 * (a < 2 ? kh : kv) * time;
      EXPECT_LT(std::abs(sum[a]), 4 * std::sqrt(s / double(n))) << c.seed.x << " " << c.seed.y << a;
      EXPECT_LT(std::abs(squares[a] - s), 4 * s * std::sqrt(2 / double(n)))
          << c.seed.x << " " << c.seed.y << " " << a;
    }
  }
}

TEST(GeodeticWalk, DriftsAsTheEllipsoidsVolumeSays) {
  // What is even stays even if the integral of w L f is 0 for any f: with f of latitude alone,
  // L f = a Hess_ee f + b Hess_nn f + drift df/dlat, a = K / (N + h)^2, b = K / (M + h)^2.
  const query::ChartImage image{.west = -180};
  const Space space(&image);
  const double k = 3.0;
  for (const int power : {2, 4, 6}) {
    double sum = 0, without = 0, size = 0;
    const int n = 20000;
    for (int i = 0; i < n; ++i) {
      const double lat = 90 * (i + 0.5) / n, s = std::sin(lat * degree), c = std::cos(lat * degree);
      const double h = -3000, nn = geo::radii(s).across + h, mm = geo::radii(s).along + h;
      const double f1 = power * std::pow(s, power - 1) * c; // f = sin^power
      const double f2 =
          power * (power - 1) * std::pow(s, power - 2) * c * c - power * std::pow(s, power);
      const double drift = space.walk_drift({10, lat, h}, k, 0).y / mm;
      const double w = nn * mm * c;
      const double hessian = k / (nn * nn) * (-s / c * f1) + k / (mm * mm) * f2;
      sum += w * (hessian + drift * f1);
      without += w * hessian;
      size += w * std::abs(hessian);
    }
    EXPECT_LT(std::abs(sum / size), 1e-7) << power;     // the midpoint rule's
    EXPECT_GT(std::abs(without / size), 1e-4) << power; // the sphere's walk alone
  }
  // Upwards, where there is more room; and the same vector on a turned chart.
  EXPECT_NEAR(space.walk_drift({10, 0, 0}, 0, 2.0).z,
              2.0 * (1 / geo::radii(0).across + 1 / geo::radii(0).along), 1e-20);
  query::ChartImage turned = image;
  turned.north_from = 30;
  const Space other(&turned);
  const Vec3d p{77, 40, -500}, q = turned(p);
  const Vec3d v = other.walk_drift(q, k, 1.0), u = space.walk_drift(p, k, 1.0);
  EXPECT_NEAR(std::hypot(v.x, v.y), std::abs(u.y), 1e-12 * std::abs(u.y));
  EXPECT_NEAR(other.to_east_north(q, v).y, u.y, 1e-12 * std::abs(u.y));
}

/// Chi-square of particles over bands of equal area between two latitudes of a sphere of equal area
/// (to 1e-3: the ellipsoid's bands differ by less than the counts tell).
double chi_over_latitudes(std::span<const Vec3d> points, double south, double north, int bins) {
  const auto area = [](double lat) { // the ellipsoid's, by Simpson's rule from the equator
    double sum = 0;
    const int n = 200;
    for (int i = 0; i <= n; ++i) {
      const double s = std::sin(lat * degree * i / n), c = std::cos(lat * degree * i / n);
      const geo::Radii r = geo::radii(s);
      sum += (i == 0 || i == n ? 1 : i % 2 ? 4 : 2) * r.across * r.along * c;
    }
    return sum * lat / (3 * n);
  };
  std::vector<double> count(std::size_t(bins), 0.0);
  const double first = area(south), last = area(north);
  for (const Vec3d& p : points) {
    const double part = (area(p.y) - first) / (last - first);
    ++count[std::size_t(std::clamp(int(part * bins), 0, bins - 1))];
  }
  const double expected = double(points.size()) / bins;
  double sum = 0;
  for (const double c : count)
    sum += (c - expected) * (c - expected) / expected;
  return sum;
}

/// Even over the ellipsoid between latitudes and longitudes.
std::vector<Vec3d> even(std::size_t n, double west, double east, double south, double north) {
  std::vector<Vec3d> points;
  const auto weight = [](double lat) {
    const geo::Radii r = geo::radii(std::sin(lat * degree));
    return r.across * r.along * std::cos(lat * degree);
  };
  const double most = weight(south);
  for (std::uint64_t i = 0; points.size() < n; ++i) {
    const double lat = south + (north - south) * core::random_unit(21, i, 1);
    if (core::random_unit(21, i, 0) * most < weight(lat))
      points.push_back({west + (east - west) * core::random_unit(21, i, 2), lat,
                        -4000 * core::random_unit(21, i, 3)});
  }
  return points;
}

/// Exceeded once in 10^5 by chi-square of 11 degrees of freedom.
constexpr double chi_limit = 43.0;

TEST(GeodeticWalk, MixedParticlesStayMixedInClosedBasins) {
  // To 80 degrees, and to the pole, where coasts meet. In the time they walk 3800 km.
  for (const double north : {80.0, 90.0}) {
    Ocean sea(fixtures::lattice({.west = 170,
                                 .south = 30,
                                 .east = 230,
                                 .north = north,
                                 .across = 12,
                                 .along = int(north - 30) / 5,
                                 .levels = {-4000, 0},
                                 .jump = -360}),
              constant({0, 0, 0}),
              [](const Vec3d& p) { return 8e5 + 7.2e6 * std::pow(std::sin(3 * p.y * degree), 2); });
    sea.settings.integrator.method = advect::Method::euler;
    sea.settings.integrator.max_steps = 1000000;
    const std::vector<Vec3d> seeds = even(800, 170, 230, 30, north);
    for (const bool varies : {false, true}) {
      Effects effects = diffusion(8e6, 0.0, 5);
      if (varies)
        effects.diffusion->horizontal.field = advect::FieldInTime{sea.scalar(), {}};
      effects.diffusion->step = varies ? 1500 : 3000; // 160 and 220 km
      const Tracer t = sea.run(effects, seeds, 9e5, 1);
      EXPECT_EQ(t.counts().alive(), std::int64_t(seeds.size()));
      EXPECT_LT(chi_over_latitudes(t.positions(), 30, north, 12), chi_limit) << north << varies;
      int middle = 0;
      for (const Vec3d& x : t.positions()) {
        EXPECT_TRUE(bool(sea.sampler().locate(x)));
        middle += std::abs(std::remainder(x.x - 200, 360)) < 15;
      }
      EXPECT_NEAR(middle, 400, 5 * std::sqrt(200.0));
      EXPECT_LE(sea.work.pinned, sea.work.contacts / 100);
    }
  }
}

TEST(GeodeticWalk, InDegreesTheyWouldGatherAtThePole) {
  // The same test tells: a walk in longitude and latitude without its drift, made here.
  std::vector<Vec3d> points = even(800, 170, 230, 30, 80);
  const double step = std::sqrt(2 * 8e6 * 3000.0) / 6.37e6 / degree;
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::uint64_t k = 0; k < 300; ++k) {
      double& y = points[i].y;
      y += step * std::sqrt(12.0) * (core::random_unit(9, i * 300 + k, 0) - 0.5);
      y = y < 30 ? 60 - y : y > 80 ? 160 - y : y;
    }
  EXPECT_GT(chi_over_latitudes(points, 30, 80, 12), 2 * chi_limit);
}

TEST(GeodeticWalk, TracksAreTheSameForAnyThreads) {
  Ocean sea(fixtures::globe({.subdivisions = 3, .tilt = 0.3}), constant({1, 2, 0}));
  std::vector<Vec3d> seeds = even(150, -180, 180, 30, 90);
  const Effects effects = diffusion(1e5, 0.01, 3);
  const core::Threads one(1), many(4);
  const Tracer a = sea.run(effects, seeds, 3e5, 3, &one),
               b = sea.run(effects, seeds, 3e5, 3, &many);
  EXPECT_EQ(std::memcmp(a.positions().data(), b.positions().data(), seeds.size() * sizeof(Vec3d)),
            0);
  const Tracer few = sea.run(effects, std::span(seeds).first(70), 3e5, 3);
  for (std::size_t i = 0; i < 70; ++i)
    EXPECT_EQ(a.positions()[i], few.positions()[i]);
}

TEST(GeodeticWalk, TheWalkMeetsCoastsAndFloors) {
  Ocean sea(fixtures::lattice({.west = 10,
                               .south = 55,
                               .east = 12,
                               .north = 57,
                               .across = 4,
                               .along = 4,
                               .levels = {-200, -100, 0}}),
            constant({0, 0, 0}));
  const std::vector<Vec3d> seeds(100, Vec3d{11, 56, -100});
  for (const AtBoundary response : {AtBoundary::leave, AtBoundary::stop, AtBoundary::slide,
                                    AtBoundary::reflect, AtBoundary::put_back}) {
    Effects effects = diffusion(2e4, 0.05);
    effects.boundary.emplace();
    effects.boundary->response = response;
    const Tracer t = sea.run(effects, seeds, 2e5);
    std::int64_t ended = 0;
    for (std::size_t i = 0; i < seeds.size(); ++i) {
      EXPECT_TRUE(bool(sea.sampler().locate(t.positions()[i])));
      const auto ending = t.particles().endings[i];
      ended += ending != INSITU_END_ALIVE;
      if (ending != INSITU_END_ALIVE) {
        EXPECT_EQ(ending, response == AtBoundary::leave ? INSITU_END_LEFT : INSITU_END_STOPPED);
      }
    }
    const bool ends = response == AtBoundary::leave || response == AtBoundary::stop;
    EXPECT_EQ(ended > 20, ends);
    EXPECT_EQ(ended == 0, !ends);
  }
}

} // namespace
} // namespace insitu::test
