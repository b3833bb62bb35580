// Frames of a run: cameras, files of every kind, and the table that tells of them.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <set>

#include "coupled.h"
#include "output/image/png.h"

namespace {

using runs::Coupled;

runs::Table table_of(const test::Folder& folder) {
  return runs::parse_table(test::content(folder / "data.csv"));
}

/// However much is drawn of the same cells: structures and the tree stay. (Points of probes and
/// tracers may pay for a better tree.)
TEST(Frames, NewValuesOfTheSameCellsRebuildNothing) {
  const test::Folder folder;
  Coupled run({.scene = R"(insitu: 1
frames:
  - name: all
    size: [96, 96]
    volume: {field: density, shading: true}
    isosurfaces: [{field: pressure, values: [0.01], normals: central}]
  - name: paths
    size: [64, 64]
    volume: {field: density}
    path_tracing: {samples: 4}
)",
               .output = folder.path(),
               .cells = 6});
  ASSERT_TRUE(run.execute()) << insitu_last_message();
  EXPECT_EQ(run.session.report().rebuilds, 1);
  run.run(12, insitu::fields);
  // They located some hundred thousand points, far more than would pay for a tree by surface area.
  EXPECT_EQ(run.session.report().rebuilds, 1);
  EXPECT_EQ(run.session.report().refits, 0);
  EXPECT_EQ(run.session.report().keeps, 12);
}

TEST(Frames, ATableOfCamerasCyclesAndFiles) {
  const test::Folder folder;
  Coupled run({.scene = R"(insitu: 1
every: 2
frames:
  - name: several
    size: [24, 16]
    cameras:
      front: {azimuth: 0, elevation: 0}
      top: {elevation: 90, azimuth: 30, orthographic: true}
      around: {path: [{cycle: 0, azimuth: -90}, {cycle: 8, azimuth: 90}], elevation: 10}
    format: [png, exr]
    volume: {field: density}
  - name: single
    size: [16, 16]
    every: 4
    camera: {position: [3, 3, 3], look_at: [0.5, 0.5, 0.5]}
    isosurfaces: [{field: pressure, values: [0.01], color: {field: velocity, component: 1, range: [-1, 2]}}]
)",
               .output = folder.path()});
  ASSERT_TRUE(run.execute()) << insitu_last_message();
  run.run(4);
  const runs::Table t = table_of(folder);
  EXPECT_EQ(t.columns, (std::vector<std::string>{"cycle", "time", "name", "camera", "format", "phi",
                                                 "theta", "camera_x", "camera_y", "camera_z",
                                                 "density_low", "density_high", "velocity_1_low",
                                                 "velocity_1_high", "FILE"}));
  ASSERT_EQ(t.rows.size(), 3u * 3 * 2 + 2); // three cycles of three cameras in two formats
  std::set<std::string> files;
  double last_high = 0;
  for (std::size_t row = 0; row < t.rows.size(); ++row) {
    const std::string file = t.text(row, "FILE");
    SCOPED_TRACE(file);
    EXPECT_TRUE(files.insert(file).second);
    EXPECT_TRUE(std::filesystem::exists(folder / file));
    const auto cycle = int(t.number(row, "cycle"));
    const std::string camera = t.text(row, "camera"), name = t.text(row, "name");
    char number[16];
    std::snprintf(number, sizeof number, "_%06d.", cycle);
    EXPECT_EQ(file, name + (camera.empty() ? "" : "_" + camera) + number + t.text(row, "format"));
    // Cinema's tools take a column's type from its first row.
    EXPECT_NE(t.text(row, "time").find_first_of(".e"), std::string::npos);
    if (camera == "front") {
      EXPECT_EQ(t.text(row, "phi"), "0.0");
      EXPECT_EQ(t.text(row, "theta"), "0.0");
      EXPECT_GT(t.number(row, "camera_x"), 1);
    } else if (camera == "top") {
      EXPECT_EQ(t.text(row, "theta"), "90.0");
      EXPECT_EQ(t.text(row, "phi"), "30.0");
    } else if (camera == "around") {
      EXPECT_NEAR(t.number(row, "phi"), -90 + 22.5 * cycle, 1e-6);
      EXPECT_NEAR(t.number(row, "theta"), 10, 1e-6);
    }
    if (name == "several") { // what the colours stretched over
      EXPECT_EQ(t.text(row, "velocity_1_low"), "");
      EXPECT_LT(t.number(row, "density_low"), t.number(row, "density_high"));
      last_high = t.number(row, "density_high");
    } else {
      EXPECT_EQ(t.text(row, "density_low"), "");
      EXPECT_EQ(t.text(row, "velocity_1_low"), "-1.0");
      EXPECT_EQ(t.text(row, "velocity_1_high"), "2.0");
    }
  }
  EXPECT_EQ(last_high, *std::max_element(run.solver.density.begin(), run.solver.density.end()));
  EXPECT_EQ(run.session.report().frames, 3 * 3 + 2);
}

