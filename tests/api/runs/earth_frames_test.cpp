// Seeds and transects in any frame, on meshes of any frame on Earth: the same places, by
// GeographicLib.
#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/Geodesic.hpp>
#include <GeographicLib/GeodesicLine.hpp>
#include <GeographicLib/LocalCartesian.hpp>
#include <GeographicLib/UTMUPS.hpp>
#include <array>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <insitu/insitu.hpp>
#include <sstream>

#include "coupled.h"

namespace {

using Point = std::array<double, 3>;

/// Metres east, north and up of a place by Munich; easting and northing in its zone; from the
/// Earth's centre. All of longitude, latitude and height.
Point local(const Point& p) {
  Point x;
  GeographicLib::LocalCartesian(48.1, 11.5, 500).Forward(p[1], p[0], p[2], x[0], x[1], x[2]);
  return x;
}
Point utm(const Point& p) {
  int zone = 0;
  bool north = false;
  Point x{0, 0, p[2]};
  GeographicLib::UTMUPS::Forward(p[1], p[0], zone, north, x[0], x[1], 32);
  return x;
}
Point geocentric(const Point& p) {
  Point x;
  GeographicLib::Geocentric::WGS84().Forward(p[1], p[0], p[2], x[0], x[1], x[2]);
  return x;
}
Point geodetic(const Point& p) {
  return p;
}

struct Frame {
  const char* name; ///< in a scene
  insitu::Frame frame;
  Point (*of)(const Point&);
  Point reach; ///< of the mesh to either side
};
const Frame frames[] = {
    {"geodetic", insitu::Frame::geodetic(), geodetic, {0.2, 0.2, 4000}},
    {"{enu: [11.5, 48.1, 500]}", insitu::Frame::enu(11.5, 48.1, 500), local, {2e4, 2e4, 4e3}},
    {"{utm: 32N}", insitu::Frame::utm(32, true), utm, {2e4, 2e4, 4e3}},
    {"geocentric", insitu::Frame::geocentric(), geocentric, {2e4, 2e4, 2e4}}};

std::string text(const Point& p) {
  std::ostringstream out;
  out.precision(17);
  out << "[" << p[0] << ", " << p[1] << ", " << p[2] << "]";
  return out.str();
}

TEST(EarthFrames, SeedsAndTransectsInAnyFrameOnMeshesOfAny) {
  const Point from{11.45, 48.07, 300}, to{11.58, 48.15, 700};
  for (const Frame& of : frames) {
    SCOPED_TRACE(std::string("mesh: ") + of.name);
    // Fields that the cells interpolate exactly: the mesh's own coordinates.
    const Point middle = of.of({11.5, 48.1, 500});
    std::vector<double> x[3], flow;
    for (int v = 0; v < 125; ++v) {
      const int ijk[3] = {v % 5, v / 5 % 5, v / 25};
      for (std::size_t a = 0; a < 3; ++a)
        x[a].push_back(middle[a] + of.reach[a] * (0.5 * ijk[a] - 1));
      flow.insert(flow.end(), {3.0, -2.0, 0.5});
    }
    std::string scene = "insitu: 1\npage: false\n", probes = "probes:\n", tracers = "tracers:\n";
    for (int f = 0; f < 4; ++f) {
      const std::string n = std::to_string(f), frame = frames[f].name;
      const std::string a = text(frames[f].of(from)), b = text(frames[f].of(to));
      probes += "  - {name: p" + n + ", frame: " + frame +
                ", fields: [x, y, z], points: {transect: {from: " + a + ", to: " + b +
                ", count: 5}}}\n";
      tracers += "  - {name: t" + n + ", frame: " + frame + ", velocity: flow, seeds: [" + a +
                 ", " + b + "]}\n";
    }
    const test::Folder folder;
    {
      insitu::Options options;
      options.scene_text = scene + probes + tracers;
      options.output = folder.path();
      insitu::Session session(options);
      insitu::Mesh mesh = session.mesh("air");
      mesh.frame(of.frame);
      mesh.points(x[0], x[1], x[2]);
      mesh.block(5, 5, 5);
      mesh.vertex_field("flow", insitu::Array(flow).components(3));
      mesh.vertex_field("x", x[0]);
      mesh.vertex_field("y", x[1]);
      mesh.vertex_field("z", x[2]);
      for (int cycle = 0; cycle < 3; ++cycle)
        ASSERT_TRUE(session.execute(cycle, 100.0 * cycle)) << insitu_last_message();
    }
    // Coordinates of 5e6 m have 1e-9; degrees have 1e-7 m at 1e-12.
    const double tolerance = of.of == &geodetic ? 1e-11 : 1e-6;
    const runs::Table first = runs::parse_table(test::content(folder / "t0.csv"));
    ASSERT_EQ(first.rows.size(), 8u); // three cycles, and the end of the session
    for (int f = 0; f < 4; ++f) {
      SCOPED_TRACE(std::string("given in: ") + frames[f].name);
      const runs::Table t =
          runs::parse_table(test::content(folder / ("t" + std::to_string(f) + ".csv")));
      ASSERT_EQ(t.rows.size(), first.rows.size());
      for (std::size_t i = 0; i < t.rows.size(); ++i) {
        const Point seed = of.of(i % 2 ? to : from), u{3.0, -2.0, 0.5};
        for (std::size_t a = 0; a < 3; ++a) {
          const char* const axes[3] = {"x", "y", "z"};
          EXPECT_NEAR(t.number(i, axes[a]), first.number(i, axes[a]), a == 2 ? 1e-6 : tolerance);
          if (i < 2 || of.of != &geodetic) {
            EXPECT_NEAR(t.number(i, axes[a]), seed[a] + u[a] * t.number(i, "time"), 1e-6);
          }
        }
      }
      // Straight in metres, and along the shortest path on the ellipsoid in degrees.
      const runs::Table p =
          runs::parse_table(test::content(folder / ("p" + std::to_string(f) + ".csv")));
      const auto line =
          GeographicLib::Geodesic::WGS84().InverseLine(from[1], from[0], to[1], to[0]);
      for (std::size_t i = 0; i < 5; ++i) {
        const double part = double(i) / 4;
        Point place{0, 0, from[2] + part * (to[2] - from[2])};
        line.Position(part * line.Distance(), place[1], place[0]);
        const Point want = of.of(place);
        // A straight line of 13 km is 4 m below the geodesic, and by half a metre beside it in UTM.
        const double off = f == 0 || i == 0 || i == 4 ? 1e-6 : 5.0;
        const char* const axes[3] = {"x", "y", "z"};
        for (std::size_t a = 0; a < 3; ++a)
          EXPECT_NEAR(p.number(i, axes[a]), want[a], of.of == &geodetic && a < 2 ? off / 7e4 : off);
      }
    }
  }
}

} // namespace
