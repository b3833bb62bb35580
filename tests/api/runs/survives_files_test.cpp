// A bad scene, folder or disk costs what needs it, is told, and leaves the solver and the rest
// alone.
#include <filesystem>
#include <gtest/gtest.h>
#include <unistd.h>

#include "core/status.h"
#include "coupled.h"
#include "fixtures/small_disk.h"
#include "output/files/atomic_file.h"
#include "scene/run/growing_table.h"
#include "unit/output/netcdf_file.h"

namespace {

using insitu::test::SmallDisk;
using runs::Coupled;

std::size_t unfinished(const std::string& folder) {
  return runs::names_of(runs::files_of(folder), std::string(insitu::output::part_suffix)).size();
}

void expect_in(const std::string& text, std::initializer_list<const char*> parts) {
  for (const char* part : parts)
    EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' is not in: " << text;
}

TEST(Survives, AFieldThatDoesNotExist) {
  const test::Folder folder;
  test::put(folder / "scene.yaml", "insitu: 1\n"
                                   "probes:\n"
                                   "  - {name: p, points: [[0.1, 0.1, 0.1]], fields: [density]}\n"
                                   "tracers:\n"
                                   "  - {name: t, velocity: velocity, seeds: [[0.1, 0.1, 0.1]]}\n"
                                   "frames:\n"
                                   "  - name: f\n"
                                   "    size: [16, 16]\n"
                                   "    volume:\n"
                                   "      field: densty\n"
                                   "  - {name: g, size: [16, 16], volume: {field: pressure}}\n");
  std::vector<std::string> log;
  insitu::Options options;
  options.scene = folder / "scene.yaml";
  options.output = folder / "out";
  options.log = [&](insitu::LogLevel, const char* message) { log.emplace_back(message); };
  Coupled run({});
  insitu::Session session(options);
  insitu::Mesh mesh = session.mesh("hydro");
  mesh.points(run.solver.x, run.solver.y, run.solver.z);
  mesh.hexahedra(run.solver.connectivity);
  mesh.cell_field("density", run.solver.density);
  mesh.cell_field("pressure", run.solver.pressure);
  mesh.vertex_field("velocity", {run.solver.u, run.solver.v, run.solver.w});
  for (int cycle = 0; cycle < 3; ++cycle) {
    EXPECT_EQ(insitu_session_execute(session.handle(), cycle, run.solver.time()),
              INSITU_ERROR_ACTION);
    expect_in(insitu_last_message(),
              {"frame 'f'", "scene.yaml:10: ", "no field 'densty'", "did you mean 'density'"});
    run.solver.advance();
    mesh.changed(insitu::geometry | insitu::fields);
  }
  EXPECT_EQ(log.size(), 1u) << "told once, not at every cycle";
  EXPECT_EQ(session.report().failures, 3);
  session.close();
  const runs::Files files = runs::files_of(folder / "out");
  EXPECT_EQ(runs::names_of(files),
            (std::vector<std::string>{"data.csv", "g_000000.png", "g_000001.png", "g_000002.png",
                                      "index.html", "p.csv", "run.js", "t.csv"}));
  EXPECT_EQ(runs::parse_table(files.at("p.csv")).rows.size(), 3u);
}

TEST(Survives, MessagesThatDifferEachTimeDoNotFloodTheLog) {
  const test::Folder folder;
  Coupled run({.scene = "insitu: 1\npage: false\nprobes:\n  - {name: p, points: "
                        "[[0.1, 0.1, 0.1]], output: [json]}\n",
               .output = folder.path(),
               .cells = 4});
  const SmallDisk disk(10); // each failure names the file of its own cycle
  for (int cycle = 0; cycle < 50; ++cycle)
    EXPECT_FALSE(run.session.execute(cycle, cycle));
  EXPECT_LE(run.log.size(), 10u);
  EXPECT_EQ(run.session.report().failures, 50);
  expect_in(run.log.back(), {"counted from here on"});
}

const std::string every_output = R"(
insitu: 1
probes:
  - {name: p, points: {line: {from: [0, 0, 0], to: [1, 1, 1], count: 200}}, output: [csv, vtp, json, netcdf]}
tracers:
  - name: t
    velocity: velocity
    seeds: {sphere: {center: [0.4, 0.4, 0.4], radius: 0.3, count: 200}}
    output: [csv, vtp, netcdf]
  - {name: s, kind: streamline, velocity: velocity, output: [csv, vtp], until: {duration: 0.1},
     seeds: {sphere: {center: [0.3, 0.3, 0.3], radius: 0.2, count: 100}}}
frames:
  - {name: f, size: [200, 200], volume: {field: pressure}, scalar_bar: true}
)";

TEST(Survives, AFileInTheFoldersPlace) {
  const test::Folder folder;
  test::put(folder / "out", "not a folder");
  Coupled run({.scene = every_output, .output = folder / "out"});
  EXPECT_FALSE(run.execute());
  expect_in(insitu_last_message(), {"probe 'p'", "tracer 't'", "tracer 's'", "frame 'f'", "out"});
  std::filesystem::remove(folder / "out"); // an operator makes room: the next cycle writes
  EXPECT_TRUE(run.step()) << insitu_last_message();
  run.session.close();
  EXPECT_EQ(runs::parse_table(test::content(folder / "out/p.csv")).rows.size(), 200u);
}