TEST(Frames, ARestartDropsLaterRowsAndASceneThatChangedKeepsOlderColumns) {
  const test::Folder folder;
  const std::string scene = "insitu: 1\nframes:\n  - {name: 'a, \"b\"', size: [8, 8], volume: "
                            "{field: density}";
  {
    // The name has what CSV must quote, but a file system takes.
    std::string named = scene;
    named.replace(named.find("'a, \"b\"'"), 8, "'a, b'");
    Coupled run({.scene = named + "}\n", .output = folder.path()});
    ASSERT_TRUE(run.execute()) << insitu_last_message();
    run.run(5);
  }
  {
    Coupled run({.scene = "insitu: 1\nframes:\n  - {name: c, size: [8, 8], images: [color], "
                          "cameras: {x: auto}, volume: {field: pressure}}\n",
                 .output = folder.path()});
    while (run.solver.cycle() < 3)
      run.solver.advance();
    run.mesh.changed(insitu::geometry | insitu::fields);
    ASSERT_TRUE(run.execute()) << insitu_last_message();
  }
  const std::string text = test::content(folder / "data.csv");
  EXPECT_EQ(
      text.substr(0, text.find('\n')),
      "cycle,time,name,camera,phi,theta,camera_x,camera_y,camera_z,pressure_low,pressure_high,"
      "density_low,density_high,FILE");
  std::vector<std::string> lines;
  for (std::size_t at = 0; at < text.size(); at = text.find('\n', at) + 1)
    lines.push_back(text.substr(at, text.find('\n', at) - at));
  ASSERT_EQ(lines.size(), 5u) << text; // cycles 0, 1, 2 of the first run and 3 of the second
  EXPECT_EQ(lines[3].substr(0, 2), "2,");
  EXPECT_NE(lines[3].find("\"a, b\","), std::string::npos) << lines[3];
  EXPECT_TRUE(lines[3].ends_with(",\"a, b_000002.png\"")) << lines[3];
  EXPECT_EQ(lines[4].substr(0, 2), "3,");
  EXPECT_TRUE(lines[4].ends_with(",,,c_x_000003.png")) << lines[4];
}

TEST(Frames, ATableThatAnotherRunWritesIsNoReasonToDrawNothing) {
  const test::Folder folder;
  const auto scene = [](const std::string& name) {
    return "insitu: 1\npage: false\nframes:\n  - {name: " + name +
           ", size: [8, 8], volume: {field: density}}\n";
  };
  Coupled first({.scene = scene("a"), .output = folder.path()});
  Coupled second({.scene = scene("b"), .output = folder.path()});
  for (int i = 0; i < 2; ++i) {
    EXPECT_TRUE(first.session.execute(i, i));
    EXPECT_TRUE(second.session.execute(i, i)) << insitu_last_message();
  }
  EXPECT_TRUE(first.log.empty());
  ASSERT_EQ(second.log.size(), 1u);
  EXPECT_NE(second.log[0].find("data.csv"), std::string::npos) << second.log[0];
  EXPECT_EQ(second.session.report().failures, 0);
  EXPECT_TRUE(std::filesystem::exists(folder / "b_000001.png"));
  EXPECT_EQ(table_of(folder).rows.size(), 2u);
}

