// A step of which something failed, and that the solver executes once more: the files of a run
// without the failure.
#include <chrono>
#include <cmath>
#include <thread>

#include "fixtures/small_disk.h"
#include "part_session.h"

using namespace insitu;
using namespace insitu::test;

namespace {

constexpr int cycles = 6;
using Files = std::map<std::string, std::string>;

/// Something in the way of the files of a folder, for a while.
struct Trouble {
  std::string name;
  std::function<void(const std::string&folder)> begin, end;
};

/// Folders where files are to be.
Trouble in_the_way(const std::vector<std::string>& files) {
  std::string name = "a folder in the place of";
  for (const std::string& file : files)
    name += " " + file;
  return {name,
          [files](const std::string& folder) {
            for (const std::string& file : files)
              std::filesystem::create_directories(folder + "/" + file);
          },
          [files](const std::string& folder) {
            for (const std::string& file : files)
              std::filesystem::remove(folder + "/" + file);
          }};
}

Trouble full_disk(std::size_t bytes) {
  const auto disk = std::make_shared<std::optional<SmallDisk>>();
  return {"files of " + std::to_string(bytes) + " bytes at most",
          [=](const std::string&) { disk->emplace(bytes); },
          [=](const std::string&) { disk->reset(); }};
}

struct Run {
  std::string scene;
  bool moves = false;   ///< the vertices
  int other_cells = -1; ///< at this cycle
};

struct Done {
  Files files;
  std::vector<std::int64_t> told; ///< rows, frames, particles by ending
};

/// Processes that go through a step: the root makes trouble, all execute, the root ends it, and all
/// execute once more.
class Solver {
public:
  Solver(const Run& run, int processes) : run_(run), processes_(processes) {}

  /// trouble: at that cycle, so many times; -1: none.
  Done go(int at = -1, const Trouble& trouble = {}, int times = 1) const {
    return go(
        [&](PartSession& process, parallel::World& world, int cycle, const std::string& folder) {
          for (int k = 0; cycle == at && k < times; ++k) {
            at_root(world, [&] { trouble.begin(folder); });
            EXPECT_NE(process.execute(cycle), "") << trouble.name << ", cycle " << cycle;
            at_root(world, [&] { trouble.end(folder); });
          }
          EXPECT_EQ(process.execute(cycle), "") << trouble.name << ", cycle " << cycle;
        });
  }

  Done go(const std::function<void(PartSession&, parallel::World&, int cycle,
                                   const std::string& folder)>& step) const {
    const OwnFolder folder;
    PartSession::Options options;
    options.scene = run_.scene;
    options.folder = folder / "out";
    Done done;
    run_processes(processes_, [&](parallel::World& world) {
      PartSession process(world, whole_, fixtures::boxes(whole_, processes_), options);
      for (int cycle = 0; cycle < cycles; ++cycle) {
        give(process, world, cycle);
        step(process, world, cycle, options.folder);
      }
      EXPECT_EQ(process.session().finish(), "");
      const insitu_report report = process.session().report();
      if (!world.is_root())
        return;
      done.told = {report.probe_rows, report.frames, report.particles_seeded};
      done.told.insert(done.told.end(), report.particles, report.particles + report.endings);
    });
    done.files = files_of(options.folder);
    return done;
  }

  void expect(const Done& expected, const Done& found, const std::string& what) const {
    expect_same(expected.files, found.files, what + ", processes: " + std::to_string(processes_));
    EXPECT_EQ(expected.told, found.told) << what;
  }

  static void at_root(parallel::World& world, const std::function<void()>& act) {
    world.agree_after([&] {
      if (world.is_root())
        act();
    });
  }

private:
  /// The solver's mesh at a cycle.
  void give(PartSession& process, parallel::World& world, int cycle) const {
    if (cycle == run_.other_cells)
      process.deal(fixtures::slabs(other_, processes_), world.rank(), &other_);
    if (!run_.moves || process.part().empty())
      return;
    const bool is_other = run_.other_cells >= 0 && cycle >= run_.other_cells;
    std::vector<Vec3d> points;
    for (const Vec3d& x : (is_other ? other_ : whole_).vertices)
      points.push_back(x + 0.03 * double(cycle) * Vec3d{std::sin(x.y), 0.5 * x.z, std::cos(x.x)});
    process.part().move(process.mesh().mesh(), points);
  }

