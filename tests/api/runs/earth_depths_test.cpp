// UTM metres with depths, whose third axis points down and whose axes are left-handed: effects
// against closed forms in true east, north and up, beside the same water in heights.
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <insitu/insitu.hpp>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "coupled.h"
#include "math/vec.h"

namespace {

using insitu::math::Vec3d;

constexpr Vec3d middle{5e5, 4.98e6, -2000}; ///< by 45 degrees north
constexpr double reach = 2000;

double length_of(const Vec3d& v) {
  return std::sqrt(dot(v, v));
}

std::string text(const Vec3d& v) {
  std::ostringstream out;
  out.precision(17);
  out << "[" << v.x << ", " << v.y << ", " << v.z << "]";
  return out.str();
}

/// Of a vector east, north and up, along the mesh's axes.
Vec3d along_axes(const Vec3d& v, bool depths) {
  return {v.x, v.y, depths ? -v.z : v.z};
}

/// Runs the tracers, all from the middle, on still water: `rest` with effects of their own. Their
/// places by time, in east, north and up of the middle.
std::map<std::string, std::vector<std::pair<double, Vec3d>>>
run(bool depths, const std::vector<std::pair<std::string, std::string>>& effects) {
  const test::Folder folder;
  std::string scene = "insitu: 1\npage: false\ntracers:\n";
  for (const auto& [name, of] : effects)
    scene += "  - {name: " + name + ", velocity: still, seeds: [" +
             text(along_axes(middle, depths)) + "], effects: [" + of + "]}\n";
  {
    insitu::Options options;
    options.scene_text = scene;
    options.output = folder.path();
    insitu::Session session(options);
    insitu::Mesh mesh = session.mesh("sea");
    mesh.frame(
        insitu::Frame::utm(32, true, depths ? insitu::Vertical::down : insitu::Vertical::up));
    std::vector<double> x[3];
    for (int v = 0; v < 125; ++v) {
      const int ijk[3] = {v % 5, v / 5 % 5, v / 25};
      Vec3d p = middle;
      for (int a = 0; a < 3; ++a)
        p[a] += reach * (0.5 * ijk[a] - 1);
      p = along_axes(p, depths);
      for (int a = 0; a < 3; ++a)
        x[std::size_t(a)].push_back(p[a]);
    }
    const std::vector<double> still(3 * 125, 0.0), speed(125, 0.004);
    mesh.points(x[0], x[1], x[2]);
    mesh.block(5, 5, 5);
    mesh.vertex_field("still", insitu::Array(still).components(3));
    mesh.vertex_field("speed", speed);
    for (int cycle = 0; cycle <= 12; ++cycle)
      EXPECT_TRUE(session.execute(cycle, 5000.0 * cycle)) << insitu_last_message();
  }
  std::map<std::string, std::vector<std::pair<double, Vec3d>>> tracks;
  for (const auto& [name, of] : effects) {
    const runs::Table t = runs::parse_table(test::content(folder / (name + ".csv")));
    for (std::size_t i = 0; i < t.rows.size(); ++i)
      if (t.text(i, "ending") == "alive") {
        const Vec3d p{t.number(i, "x"), t.number(i, "y"), t.number(i, "z")};
        tracks[name].emplace_back(t.number(i, "time"), along_axes(p, depths) - middle);
      }
    EXPECT_EQ(tracks[name].size(), 13u) << name;
  }
  return tracks;
}

/// v' = -2 rotation x v from v: the place, right-handed axes.
Vec3d turned(const Vec3d& rotation, const Vec3d& v, double t) {
  const double w = 2.0 * length_of(rotation);
  const Vec3d n = rotation / length_of(rotation), along = dot(v, n) * n, beside = v - along;
  return t * along + (std::sin(w * t) / w) * beside + ((1.0 - std::cos(w * t)) / w) * cross(v, n);
}

TEST(EarthDepths, EffectsAreThoseInHeights) {
  const Vec3d vertical{0, 0, 5.16e-5}, earth{0, 5.16e-5, 5.16e-5}, v{0.04, 0.02, 0.01};
  const double settles = 0.01, tau = 2000, g = 1e-5;
  for (const bool depths : {false, true}) {
    SCOPED_TRACE(depths ? "depths" : "heights");
    const auto of = [&](const Vec3d& w) { return text(along_axes(w, depths)); };
    const std::string flies = "{inertia: {velocity: " + of(v) + "}}, {coriolis: {rotation: ";
    const auto tracks = run(
        depths,
        {{"circle",
          "{inertia: {velocity: [0.07, 0, 0]}}, {coriolis: {rotation: " + of(vertical) + "}}"},
         {"helix", flies + of(earth) + "}}"},
         {"sinks", "{settling: {speed: 0.01}}"},
         {"rises", "{settling: {speed: -0.01}}"},
         {"as_told", "{settling: {speed: 0.01, down: " + of({0, 0, -1}) + "}}"},
         {"by_field", "{settling: {speed: speed}}"},
         {"falls", "{inertia: {response_time: 2000, gravity: " + of({0, 0, -g}) + "}}"},
         {"floats", "{inertia: {response_time: 2000, density: 900, fluid_density: 1000, gravity: " +
                        of({0, 0, -g}) + "}}"}});
    for (std::size_t i = 0; i < 13; ++i) {
      const auto at = [&](const char* name) { return tracks.at(name).at(i).second; };
      const double t = tracks.at("circle").at(i).first;
      // Metres; coordinates of 5e6 are rounded at 1e-9, steps err by 1e-6 a second at most.
      const double tolerance = 1e-6 + 1e-6 * t;
      const auto expect = [&](const char* name, const Vec3d& x) {
        EXPECT_LE(length_of(at(name) - x), tolerance) << name << " at " << t;
      };
      // The circle of inertia of the northern hemisphere is clockwise: an eastward one turns south.
      const double f = 2.0 * vertical.z, r = 0.07 / f;
      expect("circle", {r * std::sin(f * t), -r * (1.0 - std::cos(f * t)), 0.0});
      expect("helix", turned(earth, v, t));
      expect("sinks", {0, 0, -settles * t});
      expect("rises", {0, 0, settles * t});
      expect("as_told", {0, 0, -settles * t});
      expect("by_field", {0, 0, -0.004 * t});
      const double fallen = tau * (t - tau * (1.0 - std::exp(-t / tau)));
      expect("falls", {0, 0, -g * fallen});
      expect("floats", {0, 0, g * (1000.0 / 900.0 - 1.0) * fallen});
    }
  }
}

/// Cells that are the right way round on Earth are mirrored in these coordinates; that is no fault.
TEST(EarthDepths, MirroredCellsAreNoFault) {
  for (const bool depths : {false, true}) {
    std::vector<std::string> warnings;
    insitu::Options options;
    options.log_level = insitu::LogLevel::warning;
    options.log = [&](insitu::LogLevel, const char* message) { warnings.emplace_back(message); };
    insitu::Session session(options);
    insitu::Mesh mesh = session.mesh("sea");
    mesh.frame(
        insitu::Frame::utm(32, true, depths ? insitu::Vertical::down : insitu::Vertical::up));
    const double low = depths ? 100 : 0, high = depths ? 0 : 100;
    const std::vector<double> x{0, 100, 100, 0, 0, 100, 100, 0}, y{0, 0, 100, 100, 0, 0, 100, 100},
        z{low, low, low, low, high, high, high, high};
    const std::vector<std::int32_t> cell{0, 1, 2, 3, 4, 5, 6, 7};
    mesh.points(x, y, z);
    mesh.hexahedra(cell);
    mesh.commit();
    EXPECT_TRUE(warnings.empty()) << warnings[0];
  }
}

} // namespace
