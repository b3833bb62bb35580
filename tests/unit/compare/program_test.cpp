#include <gtest/gtest.h>
#include <sstream>

#include "compare/run.h"
#include "output/image/png.h"
#include "unit/output/folder.h"

namespace {

using insitu::compare::run;
using insitu::output::PngImage;
using test::Folder;
using test::put;

struct Result {
  int code;
  std::string out, err;
};

Result call(const std::vector<std::string>& arguments) {
  std::ostringstream out, err;
  const int code = run(arguments, out, err);
  return {code, out.str(), err.str()};
}

TEST(Program, ExitCodes) {
  const Folder folder;
  const std::string a = folder / "a.csv", b = folder / "b.csv", c = folder / "c.csv";
  put(a, "p\n1\n");
  put(b, "p\n1.001\n");
  put(c, "p\n1,2\n");
  EXPECT_EQ(call({a, a}).code, 0);
  const Result moved = call({a, b});
  EXPECT_EQ(moved.code, 1);
  EXPECT_NE(moved.out.find("DIFFERENT"), std::string::npos);
  EXPECT_NE(moved.out.find("1 -> 1.001"), std::string::npos);
  EXPECT_EQ(call({a, b, "--tolerance-relative", "1e-2"}).code, 0);
  EXPECT_EQ(call({a, b, "--column", "p:0:0.01"}).code, 0);
  EXPECT_EQ(call({a, b, "--ignore-column", "p"}).code, 0);
  EXPECT_EQ(call({a, c}).code, 2);
  EXPECT_EQ(call({a, folder / "absent.csv"}).code, 2);
  const Result quiet = call({a, b, "--quiet"});
  EXPECT_EQ(quiet.code, 1);
  EXPECT_EQ(quiet.out, "");
  EXPECT_EQ(call({"--help"}).code, 0);
}

TEST(Program, BadOptionsAreNamed) {
  struct Case {
    std::vector<std::string> arguments;
    const char* says;
  };
  const Case cases[] = {
      {{}, "two files or folders expected, 0 given"},
      {{"a.csv"}, "1 given"},
      {{"a.csv", "b.csv", "--max-pixle", "1"}, "did you mean '--max-pixel'"},
      {{"a.csv", "b.csv", "--key"}, "--key: a value expected"},
      {{"a.csv", "b.csv", "--column", "p:1"}, "name:relative:absolute"},
      {{"a.csv", "b.csv", "--column", "p:x:0"}, "'x'"},
      {{"a.csv", "b.csv", "--tolerance-absolute", "-1"}, "'-1'"},
      {{"a.csv", "b.csv", "--tolerance-absolute", ""}, "a number of 0 or more"},
      {{"a.csv", "b.csv", "--max-share", "50"}, "0 to 1"},
      {{"a.csv", "b.csv", "--kind", "jpg"}, "png, exr, csv, json or nc"},
      {{"a.csv", "b.png"}, "--kind"},
  };
  for (const Case& c : cases) {
    const Result result = call(c.arguments);
    EXPECT_EQ(result.code, 2);
    EXPECT_NE(result.err.find(c.says), std::string::npos) << result.err;
  }
}

TEST(Program, ImagesWithADifferenceImage) {
  const Folder folder;
  PngImage image{32, 32, 3, insitu::core::CountedVector<std::uint8_t>(32 * 32 * 3, 90)};
  write_png(folder / "a.png", image);
  image.pixels[(5 * 32 + 7) * 3] = 250;
  write_png(folder / "b.png", image);
  const Result result =
      call({folder / "a.png", folder / "b.png", "--difference", folder / "d.png"});
  EXPECT_EQ(result.code, 1);
  EXPECT_NE(result.out.find("worst pixel (7, 5)"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("(90, 90, 90) -> (250, 90, 90)"), std::string::npos) << result.out;
  EXPECT_EQ(insitu::output::read_png(folder / "d.png").pixel(7, 5)[0], 255);
  EXPECT_EQ(
      call({folder / "a.png", folder / "b.png", "--max-pixel", "100", "--min-similarity", "0.5"})
          .code,
      0);
}

TEST(Program, Folders) {
  const Folder folder;
  std::filesystem::create_directories(folder / "a/probes");
  std::filesystem::create_directories(folder / "b/probes");
  for (const char* side : {"a", "b"}) {
    put(folder / (std::string(side) + "/probes/gauges.csv"), "cycle,p\n0,1\n");
    put(folder / (std::string(side) + "/summary.json"), "{\"cells\": 8}");
    put(folder / (std::string(side) + "/notes.txt"), side); // not compared
  }
  EXPECT_EQ(call({folder / "a", folder / "b"}).code, 0);
  // Options for one file's columns are no mistake in the others.
  EXPECT_EQ(call({folder / "a", folder / "b", "--column", "p:1e-6:0", "--key", "cycle"}).code, 0);
  put(folder / "b/probes/gauges.csv", "cycle,p\n0,2\n");
  put(folder / "a/more.csv", "x\n1\n");
  const Result result = call({folder / "a", folder / "b"});
  EXPECT_EQ(result.code, 1);
  EXPECT_NE(result.out.find("more.csv: DIFFERENT\n  missing in the second folder"),
            std::string::npos)
      << result.out;
  EXPECT_NE(result.out.find("probes/gauges.csv: DIFFERENT"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("summary.json: same"), std::string::npos) << result.out;
  put(folder / "b/summary.json", "{\"cells\": [}");
  const Result broken = call({folder / "a", folder / "b"});
  EXPECT_EQ(broken.code, 2);
  EXPECT_NE(broken.out.find("probes/gauges.csv: DIFFERENT"), std::string::npos) << broken.out;
  EXPECT_EQ(call({folder / "a", folder / "a/more.csv"}).code, 2);
}

} // namespace
