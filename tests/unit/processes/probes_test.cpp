#include <sstream>

#include "part_session.h"
#include "scene/probes/probe_answers.h"

using namespace insitu;
using namespace insitu::test;

namespace {

const std::vector<int> all_sizes = {1, 2, 3, 4, 8};

/// Points within cells, on vertices, faces and edges of the jittered cubes, and outside.
std::string hard_points(const TestMesh& whole) {
  std::ostringstream out;
  out.precision(17);
  const auto add = [&](const Vec3d& x) {
    out << (out.tellp() > 0 ? ", " : "") << "[" << x.x << ", " << x.y << ", " << x.z << "]";
  };
  for (std::size_t v = 0; v < whole.vertices.size(); v += 3)
    add(whole.vertices[v]);
  for (std::size_t c = 0; c < whole.cells.size(); c += 2) {
    const auto x = whole.cell_vertices(whole.cells[c]);
    add(0.5 * (x[0] + x[1]));
    add(0.25 * (x[1] + x[2] + x[5] + x[6]));
  }
  add({-1, 0.5, 0.5});
  return "[" + out.str() + "]";
}

std::string scene_of(const TestMesh& whole, const OwnFolder& folder) {
  std::ofstream(folder / "gauges.csv") << "name,x,y,z\nmiddle,2,2,2\n\"a, b\",0.1,0.2,0.3\n"
                                          "far,100,0,0\n";
  return "insitu: 1\npage: false\nprobes:\n"
         "  - {name: hard, points: " +
         hard_points(whole) +
         ", output: [csv, vtp, json, netcdf]}\n"
         "  - {name: grid, points: {box: {min: [0, 0, 0], max: [5, 5, 5], counts: [11, 11, 11]}}, "
         "fields: [u, c], every: 2}\n"
         "  - {name: curtain, points: {curtain: {through: [[0, 0], [5, 5], [5, 0]], count: 20, "
         "levels: [0, 1, 2.5, 5]}}, output: [csv, vtp, json, netcdf], fields: [p]}\n"
         "  - {name: gauges, points: " +
         (folder / "gauges.csv") +
         ", output: [csv, netcdf], accuracy: exact}\n"
         "  - {name: near, points: {box: {min: [-2, -2, -2], max: [7, 7, 7], counts: [7, 7, 7]}}, "
         "outside: nearest, greatest_distance: 2.5, fields: [u, c], every: 4, output: [csv, vtp, "
         "json, "
         "netcdf]}\n";
}

const Act four_cycles = [](PartSession& process, parallel::World&) {
  for (int cycle = 0; cycle < 4; ++cycle)
    EXPECT_EQ(process.execute(cycle), "");
};

std::vector<std::vector<std::string>> rows_of(const std::string& csv) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream in(csv);
  for (std::string line; std::getline(in, line);) {
    rows.emplace_back();
    std::istringstream cells(line + ",");
    for (std::string cell; std::getline(cells, cell, ',');)
      rows.back().push_back(cell);
  }
  return rows;
}

} // namespace

/// With global ids, whatever the partition.
TEST(ProcessProbes, FilesAreThoseOfOneProcessToTheByte) {
  const TestMesh whole = jittered_cubes();
  const OwnFolder folder;
  PartSession::Options options;
  options.scene = scene_of(whole, folder);
  const auto expected = run_parts(whole, fixtures::slabs(whole, 1), options, four_cycles);
  EXPECT_GE(expected.size(), 20u);
  EXPECT_EQ(rows_of(expected.at("hard.csv"))[0][3], "cell");
  EXPECT_EQ(rows_of(expected.at("hard.csv"))[0][4], "r");
  for (const int processes : all_sizes)
    for (const fixtures::Partition& partition : fixtures::partitions(whole, processes))
      expect_same(expected, run_parts(whole, partition, options, four_cycles),
                  partition.name + " on " + std::to_string(processes));
}

/// The distance is 0 inside, that to the nearest cell outside, and empty beyond the greatest one.
TEST(ProcessProbes, PointsOutsideHaveTheNearestCell) {
  const TestMesh whole = jittered_cubes();
  PartSession::Options options;
  options.scene = "insitu: 1\npage: false\nprobes:\n"
                  "  - {name: near, points: [[2, 2, 2], [-3, 2.5, 2.5], [2, 2, 40]], fields: [c], "
                  "outside: nearest, greatest_distance: 4}\n";
  for (const int processes : {1, 2}) {
    const auto rows = rows_of(
        run_parts(whole, fixtures::slabs(whole, processes), options, four_cycles).at("near.csv"));
    ASSERT_EQ(rows.size(), 13u);
    EXPECT_EQ(rows[0].back(), "distance_to_cell");
    EXPECT_EQ(rows[1].back(), "0");
    EXPECT_NEAR(std::stod(rows[2].back()), 3.0, 0.2); // vertices are jittered
    EXPECT_NE(rows[2][3], "-1");
    EXPECT_EQ(rows[3].back(), "");
    EXPECT_EQ(rows[3][3], "-1");
  }
}

