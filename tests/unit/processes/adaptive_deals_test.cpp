/// Tracers on adaptive meshes whose leaves are dealt out at random, so that every process has
/// leaves everywhere: their files are those of one process, to the byte.
#include <sstream>

#include "amr_meshes.h"
#include "amr_session.h"

using namespace insitu;
using namespace insitu::test;

namespace {

Deal random_deal(int seed, int processes) {
  return [=](std::size_t number, const math::Vec3d&) {
    return int(core::random_unit(std::uint64_t(seed), number, 0) * processes);
  };
}

constexpr int side = 4, seed_count = side * side * side + 1;

/// Seeds [first, last) of a box of them, behind which is one on a face of leaves, at a corner of
/// several processes.
std::string seeds(int first, int last) {
  std::ostringstream text;
  text.precision(17);
  const auto along = [](int k) { return 0.3 + 3.4 / double(side - 1) * double(k); };
  for (int i = first; i < last; ++i) {
    text << (i == first ? "{points: [[" : "], [");
    if (i + 1 < seed_count)
      text << along(i % side) << ", " << along(i / side % side) << ", " << along(i / (side * side));
    else
      text << "2, 1.15, 3.7";
  }
  return text.str() + "]]}";
}

/// Paths, lines and streaks from some seeds, of steps within cells and of long ones, and along
/// walls. Without lines by `nearest`, where they creep along faces.
std::string scene_from(const std::string& seeds, insitu_reconstruction how) {
  const std::string from = "seeds: " + seeds;
  return "insitu: 1\npage: false\ntracers:\n"
         "  - {name: paths, velocity: v, fields: [s, v], output: [csv], " +
         from + "}\n" +
         (how == INSITU_NEAREST ? ""
                                : "  - {name: lines, velocity: v, fields: [s], kind: streamline,\n"
                                  "     until: {duration: 4}, spacing: {length: 0.1}, " +
                                      from + "}\n") +
         "  - {name: streaks, velocity: v, fields: [s], kind: streakline, times: {interval: "
         "0.07},\n"
         "     output: [csv], seeds: {points: [[1.5, 1.5, 1.5], [3.1, 1, 2.4]]}}\n"
         "  - {name: walls, velocity: v, fields: [s], kind: pathline, times: {interval: 0.07},\n"
         "     output: [csv], effects: [{boundary: {other: slide}}, {settling: {speed: 0.2}},\n"
         "     {diffusion: {coefficient: 0.01}}], " +
         from +
         "}\n"
         "  - {name: far, velocity: v, fields: [s], kind: pathline, output: [csv],\n"
         "     integrator: {method: rk4, step: 0.8}, effects: [{boundary: {other: reflect}}], " +
         from + "}\n";
}

/// What a solver does: the grids that it goes through, and whether its leaves are dealt anew.
struct Solver {
  std::vector<AmrMesh> grids;
  insitu_reconstruction how;
  bool regrids;

  std::map<std::string, std::string> files(int processes, int deal,
                                           const std::string& seeds) const {
    const std::string scene = scene_from(seeds, how);
    const OwnFolder folder;
    const std::string out = folder / "out";
    run_processes(processes, [&](parallel::World& world) {
      AmrSession process(world, grids[0], how, random_deal(deal, processes), scene, out);
      for (int cycle = 0; cycle < 4; ++cycle) {
        // The same grid in another deal, then another grid.
        if (regrids && (cycle == 1 || cycle == 2))
          process.give(world, grids[cycle == 2 ? 1 : 0], how,
                       random_deal(deal + 1000 * cycle, processes));
        EXPECT_EQ(process.execute(cycle), "");
      }
      EXPECT_EQ(process.session().finish(), "");
    });
    return files_of(out);
  }
};

/// Over 4 and 8 processes; of a deal that differs the first seed is named that differs alone.
void expect_one_in_any_deal(const Solver& run, const std::string& what, int deals) {
  const std::string all = seeds(0, seed_count);
  const auto expected = run.files(1, 0, all);
  EXPECT_EQ(expected.size(), run.how == INSITU_NEAREST ? 4u : 8u);
  for (const int processes : {4, 8})
    for (int deal = 1; deal <= deals; ++deal) {
      const auto found = run.files(processes, deal, all);
      if (found == expected)
        continue;
      std::string smallest = "no seed alone";
      for (int i = 0; i < seed_count; ++i) {
        const std::string seed = seeds(i, i + 1);
        if (run.files(1, 0, seed) != run.files(processes, deal, seed)) {
          smallest = "seed " + seed + " alone";
          break;
        }
      }
      expect_same(expected, found,
                  what + ", deal of seed " + std::to_string(deal) + " on " +
                      std::to_string(processes) + ", and " + smallest);
    }
}

} // namespace

TEST(ProcessAdaptiveDeals, TracersOnLeavesDealtAtRandom) {
  expect_one_in_any_deal({{octree()}, INSITU_DUAL, false}, "octree", 2);
  expect_one_in_any_deal({{patches()}, INSITU_DUAL, false}, "patches", 2);
  expect_one_in_any_deal({{octree()}, INSITU_NEAREST, false}, "octree by nearest", 1);
}

/// The leaves are dealt anew, and the grid becomes another one, between the cycles.
TEST(ProcessAdaptiveDeals, TracersOverRegridsDealtAtRandom) {
  for (const insitu_reconstruction how : {INSITU_DUAL, INSITU_NEAREST}) {
    const std::string by = how == INSITU_DUAL ? " by dual" : " by nearest";
    expect_one_in_any_deal({{octree(), patches()}, how, true}, "octree" + by, 3);
    expect_one_in_any_deal({{patches(), octree()}, how, true}, "patches" + by, 1);
  }
}

/// What lines are traced together does not change any of them.
TEST(ProcessAdaptiveDeals, ALineAloneIsTheOneAmongOthers) {
  const auto lines_of = [](const Solver& run, const std::string& seeds) {
    std::istringstream text(run.files(1, 0, seeds).at("lines_000002.csv"));
    std::map<int, std::string> lines; // without their numbers
    std::string row;
    std::getline(text, row);
    while (std::getline(text, row))
      lines[std::stoi(row)] += row.substr(row.find(',')) + "\n";
    return lines;
  };
  for (const AmrMesh& whole : {octree(), patches()}) {
    const Solver run{{whole}, INSITU_DUAL, false};
    const auto together = lines_of(run, seeds(0, seed_count));
    ASSERT_EQ(together.size(), std::size_t(seed_count));
    for (int i = 0; i < seed_count; i += 3)
      EXPECT_EQ(lines_of(run, seeds(i, i + 1)).at(0), together.at(i)) << "line " << i;
  }
}
