// Adaptive meshes without global ids over processes: owners on seams are the lowest process, piece
// and cell, so answers are to the bit those of one process that has the pieces in this order.
#include <sstream>

#include "amr_meshes.h"
#include "amr_session.h"

using namespace insitu;
using namespace insitu::test;

namespace {

/// Without the columns that name a cell, which are numbers of its process.
std::string without_names(const std::string& csv) {
  std::istringstream in(csv);
  std::string text;
  std::vector<bool> is_name;
  for (std::string line; std::getline(in, line);) {
    std::istringstream values(line);
    const bool is_first = is_name.empty();
    std::size_t column = 0;
    for (std::string value; std::getline(values, value, ',');) {
      if (is_first)
        is_name.push_back(value == "cell" || value == "piece" || value == "process");
      if (!is_name[column++])
        text += value + ",";
    }
    text += "\n";
  }
  return text;
}

/// in_one: the pieces of all processes on one, in their order.
std::map<std::string, std::string> run(const AmrMesh& whole, insitu_reconstruction how,
                                       int processes, const Deal& deal, const std::string& scene,
                                       bool in_one) {
  const OwnFolder folder;
  const std::string out = folder / "out";
  run_processes(in_one ? 1 : processes, [&](parallel::World& world) {
    AmrSession process(world, whole, how, deal, scene, out, false);
    AmrPart part(whole, how, deal, world.rank());
    for (int rank = 1; in_one && rank < processes; ++rank)
      part.add(whole, deal, rank);
    part.without_ids();
    process.give(std::move(part));
    for (int cycle = 0; cycle < 3; ++cycle)
      EXPECT_EQ(process.execute(cycle), "");
    EXPECT_EQ(process.session().finish(), "");
  });
  auto files = files_of(out);
  for (auto& [name, text] : files)
    if (name.ends_with(".csv"))
      text = without_names(text);
  return files;
}

void expect_one(const std::string& scene, insitu_reconstruction how, std::size_t files) {
  for (const AmrMesh& whole : {octree(), patches()})
    for (const auto& [processes, kind] : {std::pair(2, 0), std::pair(3, 2), std::pair(4, 1)}) {
      const Deal deal = deal_of(kind, processes);
      const auto expected = run(whole, how, processes, deal, scene, true);
      EXPECT_GE(expected.size(), files);
      expect_same(expected, run(whole, how, processes, deal, scene, false),
                  "deal " + std::to_string(kind) + " on " + std::to_string(processes));
    }
}

} // namespace

TEST(ProcessAdaptiveUnnamed, ProbesAndConditions) {
  const std::string scene =
      "insitu: 1\npage: false\n"
      "probes:\n"
      "  - {name: line, points: {line: {from: [-0.2, 0.3, 0.1], to: [4.1, 3.7, 3.9], count: 60}},\n"
      "     fields: [s, v], outside: nearest}\n"
      "  - {name: seams, points: {box: {min: [0, 0, 0], max: [4, 4, 4], counts: [9, 9, 9]}},\n"
      "     fields: [s], when: max(s) > 0.5 and mean(s) < 10}\n";
  for (const insitu_reconstruction how : {INSITU_DUAL, INSITU_NEAREST})
    expect_one(scene, how, 2);
}

TEST(ProcessAdaptiveUnnamed, Tracers) {
  const std::string seeds =
      "seeds: {box: {min: [0.5, 0.5, 0.5], max: [3.5, 3.5, 3.5], counts: [5, 5, 5]}}";
  const std::string scene =
      "insitu: 1\npage: false\n"
      "tracers:\n"
      "  - {name: paths, velocity: v, fields: [s], kind: pathline, " +
      seeds +
      "}\n"
      "  - {name: walls, velocity: v, fields: [s], kind: pathline, effects: [{boundary: slide}, "
      "{settling: {speed: 0.2}}], " +
      seeds +
      "}\n"
      "  - {name: lines, velocity: v, kind: streamline, until: {duration: 4}, " +
      seeds + "}\n";
  expect_one(scene, INSITU_DUAL, 3);
}

TEST(ProcessAdaptiveUnnamed, Frames) {
  const std::string scene =
      "insitu: 1\npage: false\n"
      "frames:\n"
      "  - {name: smoke, size: [32, 24], images: [color, depth, cell], format: [png, exr],\n"
      "     every: 3, volume: {field: s, opacity: [[-1, 0.05], [1, 0.8]]}}\n"
      "  - {name: skin, size: [70, 70], images: [color, cell], boundary: {color: {field: s}, "
      "opacity: 0.4}, every: 3";
  expect_one(scene + "}\n", INSITU_NEAREST, 9);
  expect_one(scene + ", isosurfaces: [{field: s, values: [0.4]}]}\n", INSITU_DUAL, 9);
}
