// Particles on the ellipsoid: velocities in metres per second on meshes in longitude and latitude.
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <numbers>

#include "advect/field/chart_motion.h"
#include "advect/integrate/integrate.h"
#include "advect/lines/streamlines.h"
#include "advect/pathlines.h"
#include "core/random.h"
#include "earth_flow.h"
#include "fixtures/committed.h"
#include "fixtures/earth_meshes.h"

namespace insitu::test {
namespace {

using advect::IntegratorSettings;
using advect::Method;
using advect::Sampled;
using advect::State;
using geo::ChartUnits;
using geo::Pole;

constexpr double degree = std::numbers::pi / 180;
constexpr ChartUnits degrees{};

/// Along the surface between two places that are near each other, metres.
double metres_apart(const ChartUnits& units, const Vec3d& p, const Vec3d& q) {
  const Vec3d d = geo::normal_of(units, p) - geo::normal_of(units, q);
  return std::sqrt(dot(d, d)) * geo::radii(1.0).across;
}

/// East, north and up (0) in metres per second along a chart's directions where the normal turns as
/// a rigid body: dn/dt = omega x n.
Vec3d rotation(const ChartUnits& units, Pole pole, const Vec3d& at, const Vec3d& omega) {
  const geo::ChartPlace place = geo::place_of(units, pole, at);
  const geo::EastNorth axes = geo::east_north(place.normal);
  const geo::Radii r = geo::radii(place.normal.z);
  const Vec3d dn = cross(omega, place.normal);
  const double h = at.z * units.up_per_unit();
  const Vec3d v = ((r.across + h) * dot(dn, axes.east)) * axes.east +
                  ((r.along + h) * dot(dn, axes.north)) * axes.north;
  return {dot(v, place.east), dot(v, place.north), 0.0};
}

/// That velocity everywhere, without a mesh.
struct Rotation {
  query::ChartImage image;
  Vec3d omega;
  advect::ChartMotion chart{&image};
  int changes = 0; ///< of charts