/// Without global ids tables name the process, and what a point's row says is right.
TEST(ProcessProbes, WithoutGlobalIdsTablesNameProcesses) {
  const TestMesh whole = jittered_cubes(4);
  PartSession::Options options;
  options.ids = false;
  options.scene =
      "insitu: 1\npage: false\nprobes:\n  - {name: hard, points: " + hard_points(whole) +
      ", fields: [p, c]}\n";
  const auto serial =
      rows_of(run_parts(whole, fixtures::slabs(whole, 1), options, four_cycles).at("hard.csv"));
  for (const int processes : {2, 8})
    for (const fixtures::Partition& partition : fixtures::partitions(whole, processes)) {
      const std::string what = partition.name + " on " + std::to_string(processes);
      const auto rows = rows_of(run_parts(whole, partition, options, four_cycles).at("hard.csv"));
      const bool pieces = partition.pieces > 1;
      ASSERT_EQ(rows.size(), serial.size()) << what;
      EXPECT_EQ(rows[0][pieces ? 5 : 4], "process") << what;
      std::vector<std::unique_ptr<fixtures::Part>> parts;
      for (int r = 0; r < processes; ++r)
        parts.push_back(std::make_unique<fixtures::Part>(whole, partition, r));
      for (std::size_t i = 1; i < rows.size(); ++i) {
        ASSERT_EQ(rows[i].size(), rows[0].size());
        EXPECT_EQ(rows[i][3] == "-1", serial[i][3] == "-1") << what << ", row " << i;
        if (rows[i][3] == "-1")
          continue;
        const double p = std::stod(rows[i][rows[i].size() - 2]), c = std::stod(rows[i].back());
        EXPECT_NEAR(p, std::stod(serial[i][serial[i].size() - 2]), 1e-9) << what; // of another cell
        const auto& piece = parts[std::stoul(rows[i][pieces ? 5 : 4])]
                                ->pieces()[pieces ? std::stoul(rows[i][4]) : 0];
        const auto id = std::size_t(piece.cells[std::stoul(rows[i][3])]);
        const double time = 0.37 * std::stod(rows[i][0]);
        EXPECT_NEAR(c, std::cos(0.1 * double(id) + time), 1e-12) << what; // of text
      }
    }
}

/// Points that go with the material change owners when the solver deals its cells anew.
TEST(ProcessProbes, AttachedPointsAreHandedOver) {
  const TestMesh whole = jittered_cubes(4);
  PartSession::Options options;
  options.scene = "insitu: 1\npage: false\nprobes:\n"
                  "  - {name: body, points: " +
                  hard_points(whole) +
                  ", attached: body, every: 2, output: [csv, vtp, json, netcdf]}\n";
  const auto moved = [&](int cycle) {
    std::vector<math::Vec3d> x = whole.vertices;
    for (math::Vec3d& p : x)
      p += 0.05 * cycle * math::Vec3d{std::sin(p.y), std::cos(p.z), std::sin(p.x)};
    if (cycle == 5) // those in its cells are lost, and found again
      x[30].x = std::nan("");
    return x;
  };
  const auto run = [&](const std::function<fixtures::Partition(int)>& at) {
    return run_parts(whole, at(0), options, [&](PartSession& process, parallel::World& world) {
      for (int cycle = 0; cycle < 10; ++cycle) {
        if (cycle == 4 || cycle == 7)
          process.deal(at(cycle), world.rank());
        if (!process.part().empty())
          process.part().move(process.mesh().mesh(), moved(cycle == 5 ? 4 : cycle));
        EXPECT_EQ(process.execute(cycle), "");
      }
    });
  };
  const auto expected = run([&](int) { return fixtures::slabs(whole, 1); });
  EXPECT_GE(expected.size(), 12u);
  for (const int processes : {2, 3, 8})
    expect_same(expected, run([&](int cycle) {
                  return cycle < 4   ? fixtures::slabs(whole, processes)
                         : cycle < 7 ? fixtures::dealt(whole, processes)
                                     : fixtures::empty_root(whole, processes);
                }),
                std::to_string(processes));
}

