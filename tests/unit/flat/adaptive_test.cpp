// Adaptive meshes of two dimensions: quadtrees and flat patches.
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <random>
#include <sstream>
#include <vector>

#include "insitu/insitu.hpp"

#include "unit/output/folder.h"

namespace {

constexpr double plane = 2.5;
constexpr std::array<double, 3> origin{0.25, -1.75, plane}, spacing{0.75, 1.125, 7};

/// Few binary digits, so that comparisons are exact.
double corner_of(int axis, int level, std::int64_t index) {
  return origin[std::size_t(axis)] + spacing[std::size_t(axis)] * std::ldexp(double(index), -level);
}

double linear(double x, double y) {
  return 3 - 2 * x + 0.5 * y;
}

/// Leaves of quadtrees; what is beyond the levels' bounds is left out.
struct Quadtree {
  std::vector<std::int32_t> levels, corners; ///< two numbers a leaf
  std::vector<double> f, number, u;

  /// across x along trees. Levels beside each other differ by any number. hole: a leaf in so many
  /// is left out; 0: none.
  Quadtree(int across, int along, int finest, unsigned seed, int hole = 0) {
    std::mt19937 random(seed);
    const std::function<void(int, int, int)> add = [&](int level, int i, int j) {
      if (level < finest && random() % 3 == 0) {
        for (int o = 0; o < 4; ++o)
          add(level + 1, 2 * i + (o & 1), 2 * j + (o >> 1));
        return;
      }
      if (hole != 0 && random() % unsigned(hole) == 0)
        return;
      levels.push_back(level);
      corners.insert(corners.end(), {i, j});
    };
    for (int j = 0; j < along; ++j)
      for (int i = 0; i < across; ++i)
        add(0, i, j);
    for (std::size_t c = 0; c < count(); ++c) {
      const auto [x, y] = centre(c);
      f.push_back(linear(x, y));
      number.push_back(double(c));
      u.insert(u.end(), {-(y - 2), x - 2});
    }
  }
  std::size_t count() const { return levels.size(); }
  double low(std::size_t c, int axis) const {
    return corner_of(axis, levels[c], corners[2 * c + std::size_t(axis)]);
  }
  double high(std::size_t c, int axis) const {
    return corner_of(axis, levels[c], corners[2 * c + std::size_t(axis)] + 1);
  }
  std::pair<double, double> centre(std::size_t c) const {
    return {0.5 * (low(c, 0) + high(c, 0)), 0.5 * (low(c, 1) + high(c, 1))};
  }
  /// The lowest of the closed leaves that hold a point; -1: none does.
  std::int64_t owner(double x, double y) const {
    for (std::size_t c = 0; c < count(); ++c)
      if (x >= low(c, 0) && x <= high(c, 0) && y >= low(c, 1) && y <= high(c, 1))
        return std::int64_t(c);
    return -1;
  }
  void give(insitu::Mesh& mesh, insitu::Reconstruction how) {
    insitu::AmrLevels given;
    given.origin = origin;
    given.spacing = spacing;
    given.count = 6;
    given.reconstruction = how;
    given.dimensions = 2;
    mesh.adaptive(given);
    mesh.leaves(levels, insitu::Array(corners).components(2));
    mesh.cell_field("f", f);
    mesh.cell_field("number", number);
    mesh.cell_field("u", insitu::Array(u).components(2));
  }
};

/// Corners, middles of edges and centres of leaves, and places anywhere, at any height.
std::vector<double> points_of(const Quadtree& tree, int across, int along) {
  std::vector<double> xyz;
  for (std::size_t c = 0; c < tree.count(); ++c)
    for (int at = 0; at < 9; ++at) {
      const auto place = [&](int axis, int part) {
        return tree.low(c, axis) + 0.5 * part * (tree.high(c, axis) - tree.low(c, axis));
      };
      xyz.insert(xyz.end(), {place(0, at % 3), place(1, at / 3), double(at)});
    }
  std::mt19937_64 random(3);
  for (int i = 0; i < 2000; ++i) {
    const double x = double(random() % 4096) / 4096 * 1.1 - 0.05,
                 y = double(random() % 4096) / 4096 * 1.1 - 0.05;
    xyz.insert(xyz.end(), {origin[0] + spacing[0] * across * x, origin[1] + spacing[1] * along * y,
                           double(i - 1000)});
  }
  return xyz;
}

} // namespace