TEST(Survives, AFolderThatMayNotBeWritten) {
  if (::geteuid() == 0)
    GTEST_SKIP() << "root may write anywhere";
  const test::Folder folder;
  namespace fs = std::filesystem;
  fs::create_directory(folder / "out");
  fs::permissions(folder / "out", fs::perms::owner_read | fs::perms::owner_exec);
  Coupled run({.scene = every_output, .output = folder / "out"});
  EXPECT_FALSE(run.execute());
  expect_in(insitu_last_message(), {"probe 'p'", "frame 'f'", "ermission"});
  fs::permissions(folder / "out", fs::perms::owner_all);
}

TEST(Survives, AFullDisk) {
  const test::Folder folder;
  Coupled run({.scene = every_output, .output = folder.path()});
  {
    const SmallDisk disk(4500); // t.nc has no room but for its description
    EXPECT_EQ(insitu_session_execute(run.session.handle(), 0, 0.0), INSITU_ERROR_ACTION);
  }
  expect_in(insitu_last_message(), {"probe 'p'", "tracer 't'", "frame 'f'", "p.csv", "f_000000.png",
                                    "index.html", "File too large", "p.nc", "t.nc"});
  EXPECT_EQ(unfinished(folder.path()), 0u);
  for (const auto& [name, content] : runs::files_of(folder.path())) {
    if (name == "run.js") { // as it was before what could not be written
      EXPECT_TRUE(content.empty()) << content;
      continue;
    }
    if (name == "t.nc") { // the records did not fit, what comes before them did
      EXPECT_EQ(test::NetcdfFile(folder / name).records(), 0u);
      continue;
    }
    EXPECT_TRUE(name.ends_with(".csv")) << name << " is there, of " << content.size() << " bytes";
    EXPECT_EQ(runs::parse_table(content).rows.size(), 0u) << name;
  }
  const std::int64_t failures = run.session.report().failures;
  EXPECT_EQ(failures, 5); // the items and the page
  // There is room again: the rows that waited come first.
  EXPECT_TRUE(run.step()) << insitu_last_message();
  EXPECT_EQ(run.session.report().failures, failures);
  run.session.close();
  const runs::Files files = runs::files_of(folder.path());
  const runs::Table p = runs::parse_table(files.at("p.csv"));
  ASSERT_EQ(p.rows.size(), 400u);
  EXPECT_EQ(p.text(0, "cycle"), "0");
  EXPECT_EQ(p.text(200, "cycle"), "1");
  EXPECT_EQ(runs::parse_table(files.at("t.csv")).rows.size(), 600u);
  EXPECT_EQ(files.count("f_000001.png"), 1u);
  EXPECT_EQ(test::NetcdfFile(folder / "t.nc").records(), 600u);
  EXPECT_EQ(test::NetcdfFile(folder / "p.nc")["cycle"].integers, std::vector<long long>{1});
}

// Rows wait for room on the disk, but not until they fill the memory.
TEST(Survives, ADiskThatStaysFull) {
  const test::Folder folder;
  insitu::output::AppendTable table(folder / "t.csv", {"cycle", "text"});
  const std::string megabyte(std::size_t(1) << 20, 'x');
  const SmallDisk disk(1000);
  std::size_t most = 0;
  int lost = 0;
  for (int cycle = 0; cycle < 150; ++cycle) {
    table.rows().cell(cycle).cell(megabyte).end_row();
    try {
      insitu::scene::flush_table(table);
      ADD_FAILURE() << "a megabyte went into a kilobyte";
    } catch (const insitu::core::Error& e) {
      EXPECT_EQ(e.status(), INSITU_ERROR_FILE);
      lost += std::string(e.what()).find("are lost") != std::string::npos;
    }
    most = std::max(most, table.rows().text().size());
  }
  EXPECT_EQ(lost, 2);
  EXPECT_LT(most, std::size_t(66) << 20);
  EXPECT_EQ(test::content(folder / "t.csv"), "cycle,text\n");
  table.rows().clear();
}

TEST(Survives, ADiskThatIsFullWhenTheSessionCloses) {
  const test::Folder folder;
  Coupled run({.scene = "insitu: 1\ntracers:\n  - {name: t, velocity: velocity, seeds: {sphere: "
                        "{center: [0.4, 0.4, 0.4], radius: 0.3, count: 200}}}\n",
               .output = folder.path()});
  ASSERT_TRUE(run.execute());
  const std::string before = test::content(folder / "t.csv");
  const SmallDisk disk(before.size() + 100);
  try {
    run.session.close();
    FAIL() << "the rows that end the particles do not fit";
  } catch (const insitu::Error& e) {
    EXPECT_EQ(e.status(), INSITU_ERROR_FILE);
    expect_in(e.what(), {"tracer 't'", "t.csv", "File too large"});
  }
  EXPECT_EQ(run.session.handle(), nullptr);
  EXPECT_EQ(test::content(folder / "t.csv"), before);
}

} // namespace