/// Ten columns of cells, from NaN over negative values to beyond the range, seen from above.
TEST(Frames, LogarithmicColoursAndThoseBeyondTheRange) {
  const test::Folder folder;
  const std::string frame = "size: [10, 10], camera: {elevation: 90, azimuth: -90, orthographic: "
                            "true, fit: box}, boundary: {color: {colors: grey, ";
  Coupled run({.scene = "insitu: 1\nframes:\n"
                        "  - {name: log, " +
                        frame +
                        "field: density, scale: log, range: [1.0e-3, 10], below: blue, above: red, "
                        "nan: yellow}}}\n"
                        "  - {name: linear, " +
                        frame +
                        "field: pressure, range: [-3, 1]}}}\n"
                        "  - {name: auto, " +
                        frame + "field: density, scale: log}}}\n",
               .output = folder.path()});
  const double values[10] = {NAN, -1, 0, 9.9e-4, 1e-3, 1e-2, 0.1, 1, 10, 10.1};
  for (std::size_t c = 0; c < run.solver.density.size(); ++c) {
    run.solver.density[c] = values[c % 10];
    run.solver.pressure[c] = std::log10(values[c % 10]);
  }
  ASSERT_TRUE(run.execute()) << insitu_last_message();
  const auto log = insitu::output::read_png(folder / "log_000000.png"),
             linear = insitu::output::read_png(folder / "linear_000000.png");
  const int beyond[10][3] = {
      {255, 255, 0}, {0, 0, 255}, {0, 0, 255}, {0, 0, 255}, {}, {}, {}, {}, {}, {255, 0, 0}};
  for (int x = 0; x < 10; ++x)
    for (int c = 0; c < 3; ++c) {
      const bool within = x >= 4 && x <= 8;
      EXPECT_NEAR(log.pixel(x, 5)[c], within ? linear.pixel(x, 5)[c] : beyond[x][c], 1) << x;
    }
  EXPECT_NEAR(log.pixel(6, 5)[0], 119, 2); // the middle of lightness
  const runs::Table t = table_of(folder);
  for (std::size_t row = 0; row < t.rows.size(); ++row)
    if (t.text(row, "name") == "auto") { // the field reaches below 0
      EXPECT_DOUBLE_EQ(t.number(row, "density_low"), 10.1e-4);
      EXPECT_EQ(t.number(row, "density_high"), 10.1);
    }
  // Nowhere above 0: all is below, and the run goes on.
  std::fill(run.solver.density.begin(), run.solver.density.end(), 0.0);
  run.mesh.changed(insitu::fields);
  EXPECT_TRUE(run.execute()) << insitu_last_message();
  EXPECT_EQ(insitu::output::read_png(folder / "log_000000.png").pixel(5, 5)[2], 255);
}

TEST(Frames, TicksOfTheOutlineStandBesideTheMeshAndLeaveRoom) {
  const test::Folder folder;
  const std::string frame = "size: [200, 200], boundary: {color: blue}, camera: {fit: box, "
                            "elevation: 90, azimuth: -90, orthographic: true}, outline: {";
  Coupled run({.scene = "insitu: 1\nframes:\n  - {name: plain, " + frame +
                        "}}\n  - {name: ticks, " + frame + "ticks: true}}\n",
               .output = folder.path()});
  ASSERT_TRUE(run.execute()) << insitu_last_message();
  const auto plain = insitu::output::read_png(folder / "plain_000000.png"),
             ticks = insitu::output::read_png(folder / "ticks_000000.png");
  // Of the mesh 98 % of the image, and 75 % with room for labels.
  const auto blue = [](const insitu::output::PngImage& image) {
    int count = 0;
    for (int x = 0; x < image.width; ++x)
      count += image.pixel(x, 100)[2] == 255 && image.pixel(x, 100)[0] == 0;
    return count;
  };
  EXPECT_NEAR(blue(plain), 196, 4);
  EXPECT_NEAR(blue(ticks), 150, 4);
  const auto ink = [&](int x0, int y0, int x1, int y1) {
    int count = 0;
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x)
        count += ticks.pixel(x, y)[0] < 128;
    return count;
  };
  EXPECT_GT(ink(25, 178, 175, 200), 30); // x below
  EXPECT_GT(ink(0, 25, 23, 175), 30);    // y to the left
  EXPECT_EQ(ink(178, 0, 200, 200), 0);
  EXPECT_EQ(ink(0, 0, 200, 22), 0);
}

