// Runs in longitude and latitude over processes that stop and go on from a checkpoint.
#include "earths.h"
#include "part_session.h"

using namespace insitu;
using namespace insitu::test;

/// A run that stops and goes on, on as many processes or on others: with the same cells, known by
/// ids or by their numbers, or with others in the first cycle.
TEST(ProcessEarth, RestartsAreThoseOfOneProcessWithoutAStop) {
  const std::vector<Earth> all = earths();
  const std::string scene =
      "insitu: 1\npage: false\nprobes:\n"
      "  - {name: marks, attached: body, points: [[180, 10, -0.05], [-40, 85, -0.07], [10, -89.9, "
      "-1], [150, 20, -1]], fields: [p], output: [csv]}\n" +
      tracers_and_walls;
  constexpr int stop = 2, end = 4;
  struct Run {
    const Earth *before, *after; ///< the stop
    int first, second;           ///< processes, 0: it does not stop
    bool ids = true;
  };
  const auto files = [&](const Run& run) {
    const OwnFolder folder;
    PartSession::Options options;
    options.frame = fixtures::frame_of(units);
    options.scene = scene;
    options.folder = folder / "out";
    options.ids = run.ids;
    const auto cut = [&](const TestMesh& mesh, int processes) {
      return processes == 3 ? fixtures::empty_root(mesh, 3) : fixtures::boxes(mesh, processes);
    };
    const auto go = [&](int processes, int from, int to) {
      run_processes(processes, [&](parallel::World& world) {
        const TestMesh& begun = (from < stop ? run.before : run.after)->mesh;
        PartSession process(world, begun, cut(begun, processes), options);
        if (from > 0)
          process.session().restart(folder / "state");
        for (int cycle = from; cycle < to; ++cycle) {
          const TestMesh& mesh = (cycle < stop ? run.before : run.after)->mesh;
          if (cycle == stop && from < stop && run.before != run.after)
            process.deal(cut(mesh, processes), world.rank(), &mesh);
          if (!process.part().empty())
            process.part().give_field(process.mesh().mesh(), "w", INSITU_VERTEX, 3,
                                      flow(mesh, cycle));
          EXPECT_EQ(process.execute(cycle), "");
        }
        if (to < end)
          process.session().checkpoint(folder / "state");
        EXPECT_EQ(process.session().finish(), "");
        for (const std::string& message : process.messages())
          EXPECT_EQ(message.find("not known again"), std::string::npos) << message;
      });
    };
    go(run.first, 0, run.second ? stop : end);
    if (run.second)
      go(run.second, stop, end);
    return files_of(options.folder);
  };
  for (const auto& [from, to] : {std::pair(0, 0), std::pair(1, 1), std::pair(2, 2), std::pair(3, 3),
                                 std::pair(3, 1), std::pair(1, 3)}) {
    const Earth &before = all[std::size_t(from)], &after = all[std::size_t(to)];
    const auto expected = files({&before, &after, 1, 0});
    EXPECT_NE(expected.at("paths.csv").find("killed"), std::string::npos);
    for (const auto& [first, second] : {std::pair(1, 1), std::pair(1, 4), std::pair(2, 2),
                                        std::pair(2, 3), std::pair(3, 2), std::pair(4, 1)})
      expect_same(expected, files({&before, &after, first, second}),
                  before.name + " to " + after.name + ", " + std::to_string(first) + " to " +
                      std::to_string(second));
    if (from == to) // each process has what it had
      expect_same(files({&before, &after, 4, 0, false}), files({&before, &after, 4, 4, false}),
                  before.name + " without ids");
  }
}
