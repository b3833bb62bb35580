// Steps that end at faces of geodetic meshes: in sheets of longitude and latitude, over the date
// line and over the poles.
#include <gtest/gtest.h>

#include "earth_flow.h"

namespace insitu::test {
namespace {

using advect::Method;

Vec3d normal_at(const Vec3d& p) {
  const double lon = p.x * degree, lat = p.y * degree;
  return {std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon), std::sin(lat)};
}

/// A flow over the globe, smooth at the poles too, which has kinks where it is interpolated.
Vec3d winding(const Vec3d& p) {
  const Vec3d n = normal_at(p), omega{12.0, 20.0, 9.0};
  const Vec3d w =
      cross(omega, n) + 6.0 * Vec3d{std::sin(4 * n.y), std::sin(3 * n.z + 1), std::cos(4 * n.x)};
  const geo::EastNorth axes = geo::east_north(n);
  return {dot(w, axes.east), dot(w, axes.north), 0.0};
}

double metres_apart(const Vec3d& p, const Vec3d& q) {
  const Vec3d d = normal_at(p) - normal_at(q);
  return std::sqrt(dot(d, d)) * geo::equatorial_radius;
}

struct Ends {
  std::vector<Vec3d> positions;
  advect::Work work;
};

/// Where seeds are after `to` seconds; a step of 0: by the tolerance.
Ends ends_of(Ocean& ocean, Method method, bool face_aware, double step, double tolerance,
             std::span<const Vec3d> seeds, double to) {
  advect::TracerSettings settings;
  settings.integrator = {.method = method, .face_aware = face_aware};
  settings.integrator.step = settings.integrator.max_step = step;
  settings.integrator.tolerance = tolerance;
  settings.integrator.max_steps = 1'000'000;
  advect::Tracer tracer(settings, ocean.memory);
  tracer.seed(seeds, 0.0);
  const mesh::FieldView v = ocean.flow();
  const advect::Advance a = tracer.advance(ocean.sampler(), v, &v, 0.0, to, ocean.threads);
  EXPECT_EQ(a.counts.alive(), std::int64_t(seeds.size()));
  return {{tracer.positions().begin(), tracer.positions().end()}, a.work};
}

double worst(const Ends& a, const Ends& b) {
  double worst = 0.0;
  for (std::size_t i = 0; i < a.positions.size(); ++i)
    worst = std::max(worst, metres_apart(a.positions[i], b.positions[i]));
  return worst;
}

std::vector<Vec3d> seeds_at(std::initializer_list<double> latitudes,
                            std::initializer_list<double> heights) {
  std::vector<Vec3d> seeds;
  for (const double z : heights)
    for (const double lon : {-179.999, -97.3, -15.0, 41.7, 133.1, 179.999})
      for (const double lat : latitudes)
        seeds.push_back({lon, lat, z});
  return seeds;
}

// Plain steps straddle kinks and err by order 2; those that end at faces keep the method's, over
// the date line and at the surface too, along which they go.
TEST(GeodeticFaces, StepsKeepTheirOrder) {
  for (const bool wraps : {false, true}) {
    Ocean ocean(fixtures::lattice({.across = 36, .along = 18, .wraps = wraps}), winding);
    const auto seeds = seeds_at({-30.1, -11.3, 7.5, 27.0}, {0.0, -50.0, -1234.5});
    const double to = 1.6e5; // some 3,500 km, three cells
    const Ends exact = ends_of(ocean, Method::dopri5, true, 0.0, 1e-9, seeds, to);
    // Two ways to the reference.
    EXPECT_LT(worst(ends_of(ocean, Method::rk4, false, 50.0, 0.1, seeds, to), exact), 0.05);
    double plain[2], aware[2];
    for (int i = 0; i < 2; ++i) {
      const double step = i == 0 ? 16000.0 : 4000.0;
      plain[i] = worst(ends_of(ocean, Method::rk4, false, step, 0.1, seeds, to), exact);
      aware[i] = worst(ends_of(ocean, Method::rk4, true, step, 0.1, seeds, to), exact);
    }
    std::printf("plain %.3g, %.3g m; face-aware %.3g, %.3g m\n", plain[0], plain[1], aware[0],
                aware[1]);
    EXPECT_NEAR(0.5 * std::log2(plain[0] / plain[1]), 2.0, 0.6);
    EXPECT_NEAR(0.5 * std::log2(aware[0] / aware[1]), 4.0, 0.6);
    EXPECT_LT(aware[1], 1e-3 * plain[1]);
  }
}

// Over the poles, where cells are copied to turned charts, whose edges are other lines than those
// of longitude and latitude: at the rim of the copies steps still straddle a kink.
TEST(GeodeticFaces, OverThePoles) {
  Ocean ocean(fixtures::lattice({.across = 36, .along = 18}), winding);
  const auto seeds = seeds_at({-88.9, -75.3, 69.9, 89.2}, {0.0, -50.0});
  const double to = 3e5;
  const Ends exact = ends_of(ocean, Method::dopri5, true, 0.0, 1e-9, seeds, to);
  EXPECT_LT(worst(ends_of(ocean, Method::rk4, false, 50.0, 0.1, seeds, to), exact), 1.0);
  for (const double step : {16000.0, 4000.0}) {
    const double plain = worst(ends_of(ocean, Method::rk4, false, step, 0.1, seeds, to), exact);
    const double aware = worst(ends_of(ocean, Method::rk4, true, step, 0.1, seeds, to), exact);
    std::printf("step %g s: plain %.3g m, face-aware %.3g m\n", step, plain, aware);
    EXPECT_LT(aware, 0.5 * plain);
  }
}

// The default errs less than the tolerance asks, and no particle costs more for being at depth 0.
TEST(GeodeticFaces, AtTheSurfaceAsBelowIt) {
  Ocean ocean(fixtures::lattice({.across = 36, .along = 18}), winding);
  const double to = 5e5;
  const auto latitudes = {-88.9, -60.0, -11.3, 7.5, 52.1, 89.2};
  const auto top = seeds_at(latitudes, {0.0}), below = seeds_at(latitudes, {-50.0});
  const Ends exact = ends_of(ocean, Method::dopri5, true, 0.0, 1e-9, top, to);
  for (const double tolerance : {1e-2, 1e-4}) { // metres per second
    const Ends surface = ends_of(ocean, Method::dopri5, true, 0.0, tolerance, top, to);
    const Ends deep = ends_of(ocean, Method::dopri5, true, 0.0, tolerance, below, to);
    const double error = worst(surface, exact);
    std::printf("tolerance %.0e m/s: %.3g m; %lld evaluations, 50 m below %lld\n", tolerance, error,
                static_cast<long long>(surface.work.evaluations),
                static_cast<long long>(deep.work.evaluations));
    EXPECT_LT(error, tolerance * to);
    EXPECT_LT(double(surface.work.evaluations), 1.05 * double(deep.work.evaluations));
    for (const Vec3d& p : surface.positions)
      EXPECT_EQ(p.z, 0.0);
  }
}

} // namespace
} // namespace insitu::test