TEST(Frames, TransparentBackgroundsKeepAlpha) {
  const test::Folder folder;
  Coupled run({.scene = R"(insitu: 1
frames:
  - {name: clear, size: [32, 32], background: transparent, volume: {field: density, opacity: [[0, 1]]}}
  - {name: half, size: [32, 32], background: {color: red, alpha: 0.5}, volume: {field: density, opacity: [[0, 0]]}}
  - {name: full, size: [32, 32], volume: {field: density}}
)",
               .output = folder.path()});
  ASSERT_TRUE(run.execute()) << insitu_last_message();
  const auto clear = insitu::output::read_png(folder / "clear_000000.png"),
             half = insitu::output::read_png(folder / "half_000000.png"),
             full = insitu::output::read_png(folder / "full_000000.png");
  ASSERT_EQ(clear.channels, 4);
  ASSERT_EQ(half.channels, 4);
  EXPECT_EQ(full.channels, 3);
  EXPECT_EQ(clear.pixel(0, 0)[3], 0);     // beside the mesh
  EXPECT_EQ(clear.pixel(16, 16)[3], 255); // an opaque volume
  for (const int at : {0, 16}) {          // a volume that is not seen
    EXPECT_EQ(half.pixel(at, at)[0], 255);
    EXPECT_EQ(half.pixel(at, at)[1], 0);
    EXPECT_EQ(half.pixel(at, at)[3], 128);
  }
}

TEST(Frames, DepthAndCellsAreWrittenToo) {
  const test::Folder folder;
  // From x = 3 against an opaque cube of 10 cells a side.
  Coupled run({.scene = R"(insitu: 1
frames:
  - name: f
    size: [8, 8]
    images: [color, depth, cell]
    format: [png, exr]
    camera: {position: [3, 0.5, 0.5], look_at: [0, 0.5, 0.5], orthographic: 0.5}
    volume: {field: density, opacity: [[0, 1]]}
)",
               .output = folder.path()});
  ASSERT_TRUE(run.execute()) << insitu_last_message();
  const runs::Table t = table_of(folder);
  ASSERT_EQ(t.rows.size(), 6u);
  const std::vector<std::string> files{"f_000000.png",       "f_000000.exr",
                                       "f_depth_000000.png", "f_depth_000000.exr",
                                       "f_cell_000000.png",  "f_cell_000000.exr"};
  for (std::size_t row = 0; row < 6; ++row) {
    EXPECT_EQ(t.text(row, "FILE"), files[row]);
    EXPECT_TRUE(std::filesystem::exists(folder / files[row]));
    EXPECT_EQ(t.text(row, "image"), row < 2 ? "color" : row < 4 ? "depth" : "cell");
    EXPECT_EQ(t.text(row, "depth_low").empty(), row < 2 || row > 3);
  }
  // To the first sample within the cube, at most a step of half a cell behind its side.
  const double before = 3 - *std::max_element(run.solver.x.begin(), run.solver.x.end());
  const double cell = *std::max_element(run.solver.x.begin(), run.solver.x.end()) / 10;
  EXPECT_GE(t.number(2, "depth_low"), before - 1e-6);
  EXPECT_LE(t.number(2, "depth_high"), before + 0.55 * cell);
}

} // namespace
