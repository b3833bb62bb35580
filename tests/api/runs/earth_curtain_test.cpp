// Curtains through meshes on Earth: where their points are, what is found there, and the files.
#include <GeographicLib/Geodesic.hpp>
#include <GeographicLib/GeodesicLine.hpp>
#include <cmath>
#include <gtest/gtest.h>

#include "coupled.h"
#include "on_earth.h"
#include "scene/probes/curtain.h"
#include "unit/output/netcdf_file.h"

namespace {

using insitu::fixtures::Lattice;
using runs::OnEarth;
using test::NetcdfFile;

struct Place {
  double lon, lat;
};

/// The place so many metres from one to another, by GeographicLib.
Place along(const Place& from, const Place& to, double s) {
  const auto line =
      GeographicLib::Geodesic::WGS84().InverseLine(from.lat, from.lon, to.lat, to.lon);
  Place p{};
  line.Position(s, p.lat, p.lon);
  return p;
}

double metres(const Place& a, const Place& b) {
  double s;
  GeographicLib::Geodesic::WGS84().Inverse(a.lat, a.lon, b.lat, b.lon, s);
  return s;
}

/// The Pacific: longitudes jump at the date line. 3 km deep.
Lattice pacific(const insitu::geo::ChartUnits& units = {}) {
  return {.units = units,
          .west = 150,
          .south = -30,
          .east = 210,
          .north = 30,
          .across = 12,
          .along = 12,
          .levels = {-3000, -500, 0},
          .jump = -360};
}

TEST(Curtains, CrossTheDateLineAndEndAtTheFloor) {
  const Place from{165, 10}, to{-165, -12};
  const double length = metres(from, to);
  // The mesh has heights, or depths in kilometres and radians: the curtain has depths in metres.
  for (const insitu::geo::ChartUnits units :
       {insitu::geo::ChartUnits{}, insitu::geo::ChartUnits{true, true, true}}) {
    const test::Folder folder;
    {
      OnEarth run(
          pacific(units),
          "probes: [{name: wall, frame: {geodetic: depth}, fields: [latitude, height], "
          "output: [csv, netcdf, vtp, json], points: {curtain: {through: [[165, 10], [-165, "
          "-12]], count: 21, levels: [0, 100, 2500, 3500]}}}]\n",
          folder.path());
      ASSERT_TRUE(run.session.execute(0, 0.0)) << insitu_last_message();
      ASSERT_TRUE(run.session.execute(1, 5.0)) << insitu_last_message();
      EXPECT_EQ(run.session.report().points_outside, 2 * 21) << "what is below the floor";
    }
    const runs::Table table = runs::parse_table(test::content(folder / "wall.csv"));
    EXPECT_EQ(table.columns,
              (std::vector<std::string>{"cycle", "time", "point", "distance", "depth", "cell", "r",
                                        "s", "t", "latitude", "height"}));
    ASSERT_EQ(table.rows.size(), 2u * 21 * 4);
    const double depths[] = {0, 100, 2500, 3500};
    for (std::size_t i = 0; i < table.rows.size(); ++i) {
      const std::size_t station = i % 84 / 4, level = i % 4;
      const double s = length * double(station) / 20;
      ASSERT_NEAR(table.number(i, "distance"), s, 1e-6) << i;
      ASSERT_EQ(table.number(i, "depth"), depths[level]);
      if (level == 3) {
        ASSERT_EQ(table.text(i, "cell"), "-1");
        ASSERT_TRUE(std::isnan(table.number(i, "latitude")));
      } else { // 1e-6 m are 1e-11 degrees
        ASSERT_NEAR(table.number(i, "latitude"), along(from, to, s).lat, 1e-10) << i;
        ASSERT_NEAR(table.number(i, "height"), -depths[level], 1e-6) << i;
      }
    }
    // CF 1.10, appendix H.5: profiles at stations, in the curtain's frame whatever the mesh's.
    const NetcdfFile file(folder / "wall.nc");
    EXPECT_EQ(file.texts.at("featureType"), "timeSeriesProfile");
    EXPECT_EQ(file.unlimited, "time");
    EXPECT_EQ(file["latitude"].dimensions, (std::vector<std::string>{"time", "station", "depth"}));
    EXPECT_EQ(file["latitude"].texts.at("coordinates"), "lon lat distance");
    EXPECT_EQ(file["depth"].dimensions, std::vector<std::string>{"depth"});
    EXPECT_EQ(file["depth"].doubles, std::vector<double>(depths, depths + 4));
    EXPECT_EQ(file["depth"].texts.at("standard_name"), "depth");
    EXPECT_EQ(file["depth"].texts.at("positive"), "down");
    EXPECT_EQ(file["depth"].texts.at("units"), "m");
    EXPECT_EQ(file["depth"].texts.at("axis"), "Z");
    EXPECT_EQ(file["distance"].texts.at("units"), "m");
    EXPECT_EQ(file["station"].texts.at("cf_role"), "timeseries_id");
    EXPECT_EQ(file["lon"].texts.at("units"), "degrees_east");
    ASSERT_EQ(file["lon"].doubles.size(), 21u);
    for (std::size_t station = 0; station < 21; ++station) {
      const Place p = along(from, to, length * double(station) / 20);
      EXPECT_NEAR(std::remainder(file["lon"].doubles[station] - p.lon, 360), 0, 1e-10);
      EXPECT_NEAR(file["lat"].doubles[station], p.lat, 1e-10);
      EXPECT_EQ(file["distance"].doubles[station], table.number(4 * station, "distance"));
    }
    ASSERT_EQ(file["height"].doubles.size(), table.rows.size());
    for (std::size_t i = 0; i < table.rows.size(); ++i) {
      EXPECT_EQ(std::to_string(file["cell"].integers[i]), table.text(i, "cell"));
      if (i % 4 < 3) {
        EXPECT_EQ(file["height"].doubles[i], table.number(i, "height"));
      } else {
        EXPECT_TRUE(std::isnan(file["height"].doubles[i]));
      }
    }
    const std::string vtp = test::content(folder / "wall_000001.vtp");
    EXPECT_NE(vtp.find("NumberOfPoints=\"84\" NumberOfVerts=\"0\" NumberOfLines=\"0\" "
                       "NumberOfStrips=\"0\" NumberOfPolys=\"60\""),
              std::string::npos)
        << vtp.substr(0, 500);
    EXPECT_NE(vtp.find("Name=\"distance\""), std::string::npos);
    EXPECT_NE(vtp.find("Name=\"depth\""), std::string::npos);
    EXPECT_NE(test::content(folder / "wall_000001.json")
                  .find("\"columns\": [\"distance\", \"depth\", \"cell\", \"latitude\", "
                        "\"height\"], \"points\": [\n  [0, 0, "),
              std::string::npos);
  }
}

TEST(Curtains, GoOverAPoleAndThroughPlaces) {
  const test::Folder folder;
  const Place places[] = {{30, 80}, {-150, 85}, {-150, 60}, {179, 60}};
  double begins[4] = {0};
  for (int i = 0; i < 3; ++i)
    begins[i + 1] = begins[i] + metres(places[i], places[i + 1]);
  {
    OnEarth run(
        {.levels = {-4000, -100, 0}, .wraps = true},
        "probes:\n"
        "  - {name: arctic, frame: geodetic, fields: [latitude, height], points: {curtain: "
        "{through: [[30, 80], [-150, 85], [-150, 60], [179, 60]], count: 101, levels: {from: "
        "-4000, to: 0, count: 5}}}}\n",
        folder.path());
    ASSERT_TRUE(run.session.execute(0, 0.0)) << insitu_last_message();
    EXPECT_EQ(run.session.report().points_outside, 0);
  }
  const runs::Table table = runs::parse_table(test::content(folder / "arctic.csv"));
  ASSERT_EQ(table.rows.size(), 505u);
  double highest = 0;
  for (std::size_t i = 0; i < 505; ++i) {
    const double s = begins[3] * double(i / 5) / 100;
    const int leg = s < begins[1] ? 0 : s < begins[2] ? 1 : 2;
    const Place at = along(places[leg], places[leg + 1], s - begins[leg]);
    ASSERT_NEAR(table.number(i, "distance"), s, 1e-6) << i;
    ASSERT_EQ(table.number(i, "height"), -4000 + 1000.0 * double(i % 5)) << i;
    // Around the pole cells are located on a chart turned to it, where the field's latitude is not
    // linear within a cell of 7.5 degrees: this says which cell, the places are checked in geo.
    ASSERT_NEAR(table.number(i, "latitude"), at.lat, at.lat < 75 ? 1e-10 : 7.5) << i;
    highest = std::max(highest, at.lat);
  }
  EXPECT_GT(highest, 89.0);
}

TEST(Curtains, StandInOtherFramesToo) {
  const test::Folder folder;
  {
    OnEarth run(
        pacific(),
        "probes:\n"
        "  - {name: flat, frame: {enu: [180, 0, 0]}, fields: [height], output: [netcdf, csv, "
        "vtp], points: {curtain: {through: [[0, 0], [3000, 4000], [3000, 0]], count: 10, "
        "levels: [-10]}}}\n",
        folder.path());
    ASSERT_TRUE(run.session.execute(0, 0.0)) << insitu_last_message();
  }
  const NetcdfFile file(folder / "flat.nc");
  EXPECT_EQ(file["height"].dimensions, (std::vector<std::string>{"time", "station", "z"}));
  EXPECT_EQ(file["height"].texts.count("grid_mapping"), 0u) << "CF has none for east, north, up";
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_NEAR(file["distance"].doubles[i], 1000.0 * double(i), 1e-9);
    EXPECT_NEAR(file["y"].doubles[i], i <= 5 ? 800.0 * double(i) : 4000 - 1000.0 * (double(i) - 5),
                1e-9);
    const double x = file["x"].doubles[i], y = file["y"].doubles[i];
    // The plane leaves the ellipsoid by d^2 / 2 R; north of the equator R is 0.7 % less.
    EXPECT_NEAR(file["height"].doubles[i], -10 + (x * x + y * y) / (2 * 6.36e6), 0.02);
  }
  EXPECT_NE(test::content(folder / "flat_000000.vtp")
                .find("NumberOfVerts=\"0\" NumberOfLines=\"1\" NumberOfStrips=\"0\" "
                      "NumberOfPolys=\"0\""),
            std::string::npos);
  EXPECT_EQ(runs::parse_table(test::content(folder / "flat.csv")).columns[4], "z");

