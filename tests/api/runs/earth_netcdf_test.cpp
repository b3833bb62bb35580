// What netCDF files say of themselves on meshes of each frame, read back by netCDF-C.
#include <cmath>
#include <gtest/gtest.h>
#include <set>
#include <sstream>

#include "coupled.h"
#include "on_earth.h"
#include "unit/output/netcdf_file.h"

namespace {

using test::NetcdfFile;

using Texts = std::map<std::string, std::string>;

/// What CF 1.10 asks of any file, as far as a program can tell.
void expect_sound(const std::string& path, const std::string& feature, const std::string& role,
                  bool is_level = true) {
  SCOPED_TRACE(path);
  const NetcdfFile file(path);
  EXPECT_EQ(file.texts.at("Conventions"), "CF-1.10");
  EXPECT_EQ(file.texts.at("featureType"), feature);
  std::multiset<std::string> axes, roles;
  for (const auto& [name, v] : file.variables) {
    const auto text = [&v = v](const std::string& attribute) {
      const auto found = v.texts.find(attribute);
      return found == v.texts.end() ? std::string() : found->second;
    };
    if (!text("axis").empty()) {
      axes.insert(text("axis"));
      EXPECT_EQ(v.numbers.count("_FillValue"), 0u) << name << ": coordinates are always there";
    }
    if (!text("cf_role").empty())
      roles.insert(text("cf_role"));
    EXPECT_TRUE(!text("long_name").empty() || !text("standard_name").empty() || name == "crs")
        << name;
    for (const std::string attribute : {"coordinates", "grid_mapping", "instance_dimension"}) {
      std::istringstream words(text(attribute));
      for (std::string word; words >> word;)
        EXPECT_TRUE(file.variables.contains(word)) << name << ":" << attribute << " " << word;
    }
    if (const auto fill = v.numbers.find("_FillValue"); fill != v.numbers.end()) {
      EXPECT_EQ(fill->second.size(), 1u) << name;
      EXPECT_EQ(std::isnan(fill->second[0]), v.type == NC_DOUBLE) << name;
    }
  }
  const std::multiset<std::string> all{"T", "X", "Y", "Z"}, time{"T"};
  EXPECT_EQ(axes, is_level ? all : time) << "level and vertical ones alone are named so";
  EXPECT_EQ(roles, std::multiset<std::string>{role});
  EXPECT_EQ(file["time"].texts,
            (Texts{{"axis", "T"}, {"long_name", "time of the solver"}, {"units", "s"}}));
  // A fill value is of its variable's type (CF 2.5.1).
  int id = -1, count = 0;
  ASSERT_EQ(nc_open(path.c_str(), NC_NOWRITE, &id), NC_NOERR);
  ASSERT_EQ(nc_inq_nvars(id, &count), NC_NOERR);
  for (int v = 0; v < count; ++v) {
    nc_type own = NC_NAT, fill = NC_NAT;
    ASSERT_EQ(nc_inq_vartype(id, v, &own), NC_NOERR);
    if (nc_inq_atttype(id, v, "_FillValue", &fill) == NC_NOERR) {
      EXPECT_EQ(own, fill) << v;
    }
  }
  nc_close(id);
}

const std::string scene(const std::string& points) {
  return "probes: [{name: gauges, points: " + points +
         ", output: [netcdf]}]\ntracers: [{name: drifters, velocity: velocity, seeds: " + points +
         ", output: [netcdf]}]\n";
}

constexpr insitu::geo::ChartUnits all_units[] = {{false, false, false},
                                                 {true, false, false},
                                                 {false, true, true},
                                                 {true, true, true},
                                                 {false, false, true}};

TEST(NetcdfFrames, GeodeticInEveryUnit) {
  for (const insitu::geo::ChartUnits& units : all_units) {
    SCOPED_TRACE(std::string(units.radians ? "radians" : "degrees") +
                 (units.kilometres ? ", kilometres" : "") + (units.down ? ", down" : ""));
    const test::Folder folder;
    std::ostringstream point;
    point.precision(17);
    point << "[[" << 10 * (units.radians ? units.radians_per_unit() * std::numbers::pi / 180 : 1)
          << ", 0, " << -100 / units.up_per_unit() << "]]";
    {
      runs::OnEarth run({.units = units, .wraps = true}, scene(point.str()), folder.path());
      ASSERT_TRUE(run.session.execute(0, 0.0)) << insitu_last_message();
      ASSERT_TRUE(run.session.execute(1, 1.5)) << insitu_last_message();
      EXPECT_EQ(run.session.report().points_outside, 0);
      EXPECT_EQ(run.session.report().probe_rows, 2) << "of netCDF alone too";
    }
    expect_sound(folder / "gauges.nc", "timeSeries", "timeseries_id");
    expect_sound(folder / "drifters.nc", "trajectory", "trajectory_id");
    const std::string vertical = units.down ? "depth" : "height";
    for (const char* name : {"gauges.nc", "drifters.nc"}) {
      const NetcdfFile file(folder / name);
      EXPECT_EQ(file["lon"].texts, (Texts{{"standard_name", "longitude"},
                                          {"units", units.radians ? "radian" : "degrees_east"},
                                          {"axis", "X"}}));
      EXPECT_EQ(file["lat"].texts, (Texts{{"standard_name", "latitude"},
                                          {"units", units.radians ? "radian" : "degrees_north"},
                                          {"axis", "Y"}}));
      EXPECT_EQ(file[vertical].texts,
                (Texts{{"standard_name", units.down ? "depth" : "height_above_reference_ellipsoid"},
                       {"units", units.kilometres ? "km" : "m"},
                       {"positive", units.down ? "down" : "up"},
                       {"axis", "Z"}}));
      EXPECT_EQ(file["crs"].texts.at("grid_mapping_name"), "latitude_longitude");
      EXPECT_EQ(file["crs"].numbers.at("semi_major_axis"), std::vector<double>{6378137.0});
      EXPECT_EQ(file["crs"].numbers.at("inverse_flattening"), std::vector<double>{298.257223563});
      // The numbers are in the units that are said.
      EXPECT_NEAR(file["lon"].doubles.at(0), units.radians ? std::numbers::pi / 18 : 10.0, 1e-14);
      EXPECT_NEAR(file[vertical].doubles.at(0) * units.up_per_unit(), -100, 1e-11);
    }
    const NetcdfFile gauges(folder / "gauges.nc");
    EXPECT_EQ(gauges["latitude"].texts.at("coordinates"), "lon lat " + vertical);
    EXPECT_EQ(gauges["latitude"].texts.at("grid_mapping"), "crs");
  }
}

TEST(NetcdfFrames, ProjectedAndLocal) {
  struct Case {
    insitu::Frame frame;
    Texts x, y, z;
    std::string mapping;
  };
  const Texts up{{"standard_name", "height_above_reference_ellipsoid"},
                 {"units", "m"},
                 {"positive", "up"},
                 {"axis", "Z"}};
  const Texts easting{{"standard_name", "projection_x_coordinate"}, {"units", "m"}, {"axis", "X"}};
  const Texts northing{{"standard_name", "projection_y_coordinate"}, {"units", "m"}, {"axis", "Y"}};
  const std::string own = "coordinate in the solver's own units";
  const Case cases[] = {
      {insitu::Frame::utm(33, true), easting, northing, up, "transverse_mercator"},
      {insitu::Frame::utm(56, false), easting, northing, up, "transverse_mercator"},
      {insitu::Frame::enu(13, 52, 40),
       {{"long_name", "east of the origin"}, {"units", "m"}, {"axis", "X"}},
       {{"long_name", "north of the origin"}, {"units", "m"}, {"axis", "Y"}},
       {{"long_name", "above the origin"}, {"units", "m"}, {"positive", "up"}, {"axis", "Z"}},
       ""},
      {insitu::Frame::geocentric(),
       {{"long_name", "from the Earth's centre towards longitude 0 on the equator"},
        {"units", "m"}},
       {{"long_name", "from the Earth's centre towards 90 degrees east on the equator"},
        {"units", "m"}},
       {{"long_name", "from the Earth's centre towards the north pole"}, {"units", "m"}},
       ""},
      {insitu::Frame::cartesian(),
       {{"long_name", own}, {"axis", "X"}},
       {{"long_name", own}, {"axis", "Y"}},
       {{"long_name", own}, {"axis", "Z"}},
       ""}};
  for (const Case& c : cases) {
    const test::Folder folder;
    {
      runs::Coupled run({.scene = "insitu: 1\npage: false\n" + scene("[[0.2, 0.3, 0.1]]"),
                         .output = folder.path()});
      run.mesh.frame(c.frame);
      ASSERT_TRUE(run.execute()) << insitu_last_message();
    }
    const bool is_level = c.x.contains("axis");
    expect_sound(folder / "gauges.nc", "timeSeries", "timeseries_id", is_level);
    expect_sound(folder / "drifters.nc", "trajectory", "trajectory_id", is_level);
    for (const char* name : {"gauges.nc", "drifters.nc"}) {
      const NetcdfFile file(folder / name);
      EXPECT_EQ(file["x"].texts, c.x);
      EXPECT_EQ(file["y"].texts, c.y);
      EXPECT_EQ(file["z"].texts, c.z);
      ASSERT_EQ(file.variables.contains("crs"), !c.mapping.empty());
      if (c.mapping.empty())
        continue;
      EXPECT_EQ(file["crs"].texts.at("grid_mapping_name"), c.mapping);
      const auto& numbers = file["crs"].numbers;
      const insitu_frame& f = c.frame.get();
      EXPECT_EQ(numbers.at("longitude_of_central_meridian").at(0), 6.0 * f.utm_zone - 183);
      EXPECT_EQ(numbers.at("scale_factor_at_central_meridian").at(0), 0.9996);
      EXPECT_EQ(numbers.at("false_easting").at(0), 500000);
      EXPECT_EQ(numbers.at("false_northing").at(0), f.utm_north ? 0 : 1e7);
    }
  }
}

// Output when a condition holds: the same cycles in every format, of probes and of tracks.
TEST(NetcdfFrames, ConditionsHoldForEveryWriter) {
  const test::Folder folder;
  const std::string due = ", when: max(velocity) > 1, every: 2";
  std::vector<double> wanted;
  {
    runs::OnEarth run(
        {.wraps = true},
        "probes: [{name: gauges, points: [[10, 0, -100]], fields: [latitude], output: "
        "[csv, vtp, json, netcdf]" +
            due +
            "}]\ntracers: [{name: drifters, velocity: velocity, seeds: [[10, 0, -100]], "
            "output: [csv, vtp, netcdf]" +
            due + "}]\n",
        folder.path());
    for (int cycle = 0; cycle <= 12; ++cycle) {
      const double speed = 2 * std::sin(0.3 * cycle);
      run.flow(speed, 0);
      ASSERT_TRUE(run.session.execute(cycle, 10.0 * cycle)) << insitu_last_message();
      if (cycle % 2 == 0 && std::fabs(speed) > 1)
        wanted.push_back(cycle);
    }
  }
  ASSERT_GT(wanted.size(), 2u);
  ASSERT_LT(wanted.size(), 6u);
  const runs::Table gauges = runs::parse_table(test::content(folder / "gauges.csv"));
  const runs::Table drifters = runs::parse_table(test::content(folder / "drifters.csv"));
  const NetcdfFile gauges_nc(folder / "gauges.nc"), drifters_nc(folder / "drifters.nc");
  ASSERT_EQ(gauges.rows.size(), wanted.size());
  ASSERT_EQ(drifters.rows.size(), wanted.size() + 1) << "and its ending";
  ASSERT_EQ(gauges_nc.records(), wanted.size());
  ASSERT_EQ(drifters_nc.records(), wanted.size() + 1);
  std::set<std::string> files;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    EXPECT_EQ(gauges.number(i, "cycle"), wanted[i]);
    EXPECT_EQ(drifters.number(i, "cycle"), wanted[i]);
    EXPECT_EQ(double(gauges_nc["cycle"].integers[i]), wanted[i]);
    EXPECT_EQ(double(drifters_nc["cycle"].integers[i]), wanted[i]);
    char number[16];
    std::snprintf(number, sizeof number, "%06d", int(wanted[i]));
    for (const std::string name : {"gauges_", "drifters_"})
      files.insert(name + number + ".vtp");
    files.insert(std::string("gauges_") + number + ".json");
  }
  files.insert("drifters_tracks.vtp");
  std::set<std::string> found;
  for (const std::string ending : {".vtp", ".json"})
    for (const std::string& name : runs::names_of(runs::files_of(folder.path()), ending))
      found.insert(name);
  EXPECT_EQ(found, files);
}

} // namespace