  const Run run_;
  const int processes_;
  const TestMesh whole_ = jittered_cubes(4);
  const TestMesh other_ = [] {
    MeshOptions options;
    options.size = 4;
    options.jitter = 0.1;
    options.kind = MeshKind::tetrahedra;
    return make_mesh(options, 5);
  }();
};

const std::string head = "insitu: 1\npage: false\n";

const std::string probes =
    "probes:\n"
    "  - {name: gauges, points: {line: {from: [0.5, 1, 1], to: [3.5, 3, 3], count: 40}}, fields: "
    "[p, c], output: [csv, vtp, json, netcdf]}\n"
    "  - {name: few, points: [[1, 1, 1]], fields: [p], output: [csv, netcdf]}\n"
    "  - {name: marks, attached: body, points: [[1, 1, 1], [2.1, 3.3, 0.7], [9, 9, 9]], fields: "
    "[u], output: [csv, netcdf], every: 2}\n";

const std::string box = "seeds: {box: {min: [0.5, 0.5, 0.5], max: [4.4, 3.5, 3.5], counts: [4, 3, "
                        "2]}}, fields: [p, c]";

const std::string tracers =
    "tracers:\n"
    "  - {name: paths, velocity: u, output: [csv, vtp, netcdf], " +
    box +
    "}\n"
    "  - {name: timed, velocity: u, output: [csv, vtp, netcdf], times: {interval: 0.06}, "
    "time_interpolation: cubic, " +
    box +
    "}\n"
    "  - {name: every, velocity: u, kind: streakline, output: [csv, vtp, netcdf], every: 2, "
    "release: {every: 1}, until: {duration: 0.6}, " +
    box +
    "}\n"
    "  - {name: often, velocity: u, kind: streakline, output: [csv, netcdf], release: {interval: "
    "0.1}, time_interpolation: quadratic, " +
    box +
    "}\n"
    "  - {name: heavy, velocity: u, output: [csv], effects: [{inertia: {response_time: 0.1}}, "
    "{boundary: {other: slide}}], " +
    box +
    "}\n"
    "  - {name: walkers, velocity: u, output: [csv], effects: [{boundary: reflect}, {diffusion: "
    "{coefficient: 0.02}}], " +
    box +
    "}\n"
    "  - {name: carried, attached: body, kind: streakline, output: [csv, netcdf], release: {every: "
    "1}, times: {interval: 0.1}, " +
    box +
    "}\n"
    "  - {name: lines, kind: streamline, velocity: u, output: [csv, vtp], until: {duration: 1}, " +
    box + "}\n";

const std::string frames =
    "frames:\n"
    "  - {name: a, size: [24, 20], images: [color, depth], isosurfaces: [{field: p, values: [1]}],"
    " camera: {orbit: {azimuth_per_frame: 20}}}\n"
    "  - {name: b, size: [20, 24], boundary: {color: {field: c}}, cameras: {side: {azimuth: 90}, "
    "top: {elevation: 80}}}\n"
    "  - {name: c, size: [16, 16], volume: {field: p}, lights: [{dome: true}], effects: "
    "[multiple_scattering], path_tracing: {samples: 2, accumulate: true}}\n";

const std::string state = "checkpoint: {every: 1, keep: 9}\n";

/// Each trouble at the first step and at a later one.
void expect_files_of_no_trouble(const Run& run, const std::vector<Trouble>& first,
                                const std::vector<Trouble>& later, int at = 3) {
  for (const int processes : {1, 2}) {
    const Solver solver(run, processes);
    const Done expected = solver.go();
    EXPECT_FALSE(expected.files.empty());
    for (const Trouble& trouble : first)
      solver.expect(expected, solver.go(0, trouble), trouble.name + ", cycle 0");
    for (const Trouble& trouble : later)
      solver.expect(expected, solver.go(at, trouble), trouble.name);
    solver.expect(expected, solver.go(at, later.front(), 2), later.front().name + ", twice");
  }
}

} // namespace