  const test::Folder other; // in the mesh's own coordinates, which are geocentric
  OnEarth run(pacific(),
              "probes: [{name: p, points: {curtain: {through: [[0, 0], [1, 1]], count: 2, "
              "levels: [0]}}}]\n",
              other.path());
  run.mesh.frame(insitu::Frame::geocentric());
  EXPECT_FALSE(run.session.execute(0, 0.0));
  EXPECT_NE(std::string(insitu_last_message()).find("no upright in geocentric coordinates"),
            std::string::npos)
      << insitu_last_message();
  EXPECT_FALSE(std::filesystem::exists(other / "p.csv"));
}

TEST(Curtains, MayBeInTheMeshsOwnUnits) {
  const insitu::geo::ChartUnits units{true, true, true};
  const test::Folder folder;
  {
    OnEarth run(
        pacific(units),
        "probes:\n"
        "  - {name: own, fields: [latitude], output: [csv, netcdf], points: {curtain: {through: "
        "[[2.9, 0.2], [-2.9, -0.2]], count: 9, levels: [0, 2.5]}}}\n"
        "  - {name: high, fields: [latitude], points: {curtain: {through: [[2.9, 0.2], [2.9, "
        "1.6]], count: 9, levels: [0]}}}\n",
        folder.path());
    EXPECT_FALSE(run.session.execute(0, 0.0));
    const std::string message = insitu_last_message();
    EXPECT_NE(message.find("probe 'high'"), std::string::npos) << message;
    EXPECT_NE(message.find("latitude"), std::string::npos) << message;
    EXPECT_EQ(message.find("probe 'own'"), std::string::npos) << message;
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "high.csv"));
  const double degree = std::numbers::pi / 180;
  const Place from{2.9 / degree, 0.2 / degree}, to{-2.9 / degree, -0.2 / degree};
  const double length = metres(from, to);
  const runs::Table t = runs::parse_table(test::content(folder / "own.csv"));
  ASSERT_EQ(t.rows.size(), 18u);
  for (std::size_t i = 0; i < 18; ++i) {
    const double s = length * double(i / 2) / 8;
    EXPECT_NEAR(t.number(i, "distance"), s, 1e-6) << "metres";
    EXPECT_EQ(t.number(i, "depth"), i % 2 ? 2.5 : 0) << "kilometres";
    EXPECT_NEAR(t.number(i, "latitude"), along(from, to, s).lat, 1e-10);
  }
  const NetcdfFile file(folder / "own.nc");
  EXPECT_EQ(file["lon"].texts.at("units"), "radian");
  EXPECT_EQ(file["lon"].doubles.front(), 2.9);
  EXPECT_EQ(file["depth"].texts.at("units"), "km");
  EXPECT_EQ(file["distance"].texts.at("units"), "m");
}