TEST(FlatAdaptive, OwnersAreTheLowestLeaves) {
  for (unsigned seed = 1; seed <= 4; ++seed)
    for (const int hole : {0, 9})
      for (const auto how : {insitu::Reconstruction::dual, insitu::Reconstruction::nearest}) {
        Quadtree tree(5, 4, 4, seed, hole);
        insitu::Session session;
        insitu::Mesh mesh = session.mesh("m");
        tree.give(mesh, how);
        mesh.commit();
        EXPECT_TRUE(mesh.amr_info().folded == 0 || hole != 0); // beside holes leaves may be split
        EXPECT_EQ(mesh.amr_info().leaves, std::int64_t(tree.count()));
        const std::vector<double> xyz = points_of(tree, 5, 4);
        const insitu::Samples found = mesh.sample("number", xyz);
        for (std::size_t i = 0; i < xyz.size() / 3; ++i) {
          const std::int64_t owner = tree.owner(xyz[3 * i], xyz[3 * i + 1]);
          ASSERT_EQ(found.cells[i], owner) << xyz[3 * i] << " " << xyz[3 * i + 1];
          if (how == insitu::Reconstruction::nearest && owner >= 0) {
            ASSERT_EQ(found.values[i], double(owner));
          }
        }
        const insitu::Locations at = mesh.locate(xyz);
        for (std::size_t i = 0; i < at.cells.size(); ++i)
          if (at.cells[i] >= 0) {
            ASSERT_EQ(at.parametric[3 * i + 2], 0.5);
          }
      }
}

/// Between the outermost centres linear fields are met, over any steps of levels, and gradients are
/// of the plane; a centre has its leaf's value.
TEST(FlatAdaptive, LinearFieldsAreMetBetweenTheCentres) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    Quadtree tree(6, 5, 5, seed);
    insitu::Session session;
    insitu::Mesh mesh = session.mesh("m");
    tree.give(mesh, insitu::Reconstruction::dual);
    mesh.commit();
    EXPECT_EQ(mesh.amr_info().folded, 0);
    const std::vector<double> xyz = points_of(tree, 6, 5);
    const insitu::Samples found = mesh.sample("f", xyz);
    int inner = 0;
    for (std::size_t i = 0; i < found.values.size(); ++i) {
      const double x = xyz[3 * i], y = xyz[3 * i + 1];
      const double within = 0.5; // cells of the coarsest level
      if (x < corner_of(0, 0, 0) + within * spacing[0] ||
          x > corner_of(0, 0, 6) - within * spacing[0] ||
          y < corner_of(1, 0, 0) + within * spacing[1] ||
          y > corner_of(1, 0, 5) - within * spacing[1])
        continue;
      ++inner;
      ASSERT_NEAR(found.values[i], linear(x, y), 2e-14) << x << " " << y; // terms of up to 13
    }
    EXPECT_GT(inner, 1000);
    std::vector<double> centres;
    for (std::size_t c = 0; c < tree.count(); ++c)
      centres.insert(centres.end(), {tree.centre(c).first, tree.centre(c).second, 0});
    const insitu::Samples at = mesh.sample("number", centres);
    for (std::size_t c = 0; c < tree.count(); ++c)
      ASSERT_NEAR(at.values[c], double(c), 1e-10);
  }
}

