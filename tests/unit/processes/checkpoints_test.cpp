// Runs over processes that stop and go on from a checkpoint, on as many processes or on others.
#include <cmath>
#include <csignal>
#include <sstream>
#include <sys/resource.h>

#include "part_session.h"

using namespace insitu;
using namespace insitu::test;

namespace {

constexpr int cycles = 7;

const std::string whole_scene =
    "insitu: 1\npage: false\n"
    "probes:\n"
    "  - {name: gauges, points: [[1, 1, 1], [2.1, 3.3, 0.7], [9, 9, 9]], fields: [p, c], every: 2, "
    "output: [csv, netcdf]}\n"
    "  - {name: marks, attached: body, points: [[1, 1, 1], [2.1, 3.3, 0.7], [9, 9, 9], [4.4, 4.2, "
    "4.9]], fields: [u], output: [csv, netcdf]}\n"
    "tracers:\n"
    "  - {name: paths, velocity: u, seeds: {box: {min: [0.5, 0.5, 0.5], max: [5.5, 4.5, 4.5], "
    "counts: [5, 4, 3]}}, fields: [p, c], output: [csv, vtp, netcdf], every: 2}\n"
    "  - {name: curved, velocity: u, time_interpolation: cubic, seeds: [[1.3, 2.2, 3.1], [3, 3, "
    "3]], effects: [{windage: {field: u, factor: 0.1}}]}\n"
    "  - {name: streaks, velocity: u, kind: streakline, seeds: {points: [[1, 1, 1], [3.1, 2.2, "
    "2.7]]}, until: {duration: 0.6}, times: {interval: 0.11}, fields: [p], output: [csv, vtp, "
    "netcdf]}\n"
    "  - {name: walkers, velocity: u, seeds: {box: {min: [1, 1, 1], max: [4, 4, 4], counts: [3, 2, "
    "2]}}, effects: [{boundary: reflect}, {diffusion: {coefficient: 0.02}}], output: [csv]}\n"
    "  - {name: heavy, velocity: u, seeds: {box: {min: [1, 1, 1], max: [4, 4, 4], counts: [3, 2, "
    "2]}}, effects: [{inertia: {response_time: 0.1}}], output: [csv]}\n"
    "  - {name: lines, kind: streamline, velocity: u, seeds: [[2, 2, 2], [9, 9, 9]], until: "
    "{duration: 1}, every: 3}\n"
    "frames:\n"
    "  - {name: seen, size: [24, 24], isosurfaces: [{field: p, values: [2]}], every: 3}\n";

std::vector<Vec3d> vertices_at(const TestMesh& whole, std::int64_t cycle) {
  std::vector<Vec3d> points;
  for (const Vec3d& x : whole.vertices)
    points.push_back(x + 0.03 * double(cycle) * Vec3d{std::sin(x.y), 0.5 * x.z, std::cos(x.x)});
  return points;
}

/// Cycles [from, to) of a solver whose mesh moves.
void go_on(PartSession& process, const TestMesh& whole, int from, int to) {
  for (int cycle = from; cycle < to; ++cycle) {
    if (!process.part().empty())
      process.part().move(process.mesh().mesh(), vertices_at(whole, cycle));
    EXPECT_EQ(process.execute(cycle), "");
  }
}

using Files = std::map<std::string, std::string>;

/// A way for a run to stop and to go on.
struct Stop {
  int after = 2;      ///< the cycle of the checkpoint
  int beyond = 0;     ///< cycles further, that the restart takes back
  bool closed = true; ///< in order; else killed
};

/// A run on one partition to the stop, and on another one from there.
Files interrupted(const TestMesh& whole, const fixtures::Partition& first,
                  const fixtures::Partition& second, PartSession::Options options,
                  const Stop& stop = {}, std::vector<std::string>* messages = nullptr) {
  const OwnFolder folder;
  options.folder = folder / "out";
  const std::string file = folder / "state";
  run_processes(first.processes, [&](parallel::World& world) {
    PartSession process(world, whole, first, options);
    go_on(process, whole, 0, stop.after + 1);
    process.session().checkpoint(file);
    go_on(process, whole, stop.after + 1, stop.after + 1 + stop.beyond);
    if (stop.closed) {
      EXPECT_EQ(process.session().finish(), "");
    }
  });
  run_processes(second.processes, [&](parallel::World& world) {
    PartSession process(world, whole, second, options);
    process.session().restart(file);
    go_on(process, whole, stop.after + 1, cycles);
    EXPECT_EQ(process.session().finish(), "");
    if (messages && world.is_root())
      *messages = process.messages();
  });
  return files_of(options.folder);
}

Files whole_run(const TestMesh& whole, const fixtures::Partition& partition,
                const PartSession::Options& options) {
  return run_parts(whole, partition, options, [&](PartSession& process, parallel::World&) {
    go_on(process, whole, 0, cycles);
  });
}

PartSession::Options with_ids(bool ids) {
  PartSession::Options options;
  options.scene = whole_scene;
  options.ids = ids;
  return options;
}

/// The rows of a table of tracks by cycle and particle: their places.
std::map<std::pair<int, int>, Vec3d> places_of(const std::string& csv) {
  std::map<std::pair<int, int>, Vec3d> places;
  std::istringstream in(csv);
  std::string line, cell;
  std::getline(in, line);
  const std::string head = line.substr(0, line.find(",x,y,z"));
  const auto before = std::ranges::count(head, ',') + 1; // columns
  while (std::getline(in, line)) {
    std::istringstream cells(line);
    std::vector<std::string> row;
    while (std::getline(cells, cell, ','))
      row.push_back(cell);
    const auto at = [&](std::ptrdiff_t i) { return std::stod(row[std::size_t(before + i)]); };
    places[{std::stoi(row[0]), std::stoi(row[2])}] = {at(0), at(1), at(2)};
  }
  return places;
}

} // namespace