TEST(Retry, Probes) {
  expect_files_of_no_trouble(
      {head + state + probes},
      {full_disk(0), full_disk(2500), in_the_way({"gauges.csv"}), in_the_way({"gauges.nc"}),
       in_the_way({"marks.csv", "gauges_000000.json"}), in_the_way({"few.csv", "few.nc"})},
      {full_disk(0), full_disk(2500), full_disk(9000), in_the_way({"gauges_000003.json"}),
       in_the_way({"gauges_000003.vtp"}), in_the_way({"checkpoint_000003.insitu"})});
}

TEST(Retry, Tracers) {
  expect_files_of_no_trouble(
      {head + state + tracers},
      {full_disk(0), full_disk(3000), in_the_way({"paths.csv"}), in_the_way({"timed.nc"}),
       in_the_way({"often.csv", "every.nc", "carried.csv", "paths_tracks.vtp"}),
       in_the_way({"lines_000000.csv"})},
      {full_disk(0), full_disk(6000), full_disk(15000), in_the_way({"paths_000003.vtp"}),
       in_the_way({"timed_t000011.vtp", "lines_000003.vtp"}),
       in_the_way({"checkpoint_000003.insitu"})});
}

TEST(Retry, TracersOfMovingVertices) {
  expect_files_of_no_trouble({head + tracers, true}, {in_the_way({"timed.csv", "often.nc"})},
                             {in_the_way({"timed_t000011.vtp", "lines_000003.vtp"}), full_disk(0)});
}

/// The step that fails has other cells than the step before, or the step after it has.
TEST(Retry, TracersOverAChangeOfCells) {
  for (const int other : {3, 4})
    expect_files_of_no_trouble(
        {head + tracers, other == 3, other}, {},
        {in_the_way({"timed_t000011.vtp", "lines_000003.vtp"}), full_disk(0)});
}

TEST(Retry, Frames) {
  expect_files_of_no_trouble({head + frames},
                             {in_the_way({"a_000000.png"}), in_the_way({"b_side_000000.png"})},
                             {in_the_way({"a_000003.png"}), in_the_way({"b_top_000003.png"}),
                              in_the_way({"a_depth_000003.png", "c_000003.png"}), full_disk(0),
                              full_disk(700), full_disk(1000)});
}

/// What fails before particles move: a field that is missing, and given then.
TEST(Retry, AFieldThatIsGivenThen) {
  for (const bool moves : {false, true})
    for (const char* const field : {"u", "p"})
      for (const int processes : {1, 2}) {
        const Solver solver({head + state + probes + tracers + frames, moves}, processes);
        const Done expected = solver.go();
        for (const bool one_process_lacks_it : {false, true}) {
          const Done found = solver.go(
              [&](PartSession& process, parallel::World& world, int cycle, const std::string&) {
                if (cycle == 3) {
                  process.give_fields(cycle);
                  if (!one_process_lacks_it || world.rank() == processes - 1)
                    process.part().remove_field(process.mesh().mesh(), field);
                  EXPECT_NE(process.session().execute(cycle, 0.25 * cycle), "");
                }
                EXPECT_EQ(process.execute(cycle), "");
              });
          solver.expect(expected, found, field);
        }
      }
}

