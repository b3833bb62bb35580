// Runs of adaptive meshes that stop and go on from a checkpoint, on as many processes or on others:
// their files are those of one process without a stop, to the byte.
#include "amr_meshes.h"
#include "amr_session.h"

using namespace insitu;
using namespace insitu::test;

namespace {

using Files = std::map<std::string, std::string>;

constexpr int cycles = 6;

/// Grids that follow each other; the second cycle and the fourth one begin with a regrid.
struct Case {
  std::vector<AmrMesh> grids;
  insitu_reconstruction how;
  std::string scene;

  const AmrMesh& grid(int cycle) const { return grids[std::size_t(cycle / 2) % grids.size()]; }
  static bool is_regrid(int cycle) { return cycle > 0 && cycle % 2 == 0; }
};

struct Size {
  int processes, kind; ///< deal_of()
  Deal deal() const { return deal_of(kind, processes); }
};

std::string scene_of(const AmrMesh& mesh) {
  const bool is_flat = mesh.lattice.is_flat != 0;
  const std::string seeds =
      is_flat ? "{box: {min: [0.3, 0.3, 0], max: [3.7, 3.7, 0], counts: [6, 6, 1]}}"
              : "{box: {min: [0.3, 0.3, 0.3], max: [3.7, 3.7, 3.7], counts: [4, 4, 4]}}";
  return "insitu: 1\npage: false\ntracers:\n"
         "  - {name: paths, velocity: v, fields: [s, v], output: [csv], seeds: " +
         seeds +
         "}\n"
         "  - {name: times, velocity: v, times: {interval: 0.07}, fields: [s], seeds: " +
         seeds +
         ", output: [csv]}\n"
         "  - {name: sliding, velocity: v, fields: [s], seeds: " +
         seeds + ", effects: [{boundary: {other: slide}}], output: [csv]}\n";
}

void go_on(AmrSession& process, parallel::World& world, const Case& c, const Size& size, int from,
           int to) {
  for (int cycle = from; cycle < to; ++cycle) {
    if (Case::is_regrid(cycle) && cycle > from)
      process.give(world, c.grid(cycle), c.how, size.deal());
    EXPECT_EQ(process.execute(cycle), "");
  }
}

/// The cycle `stop` is the first one after the restart; 0: no stop.
Files run(const Case& c, const Size& first, const Size& then = {1, 0}, int stop = 0) {
  const OwnFolder folder;
  const std::string out = folder / "out", state = folder / "state";
  run_processes(first.processes, [&](parallel::World& world) {
    AmrSession process(world, c.grid(0), c.how, first.deal(), c.scene, out);
    go_on(process, world, c, first, 0, stop ? stop : cycles);
    if (stop)
      process.session().checkpoint(state);
    EXPECT_EQ(process.session().finish(), "");
  });
  if (stop)
    run_processes(then.processes, [&](parallel::World& world) {
      AmrSession process(world, c.grid(stop), c.how, then.deal(), c.scene, out);
      process.session().restart(state);
      go_on(process, world, c, then, stop, cycles);
      EXPECT_EQ(process.session().finish(), "");
    });
  return files_of(out);
}

/// Other processes than those that stopped go on before a regrid; cells of an adaptive mesh that
/// are dealt otherwise and the same are not known again.
void expect_whole(const std::vector<AmrMesh>& grids, insitu_reconstruction how,
                  const std::vector<std::pair<Size, Size>>& sizes) {
  const Case c{grids, how, scene_of(grids.front())};
  const Files whole = run(c, {1, 0});
  std::string all;
  for (const auto& [name, text] : whole)
    all += text;
  EXPECT_GT(std::ranges::count(all, '\n'), 300);
  for (const auto& [first, then] : sizes)
    for (int stop = 1; stop < cycles; ++stop)
      if (Case::is_regrid(stop) || first.processes == then.processes)
        expect_same(whole, run(c, first, then, stop),
                    (how == INSITU_DUAL ? "dual" : "nearest") + std::string(", stopped before ") +
                        std::to_string(stop) + ", " + std::to_string(first.processes) + " to " +
                        std::to_string(then.processes));
}

const std::vector<std::pair<Size, Size>> one_and_others{
    {{1, 0}, {1, 0}}, {{2, 0}, {2, 0}}, {{1, 0}, {3, 1}}, {{3, 0}, {2, 0}}, {{3, 0}, {1, 0}}};

} // namespace

TEST(ProcessAdaptiveRestarts, OfQuadtreesAndFlatPatches) {
  for (const insitu_reconstruction how : {INSITU_DUAL, INSITU_NEAREST})
    expect_whole({quadtree(false), flat_patches()}, how, one_and_others);
}

TEST(ProcessAdaptiveRestarts, OfOctreesAndPatches) {
  for (const insitu_reconstruction how : {INSITU_DUAL, INSITU_NEAREST})
    expect_whole({octree(), patches()}, how, one_and_others);
}

/// Cubes in gridlets, and where most cells stitch none.
TEST(ProcessAdaptiveRestarts, OfLargerGrids) {
  const std::vector<std::pair<Size, Size>> sizes{
      {{1, 0}, {1, 0}}, {{2, 0}, {1, 0}}, {{2, 0}, {3, 0}}};
  expect_whole({refined_block(3), refined_block(6), refined_block(8)}, INSITU_DUAL, sizes);
  expect_whole({checkers(0), checkers(1)}, INSITU_DUAL, {{{1, 0}, {1, 0}}, {{2, 0}, {3, 0}}});
}

/// Grids of as many leaves, in the same order, in other places: the step before is not theirs.
TEST(ProcessAdaptiveRestarts, OfGridsThatMove) {
  AmrMesh there = flat_patches(), here = there;
  for (AmrPiece& patch : there.pieces)
    if (patch.level == 2)
      for (std::size_t a = 0; a < 2; ++a)
        patch.lower[a] += 4;
  for (const insitu_reconstruction how : {INSITU_DUAL, INSITU_NEAREST})
    expect_whole({here, there}, how, {{{1, 0}, {1, 0}}, {{2, 0}, {2, 0}}});
}