/// Without global ids, too: each process has what it had.
TEST(ProcessCheckpoints, OnTheSameProcessesFilesAreThoseOfARunWithoutAStop) {
  const TestMesh whole = jittered_cubes(4);
  for (const bool ids : {true, false})
    for (const fixtures::Partition& partition :
         {fixtures::in_pieces(fixtures::boxes(whole, 3), 2),
          fixtures::with_ghosts(fixtures::boxes(whole, 4)), fixtures::empty_root(whole, 2)}) {
      const Files expected = whole_run(whole, partition, with_ids(ids));
      const std::string what = partition.name + " on " + std::to_string(partition.processes) +
                               (ids ? " with ids" : " without ids");
      expect_same(expected, interrupted(whole, partition, partition, with_ids(ids), {2, 2, false}),
                  what + ", killed");
      expect_same(expected, interrupted(whole, partition, partition, with_ids(ids), {3, 0, true}),
                  what + ", closed");
    }
}

/// With global ids cells are known again, whichever process has them.
TEST(ProcessCheckpoints, OnOtherProcessesFilesAreThoseOfOneProcessToTheByte) {
  const TestMesh whole = jittered_cubes(4);
  const Files expected = whole_run(whole, fixtures::slabs(whole, 1), with_ids(true));
  std::size_t rows = 0;
  for (const auto& [name, text] : expected)
    rows += name.ends_with(".csv") ? std::size_t(std::ranges::count(text, '\n')) : 0;
  EXPECT_GT(rows, 300u);
  using Pair = std::pair<fixtures::Partition, fixtures::Partition>;
  const std::vector<Pair> pairs = {
      {fixtures::slabs(whole, 1), fixtures::slabs(whole, 1)},
      {fixtures::slabs(whole, 1), fixtures::boxes(whole, 3)},
      {fixtures::boxes(whole, 3), fixtures::slabs(whole, 1)},
      {fixtures::slabs(whole, 2), fixtures::boxes(whole, 3)},
      {fixtures::with_ghosts(fixtures::boxes(whole, 4)), fixtures::slabs(whole, 2)},
      {fixtures::slabs(whole, 2), fixtures::dealt(whole, 2)},
      {fixtures::empty_root(whole, 2), fixtures::in_pieces(fixtures::boxes(whole, 3), 3)},
      {fixtures::boxes(whole, 3), fixtures::with_ghosts(fixtures::boxes(whole, 8))},
      {fixtures::boxes(whole, 8), fixtures::slabs(whole, 2)}};
  Stop stop{0, 1, false};
  for (const auto& [first, second] : pairs) {
    expect_same(expected, interrupted(whole, first, second, with_ids(true), stop),
                first.name + " on " + std::to_string(first.processes) + ", " + second.name +
                    " on " + std::to_string(second.processes) + ", stopped at " +
                    std::to_string(stop.after));
    stop.after = (stop.after + 1) % 5; // with fewer steps than the cubic takes, too
    stop.closed = !stop.closed;
  }
}