/// Points in slices of any length, of which the last is shorter.
TEST(ProcessProbes, SlicesOfPointsAreAnsweredAlike) {
  const TestMesh whole = jittered_cubes(3);
  const WholeFields fields(whole, 0);
  std::vector<math::Vec3d> points;
  for (int i = 0; i < 100; ++i)
    points.push_back({0.0301 * i, 0.03 * i, 0.029 * i}); // all inside
  std::vector<std::int64_t> cells;
  std::vector<double> values;
  for (const int processes : {1, 3})
    for (const std::size_t slice : {1, 7, 50, 1000})
      run_processes(processes, [&](parallel::World& world) {
        core::Memory memory;
        const core::Threads threads(1);
        const core::Log log{insitu_log_level(0), nullptr, nullptr};
        commit::CommittedMesh mesh("m", memory);
        fixtures::Part part(whole, fixtures::boxes(whole, processes), world.rank());
        part.give(mesh.mesh(), true);
        part.give_field(mesh.mesh(), "p", INSITU_VERTEX, 1, fields.p);
        mesh.commit(threads, log, memory, false);
        const std::vector<mesh::FieldView> views{mesh.mesh().field("p")};
        std::vector<math::Vec3d> asked = points;
        const scene::ProbeAnswers answers = scene::answer_points(
            {mesh, views, query::LocateOptions{}, true, nullptr}, asked, world, threads, slice);
        EXPECT_EQ(answers.columns, std::vector<std::string>{"p"});
        EXPECT_EQ(answers.cells.size(), world.is_root() ? points.size() : 0u);
        if (!world.is_root())
          return;
        std::vector<std::int64_t> found;
        for (const scene::OwnCell& own : answers.cells)
          found.push_back(own.global);
        if (cells.empty()) {
          cells = found;
          values = answers.values;
        }
        EXPECT_EQ(found, cells) << processes << ", " << slice;
        EXPECT_EQ(answers.values, values) << processes << ", " << slice;
      });
  EXPECT_EQ(std::count(cells.begin(), cells.end(), -1), 0);
}

/// The root alone opens files: the page, and the summary with sums of all.
TEST(ProcessProbes, OnePageAndOneSummary) {
  const TestMesh whole = jittered_cubes(3);
  PartSession::Options options;
  options.scene = "insitu: 1\nprobes:\n  - {name: a, points: [[1, 1, 1], [9, 9, 9]]}\n";
  const OwnFolder folder;
  options.folder = folder / "out";
  run_processes(3, [&](parallel::World& world) {
    PartSession process(world, whole, fixtures::boxes(whole, 3), options);
    for (int cycle = 0; cycle < 3; ++cycle)
      EXPECT_EQ(process.execute(cycle), "");
    process.session().write_summary(folder / "summary.json", -1);
    EXPECT_FALSE(process.session().plan().empty());
    EXPECT_EQ(process.session().finish(), "");
    EXPECT_EQ(process.messages().size(), 0u);
  });
  const std::string summary = read_file(folder / "summary.json");
  for (const char* line :
       {"\"processes\": 3", "\"executions\": 3", "\"probe_rows\": 6", "\"points_located\": 6",
        "\"points_outside\": 3", "\"failures\": 0", "\"rebuild\": 3", "\"seconds_of_greatest\""})
    EXPECT_NE(summary.find(line), std::string::npos) << line << "\n" << summary;
  EXPECT_NE(read_file(folder / "out/run.js").find("\"processes\":{\"count\":3,\"least\":["),
            std::string::npos);
  for (const auto& entry : std::filesystem::directory_iterator(options.folder))
    EXPECT_TRUE(entry.is_regular_file()) << entry.path();
}

/// Reports tell a process's halo and what it sent, and the summary all processes'.
TEST(ProcessProbes, HalosAndMessagesAreTold) {
  const TestMesh whole = jittered_cubes(4);
  PartSession::Options options;
  options.scene = "insitu: 1\ntracers:\n  - {name: a, velocity: u, seeds: [[0.5, 0.5, 0.5]]}\n";
  const OwnFolder folder;
  options.folder = folder / "out";
  std::int64_t halo_cells[2] = {}, bytes[2] = {};
  run_processes(2, [&](parallel::World& world) {
    PartSession process(world, whole, fixtures::boxes(whole, 2), options);
    for (int cycle = 0; cycle < 2; ++cycle)
      EXPECT_EQ(process.execute(cycle), "");
    const insitu_report report = process.session().report();
    halo_cells[world.rank()] = report.halo_cells;
    bytes[world.rank()] = report.bytes_by_purpose[INSITU_MEMORY_HALO];
    EXPECT_GT(report.messages_sent, 0);
    EXPECT_GT(report.bytes_sent, report.messages_sent);
    process.session().write_summary(folder / "summary.json", -1);
    EXPECT_EQ(process.session().finish(), "");
  });
  EXPECT_EQ(halo_cells[0], 16); // two halves of 4 x 4 x 4 cells: those on the other side
  EXPECT_EQ(halo_cells[1], 16);
  const std::string summary = read_file(folder / "summary.json");
  const auto total = std::to_string(std::min(bytes[0], bytes[1]));
  for (const std::string& line :
       {std::string("\"halo_cells\": {\n"), std::string("\"least\": 16"),
        std::string("\"greatest\": 16"), "\"least\": " + total, std::string("\"work_seconds\""),
        std::string("\"greatest_over_mean\"")})
    EXPECT_NE(summary.find(line), std::string::npos) << line << "\n" << summary;
}