/// Coarse patches, one of ratio 4 over them, and ghosts: linear up to the boundary, steps covered.
TEST(FlatAdaptive, PatchesWithGhostsAreLinearUpToTheBoundary) {
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
  insitu::AmrLevels levels;
  levels.origin = origin;
  levels.spacing = spacing;
  levels.ratios = {4};
  levels.dimensions = 2;
  mesh.adaptive(levels);
  struct Patch {
    int level;
    std::int64_t lower[2], n[2];
    std::vector<double> values;
  };
  std::vector<Patch> patches{{0, {0, 0}, {6, 5}, {}}, {1, {8, 8}, {8, 4}, {}}};
  for (std::size_t p = 0; p < patches.size(); ++p) {
    Patch& patch = patches[p];
    const std::int64_t g = p == 0 ? 1 : 0, row = patch.n[0] + 2 * g;
    for (std::int64_t j = -g; j < patch.n[1] + g; ++j)
      for (std::int64_t i = -g; i < patch.n[0] + g; ++i) {
        const auto middle = [&](int a, std::int64_t k) {
          return 0.5 * (corner_of(a, 2 * patch.level, patch.lower[a] + k) +
                        corner_of(a, 2 * patch.level, patch.lower[a] + k + 1));
        };
        patch.values.push_back(linear(middle(0, i), middle(1, j)));
      }
    insitu::PatchGhosts ghosts;
    ghosts.before = ghosts.after = {int(g), int(g), 5}; // the third is of no account
    mesh.piece(int(p)).patch(patch.level, {patch.lower[0], patch.lower[1], 99},
                             {patch.n[0], patch.n[1], 1}, ghosts);
    const std::int64_t size = sizeof(double);
    mesh.piece(int(p)).cell_field(
        "f", insitu::Array(patch.values.data() + g * (1 + row))
                 .block({patch.n[0], patch.n[1], 1}, {size, row * size, row * patch.n[1] * size}));
  }
  mesh.commit();
  EXPECT_EQ(mesh.amr_info().masked, 2);
  std::mt19937_64 random(5);
  for (int i = 0; i < 2000; ++i) {
    const double x = corner_of(0, 0, 0) + 6 * spacing[0] * double(random() % 1025) / 1024;
    const double y = corner_of(1, 0, 0) + 5 * spacing[1] * double(random() % 1025) / 1024;
    double value = 0;
    ASSERT_TRUE(mesh.sample_point("f", {x, y, 1e5}, insitu::View<double>(&value, 1)));
    ASSERT_NEAR(value, linear(x, y), 2e-14) << x << " " << y;
  }
}

namespace {

insitu::Session session_of(const std::string& scene, const std::string& output, std::string& log) {
  insitu::Options options;
  options.scene_text = scene;
  options.output = output;
  options.log = [&log](insitu::LogLevel level, const char* message) {
    if (level <= insitu::LogLevel::warning)
      log += message;
  };
  return insitu::Session(options);
}

} // namespace

/// Closed orbits of a vortex, whose velocity is linear, in the plane to the bit, over a regrid;
/// with a third component, too, which is of no account.
TEST(FlatAdaptive, TracersOfAVortexStayOnTheirCirclesAndInThePlane) {
  for (const int components : {2, 3}) {
    const test::Folder folder;
    std::string log;
    insitu::Session session =
        session_of("insitu: 1\npage: false\ntracers:\n"
                   "  - {name: turns, velocity: u, seeds: [[3, 2, 0], [2, 1.25, 50]],\n"
                   "     integrator: {method: dopri5, tolerance: 1e-11}, output: [csv]}\n",
                   folder.path(), log);
    insitu::Mesh mesh = session.mesh("m");
    Quadtree before(6, 6, 4, 2), after(6, 6, 3, 5);
    std::vector<double> three[2];
    const auto give = [&](Quadtree& tree) {
      tree.give(mesh, insitu::Reconstruction::dual);
      if (components == 2)
        return;
      std::vector<double>& u = three[&tree == &after];
      for (std::size_t c = 0; c < tree.count(); ++c)
        u.insert(u.end(), {tree.u[2 * c], tree.u[2 * c + 1], 1e3});
      mesh.cell_field("u", insitu::Array(u).components(3));
    };
    give(before);
    for (int cycle = 0; cycle <= 4; ++cycle) {
      if (cycle == 2)
        give(after);
      ASSERT_TRUE(session.execute(cycle, 0.5 * std::numbers::pi * cycle)) << insitu_last_message();
    }
    session.close();
    EXPECT_EQ(log, "");
    std::ifstream in(folder / "turns.csv");
    std::string line;
    std::getline(in, line);
    int rows = 0;
    for (; std::getline(in, line); ++rows) {
      std::istringstream row(line);
      std::string cell;
      std::vector<std::string> cells;
      while (std::getline(row, cell, ','))
        cells.push_back(cell);
      const auto at = [&](std::size_t i) { return std::stod(cells[i]); };
      const bool first = cells[2] == "0"; // cycle, time, particle, x, y, z
      EXPECT_NEAR(std::hypot(at(3) - 2, at(4) - 2), first ? 1.0 : 0.75, 1e-9) << line;
      EXPECT_EQ(at(5), plane) << line;
    }
    EXPECT_GE(rows, 10);
  }
}