/// Without ids particles go over the cells' change, as one process's would from cells in another
/// order. Parts of equal numbers that changed hands are not mistaken for what they were.
TEST(ProcessCheckpoints, WithoutIdsOnOtherProcessesTracksAreNear) {
  MeshOptions grid;
  grid.size = 4;
  grid.jitter = 0.0;
  const TestMesh whole = make_mesh(grid, 1);
  const auto slabs = [&](int processes) { return fixtures::slabs(whole, processes); };
  fixtures::Partition swapped = slabs(2);
  for (int& process : swapped.process)
    process = 1 - process;
  PartSession::Options options = with_ids(false);
  options.scene =
      "insitu: 1\npage: false\nprobes:\n"
      "  - {name: marks, attached: body, points: [[1, 1, 1], [2.1, 3.3, 0.7]], fields: [u], "
      "output: "
      "[json]}\n"
      "tracers:\n  - {name: paths, velocity: u, seeds: {box: {min: [1.1, 1.1, 1.1], max: [2.9, "
      "2.9, 2.9], counts: [3, 3, 2]}}, output: [csv]}\n";
  using Places = std::map<std::pair<int, int>, Vec3d>;
  const auto run = [&](const fixtures::Partition& first, const fixtures::Partition& second) {
    std::vector<std::string> messages;
    const Files files = interrupted(whole, first, second, options, {2, 1, false}, &messages);
    for (const std::string& message : messages)
      EXPECT_EQ(message.find("not known again"), std::string::npos) << message;
    return places_of(files.at("paths.csv"));
  };
  // The largest distance; one that is near the mesh's end may leave a cycle earlier.
  const auto difference = [](const Places& a, const Places& b) {
    double most = 0.0;
    std::size_t common = 0;
    for (const auto& [key, place] : a)
      if (const auto at = b.find(key); at != b.end()) {
        const Vec3d by = at->second - place;
        most = std::max(most, std::sqrt(dot(by, by)));
        ++common;
      }
    EXPECT_LE(std::max(a.size(), b.size()), common + 2);
    return most;
  };
  const Places never_stopped = places_of(whole_run(whole, slabs(1), options).at("paths.csv"));
  ASSERT_GT(never_stopped.size(), 60u);
  const Places one = run(slabs(1), fixtures::in_pieces(slabs(1), 2));
  EXPECT_GT(difference(never_stopped, one), 0.0);
  // Particles go about 1 in an interval, in which the cells' change makes 0.05.
  EXPECT_LT(difference(never_stopped, one), 0.1);
  for (const auto& [first, second] :
       {std::pair(slabs(3), slabs(1)), std::pair(slabs(1), slabs(2)),
        std::pair(slabs(2), fixtures::boxes(whole, 3)), std::pair(slabs(2), swapped)})
    EXPECT_LT(difference(one, run(first, second)), 1e-12) // places are about 1
        << first.name << ", " << second.name;
}

