// Meshes in longitude, latitude and depth: every point has one owner, over the seam and the poles.
#include <algorithm>
#include <initializer_list>

#include "core/status.h"
#include "geodetic_earth.h"

using namespace insitu;
using fixtures::Globe;
using fixtures::globe;
using fixtures::Lattice;
using fixtures::lattice;
using geo::ChartUnits;
using geo::Pole;
using math::Vec3d;
using test::degrees;
using test::Earth;
using test::expect_one_owner;
using test::hard_places;
using test::random_point;

TEST(GeodeticMesh, LatticesNeedNoCopies) {
  for (const double west : {-180.0, 0.0, -30.0, 170.0, -540.0})
    for (const bool in_radians : {false, true}) {
      const ChartUnits units{in_radians, in_radians, in_radians};
      Lattice l{.units = units, .west = west, .east = west + 360};
      const Earth earth(lattice(l), units);
      EXPECT_FALSE(earth.geodetic()->has_copies());
      EXPECT_FALSE(earth.mesh.mesh().has_stand_in());
      for (const insitu_audit_entry& e : earth.mesh.audit())
        EXPECT_TRUE(e.borrowed) << e.name;
      EXPECT_EQ(earth.memory.current(INSITU_MEMORY_CHART), 0);
      expect_one_owner(earth, units, "west " + std::to_string(west));
    }
}

TEST(GeodeticMesh, CellsThatWrapAround) {
  for (const double west : {-180.0, 0.0, 13.0}) {
    Lattice l{.west = west, .east = west + 360, .wraps = true};
    const Earth earth(lattice(l));
    // A column of cells, on one side of the seam alone: its west side is where images begin.
    EXPECT_EQ(earth.geodetic()->hidden_cells(), 24);
    EXPECT_EQ(earth.geodetic()->copied_cells(), 24);
    expect_one_owner(earth, degrees, "west " + std::to_string(west));
    // Longitudes that jump from 180 to -180 within the lattice.
    l = {.west = -170, .east = 190, .jump = -360};
    expect_one_owner(Earth(lattice(l)), degrees, "jump");
  }
}

TEST(GeodeticMesh, GlobesOfWedges) {
  for (const double tilt : {0.0, 0.3, 1.1, std::atan(2.0) / 2, 0.5535743588970452}) // the last
    for (const double first : {-180.0, 0.0}) { // ones: the pole on an edge of a triangle
      Globe g{.tilt = tilt, .first = first, .pole_longitude = first + 77};
      const Earth earth(globe(g));
      EXPECT_TRUE(earth.geodetic()->has_copies());
      EXPECT_LT(earth.geodetic()->copied_cells(),
                earth.mesh.mesh().own_view().cell_count() / 3);
      expect_one_owner(earth, degrees,
                       "tilt " + std::to_string(tilt) + ", from " + std::to_string(first));
    }
}

TEST(GeodeticMesh, UnitsDepthsAndPieces) {
  const ChartUnits other{.radians = true, .kilometres = true, .down = true};
  Globe g{.tilt = 0.3};
  const Earth plain(globe(g)), pieces(globe(g), degrees, 3);
  g.units = other;
  const Earth radians(globe(g), other);
  expect_one_owner(radians, other, "radians, kilometres of depth");
  expect_one_owner(pieces, degrees, "three pieces");
  test::Random random(8);
  for (int i = 0; i < 3000; ++i) {
    const Vec3d p = random_point(random, random.uniform(-4000, 0));
    const query::Location a = plain.sampler().locate(p);
    const query::Location b = radians.sampler().locate(fixtures::in_units(other, p));
    ASSERT_EQ(plain.mesh.own(a, p).cell, radians.mesh.own(b, p).cell) << p.x << " " << p.y;
    ASSERT_EQ(plain.mesh.own(a, p).cell, pieces.owner(p));
    for (int c = 0; c < 3; ++c) // the pole's limit is another rounding, and a chart's edges others
      ASSERT_NEAR(a.parametric[c], b.parametric[c], 1e-9);
  }
}

// Every surface cell holds a drifter at depth 0, wherever: the vertical number is never touched.
TEST(GeodeticMesh, DepthZeroIsInside) {
  for (const bool down : {false, true}) {
    const ChartUnits units{.down = down};
    const Earth earth(globe({.units = units, .subdivisions = 4, .tilt = 0.4}), units);
    test::Random random(9);
    for (int i = 0; i < 20000; ++i)
      ASSERT_GE(earth.owner(random_point(random, 0.0)), 0) << i;
    EXPECT_EQ(earth.owner({10, 20, down ? -1e-12 : 1e-12}), -1);
    EXPECT_TRUE(earth.warnings.empty()) << earth.warnings[0]; // mirrored is no fault of depths
  }
}

