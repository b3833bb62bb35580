// Tracks and probes in netCDF: CF conventions, and number for number what the CSV tables have.
#include <algorithm>
#include <bit>
#include <cmath>
#include <gtest/gtest.h>
#include <sstream>

#include "coupled.h"
#include "unit/output/netcdf_file.h"

namespace {

using runs::Coupled;
using test::NetcdfFile;

/// An empty cell of CSV is NaN; every other number has the same bits.
void expect_same(const runs::Table& table, const std::string& column, std::size_t row,
                 double value) {
  const double wanted = table.number(row, column);
  if (std::isnan(wanted))
    EXPECT_TRUE(std::isnan(value)) << column << ", row " << row;
  else
    EXPECT_EQ(std::bit_cast<std::uint64_t>(wanted), std::bit_cast<std::uint64_t>(value))
        << column << ", row " << row;
}

const std::string scene = R"(
insitu: 1
tracers:
  - name: paths
    velocity: velocity
    fields: [density, velocity]
    seeds: {box: {min: [-0.1, 0.05, 0.05], max: [1.3, 1.15, 1.15], counts: [8, 5, 5]}}
    until: {length: 0.05}
    output: [csv, netcdf, vtp]
    every: 3
  - name: streaks
    kind: streakline
    velocity: velocity
    seeds: [[0.1, 0.1, 0.1], [0.2, 0.1, 0.1], [5, 5, 5]]
    until: {duration: 0.03}
    output: [netcdf, csv]
    when: cycle == 2 or cycle == 6
probes:
  - {name: gauges, points: places.txt, output: [netcdf, csv], every: 2}
)";

std::string scene_in(const test::Folder& folder) {
  test::put(folder / "places.txt", "name,x,y,z\nfirst,0.1,0.1,0.1\na b,0.3,0.25,0.7\nout,9,9,9\n");
  std::string text = scene;
  text.replace(text.find("places.txt"), 10, folder / "places.txt");
  return text;
}

TEST(Netcdf, TracksHaveWhatTheTableHas) {
  const test::Folder folder;
  {
    Coupled run({.scene = scene_in(folder), .output = folder.path()});
    ASSERT_TRUE(run.execute()) << insitu_last_message();
    for (int cycle = 1; cycle <= 20; ++cycle) {
      ASSERT_TRUE(run.step()) << insitu_last_message();
      if (cycle == 6 || cycle == 9) { // read while it runs
        const NetcdfFile file(folder / "paths.nc");
        EXPECT_EQ(file.records(),
                  runs::parse_table(test::content(folder / "paths.csv")).rows.size());
        EXPECT_EQ(file["cycle"].integers.back(), cycle);
      }
    }
  }
  for (const char* name : {"paths", "streaks"}) {
    SCOPED_TRACE(name);
    const runs::Table table =
        runs::parse_table(test::content(folder / (std::string(name) + ".csv")));
    const NetcdfFile file(folder / (std::string(name) + ".nc"));
    ASSERT_EQ(file.records(), table.rows.size());
    ASSERT_GT(file.records(), 60u);
    const std::string meanings = file["ending"].texts.at("flag_meanings");
    std::vector<std::string> words;
    for (std::istringstream in(meanings); in;)
      if (std::string word; in >> word)
        words.push_back(word);
    ASSERT_EQ(words.size(), std::size_t(INSITU_END_COUNT));
    ASSERT_EQ(file["ending"].numbers.at("flag_values").size(), words.size());
    long long most = 0;
    for (std::size_t i = 0; i < table.rows.size(); ++i) {
      for (const std::string& column : table.columns) {
        if (column == "ending")
          EXPECT_EQ(words.at(std::size_t(file["ending"].integers[i])), table.text(i, column));
        else if (const auto& v = file[column]; v.type == NC_DOUBLE)
          expect_same(table, column, i, v.doubles[i]);
        else
          EXPECT_EQ(std::to_string(v.integers[i]), table.text(i, column)) << column << ", " << i;
      }
      most = std::max(most, file["particle"].integers[i]);
    }
    // CF 1.10, appendix H.4.4: an indexed ragged array of trajectories.
    EXPECT_EQ(file.texts.at("Conventions"), "CF-1.10");
    EXPECT_EQ(file.texts.at("featureType"), "trajectory");
    EXPECT_EQ(file.unlimited, "obs");
    EXPECT_EQ(file["trajectory"].texts.at("cf_role"), "trajectory_id");
    EXPECT_EQ(file["trajectory"].dimensions, std::vector<std::string>{"trajectory"});
    EXPECT_EQ(file["particle"].texts.at("instance_dimension"), "trajectory");
    EXPECT_GT(file["trajectory"].integers.size(), std::size_t(most));
    EXPECT_LE(file["trajectory"].integers.size(), std::size_t(2 * most + 2));
    EXPECT_EQ(file["trajectory"].integers[std::size_t(most)], most);
    EXPECT_EQ(file["time"].texts.at("units"), "s");
    EXPECT_EQ(file["time"].texts.at("axis"), "T");
    EXPECT_EQ(file["x"].texts.at("axis"), "X");
    EXPECT_EQ(file["x"].texts.count("units"), 0u) << "the solver's own";
    EXPECT_EQ(file["cell"].numbers.at("_FillValue"), std::vector<double>{-1});
    if (std::string(name) == "paths") {
      EXPECT_EQ(file["velocity_x"].texts.at("coordinates"), "time x y z");
      EXPECT_TRUE(std::isnan(file["density"].numbers.at("_FillValue").at(0)));
    }
  }
  // Output under a condition: the same cycles in both formats, and rows of endings in between.
  const NetcdfFile streaks(folder / "streaks.nc");
  const auto alive_at = [&](long long cycle) {
    for (std::size_t i = 0; i < streaks.records(); ++i)
      if (streaks["cycle"].integers[i] == cycle &&
          streaks["ending"].integers[i] == INSITU_END_ALIVE)
        return true;
    return false;
  };
  EXPECT_TRUE(alive_at(2));
  EXPECT_TRUE(alive_at(6));
  EXPECT_FALSE(alive_at(17));
}