/// Files that cannot be taken up: all processes say so alike, and the solver goes on.
TEST(ProcessCheckpoints, WhatIsRefusedIsRefusedByAll) {
  const TestMesh whole = jittered_cubes(3);
  const OwnFolder folder;
  PartSession::Options options = with_ids(true);
  options.folder = folder / "out";
  const std::string file = folder / "state";
  run_processes(2, [&](parallel::World& world) {
    PartSession process(world, whole, fixtures::slabs(whole, 2), options);
    EXPECT_NE(failure_of([&] { process.session().checkpoint(file); }).find("nothing was executed"),
              std::string::npos);
    go_on(process, whole, 0, 2);
    process.session().checkpoint(file);
    EXPECT_NE(failure_of([&] { process.session().restart(file); }).find("executed 2 times"),
              std::string::npos);
    // One process's mesh is changed.
    if (world.rank() == 1)
      process.mesh().mesh().set_changed(INSITU_CHANGED_FIELDS);
    EXPECT_EQ(failure_of([&] {
                process.session().checkpoint(file);
              }).find("process 1 of 2: checkpoint '" + file + "': mesh 'm' was changed"),
              0u);
    EXPECT_EQ(
        failure_of([&] { process.session().checkpoint(file + (world.rank() == 1 ? "_b" : "_a")); }),
        "processes differ: checkpoint '" + file + "_a' on process 0, checkpoint '" + file +
            "_b' on process 1 of 2");
  });
  const std::string good = read_file(file);
  ASSERT_GT(good.size(), 10000u);
  const auto refused = [&](const std::string& content, const std::string& why,
                           const std::string& with = whole_scene) {
    if (!content.empty())
      std::ofstream(file, std::ios::binary) << content;
    options.scene = with;
    options.folder = folder / "other";
    run_processes(3, [&](parallel::World& world) {
      PartSession process(world, whole, fixtures::boxes(whole, 3), options);
      const std::string said = failure_of([&] { process.session().restart(file); });
      EXPECT_EQ(said.find("process 0 of 3: cannot re"), 0u) << said;
      EXPECT_NE(said.find(why), std::string::npos) << said;
      go_on(process, whole, 0, 2);
      EXPECT_EQ(process.session().finish(), "");
    });
    std::filesystem::remove_all(options.folder);
  };
  refused(good.substr(0, good.size() - 1), "bytes after its head");
  refused("cycle,time\n", "it is no checkpoint");
  std::string damaged = good;
  damaged[good.size() / 2] = char(damaged[good.size() / 2] ^ 4);
  refused(damaged, "it is damaged");
  std::string earlier = good;
  earlier[8] = 6;
  refused(earlier, "it is of version 6, version 9 expected");
  std::string other = whole_scene;
  other.replace(other.find("name: heavy"), 11, "name: light");
  refused(good, "'light'", other);
  std::filesystem::remove(file);
  refused("", "No such file");
}

