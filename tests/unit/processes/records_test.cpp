// Records of several processes, replayed by one: the files of the run, to the byte.
#include "insitu/insitu.hpp"

#include "part_session.h"
#include "records/meshes.h"

using namespace insitu;
using namespace insitu::test;

namespace {

constexpr int cycles = 4;

const std::string recorded_scene =
    "insitu: 1\npage: false\nrecord: {every: 1}\n"
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
Files replayed(const std::string& folder, const std::string& to) {
  insitu_replay::RecordedMeshes meshes; // outlives the session, which reads its arrays
  Options options;
  options.scene_text = recorded_scene;
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
    const Files again = replayed(options.folder, folder / "again");
    EXPECT_EQ(again.size(), live.size());
    for (const auto& [name, bytes] : live) {
      EXPECT_TRUE(bytes == expected[name]) << partition.name << ", live: " << name;
      EXPECT_TRUE(again.count(name) && again.at(name) == bytes) << partition.name << ": " << name;
    }
  }
}