TEST(Netcdf, ProbesAreTimeSeries) {
  const test::Folder folder;
  {
    Coupled run({.scene = scene_in(folder), .output = folder.path()});
    ASSERT_TRUE(run.execute()) << insitu_last_message();
    run.run(9);
    EXPECT_EQ(NetcdfFile(folder / "gauges.nc").records(), 5u) << "while the run goes on";
  }
  const runs::Table table = runs::parse_table(test::content(folder / "gauges.csv"));
  const NetcdfFile file(folder / "gauges.nc");
  EXPECT_EQ(file.texts.at("featureType"), "timeSeries");
  EXPECT_EQ(file.unlimited, "time");
  EXPECT_EQ(file["cycle"].integers, (std::vector<long long>{0, 2, 4, 6, 8}));
  EXPECT_EQ(file["pressure"].dimensions, (std::vector<std::string>{"time", "station"}));
  EXPECT_EQ(file["pressure"].texts.at("coordinates"), "x y z station_name");
  EXPECT_EQ(file["station"].texts.at("cf_role"), "timeseries_id");
  EXPECT_EQ(file["y"].doubles, (std::vector<double>{0.1, 0.25, 9}));
  EXPECT_EQ(file["station_name"].text.substr(0, 10), std::string("firsta b\0\0", 10));
  EXPECT_EQ(file["cell"].integers[2], -1);
  EXPECT_TRUE(std::isnan(file["pressure"].doubles[2]));
  ASSERT_EQ(table.rows.size(), 15u);
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    expect_same(table, "time", i, file["time"].doubles[i / 3]);
    EXPECT_EQ(std::to_string(file["cell"].integers[i]), table.text(i, "cell"));
    for (const char* column : {"r", "s", "t", "density", "velocity_y"})
      expect_same(table, column, i, file[column].doubles[i]);
  }
}

TEST(Netcdf, ProbesThatGoWithTheMaterialAreTrajectories) {
  const test::Folder folder;
  {
    Coupled run({.scene = R"(
insitu: 1
page: false
probes:
  - {name: marks, points: [[0.11, 0.13, 0.17], [9, 9, 9]], attached: body, every: 4,
     output: [csv, netcdf, json]}
)",
                 .output = folder.path()});
    ASSERT_TRUE(run.execute()) << insitu_last_message();
    run.run(12);
  }
  const runs::Table table = runs::parse_table(test::content(folder / "marks.csv"));
  const NetcdfFile file(folder / "marks.nc");
  EXPECT_EQ(file.texts.at("featureType"), "trajectory");
  EXPECT_EQ(file["station"].texts.at("cf_role"), "trajectory_id");
  EXPECT_EQ(file["pressure"].texts.at("coordinates"), "x y z");
  ASSERT_EQ(table.rows.size(), 8u);
  for (const char* axis : {"x", "y", "z"}) {
    EXPECT_EQ(file[axis].dimensions, (std::vector<std::string>{"time", "station"}));
    for (std::size_t i = 0; i < table.rows.size(); ++i)
      expect_same(table, axis, i, file[axis].doubles[i]);
    EXPECT_EQ(file[axis].doubles[7], 9) << "what is outside stays";
    EXPECT_NE(file[axis].doubles[6], file[axis].doubles[0]) << "the blast pushes";
  }
  const std::string json = test::content(folder / "marks_000012.json");
  EXPECT_NE(json.find("[\"x\", \"y\", \"z\", \"cell\""), std::string::npos) << json;
  EXPECT_NE(json.find("\n  [" + table.text(6, "x") + ", " + table.text(6, "y") + ", " +
                      table.text(6, "z") + ", " + table.text(6, "cell")),
            std::string::npos)
      << json;
}

} // namespace
