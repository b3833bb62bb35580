// Records of several processes, replayed by one: the files of the run, to the byte.
#include <csignal>
#include <sys/resource.h>

#include "insitu/insitu.hpp"

#include "part_session.h"
#include "records/meshes.h"
#include "solvers.h"

using namespace insitu;
using namespace insitu::test;

namespace {

constexpr int cycles = 4;

const std::string begin = "insitu: 1\npage: false\nrecord: {every: 1}\n";
const std::string recorded_scene =
    begin +
    "probes:\n"
    "  - {name: gauges, points: [[1, 1, 1], [2.1, 3.3, 0.7], [2, 2, 2], [9, 9, 9]], fields: [p, "
    "c], "
    "output: [csv, netcdf]}\n"
    "tracers:\n"
    "  - {name: paths, velocity: u, seeds: {box: {min: [0.5, 0.5, 0.5], max: [3.5, 3.5, 3.5], "
    "counts: [3, 3, 3]}}, fields: [p, c], output: [csv, vtp]}\n"
    "frames:\n"
    "  - {name: seen, size: [24, 24], isosurfaces: [{field: c, values: [0.5]}]}\n"
    "  - {name: inside, size: [24, 24], volume: {field: p}}\n";

using Files = std::map<std::string, std::string>;

/// Without the records.
Files without_records(Files files) {
  std::erase_if(files,
                [](const auto& file) { return file.first.find(".hdf") != std::string::npos; });
  return files;
}

/// What is replayed from the records in a folder.
Files replayed(const std::string& scene, const std::string& folder, const std::string& to) {
  insitu_replay::RecordedMeshes meshes; // outlives the session, which reads its arrays
  Options options;
  options.scene_text = scene;
  options.output = to;
  options.threads = 1;
  Session session(options);
  for (int cycle = 0; cycle < cycles; ++cycle) {
    const insitu_replay::Record record =
        meshes.give(session, folder + "/record_00000" + std::to_string(cycle) + ".hdf");
    EXPECT_EQ(record.cycle, cycle);
    EXPECT_TRUE(session.execute(record.cycle, record.time));
  }
  session.close();
  return without_records(files_of(to));
}

} // namespace

TEST(ProcessRecords, AreReplayedByOneProcessToTheByte) {
  MeshOptions grid;
  grid.size = 4;
  const TestMesh whole = make_mesh(grid, 3);
  Files expected;
  std::vector<fixtures::Partition> partitions = fixtures::partitions(whole, 3);
  partitions.insert(partitions.begin(), fixtures::slabs(whole, 1));
  for (const fixtures::Partition& partition : partitions) {
    const OwnFolder folder;
    PartSession::Options options;
    options.scene = recorded_scene;
    options.folder = folder / "out";
    run_processes(partition.processes, [&](parallel::World& world) {
      PartSession process(world, whole, partition, options);
      for (int cycle = 0; cycle < cycles; ++cycle) {
        std::vector<Vec3d> points = whole.vertices;
        for (Vec3d& x : points)
          x += 0.03 * cycle * Vec3d{std::sin(x.y), 0.5 * x.z, std::cos(x.x)};
        if (!process.part().empty())
          process.part().move(process.mesh().mesh(), points);
        EXPECT_EQ(process.execute(cycle), "");
      }
      EXPECT_EQ(process.session().finish(), "");
    });
    const Files live = without_records(files_of(options.folder));
    if (expected.empty())
      expected = live;
    EXPECT_GT(live.size(), 8u);
    expect_same(live, replayed(recorded_scene, options.folder, folder / "again"), partition.name);
    expect_same(expected, live, partition.name + ", live");
  }
}

/// Cells given by faces that move, flat cells, blocks of all kinds and an adaptive mesh.
TEST(ProcessRecords, OfAllKindsOfMeshesAreReplayedByOneProcessToTheByte) {
  for (const SolverKind& kind : solver_kinds()) {
    Files expected;
    for (const int processes : {1, 4}) {
      const OwnFolder folder;
      const std::string out = folder / "out", scene = begin + kind.actions;
      run_processes(processes, [&](parallel::World& world) {
        SolverSession process(world, scene, out);
        process.take(kind.make(processes, world.rank()));
        for (int cycle = 0; cycle < cycles; ++cycle)
          EXPECT_EQ(process.execute(cycle), "");
        EXPECT_EQ(process.session().finish(), "");
      });
      const std::string which = kind.name + " on " + std::to_string(processes);
      const Files live = without_records(files_of(out));
      if (expected.empty())
        expected = live;
      EXPECT_GT(live.size(), 8u);
      expect_same(expected, live, which + ", live");
      expect_same(live, replayed(scene, out, folder / "again"), which);
    }
  }
}

/// The disk is full: all processes say so, the record before stays, and the next one works. The
/// sizes stop the writing in the midst of arrays, and where HDF5 writes its own tables at the end.
TEST(ProcessRecords, AFullDiskLeavesTheRecordBefore) {
  MeshOptions grid;
  grid.size = 4;
  const TestMesh whole = make_mesh(grid, 3);
  const OwnFolder folder;
  PartSession::Options options;
  options.scene = "insitu: 1\npage: false\n";
  options.folder = folder / "out";
  const std::string file = folder / "state.hdf";
  const auto handler = std::signal(SIGXFSZ, SIG_IGN); // in its place there is an error
  run_processes(3, [&](parallel::World& world) {
    PartSession process(world, whole, fixtures::boxes(whole, 3), options);
    EXPECT_EQ(process.execute(0), "");
    process.session().record(file);
    EXPECT_EQ(process.execute(1), "");
    const std::string before = read_file(file);
    rlimit limit{};
    getrlimit(RLIMIT_FSIZE, &limit);
    for (const std::size_t size : {before.size() / 2, before.size() - 100, std::size_t(10)}) {
      world.agree_after([&] {
        rlimit full = limit;
        full.rlim_cur = size;
        if (world.is_root())
          setrlimit(RLIMIT_FSIZE, &full);
      });
      std::string said;
      try {
        process.session().record(file);
      } catch (const core::Error& e) {
        said = e.what();
      }
      world.agree_after([&] {
        if (world.is_root())
          setrlimit(RLIMIT_FSIZE, &limit);
      });
      EXPECT_EQ(said.find("process 0 of 3: cannot write '" + file), 0u) << said;
      EXPECT_EQ(read_file(file), before);
    }
    world.agree_after([] {});
    process.session().record(file);
    EXPECT_NE(read_file(file), before);
    world.agree_after([] {});
    // Another session that is open writes the same file, or the same records, and is refused.
    PartSession::Options same = options;
    same.scene += "record: {every: 1}\n";
    same.folder = folder / "same";
    PartSession first(world, whole, fixtures::boxes(whole, 3), same);
    EXPECT_THROW(PartSession(world, whole, fixtures::boxes(whole, 3), same), core::Error);
    EXPECT_EQ(first.execute(0), "");
    EXPECT_THROW(first.session().record(file), core::Error);
    EXPECT_EQ(first.session().finish(), "");
    EXPECT_EQ(process.session().finish(), "");
  });
  std::signal(SIGXFSZ, handler);
  for (const auto& [name, text] : files_of(folder / ""))
    EXPECT_EQ(name.find("insitu-part"), std::string::npos) << name;
}