/// Stopped after a cycle and after a regrid, and gone on with from the checkpoint, over a regrid
/// too.
TEST(FlatAdaptive, GoOnFromACheckpointToTheByte) {
  const std::string scene =
      "insitu: 1\npage: false\n"
      "probes:\n"
      "  - {name: line, points: {line: {from: [0.5, -1.5, 0], to: [4, 4, 9], count: 20}}, fields: "
      "[f, u]}\n"
      "tracers:\n"
      "  - {name: turns, velocity: u, fields: [f], output: [csv],\n"
      "     seeds: {box: {min: [0.5, -1.5, 0], max: [4.5, 4.5, 0], counts: [4, 4, 1]}}}\n"
      "frames: [{name: sheet, size: [32, 32], boundary: {color: {field: f}}}]\n";
  constexpr int regrid = 2, cycles = 5;
  for (const auto how : {insitu::Reconstruction::dual, insitu::Reconstruction::nearest}) {
    const test::Folder folder;
    const std::string state = folder / "state";
    const auto go = [&](const std::string& out, int from, int to) {
      Quadtree before(6, 6, 4, 2), after(6, 6, 3, 5);
      std::string log;
      insitu::Session session = session_of(scene, out, log);
      insitu::Mesh mesh = session.mesh("m");
      for (int cycle = from; cycle < to; ++cycle) {
        if (cycle == from || cycle == regrid)
          (cycle < regrid ? before : after).give(mesh, how);
        if (cycle == from && from > 0)
          session.restart(state);
        ASSERT_TRUE(session.execute(cycle, 0.25 * cycle)) << insitu_last_message();
      }
      if (to < cycles)
        session.checkpoint(state);
      else
        session.close();
      EXPECT_EQ(log, "");
    };
    const std::string whole = folder / "whole";
    go(whole, 0, cycles);
    for (const int stop : {1, regrid, regrid + 1}) {
      const std::string rest = folder / ("rest" + std::to_string(stop));
      go(rest, 0, stop);
      go(rest, stop, cycles);
      int files = 0;
      for (const auto& file : std::filesystem::recursive_directory_iterator(whole))
        if (const auto end = file.path().extension(); end == ".csv" || end == ".png") {
          const auto name = std::filesystem::relative(file.path(), whole);
          EXPECT_EQ(test::content(file.path()), test::content(rest / name))
              << name << ", stopped after " << stop;
          ++files;
        }
      EXPECT_GE(files, 2 + cycles);
    }
  }
}

TEST(FlatAdaptive, WhatDoesNotFitIsRefused) {
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
  insitu::AmrLevels levels;
  const auto refusal = [](const std::function<void()>& call) {
    try {
      call();
    } catch (const insitu::Error& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  levels.dimensions = 1;
  EXPECT_NE(refusal([&] { mesh.adaptive(levels); }).find("dimensions 1, 2 or 3 expected"),
            std::string::npos);
  levels.dimensions = 2;
  levels.origin[2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(refusal([&] { mesh.adaptive(levels); }).find("the plane"), std::string::npos);
  levels.origin[2] = 0;
  levels.count = 2;
  mesh.adaptive(levels);
  const std::vector<double> values(4, 1.0);
  mesh.patch(0, {0, 0, 0}, {2, 2, 1});
  mesh.cell_field("f", values);
  levels.dimensions = 3;
  EXPECT_NE(refusal([&] { mesh.adaptive(levels); }).find("drop them first"), std::string::npos);
  mesh.piece(1).patch(1, {1, 0, 0}, {2, 2, 1}); // not on faces of the level above
  mesh.piece(1).cell_field("f", values);
  EXPECT_NE(refusal([&] { mesh.commit(); }).find("covered by finer cells in part only"),
            std::string::npos);
}