/// Of what the step had written nothing is written again.
TEST(Retry, FilesThatWereWrittenAreNotWrittenAgain) {
  using std::filesystem::file_time_type;
  const std::vector<std::string> written = {"gauges_000003.json", "gauges.csv", "few.nc",
                                            "a_000003.png"};
  for (const int processes : {1, 2}) {
    const Solver solver({head + probes + frames}, processes);
    const Trouble trouble = in_the_way({"gauges_000003.vtp", "b_top_000003.png"});
    std::vector<file_time_type> before;
    solver.go([&](PartSession& process, parallel::World& world, int cycle, const std::string& out) {
      const auto at_cycle = [&](const std::function<void()>& act) {
        if (cycle == 3)
          Solver::at_root(world, act);
      };
      const auto times = [&] {
        std::vector<file_time_type> of;
        for (const std::string& file : written)
          of.push_back(std::filesystem::last_write_time(out + "/" + file));
        return of;
      };
      if (cycle == 3) {
        Solver::at_root(world, [&] { trouble.begin(out); });
        EXPECT_NE(process.execute(cycle), "");
      }
      at_cycle([&] {
        trouble.end(out);
        before = times();
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
      });
      EXPECT_EQ(process.execute(cycle), "");
      at_cycle([&] { EXPECT_EQ(times(), before) << processes << " processes"; });
    });
  }
}

/// A step that was done in whole and is executed once more is executed in whole, and one of the
/// same cycle at another time, too.
TEST(Retry, WhatWasDoneIsNoRetry) {
  const Solver solver({head + probes}, 2);
  const Done once = solver.go();
  const Done twice = solver.go(
      [](PartSession& process, parallel::World& world, int cycle, const std::string& out) {
        if (cycle != 2) {
          EXPECT_EQ(process.execute(cycle), "");
          if (cycle == 1) {
            EXPECT_EQ(process.execute(cycle), "");
          }
          return;
        }
        Solver::at_root(world, [&] { in_the_way({"gauges_000002.vtp"}).begin(out); });
        EXPECT_NE(process.session().execute(cycle, 0.5), "");
        Solver::at_root(world, [&] { in_the_way({"gauges_000002.vtp"}).end(out); });
        EXPECT_EQ(process.session().execute(cycle, 0.6), "");
      });
  const auto rows = [](const Done& done) {
    return std::ranges::count(done.files.at("few.csv"), '\n');
  };
  EXPECT_EQ(rows(twice), rows(once) + 2);
}

/// It tells of both executions.
TEST(Retry, OnThePageAStepHasOneEntry) {
  const OwnFolder folder;
  const TestMesh whole = jittered_cubes(3);
  run_processes(2, [&](parallel::World& world) {
    PartSession::Options options;
    options.scene = "insitu: 1\n" + probes + frames;
    options.folder = folder / "out";
    PartSession process(world, whole, fixtures::boxes(whole, 2), options);
    const Trouble trouble = in_the_way({"gauges_000001.json", "a_000001.png"});
    for (int cycle = 0; cycle < 3; ++cycle) {
      if (cycle == 1) {
        Solver::at_root(world, [&] { trouble.begin(options.folder); });
        EXPECT_NE(process.execute(cycle), "");
        Solver::at_root(world, [&] { trouble.end(options.folder); });
      }
      EXPECT_EQ(process.execute(cycle), "");
    }
    EXPECT_EQ(process.session().finish(), "");
  });
  const std::string page = read_file(folder / "out/run.js");
  const auto count = [&](const std::string& text) {
    std::size_t found = 0;
    for (std::size_t at = 0; (at = page.find(text, at)) != std::string::npos; ++at)
      ++found;
    return found;
  };
  EXPECT_EQ(std::ranges::count(page, '\n'), 1 + 3 + 1) << page; // head, cycles, end
  EXPECT_EQ(count("{\"cycle\":1,"), 1u) << page;
  EXPECT_EQ(count("a_000001.png\""), 1u) << page;
  EXPECT_EQ(count("\"failures\":2"), 1u) << page;
  EXPECT_EQ(count("\"executions\":2"), 1u) << page;
  EXPECT_EQ(count("{\"name\":\"gauges\""), 3u) << page;
  EXPECT_EQ(count("numbers of cycles come again"), 0u) << page;
}
