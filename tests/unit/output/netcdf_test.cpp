// Tables in netCDF: what netCDF-C reads of them, over restarts, cuts and failures.
#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "core/status.h"
#include "folder.h"
#include "netcdf_file.h"
#include "output/netcdf/netcdf_table.h"

namespace insitu::output {
namespace {

NetcdfLayout layout(std::int64_t instances = 3, const std::string& field = "p") {
  NetcdfLayout l;
  l.record_dimension = "obs";
  l.dimensions = {{"trajectory", instances}, {"length", 2}};
  const auto add = [&](const char* name, NetcdfType type) -> NetcdfVariable& {
    NetcdfVariable v;
    v.name = name;
    v.type = type;
    return l.variables.emplace_back(v);
  };
  add("cycle", NetcdfType::int64);
  add("flag", NetcdfType::int8).attributes = {{"flag_values", std::vector<std::int8_t>{0, 1}},
                                              {"flag_meanings", std::string("no yes")}};
  add("small", NetcdfType::int32).attributes = {{"_FillValue", std::int32_t(-1)}};
  NetcdfVariable& pair = add("pair", NetcdfType::float64);
  pair.dimensions = {"length"};
  NetcdfVariable& ids = add("trajectory", NetcdfType::int64);
  ids.per_record = false;
  ids.dimensions = {"trajectory"};
  for (std::int64_t i = 0; i < instances; ++i)
    ids.integers.push_back(i);
  add(field.c_str(), NetcdfType::float64).attributes = {{"units", std::string("Pa")}};
  l.attributes = {{"Conventions", std::string("CF-1.10")}};
  return l;
}

void add(NetcdfTable& table, std::int64_t cycle) {
  const double x = double(cycle);
  const std::vector<double> pair{x / 3, -x};
  table.rows()
      .put(cycle)
      .put(std::int8_t(cycle % 2))
      .put(std::int32_t(-cycle))
      .put(pair)
      .put(std::sqrt(x));
}

void expect_cycles(const std::string& path, const std::vector<long long>& cycles) {
  const test::NetcdfFile file(path);
  ASSERT_EQ(file["cycle"].integers, cycles);
  for (std::size_t i = 0; i < cycles.size(); ++i) {
    const auto x = double(cycles[i]);
    EXPECT_EQ(file["flag"].integers[i], cycles[i] % 2);
    EXPECT_EQ(file["small"].integers[i], -cycles[i]);
    EXPECT_EQ(file["pair"].doubles[2 * i], x / 3);
    EXPECT_EQ(file["pair"].doubles[2 * i + 1], -x);
    EXPECT_EQ(file["p"].doubles[i], std::sqrt(x));
  }
}

TEST(NetcdfTable, IsReadByNetcdfAtAnyMomentAndAfterRestarts) {
  const test::Folder folder;
  const std::string path = folder / "a/t.nc";
  {
    NetcdfTable table(path, layout(), 0);
    expect_cycles(path, {}); // whole from its first moment on
    for (std::int64_t c = 0; c < 4; ++c) {
      add(table, c);
      table.flush();
      EXPECT_EQ(test::NetcdfFile(path).records(), std::size_t(c + 1));
    }
    add(table, 4); // flushed by the end
  }
  expect_cycles(path, {0, 1, 2, 3, 4});
  {
    NetcdfTable table(path, layout(), 3); // a run that restarts at cycle 3
    EXPECT_EQ(table.records(), 3);
    expect_cycles(path, {0, 1, 2});
    add(table, 3);
    add(table, 3);
  }
  expect_cycles(path, {0, 1, 2, 3, 3});
  {
    NetcdfTable table(path, layout()); // all stay
    EXPECT_EQ(table.records(), 5);
  }
  const test::NetcdfFile file(path);
  EXPECT_EQ(file.unlimited, "obs");
  EXPECT_EQ(file["trajectory"].integers, (std::vector<long long>{0, 1, 2}));
  EXPECT_EQ(file["flag"].numbers.at("flag_values"), (std::vector<double>{0, 1}));
  EXPECT_EQ(file["flag"].texts.at("flag_meanings"), "no yes");
  EXPECT_EQ(file["small"].numbers.at("_FillValue"), std::vector<double>{-1});
  EXPECT_EQ(file["p"].texts.at("units"), "Pa");
  EXPECT_EQ(file.texts.at("Conventions"), "CF-1.10");
}

// Of a run in reverse, whose cycles count down, the lower ones are the later.
TEST(NetcdfTable, CyclesThatGoDownAreCutWhereTheRunGoesOn) {
  const test::Folder folder;
  const std::string path = folder / "t.nc";
  {
    NetcdfTable table(path, layout(), 9);
    for (const std::int64_t c : {9, 8, 8, 7, 6, 5})
      add(table, c);
  }
  {
    NetcdfTable table(path, layout(), 7);
    EXPECT_EQ(table.records(), 3);
    add(table, 7);
  }
  expect_cycles(path, {9, 8, 8, 7});
  EXPECT_THROW(NetcdfTable(path, layout(4), 7), core::Error) << "what stays is of another layout";
  ASSERT_TRUE(output::summary_before(path, 8));
  EXPECT_EQ(output::summary_before(path, 8)->dimension("trajectory"), 3);
  EXPECT_FALSE(output::summary_before(path, 9));
  { // from its first cycle on nothing stays
    NetcdfTable table(path, layout(4), 9);
    EXPECT_EQ(table.records(), 0);
  }
}

TEST(NetcdfTable, HoldsEveryBitOfNumbers) {
  const test::Folder folder;
  NetcdfLayout l;
  l.record_dimension = "time";
  NetcdfVariable cycle, value;
  cycle.name = "cycle";
  cycle.type = NetcdfType::int64;
  value.name = "value";
  l.variables = {cycle, value};
  std::mt19937_64 random(7);
  std::vector<double> values{0.0,
                             -0.0,
                             1e-308,
                             5e-324,
                             std::numeric_limits<double>::infinity(),
                             std::numeric_limits<double>::max()};
  while (values.size() < 1000)
    if (const double v = std::bit_cast<double>(random()); !std::isnan(v))
      values.push_back(v);
  {
    NetcdfTable table(folder / "t.nc", l, 0);
    for (std::size_t i = 0; i < values.size(); ++i)
      table.rows().put(std::int64_t(i) - (std::int64_t(1) << 40)).put(values[i]);
  }
  const test::NetcdfFile file(folder / "t.nc");
  ASSERT_EQ(file.records(), values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    EXPECT_EQ(std::bit_cast<std::uint64_t>(file["value"].doubles[i]),
              std::bit_cast<std::uint64_t>(values[i]))
        << i << " of seed 7";
    EXPECT_EQ(file["cycle"].integers[i], static_cast<long long>(i) - (1LL << 40));
  }
}

TEST(NetcdfTable, TakesUpWhatAKillCutShort) {
  const test::Folder folder;
  const std::string path = folder / "t.nc";
  {
    NetcdfTable table(path, layout(), 0);
    for (std::int64_t c = 0; c < 5; ++c)
      add(table, c);
  }
  const auto size = std::filesystem::file_size(path);
  const auto record = std::uintmax_t(layout().record_bytes());
  // Records that are there and not counted, or counted and not there.
  for (const std::uintmax_t cut : {size + 13, size - 1, size - record, size - 2 * record - 5}) {
    SCOPED_TRACE(cut);
    std::filesystem::resize_file(path, cut);
    const std::int64_t left = std::min<std::int64_t>(
        5, 5 - (std::int64_t(size) - std::int64_t(cut) + std::int64_t(record) - 1) /
                   std::int64_t(record));
    NetcdfTable table(path, layout());
    EXPECT_EQ(table.records(), left);
    for (std::int64_t c = left; c < 5; ++c)
      add(table, c);
    table.flush();
    expect_cycles(path, {0, 1, 2, 3, 4});
  }
}

TEST(NetcdfTable, RefusesWhatIsNotItsOwn) {
  const test::Folder folder;
  const std::string path = folder / "t.nc";
  {
    NetcdfTable table(path, layout(), 0);
    add(table, 0);
    EXPECT_THROW(NetcdfTable(path, layout()), core::Error); // one writer at a time
  }
  try {
    NetcdfTable table(path, layout(3, "density"), 1);
    FAIL();
  } catch (const core::Error& e) {
    EXPECT_EQ(e.status(), INSITU_ERROR_FILE);
    for (const char* part : {"t.nc", "'cycle,flag,small,pair,trajectory,p'", "density"})
      EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
  }
  EXPECT_THROW(NetcdfTable(path, layout(4), 1), core::Error);
  expect_cycles(path, {0});
  { // of a run that starts anew nothing is left
    NetcdfTable table(path, layout(3, "density"), 0);
  }
  EXPECT_EQ(test::NetcdfFile(path).variables.count("density"), 1u);
  test::put(folder / "f.nc", "somebody's notes");
  EXPECT_THROW(NetcdfTable(folder / "f.nc", layout(), 0), core::Error);
  EXPECT_EQ(test::content(folder / "f.nc"), "somebody's notes");
  EXPECT_EQ(folder.count(), 2u) << "no unfinished files";
}

TEST(NetcdfTable, GrowsByInstances) {
  const test::Folder folder;
  const std::string path = folder / "t.nc";
  NetcdfTable table(path, layout(1), 0);
  for (std::int64_t c = 0; c < 40; ++c) {
    add(table, c);
    table.flush();
    if (c % 10 == 9)
      table.change(layout(std::int64_t(1) << (c / 10 + 1)));
  }
  std::vector<long long> cycles;
  for (long long c = 0; c < 40; ++c)
    cycles.push_back(c);
  expect_cycles(path, cycles);
  EXPECT_EQ(test::NetcdfFile(path).dimensions.at("trajectory"), 16u);
  EXPECT_EQ(test::NetcdfFile(path)["trajectory"].integers.back(), 15);
}

TEST(NetcdfTable, NamesThatNetcdfTakes) {
  NetcdfLayout l = layout();
  EXPECT_EQ(l.free_name("density"), "density");
  EXPECT_EQ(l.free_name("p"), "p_2");
  EXPECT_EQ(l.free_name("wind speed/m"), "wind_speed_m");
  EXPECT_EQ(l.free_name(" x"), "_x");
  EXPECT_EQ(l.free_name("\xc3\xa9t\xff"), "_t_");
  EXPECT_EQ(l.free_name(""), "_");
  EXPECT_EQ(l.free_name("2m"), "2m");
}

} // namespace
} // namespace insitu::output
