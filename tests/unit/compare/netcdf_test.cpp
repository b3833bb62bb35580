#include <gtest/gtest.h>
#include <limits>
#include <netcdf.h>
#include <sstream>

#include "compare/netcdf_compare.h"
#include "compare/run.h"
#include "core/status.h"
#include "unit/output/folder.h"

namespace {

using insitu::compare::compare_netcdf;
using insitu::compare::NetcdfOptions;
using insitu::compare::Verdict;
using insitu::core::Error;
using test::Folder;

/// A small file: two records of p(time, station), n(station), name(station, length).
struct Made {
  std::vector<double> p{1, 2, 3, 4, std::numeric_limits<double>::quiet_NaN(), 6};
  std::vector<long long> n{1, 1LL << 60, 3};
  std::string names = "ab cd ef ";
  std::string units = "Pa";
  std::string p_name = "p";
  double fill = -1;
  std::size_t stations = 3;
  nc_type type = NC_DOUBLE;
  int format = NC_64BIT_DATA;

  void write(const std::string& path) const {
    int id, time, station, length, v[3];
    const auto ok = [](int status) { ASSERT_EQ(status, NC_NOERR) << nc_strerror(status); };
    ok(nc_create(path.c_str(), NC_CLOBBER | format, &id));
    ok(nc_def_dim(id, "time", NC_UNLIMITED, &time));
    ok(nc_def_dim(id, "station", stations, &station));
    ok(nc_def_dim(id, "length", 3, &length));
    const int both[] = {time, station}, text[] = {station, length};
    ok(nc_def_var(id, p_name.c_str(), type, 2, both, &v[0]));
    ok(nc_def_var(id, "n", NC_INT64, 1, &station, &v[1]));
    ok(nc_def_var(id, "name", NC_CHAR, 2, text, &v[2]));
    ok(nc_put_att_text(id, v[0], "units", units.size(), units.c_str()));
    ok(nc_put_att_double(id, v[0], "_FillValue", type, 1, &fill));
    ok(nc_put_att_text(id, NC_GLOBAL, "title", 4, "made"));
    ok(nc_enddef(id));
    const std::size_t begin[] = {0, 0}, count[] = {p.size() / stations, stations};
    ok(nc_put_vara_double(id, v[0], begin, count, p.data()));
    ok(nc_put_var_longlong(id, v[1], n.data()));
    ok(nc_put_var_text(id, v[2], names.c_str()));
    ok(nc_close(id));
  }
};

Verdict compare(const Made& a, const Made& b, const NetcdfOptions& options = {}) {
  const Folder folder;
  a.write(folder / "a.nc");
  b.write(folder / "b.nc");
  return compare_netcdf(folder / "a.nc", folder / "b.nc", options);
}

std::string text_of(const Verdict& verdict) {
  std::string text;
  for (const std::string& line : verdict.lines) {
    text += line + "\n";
  }
  return text;
}

TEST(Netcdf, EqualFilesAreTheSame) {
  const Verdict verdict = compare({}, {});
  EXPECT_TRUE(verdict.same) << text_of(verdict);
  EXPECT_EQ(text_of(verdict), "same: 3 variables\n");
  Made other; // in another format
  other.format = NC_NETCDF4;
  EXPECT_TRUE(compare({}, other).same) << text_of(compare({}, other));
}

TEST(Netcdf, TheWorstValueIsNamed) {
  Made b;
  b.p[1] = 2.1;
  b.p[5] = 6.5;
  EXPECT_EQ(text_of(compare({}, b)), "variable 'p' moved in 2 of 6 values, most at time 1, station "
                                     "2: 6 -> 6.5 (by 0.5, relative 0.0769)\n");
  NetcdfOptions options;
  options.tolerance = {0.08, 0};
  EXPECT_TRUE(compare({}, b, options).same);
  options.tolerance = {0, 0.2};
  EXPECT_EQ(text_of(compare({}, b, options)),
            "variable 'p' moved in 1 of 6 values, most at time 1, station 2: 6 -> 6.5 (by 0.5, "
            "relative 0.0769)\n");
  options.variables = {{"p", {0, 0.5}}};
  EXPECT_TRUE(compare({}, b, options).same);
  b.p[4] = 0; // was not a number
  options.variables = {{"p", {1, 1e9}}};
  EXPECT_NE(text_of(compare({}, b, options)).find("at time 1, station 1: nan -> 0"),
            std::string::npos);
  options = {};
  options.ignored = {"p"};
  EXPECT_TRUE(compare({}, b, options).same);
}

TEST(Netcdf, LargeWholeNumbersAreToldApart) {
  Made b;
  ++b.n[1]; // the same as a double
  EXPECT_NE(text_of(compare({}, b)).find("variable 'n' moved in 1 of 3 values, most at station 1"),
            std::string::npos);
  NetcdfOptions options;
  options.tolerance = {0, 1};
  EXPECT_TRUE(compare({}, b, options).same);
}

TEST(Netcdf, TextsAreComparedAsTexts) {
  Made b;
  b.names = "ab cx ef ";
  NetcdfOptions options;
  options.tolerance = {1, 1e9};
  EXPECT_EQ(text_of(compare({}, b, options)), "variable 'name' moved in 1 of 9 values, most at "
                                              "station 1, length 1: 'd' -> 'x'\n");
}

TEST(Netcdf, WhatIsMissingOrOfAnotherKindIsNamed) {
  Made b;
  b.p_name = "q";
  EXPECT_EQ(text_of(compare({}, b)), "variable 'p' is missing in the second file\n"
                                     "variable 'q' is missing in the first file\n");
  b = {};
  b.units = "hPa";
  b.fill = -2;
  EXPECT_EQ(text_of(compare({}, b)), "attribute 'p:_FillValue': -1 -> -2\n"
                                     "attribute 'p:units': 'Pa' -> 'hPa'\n");
  NetcdfOptions options;
  options.ignored = {"p:units", "p:_FillValue"};
  EXPECT_TRUE(compare({}, b, options).same);
  b = {};
  b.type = NC_FLOAT;
  options.ignored = {"p:_FillValue"};
  EXPECT_EQ(text_of(compare({}, b, options)), "variable 'p' is float64 -> float32\n");
  b = {}; // fewer records: those that both have are compared
  b.p = {1, 2, 9};
  EXPECT_EQ(
      text_of(compare({}, b)),
      "dimension 'time' has 2 -> 1\n"
      "variable 'p' moved in 1 of 3 values, most at time 0, station 2: 3 -> 9 (by 6, relative "
      "0.667)\n");
  b = {};
  b.stations = 2;
  b.p = {1, 2, 3, 4};
  b.n = {1, 1LL << 60};
  b.names = "ab cd ";
  EXPECT_EQ(text_of(compare({}, b)), "dimension 'station' has 3 -> 2\n"
                                     "variable 'p' has another shape\n"
                                     "variable 'n' has another shape\n"
                                     "variable 'name' has another shape\n");
  options.ignored = {"nonsense"};
  EXPECT_THROW(compare({}, {}, options), Error);
  options.lenient = true;
  EXPECT_TRUE(compare({}, {}, options).same);
}

TEST(Netcdf, IsAKindOfTheProgram) {
  const Folder folder;
  Made().write(folder / "a.nc");
  Made b;
  b.p[0] = 1.5;
  b.write(folder / "b.nc");
  test::put(folder / "c.nc", "no netCDF");
  const auto code = [&](std::vector<std::string> arguments, const std::string& says) {
    std::ostringstream out, err;
    const int ended = insitu::compare::run(arguments, out, err);
    EXPECT_NE((out.str() + err.str()).find(says), std::string::npos) << out.str() << err.str();
    return ended;
  };
  EXPECT_EQ(code({folder / "a.nc", folder / "a.nc"}, "same: 3 variables"), 0);
  EXPECT_EQ(code({folder / "a.nc", folder / "b.nc"}, "1 -> 1.5"), 1);
  EXPECT_EQ(code({folder / "a.nc", folder / "b.nc", "--column", "p:0:1"}, "same"), 0);
  EXPECT_EQ(code({folder / "a.nc", folder / "c.nc"}, "cannot read '" + (folder / "c.nc") + "'"), 2);
  EXPECT_EQ(code({folder / "a.nc", folder / "b.nc", "--key", "n"}, "--key: matches rows"), 2);
  std::filesystem::create_directories(folder / "x");
  std::filesystem::create_directories(folder / "y");
  Made().write(folder / "x/t.nc");
  b.write(folder / "y/t.nc");
  EXPECT_EQ(code({folder / "x", folder / "y"}, "t.nc: DIFFERENT"), 1);
}

} // namespace