TEST(GeodeticMesh, CellsOfAspect1e5) {
  // Layers of metres over cells of hundreds of kilometres.
  const Earth earth(globe({.subdivisions = 3, .tilt = 0.2, .levels = {-7, -4, -1, 0}}));
  test::Random random(10);
  for (int i = 0; i < 5000; ++i) {
    const Vec3d p = random_point(random, i % 2 ? random.uniform(-7, 0) : -4.0);
    const query::Location at = earth.sampler().locate(p);
    ASSERT_TRUE(at) << p.x << " " << p.y << " " << p.z;
    // The wedge's third coordinate is the height within its layer.
    const std::int64_t layer = earth.mesh.own(at, p).cell / 1280;
    const double low[] = {-7, -4, -1, 0};
    ASSERT_NEAR(low[layer] + at.parametric.z * (low[layer + 1] - low[layer]), p.z, 1e-12);
  }
}

/// A vector field that is one vector throughout space, as east, north and up at every vertex; at a
/// pole by its vertex' own longitude.
std::vector<double> one_vector(const test::TestMesh& from, const Vec3d& v) {
  std::vector<double> out;
  for (const Vec3d& x : from.vertices) {
    const geo::ChartPlace at = geo::place_of(degrees, Pole::none, x);
    out.insert(out.end(), {dot(v, at.east), dot(v, at.north), dot(v, at.normal)});
  }
  return out;
}

TEST(GeodeticMesh, VectorsTurnWithEast) {
  const Vec3d v{0.6, -0.5, 0.2};
  for (const double tilt : {0.0, 0.3}) {
    const test::TestMesh from = globe({.subdivisions = 4, .tilt = tilt, .pole_longitude = 55});
    Earth earth(from);
    const std::vector<double> values = one_vector(from, v);
    std::vector<double> ids(from.cells.size());
    for (std::size_t c = 0; c < ids.size(); ++c)
      ids[c] = double(c);
    const insitu_array a =
        insitu_array_of(values.data(), INSITU_FLOAT64, std::int64_t(from.vertices.size()), 3);
    const insitu_array b = insitu_array_of(ids.data(), INSITU_FLOAT64, std::int64_t(ids.size()), 1);
    earth.mesh.mesh().set_field(0, "v", INSITU_VERTEX, &a, 1);
    earth.mesh.mesh().set_field(0, "id", INSITU_CELL, &b, 1);
    earth.commit();
    const mesh::FieldView fields[] = {earth.mesh.mesh().field("v"), earth.mesh.mesh().field("id")};
    test::Random random(12);
    double worst = 0;
    for (int i = 0; i < 4000; ++i) {
      Vec3d p = random_point(random, random.uniform(-4000, 0));
      if (i % 2)
        p.y = std::copysign(90 - std::pow(10.0, random.uniform(-7, 1)), p.y);
      const query::Location at = earth.sampler().locate(p);
      ASSERT_TRUE(at);
      double out[4];
      earth.sampler().interpolate(fields, at, out);
      const geo::ChartPlace here = geo::place_of(degrees, Pole::none, p);
      const Vec3d got = out[0] * here.east + out[1] * here.north + out[2] * here.normal;
      worst = std::max(worst, std::sqrt(dot(got - v, got - v)));
      ASSERT_EQ(std::int64_t(out[3]), earth.mesh.own(at, p).cell);
    }
    // Linear interpolation over cells of 4 degrees: h^2 / 8 = 6e-4 of the vector; of the components
    // themselves where a cell spans 20 degrees of longitude, at most 20^2 / 8 = 1.5e-2.
    EXPECT_LT(worst, 1.7e-2) << tilt;
  }
}

TEST(GeodeticMesh, MovingMeshes) {
  const Globe g{.subdivisions = 3, .tilt = 0.3};
  const test::TestMesh from = globe(g);
  Earth earth(from);
  const std::uint64_t topology = earth.mesh.topology_version();
  earth.mesh.mesh().keep_earlier({}, earth.threads);
  for (std::size_t v = 0; v < from.vertices.size(); ++v) // layers breathe
    earth.arrays.points[3 * v + 2] *= 1.01;
  EXPECT_EQ(earth.commit(INSITU_CHANGED_GEOMETRY).action, INSITU_REFIT);
  EXPECT_EQ(earth.mesh.topology_version(), topology);
  expect_one_owner(earth, degrees, "breathing");
  // Between the steps, copies too: a point at the surface of the blended mesh.
  earth.mesh.show_earlier(earth.threads);
  ASSERT_NE(earth.mesh.mesh().view().earlier_points, nullptr);
  for (const Vec3d& p : {Vec3d{3, 4, 0}, Vec3d{3, 90, 0}, Vec3d{180, 5, 0}}) {
    const Vec3d deep{p.x, p.y, -4020 + 1e-6};
    EXPECT_TRUE(earth.sampler().locate(deep, -1, {INSITU_STANDARD, 0.5 + 1e-9}));
    EXPECT_FALSE(earth.sampler().locate(deep, -1, {INSITU_STANDARD, 0.5 - 1e-6}));
  }
  // The mesh turns with the Earth: other cells wrap.
  for (std::size_t v = 0; v < from.vertices.size(); ++v)
    earth.arrays.points[3 * v] =
        geo::longitude_from(-180, degrees, earth.arrays.points[3 * v] + 40);
  EXPECT_EQ(earth.commit(INSITU_CHANGED_GEOMETRY).action, INSITU_REBUILD);
  EXPECT_NE(earth.mesh.topology_version(), topology);
  expect_one_owner(earth, degrees, "turned");
}

