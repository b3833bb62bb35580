// Runs over processes whose first cycle after a restart has other cells.
#include <algorithm>
#include <sstream>

#include "part_session.h"

using namespace insitu;
using namespace insitu::test;

namespace {

constexpr int cycles = 5, change = 3;

const std::string scene =
    "insitu: 1\npage: false\ntracers:\n"
    "  - {name: paths, velocity: u, seeds: {box: {min: [0.5, 0.5, 0.5], max: [5.5, 4.5, 4.5], "
    "counts: [5, 4, 3]}}, fields: [p, c], output: [csv, vtp]}\n"
    "  - {name: streaks, velocity: u, kind: streakline, seeds: {points: [[1, 1, 1], [3.1, 2.2, "
    "2.7]]}, until: {duration: 0.6}, times: {interval: 0.11}, fields: [p], output: [csv]}\n"
    "  - {name: sliding, velocity: u, seeds: {box: {min: [1, 1, 1], max: [4, 4, 4], counts: [3, 2, "
    "2]}}, effects: [{boundary: {other: slide}}, {settling: {speed: 0.3}}], output: [csv]}\n";

TestMesh tetrahedra() {
  MeshOptions options;
  options.size = 5;
  options.jitter = 0.1;
  options.kind = MeshKind::tetrahedra;
  return make_mesh(options, 5);
}

/// Particles that begin at vertices in every cycle, also in the last one before the stop: which
/// cell's corner they are counts in the last digits.
std::string from_vertices(const TestMesh& mesh) {
  std::string points;
  for (std::size_t v = 40; v < mesh.vertices.size() && v < 160; v += 5) {
    char text[96];
    std::snprintf(text, sizeof text, "[%.17g, %.17g, %.17g]", mesh.vertices[v].x,
                  mesh.vertices[v].y, mesh.vertices[v].z);
    points += (points.empty() ? "" : ", ") + std::string(text);
  }
  return "  - {name: corners, velocity: u, kind: streakline, seeds: {points: [" + points +
         "]}, until: {duration: 0.6}, output: [csv]}\n";
}

using Cut = std::function<fixtures::Partition(const TestMesh&)>;

/// second: on which the run goes on from the change of cells; none: it does not stop.
std::map<std::string, std::string> run(const Cut& first, const Cut& second, bool ids) {
  const TestMesh before = jittered_cubes(5), after = tetrahedra();
  const OwnFolder folder;
  const std::string state = folder / "state";
  PartSession::Options options;
  options.scene = scene + from_vertices(before);
  options.ids = ids;
  options.folder = folder / "out";
  const auto go = [&](const Cut& cut, int from, int to) {
    const fixtures::Partition begun = cut(from < change ? before : after);
    run_processes(begun.processes, [&](parallel::World& world) {
      PartSession process(world, from < change ? before : after, begun, options);
      if (from > 0)
        process.session().restart(state);
      for (int cycle = from; cycle < to; ++cycle) {
        if (cycle == change && from < change)
          process.deal(cut(after), world.rank(), &after);
        EXPECT_EQ(process.execute(cycle), "");
      }
      if (to < cycles)
        process.session().checkpoint(state);
      EXPECT_EQ(process.session().finish(), "");
      for (const std::string& message : process.messages())
        EXPECT_EQ(message.find("not known again"), std::string::npos) << message;
    });
  };
  go(first, 0, second ? change : cycles);
  if (second)
    go(second, change, cycles);
  return files_of(options.folder);
}

Cut slabs(int processes) {
  return [=](const TestMesh& mesh) { return fixtures::slabs(mesh, processes); };
}

/// Of tables, where particles are and when, as text: cells have no names without ids.
std::map<std::string, std::string> places_of(const std::map<std::string, std::string>& files) {
  std::map<std::string, std::string> places;
  const auto cells_of = [](const std::string& line) {
    std::vector<std::string> cells;
    std::istringstream in(line);
    for (std::string cell; std::getline(in, cell, ',');)
      cells.push_back(cell);
    return cells;
  };
  for (const auto& [name, text] : files) {
    if (!name.ends_with(".csv"))
      continue;
    std::istringstream in(text);
    std::string line;
    std::getline(in, line);
    const std::vector<std::string> head = cells_of(line);
    while (std::getline(in, line)) {
      const std::vector<std::string> row = cells_of(line);
      for (std::size_t c = 0; c < head.size(); ++c)
        if (const std::string& of = head[c]; of == "cycle" || of == "time" || of == "particle" ||
                                             of == "x" || of == "y" || of == "z" || of == "ending")
          places[name] += row[c] + ",";
      places[name] += "\n";
    }
  }
  return places;
}

/// Without ids the cell of the lowest process counts at a corner.
std::map<std::string, std::string> without_corners(std::map<std::string, std::string> files) {
  files.erase("corners.csv");
  return places_of(files);
}

} // namespace

TEST(ProcessOtherCells, FilesAreThoseOfOneProcessWithoutAStop) {
  const auto expected = run(slabs(1), {}, true);
  std::string all;
  for (const auto& [name, text] : expected)
    all += text;
  EXPECT_GT(std::ranges::count(all, '\n'), 200);
  const Cut boxes = [](const TestMesh& mesh) { return fixtures::boxes(mesh, 4); };
  const Cut dealt = [](const TestMesh& mesh) { return fixtures::dealt(mesh, 3); };
  const Cut rootless = [](const TestMesh& mesh) { return fixtures::empty_root(mesh, 2); };
  for (const auto& [first, second] :
       {std::pair(slabs(1), slabs(1)), std::pair(slabs(1), boxes), std::pair(slabs(2), slabs(2)),
        std::pair(boxes, slabs(3)), std::pair(slabs(3), slabs(1)), std::pair(rootless, dealt),
        std::pair(dealt, slabs(1))}) {
    expect_same(expected, run(first, second, true), "with ids");
    expect_same(without_corners(expected), without_corners(run(first, second, false)),
                "without ids");
  }
}