/// The disk is full: all processes say so, the checkpoint before stays, and the next one works.
TEST(ProcessCheckpoints, AFullDiskLeavesTheCheckpointBefore) {
  const TestMesh whole = jittered_cubes(4);
  const OwnFolder folder;
  PartSession::Options options = with_ids(true);
  options.folder = folder / "out";
  const std::string file = folder / "state";
  const auto handler = std::signal(SIGXFSZ, SIG_IGN); // in its place there is an error
  run_processes(3, [&](parallel::World& world) {
    PartSession process(world, whole, fixtures::boxes(whole, 3), options);
    go_on(process, whole, 0, 2);
    process.session().checkpoint(file);
    go_on(process, whole, 2, 3);
    const std::string before = read_file(file);
    rlimit limit{};
    getrlimit(RLIMIT_FSIZE, &limit);
    world.agree_after([&] {
      rlimit full = limit;
      full.rlim_cur = before.size() / 2;
      if (world.is_root())
        setrlimit(RLIMIT_FSIZE, &full);
    });
    const std::string said = failure_of([&] { process.session().checkpoint(file); });
    EXPECT_EQ(said.find("process 0 of 3: cannot write '" + file), 0u) << said;
    world.agree_after([&] {
      if (world.is_root())
        setrlimit(RLIMIT_FSIZE, &limit);
    });
    EXPECT_EQ(read_file(file), before);
    world.agree_after([] {});
    process.session().checkpoint(file);
    EXPECT_NE(read_file(file), before);
    EXPECT_EQ(process.session().finish(), "");
  });
  std::signal(SIGXFSZ, handler);
  for (const auto& [name, text] : files_of(folder / ""))
    EXPECT_EQ(name.find("insitu-part"), std::string::npos) << name;
}

/// A scene's own, of which the last stay; a run goes on from one of them on other processes.
TEST(ProcessCheckpoints, OfTheSceneAreWrittenWhenDueAndOldOnesGo) {
  const TestMesh whole = jittered_cubes(3);
  const OwnFolder folder;
  PartSession::Options options = with_ids(true);
  options.scene += "checkpoint: {every: 2, keep: 2}\n";
  options.folder = folder / "out";
  const auto names = [&] {
    std::string all;
    for (const auto& [name, text] : files_of(options.folder))
      if (name.ends_with(".insitu"))
        all += name + " ";
    return all;
  };
  const std::string last = options.folder + "/checkpoint_000004.insitu";
  run_processes(2, [&](parallel::World& world) {
    PartSession process(world, whole, fixtures::boxes(whole, 2), options);
    go_on(process, whole, 0, 6);
  });
  EXPECT_EQ(names(), "checkpoint_000002.insitu checkpoint_000004.insitu ");
  run_processes(3, [&](parallel::World& world) {
    PartSession process(world, whole, fixtures::slabs(whole, 3), options);
    process.session().restart(last);
    go_on(process, whole, 5, cycles);
    EXPECT_EQ(process.session().finish(), "");
  });
  EXPECT_EQ(names(), "checkpoint_000004.insitu checkpoint_000006.insitu ");
  // But for .vtp, which have no values of particles whose last place the mesh has left.
  const auto without = [](Files files) {
    std::erase_if(files, [](const auto& file) {
      return file.first.ends_with(".insitu") || file.first.ends_with(".vtp");
    });
    return files;
  };
  expect_same(without(whole_run(whole, fixtures::slabs(whole, 1), options)),
              without(files_of(options.folder)), "2, then 3 processes");
}

/// A session that goes on and stops at once, before its particles were dealt, loses none.
TEST(ProcessCheckpoints, ARestartThatExecutesNothingEndsAllParticles) {
  const TestMesh whole = jittered_cubes(3);
  const OwnFolder folder;
  PartSession::Options options = with_ids(true);
  options.folder = folder / "out";
  const std::string file = folder / "state";
  std::string rows;
  for (const int processes : {2, 3})
    run_processes(processes, [&](parallel::World& world) {
      PartSession process(world, whole, fixtures::boxes(whole, processes), options);
      if (processes == 2) {
        go_on(process, whole, 0, 3);
        process.session().checkpoint(file);
      } else {
        process.session().restart(file);
        std::int64_t seeded = process.session().report().particles_seeded;
        world.reduce(std::span(&seeded, 1), parallel::Reduction::sum);
        EXPECT_GT(seeded, 80);
      }
      EXPECT_EQ(process.session().finish(), "");
      world.agree_after([] {});
      if (world.is_root()) {
        const std::string now = read_file(options.folder + "/heavy.csv");
        EXPECT_TRUE(rows.empty() || rows == now) << rows << "-----\n" << now;
        rows = now;
      }
    });
}