TEST(GeodeticMesh, GhostsOwnNothing) {
  const test::TestMesh from = lattice({.west = 0, .east = 360, .wraps = true});
  Earth earth(from);
  std::vector<std::uint8_t> ghosts(from.cells.size(), 0);
  for (std::size_t c = 0; c < ghosts.size(); c += 24)
    ghosts[c + 23] = 1; // the column that wraps
  const insitu_array g =
      insitu_array_of(ghosts.data(), INSITU_UINT8, std::int64_t(ghosts.size()), 1);
  earth.mesh.mesh().set_ghosts(0, &g, INSITU_GHOSTS_VTK);
  earth.commit();
  EXPECT_FALSE(earth.geodetic()->has_copies());
  EXPECT_EQ(earth.owner({350, 10, -5}), -1);
  EXPECT_GE(earth.owner({344, 10, -5}), 0);
  EXPECT_GE(earth.owner({-17, 10, -5}), 0);
}

TEST(GeodeticMesh, FewerPointsThanTheWholeEarth) {
  // A region across the date line, given three ways.
  for (const double jump : {0.0, -360.0}) {
    const Earth earth(lattice({.west = 170, .south = -20, .east = 190, .north = 15, .jump = jump}));
    EXPECT_EQ(earth.geodetic()->has_copies(), jump != 0);
    for (const double lon : {170.0, 179.999, 180.0, -180.0, -179.999, -170.0, 190.0, 530.0, 550.0})
      EXPECT_GE(earth.owner({lon, 3, -7}), 0) << lon;
    for (const double lon : {169.999, -169.999, 0.0, 10.0, -190.001})
      EXPECT_EQ(earth.owner({lon, 3, -7}), -1) << lon;
    for (const double bad : {double(NAN), double(INFINITY), -double(INFINITY), 1e300})
      for (int a = 0; a < 3; ++a) {
        Vec3d p{175, 3, -7};
        p[a] = bad;
        if (a > 0 || std::abs(bad) != 1e300) {
          EXPECT_EQ(earth.owner(p), -1) << a << " " << bad;
        }
      }
  }
}

TEST(GeodeticMesh, RayMethodsAnswerAlike) {
  const test::TestMesh from = globe({.subdivisions = 3, .tilt = 0.3});
  const Earth plain(from);
  Earth rays(from);
  std::vector<Vec3d> points = hard_places(4);
  test::Random random(6);
  for (int i = 0; i < 3000; ++i)
    points.push_back(random_point(random, random.uniform(-4000, 10)));
  std::vector<query::Location> want(points.size()), got(points.size());
  plain.sampler().locate(plain.threads, points, want);
  for (const accel::Method method : {accel::Method::user_geometry, accel::Method::shared_faces,
                                     accel::Method::shared_bilinear_faces}) {
    rays.mesh.set_locator({method, accel::Backend::cpu});
    rays.commit(INSITU_CHANGED_TOPOLOGY);
    rays.sampler().locate(rays.threads, points, got);
    for (std::size_t i = 0; i < points.size(); ++i)
      ASSERT_EQ(got[i].cell, want[i].cell)
          << accel::name(method) << " " << points[i].x << " " << points[i].y << " " << points[i].z;
  }
}

TEST(GeodeticMesh, WhatIsRefusedSaysWhy) {
  const auto error = [](const test::TestMesh& from, const ChartUnits& units = {}) {
    try {
      Earth earth(from, units);
    } catch (const core::Error& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  const auto has = [](const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << "'" << text << "' lacks '" << part << "'";
  };
  has(error(lattice({.south = 0, .north = 95})), "has the latitude 95 degrees; at most 90");
  has(error(lattice({.south = 0, .north = 95}), {.radians = true}), "radians");
  has(error(globe({.subdivisions = 0})), "cells that hold a pole may reach down to 30 degrees");
  has(error(lattice({.across = 2})), "half a turn");
}
