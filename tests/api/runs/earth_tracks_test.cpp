// Geodesics of tracks: closed forms on the equator and a meridian, and GeographicLib itself.
#include <GeographicLib/Geodesic.hpp>
#include <bit>
#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>
#include <map>

#include "coupled.h"
#include "geo/reference_frames.h"
#include "on_earth.h"
#include "unit/advect/earth_flow.h"
#include "unit/output/netcdf_file.h"

namespace {

using insitu::fixtures::Lattice;
using runs::OnEarth;
using runs::pacific;

const std::string columns = "geodesics: [path_length, release_distance, release_bearing]";

struct Inverse {
  double distance, bearing;
};

Inverse inverse(double lon1, double lat1, double lon2, double lat2) {
  Inverse out{};
  double there;
  GeographicLib::Geodesic::WGS84().Inverse(lat1, lon1, lat2, lon2, out.distance, out.bearing,
                                           there);
  return out;
}

TEST(TrackGeodesics, AreClosedFormsOnTheEquatorAndAMeridian) {
  for (const bool north : {false, true}) {
    const test::Folder folder;
    {
      OnEarth run(pacific(),
                  "tracers: [{name: t, velocity: velocity, seeds: [[179, 0, 0]], " + columns +
                      ", integrator: {method: dopri5, tolerance: 1e-9}}]\n",
                  folder.path());
      run.flow(north ? 0 : 1.5, north ? 1.5 : 0); // m/s
      for (int cycle = 0; cycle <= 20; ++cycle)
        ASSERT_TRUE(run.session.execute(cycle, 10000.0 * cycle)) << insitu_last_message();
    }
    const runs::Table t = runs::parse_table(test::content(folder / "t.csv"));
    ASSERT_EQ(t.rows.size(), 22u) << "and one of its ending";
    EXPECT_EQ(t.text(21, "ending"), "killed");
    EXPECT_EQ(t.number(20, "release_distance"), t.number(21, "release_distance"));
    if (!north) {
      EXPECT_GT(t.number(20, "x"), 181.0) << "over the date line";
    }
    for (std::size_t i = 0; i < 21; ++i) {
      const double way = 1.5 * 10000.0 * double(i); // at height 0 the speed is along the ellipsoid
      // 20 steps of a tolerance of 1e-9 m/s over 1e4 s are within 0.2 mm.
      EXPECT_NEAR(t.number(i, "path_length"), way, 1e-3) << i;
      EXPECT_NEAR(t.number(i, "release_distance"), way, 1e-3) << i;
      if (i == 0) {
        EXPECT_TRUE(std::isnan(t.number(i, "release_bearing")));
      } else {
        EXPECT_NEAR(t.number(i, "release_bearing"), north ? 0 : 90, 1e-9) << i;
      }
    }
  }
}

// Tracks over steps on other cells, about a date line that is a seam on some of them: the flow
// grows evenly with time, so what is between two steps is known, at depth 0 too; and a stop loses
// nothing.
TEST(EarthRemeshing, DriftersCrossToOtherCellsAndOverAStop) {
  const std::string scene =
      "tracers:\n  - {name: t, velocity: velocity, seeds: [[175, 5, 0], [179.999, -20, -700]], "
      "fields: [latitude, height], times: {interval: 7000}, integrator: {tolerance: 1e-9}}\n"
      "  - {name: coast, velocity: velocity, seeds: [[179, 30, 0]], "
      "effects: [{boundary: slide}], fields: [latitude], integrator: {tolerance: 1e-9}}\n";
  const auto cells = [](int cycle) {
    Lattice l = pacific();
    l.across = 12 + cycle % 5;
    l.along = 12 * (1 + cycle % 2);
    l.jump = cycle % 3 == 1 ? -360 : 0; // longitudes from -180 on: there a seam
    return l;
  };
  const auto execute = [&](OnEarth& run, int first, int last) {
    for (int cycle = first; cycle <= last; ++cycle) {
      if (cycle % 3 != 0)
        run.remesh(cells(cycle));
      run.flow(0.5 + 0.1 * cycle, 0);
      ASSERT_TRUE(run.session.execute(cycle, 50000.0 * cycle)) << insitu_last_message();
    }
  };
  const runs::Files files = runs::in_one_and_in_two(cells(0), scene, execute);
  const runs::Table t = runs::parse_table(files.at("t.csv"));
  EXPECT_GE(t.rows.size(), 2u * 142);
  const double per_degree[] = {insitu::test::metres_per_degree(5).x,
                               insitu::test::metres_per_degree(-20, -700).x};
  for (std::size_t i = 0; i < t.rows.size(); ++i) {
    if (t.text(i, "ending") == "killed")
      continue; // as the session closed, without fields
    EXPECT_EQ(t.text(i, "ending"), "alive") << i;
    const auto particle = std::size_t(t.number(i, "particle"));
    const double time = t.number(i, "time"), c = time / 50000;
    const double way = 50000 * (0.5 * c + 0.05 * c * c) / per_degree[particle];
    EXPECT_NEAR(std::remainder(t.number(i, "x") - (particle ? 179.999 : 175) - way, 360), 0, 1e-8);
    EXPECT_NEAR(t.number(i, "y"), particle ? -20 : 5, 1e-9);
    EXPECT_EQ(t.number(i, "z"), particle ? -700 : 0);
    EXPECT_NEAR(t.number(i, "latitude"), t.number(i, "y"), 1e-9);
    EXPECT_NEAR(t.number(i, "height"), t.number(i, "z"), 1e-6);
  }
}

TEST(TrackGeodesics, AreThoseOfGeographicLib) {
  const test::Folder folder;
  const std::string tracer = "velocity: velocity, fields: [latitude], seeds: [[178.5, 5, 0], "
                             "[179.9, -20, -700], [-160, 0, "
                             "0], [152, 3, 0], [9, 9, 0]], " +
                             columns + ", output: [csv, netcdf, vtp], release: {interval: 50000}";
  {
    OnEarth run(pacific(),
                "tracers:\n  - {name: all, " + tracer + "}\n  - {name: fifth, every: 5, " + tracer +
                    "}\n",
                folder.path());
    for (int cycle = 0; cycle <= 20; ++cycle) {
      run.flow(2.5 * std::cos(0.4 * cycle), 1.5 * std::sin(0.4 * cycle) + 0.5);
      ASSERT_TRUE(run.session.execute(cycle, 20000.0 * cycle)) << insitu_last_message();
    }
  }
  const runs::Table t = runs::parse_table(test::content(folder / "all.csv"));
  struct Track {
    double lon0, lat0, lon, lat, length = 0;
  };
  std::map<int, Track> tracks;
  const double seeds[][2] = {{178.5, 5}, {179.9, -20}, {-160, 0}, {152, 3}, {9, 9}};
  std::map<std::pair<int, int>, double> lengths; // of particle and cycle
  int far = 0;
  for (std::size_t i = 0; i < t.rows.size(); ++i) {
    const int particle = int(t.number(i, "particle"));
    const double lon = t.number(i, "x"), lat = t.number(i, "y");
    const double* seed = seeds[particle % 5];
    Track& track =
        tracks.try_emplace(particle, Track{seed[0], seed[1], seed[0], seed[1]}).first->second;
    track.length += inverse(track.lon, track.lat, lon, lat).distance;
    track.lon = lon;
    track.lat = lat;
    const Inverse from = inverse(track.lon0, track.lat0, lon, lat);
    // Positions are in the table to the bit.
    ASSERT_NEAR(t.number(i, "path_length"), track.length, 1e-6) << i;
    ASSERT_NEAR(t.number(i, "release_distance"), from.distance, 1e-6) << i;
    ASSERT_LE(t.number(i, "release_distance"), t.number(i, "path_length") + 1e-6) << i;
    if (from.distance == 0) {
      ASSERT_TRUE(std::isnan(t.number(i, "release_bearing"))) << i;
    } else {
      ASSERT_NEAR(std::remainder(t.number(i, "release_bearing") - from.bearing, 360), 0, 1e-9) << i;
    }
    far += t.number(i, "path_length") > 2 * t.number(i, "release_distance") + 1000 ? 1 : 0;
    lengths[{particle, int(t.number(i, "cycle"))}] = t.number(i, "path_length");
  }
  ASSERT_GT(tracks.size(), 30u) << "released between cycles too";
  EXPECT_GT(far, 0) << "some come back";
  // Written every fifth cycle, it is the same way.
  const runs::Table fifth = runs::parse_table(test::content(folder / "fifth.csv"));
  ASSERT_GT(fifth.rows.size(), 40u);
  for (std::size_t i = 0; i < fifth.rows.size(); ++i)
    EXPECT_EQ(fifth.number(i, "path_length"),
              lengths.at({int(fifth.number(i, "particle")), int(fifth.number(i, "cycle"))}));
  // The other formats have the same numbers.
  const test::NetcdfFile file(folder / "all.nc");
  ASSERT_EQ(file.records(), t.rows.size());
  for (const char* column : {"path_length", "release_distance", "release_bearing"}) {
    for (std::size_t i = 0; i < t.rows.size(); ++i) {
      const double a = t.number(i, column), b = file[column].doubles[i];
      EXPECT_TRUE(a == b || (std::isnan(a) && std::isnan(b))) << column << i;
    }
    EXPECT_EQ(file[column].texts.at("units"),
              std::string(column) == "release_bearing" ? "degree" : "m");
    EXPECT_TRUE(std::isnan(file[column].numbers.at("_FillValue").at(0)));
    for (const char* vtp : {"fifth_tracks.vtp", "fifth_000010.vtp"})
      EXPECT_NE(test::content(folder / vtp).find("Name=\"" + std::string(column) + "\""),
                std::string::npos)
          << vtp << column;
  }
  EXPECT_EQ(file["path_length"].texts.at("long_name"),
            "distance along the track since the release");
}

// At times between cycles: along the equator closed forms; else what the places in the table say,
// by way of the cycles, where the track bends.
TEST(TrackGeodesics, AtTimesBetweenCycles) {
  const test::Folder folder;
  const std::string tracer = ", velocity: velocity, seeds: [[179, 0, 0], [160, 0, -100]], " +
                             columns + ", integrator: {method: dopri5, tolerance: 1e-9}";
  {
    OnEarth run(pacific(),
                "tracers:\n  - {name: t" + tracer +
                    ", times: {interval: 3000}, output: [csv, vtp, netcdf]}\n  - {name: cycles" +
                    tracer + "}\n",
                folder.path());
    for (int cycle = 0; cycle <= 20; ++cycle) {
      run.flow(cycle <= 10 ? 1.5 : 0.9, cycle <= 10 ? 0 : 1.2); // m/s
      ASSERT_TRUE(run.session.execute(cycle, 10000.0 * cycle)) << insitu_last_message();
    }
  }
  const runs::Table t = runs::parse_table(test::content(folder / "t.csv")),
                    cycles = runs::parse_table(test::content(folder / "cycles.csv"));
  ASSERT_EQ(t.rows.size(), 2 * 68u) << "3000 k up to 200000, and the endings";
  const test::NetcdfFile file(folder / "t.nc");
  ASSERT_EQ(file.records(), t.rows.size());
  for (std::size_t i = 0; i < t.rows.size(); ++i) {
    const double time = t.number(i, "time"), length = t.number(i, "path_length");
    EXPECT_EQ(file["path_length"].doubles[i], length);
    const bool first = t.text(i, "particle") == "0";
    if (time <= 1e5 && first) {
      EXPECT_NEAR(length, 1.5 * time, 1e-3);
      EXPECT_NEAR(t.number(i, "release_distance"), 1.5 * time, 1e-3);
    }
    const Inverse from = inverse(first ? 179 : 160, 0, t.number(i, "x"),
                                 t.number(i, "y")); // to the bit in the table
    EXPECT_NEAR(t.number(i, "release_distance"), from.distance, 1e-6);
    if (i >= 2) {
      const double step =
          inverse(t.number(i - 2, "x"), t.number(i - 2, "y"), t.number(i, "x"), t.number(i, "y"))
              .distance;
      EXPECT_GE(length - t.number(i - 2, "path_length"), step - 1e-6) << "by way of a cycle";
      // A way turns by 1e-3 at most within 3000 s, but at cycle 10.
      EXPECT_LE(length - t.number(i - 2, "path_length"), step * 1.001 + (time == 102000 ? 500 : 0));
    }
    for (std::size_t c = 0; c < cycles.rows.size(); ++c) // a way with more corners is longer
      if (cycles.number(c, "time") == time && cycles.text(c, "particle") == t.text(i, "particle")) {
        EXPECT_GE(length, cycles.number(c, "path_length") - 1e-6);
        // Of the 15 km in which the velocity turns by 53 degrees.
        EXPECT_NEAR(length, cycles.number(c, "path_length"), 600);
      }
  }
  EXPECT_NE(test::content(folder / "t_tracks.vtp").find("Name=\"path_length\""), std::string::npos);
}

TEST(TrackGeodesics, GoOnFromACheckpoint) {
  const std::string scene =
      "tracers: [{name: t, velocity: velocity, seeds: [[178.5, 5, 0], [9, 9, 0], "
      "[152, 3, 0]], release: {every: 4}, output: [csv, vtp], every: 3, " +
      columns +
      "}, {name: between, velocity: velocity, seeds: [[178.5, 5, 0], [152, 3, 0]], output: [csv, "
      "vtp], "
      "times: {interval: 13000}, " +
      columns + "}]\n";
  const auto execute = [](OnEarth& run, int first, int last) {
    for (int cycle = first; cycle <= last; ++cycle) {
      run.flow(2.5 * std::cos(0.4 * cycle), 1.5);
      ASSERT_TRUE(run.session.execute(cycle, 20000.0 * cycle)) << insitu_last_message();
    }
  };
  runs::in_one_and_in_two(pacific(), scene, execute);
}

TEST(TrackGeodesics, NeedAPlaceOnEarth) {
  const std::string scene = "insitu: 1\npage: false\ntracers:\n  - {name: t, velocity: velocity, "
                            "seeds: [[0.2, 0.3, 0.1]], " +
                            columns + "}\n";
  const test::Folder folder;
  {
    runs::Coupled run({.scene = scene, .output = folder.path()});
    EXPECT_FALSE(run.execute());
    EXPECT_NE(std::string(insitu_last_message()).find(":4: geodesics need a mesh with a place"),
              std::string::npos)
        << insitu_last_message();
    EXPECT_EQ(run.session.report().particles_seeded, 0);
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "t.csv"));
  // The same cube of a metre, put down in Munich: over so few metres the ellipsoid is flat.
  runs::Coupled run({.scene = scene, .output = folder.path()});
  run.mesh.frame(insitu::Frame::enu(11.5, 48.1, 0));
  ASSERT_TRUE(run.execute()) << insitu_last_message();
  run.run(20);
  run.session.close();
  const runs::Table t = runs::parse_table(test::content(folder / "t.csv"));
  const std::size_t last = t.rows.size() - 1;
  const double east = t.number(last, "x") - 0.2, north = t.number(last, "y") - 0.3;
  ASSERT_GT(std::hypot(east, north), 1e-4);
  EXPECT_NEAR(t.number(last, "release_distance"), std::hypot(east, north),
              1e-6 * std::hypot(east, north) + 1e-8);
  EXPECT_NEAR(t.number(last, "release_bearing"), std::atan2(east, north) * 180 / std::numbers::pi,
              0.01); // 15 nm of some millimetres
}

} // namespace