  Sampled operator()(const Vec3d& x, double, Vec3d& v) {
    Vec3d at;
    if (!chart.image(x, at))
      return Sampled::outside;
    const double turns = (at.x - image.west) / image.units.turn(); // see ChartImage::offset
    const Pole pole = turns <= 1 ? Pole::none : turns < 13.0 / 6 ? Pole::north : Pole::south;
    const Vec3d local{at.x - image.offset(pole), at.y, at.z};
    v = chart.rates(x, at, pole, rotation(image.units, pole, local, omega));
    return Sampled::inside;
  }
  void accepted() {}
  void settle(Vec3d& x, Vec3d& rate) { changes += chart.settle(x, rate); }
  double length(const Vec3d& x, const Vec3d& d) const { return chart.length(x, d); }
  Vec3d extent() const {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    return {infinity, infinity, infinity};
  }
};

/// The axis of a rotation that is tilted from the Earth's towards a longitude.
Vec3d axis(double tilt, double towards) {
  return {std::sin(tilt * degree) * std::cos(towards * degree),
          std::sin(tilt * degree) * std::sin(towards * degree), std::cos(tilt * degree)};
}

TEST(GeodeticTracks, RotationsReturnAfterATurnToTheMillimetre) {
  constexpr double speed = 10, radius = 6.4e6, period = 2 * std::numbers::pi * radius / speed;
  for (const bool in_radians : {false, true})         // the latter with cells on the poles' charts
    for (const double tilt : {0.0, 23.4, 60.0, 90.0}) // the last goes over both poles, exactly
      for (const Method method : {Method::rk4, Method::dopri5}) {
        const ChartUnits units{.radians = in_radians, .kilometres = in_radians, .down = in_radians};
        Rotation field{.image = {.units = units, .west = -units.turn() / 2},
                       .omega = (speed / radius) * axis(tilt, -90)};
        if (in_radians) {
          field.image.north_from = 1.3;
          field.image.south_from = -1.4;
        }
        for (const Vec3d& seed : {Vec3d{0, 30, -100}, Vec3d{179.999, -12, 0}, Vec3d{-90, 89.9, 0},
                                  Vec3d{17, -90, -5}, Vec3d{180, 66, 3000}}) {
          const Vec3d from = fixtures::in_units(units, seed);
          State p;
          field.chart = advect::ChartMotion(&field.image);
          p.x = field.chart.enter(from);
          IntegratorSettings settings;
          settings.method = method;
          settings.tolerance = 1e-11; // m/s: 0.04 mm in a turn
          settings.step = method == Method::rk4 ? period / 4000 : 0.0;
          settings.max_step = period / 100;
          settings.max_steps = 1000000;
          advect::Work work;
          double low = 90, high = -90;
          const insitu_ending ending =
              integrate(field, settings, period, 1e300, p, work, [&](const State& s) {
                const Vec3d at = field.chart.position(s.x);
                EXPECT_EQ(at.z, from.z);
                low = std::min(low, at.y / units.quarter() * 90);
                high = std::max(high, at.y / units.quarter() * 90);
              });
          ASSERT_EQ(ending, INSITU_END_ALIVE);
          const Vec3d at = field.chart.position(p.x);
          EXPECT_LT(metres_apart(units, at, from), 1e-3)
              << "tilt " << tilt << ", seed " << seed.x << " " << seed.y << ", method "
              << int(method);
          EXPECT_EQ(at.z, from.z);
          if (tilt == 90) { // around the axis through (-90, 0): from pole to pole
            EXPECT_GT(high - low, seed.x == -90 || seed.x == 17 || seed.y == -12 ? 100 : 50);
          }
        }
        EXPECT_EQ(field.changes > 0, tilt > 0);
      }
}

TEST(GeodeticTracks, PathsAreMeasuredInMetres) {
  // Around the equator the length is its circumference, over the poles that of a meridian.
  for (const double tilt : {0.0, 90.0}) {
    constexpr double period = 1e6;
    Rotation field{.image = {.west = -180},
                   .omega = (2 * std::numbers::pi / period) * axis(tilt, -90)};
    State p;
    p.x = field.chart.enter({0, 0, 0});
    IntegratorSettings settings;
    settings.method = Method::rk4;
    settings.step = period / 4000;
    advect::Work work;
    integrate(field, settings, period, 1e300, p, work, [](const State&) {});
    // Meridian: GeographicLib's quarter, 10001965.729 m.
    const double want =
        tilt == 0 ? 2 * std::numbers::pi * geo::equatorial_radius : 4 * 10001965.729;
    EXPECT_NEAR(p.length / want, 1, 2e-6) << tilt;
  }
}

/// A committed mesh with a velocity.
struct EarthFlow : fixtures::Committed {
  EarthFlow(const TestMesh& from, const ChartUnits& units, const Vec3d& omega, double up = 0)
      : Committed() {
    arrays = fixtures::SolverArrays(from);
    mesh.reference_frame = fixtures::frame_of(units);
    for (const Vec3d& x : from.vertices) {
      const Vec3d v = rotation(units, Pole::none, x, omega);
      velocity.insert(velocity.end(), {v.x, v.y, up});
    }
    const insitu_array a = arrays.point_array();
    const insitu_cells c = arrays.cells();
    const insitu_array v =
        insitu_array_of(velocity.data(), INSITU_FLOAT64, std::int64_t(from.vertices.size()), 3);
    mesh.mesh().set_points(0, &a, 1);
    mesh.mesh().set_cells(0, &c);
    mesh.mesh().set_field(0, "v", INSITU_VERTEX, &v, 1);
    commit();
  }
  mesh::FieldView field() const { return mesh.mesh().field("v"); }
  std::vector<double> velocity;
};

constexpr double turn_time = 4e6;

/// Where seeds are after a time, in cycles.
std::vector<Vec3d> carried(const EarthFlow& earth, std::span<const Vec3d> seeds, double time,
                           int cycles, const core::Threads& threads, core::Memory& memory) {
  advect::TracerSettings settings;
  settings.integrator.method = Method::rk4;
  advect::Tracer tracer(settings, memory);
  tracer.seed(seeds, 0.0);
  const mesh::FieldView v = earth.field();
  for (int c = 0; c < cycles; ++c) {
    const advect::Advance a =
        tracer.advance(earth.sampler(), v, &v, time * c / cycles, time * (c + 1) / cycles, threads);
    EXPECT_EQ(a.counts.alive(), std::int64_t(seeds.size())) << "cycle " << c;
  }
  const auto at = tracer.positions();
  return {at.begin(), at.end()};
}

std::vector<Vec3d> seeds_over_the_globe(int count, const ChartUnits& units) {
  std::vector<Vec3d> seeds{{0, 90, 0},      {33, -90, 0},         {180, 10, 0},
                           {-180, 10, -50}, {179.999, -20, -100}, {-179.999, 40, -4000},
                           {0, 0, 0},       {360, 5, 0},          {-540, 89.99, 0}};
  for (int i = 0; int(seeds.size()) < count; ++i)
    seeds.push_back({core::random_unit(3, std::uint64_t(i), 0) * 360 - 180,
                     std::asin(2 * core::random_unit(3, std::uint64_t(i), 1) - 1) / degree,
                     i % 2 ? 0.0 : -4000 * core::random_unit(3, std::uint64_t(i), 2)});
  for (Vec3d& p : seeds)
    p = fixtures::in_units(units, p);
  return seeds;
}

// Zonal rotation along rows of a lattice is exact in the mesh too: back after a turn, to the
// millimetre, over the seam, at any depth.
TEST(GeodeticTracks, ZonalRotationOnAMesh) {
  core::Memory memory;
  for (const bool wraps : {false, true}) {
    const EarthFlow earth(
        fixtures::lattice({.south = -80, .north = 80, .across = 36, .along = 16, .wraps = wraps}),
        degrees, {0, 0, 2 * std::numbers::pi / turn_time});
    std::vector<Vec3d> seeds;
    for (int j = 1; j < 16; ++j)
      seeds.push_back({-180 + 21.7 * j, -80.0 + 10 * j, j % 2 ? 0.0 : -4000.0});
    const std::vector<Vec3d> at = carried(earth, seeds, turn_time, 5, earth.threads, memory);
    for (std::size_t i = 0; i < seeds.size(); ++i) {
      EXPECT_LT(metres_apart(degrees, at[i], seeds[i]), 1e-3) << seeds[i].x << " " << seeds[i].y;
      EXPECT_EQ(at[i].z, seeds[i].z);
      EXPECT_GE(at[i].x, -180);
      EXPECT_LT(at[i].x, 180);
    }
  }
}

// A rotation about a tilted axis, over both poles, interpolated on a mesh: nothing is lost, depths
// stay to the bit, and the error is the interpolation's.
TEST(GeodeticTracks, TiltedRotationOnMeshes) {
  core::Memory memory;
  const core::Threads one(1), many(4);
  for (const int kind : {0, 1, 2, 3}) {
    const double tilt = kind < 2 ? 90 : 60 + 30 * (kind - 2);
    const ChartUnits units = kind == 2 ? ChartUnits{true, true, true} : degrees;
    const TestMesh mesh =
        kind == 0 ? fixtures::lattice({.across = 72, .along = 36})
        : kind == 1
            ? fixtures::lattice({.west = 0, .east = 360, .across = 72, .along = 36, .wraps = true})
            : fixtures::globe({.units = units,
                               .subdivisions = 4,
                               .tilt = kind == 3 ? 0.0 : 0.3,
                               .pole_longitude = 40});
    const Vec3d omega = (2 * std::numbers::pi / turn_time) * axis(tilt, 20);
    const EarthFlow earth(mesh, units, omega);
    const std::vector<Vec3d> seeds = seeds_over_the_globe(60, units);
    const std::vector<Vec3d> at = carried(earth, seeds, turn_time, 4, many, memory);
    double worst = 0, sum = 0;
    for (std::size_t i = 0; i < seeds.size(); ++i) {
      EXPECT_EQ(at[i].z, seeds[i].z);
      const double error = metres_apart(units, at[i], seeds[i]);
      worst = std::max(worst, error);
      sum += error;
    }
    // Interpolation over 5 degrees: a velocity that is right to h^2 / 12 = 6e-4 on average, of
    // 40,000 km; more within a few degrees of a pole, where components turn with the lattice.
    EXPECT_LT(sum / double(seeds.size()), 40e3) << "mesh " << kind << ", tilt " << tilt;
    EXPECT_LT(worst, 200e3) << "mesh " << kind << ", tilt " << tilt;
    const std::vector<Vec3d> again = carried(earth, seeds, turn_time, 4, one, memory);
    EXPECT_EQ(std::memcmp(at.data(), again.data(), at.size() * sizeof(Vec3d)), 0);
  }
}

TEST(GeodeticTracks, UnitsGiveTheSameTracks) {
  core::Memory memory;
  const ChartUnits other{.radians = true, .kilometres = true, .down = true};
  const Vec3d omega = (2 * std::numbers::pi / turn_time) * axis(60, 20);
  const double up = 1e-5; // m/s
  const fixtures::Lattice l{.across = 72, .along = 36, .levels = {-4000, -2000, 100}};
  fixtures::Lattice o = l;
  o.units = other;
  const EarthFlow plain(fixtures::lattice(l), degrees, omega, up),
      radians(fixtures::lattice(o), other, omega, up);
  const auto a = carried(plain, seeds_over_the_globe(100, degrees), 1e6, 3, plain.threads, memory);
  const auto b = carried(radians, seeds_over_the_globe(100, other), 1e6, 3, plain.threads, memory);
  const auto from = seeds_over_the_globe(100, degrees);
  int otherwise = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Vec3d there = fixtures::in_units(other, a[i]);
    // Steps follow from cells: the same to rounding but where a point on a face, or at a pole, is
    // the next cell's by rounding; then the error of the steps is another.
    const double apart = metres_apart(other, there, b[i]);
    EXPECT_LT(apart, 100);
    otherwise += apart > 1e-2;
    EXPECT_NEAR(there.z, b[i].z, 1e-9);
    EXPECT_NEAR(a[i].z, from[i].z + 10, 1e-6); // 1e-5 m/s upwards for 1e6 s
  }
  EXPECT_LE(otherwise, 15);
}

TEST(GeodeticTracks, StreamlinesEndAfterMetres) {
  core::Memory memory;
  const Vec3d omega = (2 * std::numbers::pi / turn_time) * axis(0, 0);
  const EarthFlow earth(fixtures::lattice({.across = 72, .along = 36}), degrees, omega);
  advect::StreamlineSettings settings;
  settings.length = 1e6;
  const std::vector<Vec3d> seeds{{175, 0, 0}, {0, 60, -100}};
  const advect::Streamlines lines =
      trace_streamlines(earth.sampler(), earth.field(), seeds, settings, earth.threads, memory);
  for (std::size_t l = 0; l < 2; ++l) {
    EXPECT_EQ(lines.lines.endings[l], INSITU_END_EXPIRED);
    const Vec3d end = lines.lines.points[std::size_t(lines.lines.offsets[l + 1]) - 1];
    const geo::Radii r = geo::radii(std::sin(seeds[l].y * degree));
    const double turned = 1e6 / ((r.across + seeds[l].z) * std::cos(seeds[l].y * degree)) / degree;
    EXPECT_NEAR(end.x, geo::longitude_from(-180, degrees, seeds[l].x + turned), 1e-6);
    EXPECT_EQ(end.z, seeds[l].z);
  }
}

TEST(GeodeticTracks, SeedsOutsideEndAsSuch) {
  core::Memory memory;
  const EarthFlow earth(fixtures::lattice({}), degrees, {0, 0, 1e-6});
  advect::Tracer tracer({}, memory);
  const std::vector<Vec3d> seeds{{0, 0, 1e-9}, {0, 95, -1}, {0, -90.0001, -1}, {5, 5, -4001},
                                 {NAN, 0, 0},  {0, NAN, 0}, {INFINITY, 1, -1}};
  tracer.seed(seeds, 0);
  const mesh::FieldView v = earth.field();
  const advect::Advance a = tracer.advance(earth.sampler(), v, nullptr, 0, 1000, earth.threads);
  EXPECT_EQ(a.counts.by_ending[INSITU_END_SEED_OUTSIDE], 7);
}

} // namespace
} // namespace insitu::test