TEST(Curtains, HaveNoJumpAsSurfaces) {
  insitu::scene::ScenePoints points;
  points.curtain.emplace();
  points.curtain->frame.kind = INSITU_FRAME_GEODETIC;
  points.curtain->frame.vertical = INSITU_DOWN;
  points.curtain->levels = {0, 10};
  for (int i = 0; i < 10; ++i) { // 176 to 194, as frames have them
    const double lon = 176 + 2 * i > 180 ? 176 + 2 * i - 360 : 176 + 2 * i;
    points.curtain->stations.push_back({lon, 5, 0});
    points.curtain->distances.push_back(i);
    for (const double level : points.curtain->levels)
      points.mesh_points.push_back({lon, 5, -level});
  }
  const insitu::scene::CurtainSurface surface(points, points.curtain->frame);
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_EQ(surface.points[i].x, 176.0 + 2.0 * double(i / 2));
    EXPECT_EQ(surface.points[i].z, points.mesh_points[i].z);
  }
  insitu::output::VtkPolyData data;
  surface.add_to(data);
  ASSERT_EQ(data.quads.size(), 36u);
  EXPECT_EQ(std::vector<std::int64_t>(data.quads.begin(), data.quads.begin() + 4),
            (std::vector<std::int64_t>{0, 2, 3, 1}));
  EXPECT_EQ(data.point_data[1].name, "depth");
}

} // namespace
