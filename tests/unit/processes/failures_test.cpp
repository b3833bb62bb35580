#include "part_session.h"

using namespace insitu;
using namespace insitu::test;

namespace {

constexpr int processes = 3;

PartSession::Options with(const std::string& items, const std::string& folder) {
  PartSession::Options options;
  options.scene = "insitu: 1\npage: false\n" + items;
  options.folder = folder;
  return options;
}

const std::string probe = "probes: [{name: a, points: [[1, 1, 1]], fields: [p]}]\n";

/// Runs one process's body on a few cubes; the files of the folder `out` are returned.
void run(const std::string& items, const std::function<void(PartSession&, parallel::World&)>& body,
         const std::string& output = {}) {
  const TestMesh whole = jittered_cubes(3);
  const OwnFolder folder;
  run_processes(processes, [&](parallel::World& world) {
    PartSession process(world, whole, fixtures::boxes(whole, processes),
                        with(items, output.empty() ? folder / "out" : output));
    body(process, world);
  });
}

bool is_last(const parallel::World& world) {
  return world.rank() == world.size() - 1;
}

} // namespace

/// A process with cells lacks the field that a probe wants.
TEST(ProcessFailures, AFieldThatOneProcessLacks) {
  run(probe, [](PartSession& process, parallel::World& world) {
    EXPECT_EQ(process.execute(0), "");
    if (is_last(world))
      process.mesh().mesh().remove_field("p");
    const std::string said = process.session().execute(1, 0.25);
    EXPECT_EQ(said.find("probe 'a': process 2 of 3: "), 0u) << said;
    EXPECT_NE(said.find("field 'p'"), std::string::npos) << said;
    EXPECT_EQ(process.messages().size(), world.is_root() ? 1u : 0u); // told once
  });
}

/// The halo has a field of a process under its name, whatever other fields some processes have.
TEST(ProcessFailures, FieldsThatSomeProcessesHave) {
  const TestMesh whole = jittered_cubes(3);
  const PartSession::Options options = with(
      probe + "tracers: [{name: t, velocity: u, fields: [p], output: [csv], seeds: {box: {min: "
              "[0.5, 0.5, 0.5], max: [2.5, 2.5, 2.5], counts: [4, 4, 4]}}}]\n",
      "");
  const auto files = [&](bool some_have) {
    return run_parts(whole, fixtures::boxes(whole, processes), options,
                     [&](PartSession& process, parallel::World& world) {
                       mesh::Mesh& mesh = process.mesh().mesh();
                       for (int cycle = 0; cycle < 4; ++cycle) {
                         process.give_fields(cycle);
                         if (some_have && world.rank() == 1)
                           process.part().remove_field(mesh, "c");
                         if (some_have && is_last(world))
                           process.part().give_field(mesh, "a", INSITU_CELL, 1,
                                                     WholeFields(whole, cycle).c);
                         EXPECT_EQ(process.session().execute(cycle, 0.25 * cycle), "");
                       }
                     });
  };
  expect_same(files(false), files(true), "fields that some processes have");
}

/// They are in tables of all fields, and in no message: those of the halo are as many bytes as
/// without them.
TEST(ProcessFailures, FieldsThatTheSceneDoesNotNameStayWhereTheyAre) {
  const TestMesh whole = jittered_cubes(4);
  const PartSession::Options options =
      with("probes: [{name: all, points: {box: {min: [0, 0, 0], max: [4, 4, 4], counts: [5, 5, "
           "5]}}, output: [csv]}]\n"
           "tracers: [{name: t, velocity: u, fields: [p], output: [csv], seeds: {box: {min: "
           "[0.5, 0.5, 0.5], max: [3.5, 3.5, 3.5], counts: [4, 4, 4]}}}]\n"
           "frames: [{name: f, size: [24, 24], isosurfaces: [{field: p, values: [2], normals: "
           "smooth, color: {field: \"\\x63\"}}]}]\n", // an escaped c
           "");
  std::atomic<std::int64_t> sent{0};
  const auto files = [&](int processes, int more) {
    sent = 0;
    return run_parts(whole, fixtures::boxes(whole, processes), options,
                     [&](PartSession& process, parallel::World&) {
                       for (int cycle = 0; cycle < 3; ++cycle) {
                         for (int i = 0; i < more; ++i)
                           process.part().give_field(process.mesh().mesh(),
                                                     "species" + std::to_string(i), INSITU_VERTEX,
                                                     1, WholeFields(whole, cycle + i).p);
                         EXPECT_EQ(process.execute(cycle), "");
                       }
                       if (const commit::Halo* const halo = process.mesh().halo())
                         sent += halo->bytes_sent();
                     });
  };
  const auto expected = files(1, 9);
  expect_same(expected, files(4, 9), "nine fields more");
  const std::int64_t with_more = sent;
  EXPECT_NE(expected.at("all.csv").find("species8"), std::string::npos);
  files(4, 0);
  EXPECT_GT(sent, 0);
  EXPECT_EQ(sent, with_more);
}

/// Others' cells are in its halo.
TEST(ProcessFailures, AVelocityThatOneProcessLacks) {
  run(probe + "tracers: [{name: t, velocity: u, output: [csv], seeds: {points: [[1, 1, 1]]}}]\n",
      [](PartSession& process, parallel::World& world) {
        EXPECT_EQ(process.execute(0), "");
        if (is_last(world))
          process.part().remove_field(process.mesh().mesh(), "u");
        const std::string said = process.session().execute(1, 0.25);
        EXPECT_EQ(said.find("tracer 't': process 2 of 3: "), 0u) << said;
        EXPECT_NE(said.find("field 'u'"), std::string::npos) << said;
        EXPECT_EQ(process.execute(1), "");
      });
}

TEST(ProcessFailures, AConditionOfAFieldThatOneProcessLacks) {
  run("when: mean(c) > -5\n" + probe, [](PartSession& process, parallel::World& world) {
    EXPECT_EQ(process.execute(0), "");
    if (is_last(world))
      process.mesh().mesh().remove_field("c");
    const std::string said = process.session().execute(1, 0.25);
    EXPECT_EQ(said.find("probe 'a': process 2 of 3: "), 0u) << said;
    EXPECT_NE(said.find("field 'c'"), std::string::npos) << said;
  });
}

/// The root cannot write; all hear of it, and of the next cycle's too, which works.
TEST(ProcessFailures, TheRootCannotWrite) {
  const OwnFolder folder;
  std::ofstream(folder / "file") << "no folder";
  run(
      probe,
      [&](PartSession& process, parallel::World& world) {
        const std::string said = process.execute(0);
        EXPECT_EQ(said.find("probe 'a': process 0 of 3: "), 0u) << said;
        world.agree_after([&] {
          if (world.is_root())
            std::filesystem::remove(folder / "file");
        });
        EXPECT_EQ(process.execute(1), "");
        EXPECT_EQ(process.session().finish(), "");
      },
      folder / "file");
  EXPECT_TRUE(std::filesystem::exists(folder / "file/a.csv"));
}

TEST(ProcessFailures, AFileOfPointsThatIsNotThere) {
  run("probes: [{name: a, points: /nowhere/points.csv}]\n",
      [](PartSession& process, parallel::World&) {
        const std::string said = process.execute(0);
        EXPECT_EQ(said.find("probe 'a': process 0 of 3: file of points '/nowhere/points.csv'"), 0u)
            << said;
      });
}

/// A commit fails on one process.
TEST(ProcessFailures, ACommitOfOneProcess) {
  run(probe, [](PartSession& process, parallel::World& world) {
    EXPECT_EQ(process.execute(0), "");
    const double value = 1;
    const insitu_array few = insitu_array_of(&value, INSITU_FLOAT64, 1, 1);
    if (is_last(world))
      process.mesh().mesh().set_field(0, "p", INSITU_VERTEX, &few, 1);
    const std::string said = failure_of([&] { process.session().execute(1, 0.25); });
    EXPECT_EQ(said.find("process 2 of 3: mesh 'm'"), 0u) << said;
  });
}

/// Cycles, times, fields and frames of reference that differ.
TEST(ProcessFailures, WhatDiffersIsNamed) {
  run(probe, [](PartSession& process, parallel::World& world) {
    EXPECT_EQ(process.execute(0), "");
    const int extra = is_last(world);
    EXPECT_EQ(failure_of([&] { process.session().execute(7 + extra, 0.5); }),
              "processes differ: cycle 7 on process 0, cycle 8 on process 2 of 3");
    EXPECT_EQ(failure_of([&] { process.session().execute(8, 0.5 + extra); }),
              "processes differ: time 0.5 on process 0, time 1.5 on process 2 of 3");
    if (extra)
      process.mesh().reference_frame.kind = INSITU_FRAME_GEOCENTRIC;
    const std::string said = failure_of([&] { process.session().execute(9, 0.5); });
    EXPECT_NE(said.find("processes differ: the frame of mesh 'm' is cartesian"), std::string::npos)
        << said;
    if (extra)
      process.mesh().reference_frame.kind = INSITU_FRAME_CARTESIAN;
    EXPECT_EQ(process.execute(10), "");
  });
}

/// Scenes of a file are read by the root; others that give another file are named.
TEST(ProcessFailures, Scenes) {
  const TestMesh whole = jittered_cubes(2);
  const OwnFolder folder;
  std::ofstream(folder / "good.yaml") << "insitu: 1\npage: false\n" + probe;
  std::ofstream(folder / "bad.yaml") << "insitu: 1\nprobs: []\n";
  const auto open = [&](parallel::World& world, const std::string& file) {
    PartSession::Options options;
    options.scene = file;
    options.scene_is_file = true;
    options.folder = folder / "out";
    const fixtures::Partition partition = fixtures::boxes(whole, processes);
    return failure_of([&] {
      PartSession process(world, whole, partition, options);
      EXPECT_EQ(process.execute(0), "");
      process.session().finish();
    });
  };
  run_processes(processes, [&](parallel::World& world) {
    EXPECT_EQ(open(world, folder / "good.yaml"), "");
    const std::string bad = open(world, folder / "bad.yaml");
    EXPECT_EQ(bad.find("process 0 of 3: " + (folder / "bad.yaml") + ":2"), 0u) << bad;
    const std::string other = open(world, folder / (is_last(world) ? "bad.yaml" : "good.yaml"));
    EXPECT_EQ(other.find("processes differ: scene file '"), 0u) << other;
    const std::string none = open(world, folder / "none.yaml");
    EXPECT_EQ(none.find("process 0 of 3: scene file '"), 0u) << none;
  });
}

/// Meshes that processes make in other orders, or that have no cells anywhere, or no fields.
TEST(ProcessFailures, NothingIsNoFailure) {
  const TestMesh whole = jittered_cubes(2);
  const OwnFolder folder;
  run_processes(processes, [&](parallel::World& world) {
    insitu_session_options o = insitu_session_options_default();
    o.scene_text = "insitu: 1\npage: false\nprobes:\n"
                   "  - {name: first, points: [[1, 1, 1]], fields: [f]}\n"
                   "  - {name: second, mesh: b, points: [[1, 1, 1]], fields: [f]}\n"
                   "  - {name: all, mesh: b, points: [[1, 1, 1]]}\n";
    const std::string output = folder / "out";
    o.output = output.c_str();
    o.threads = 1;
    api::Session session(o, std::shared_ptr<parallel::World>(&world, [](auto*) {}));
    session.open(o);
    session.mesh(world.rank() == 1 ? "b" : "a");
    if (world.rank() < 2)
      session.mesh(world.rank() == 1 ? "a" : "b");
    EXPECT_EQ(session.execute(0, 0), "");
    // Cells of 'a' at last, of the last process, which has no 'b' of its own making.
    fixtures::Part part(whole, fixtures::slabs(whole, 1), is_last(world) ? 0 : 1);
    part.give(session.mesh("a").mesh.mesh());
    part.give_field(session.mesh("a").mesh.mesh(), "f", INSITU_CELL, 1,
                    std::vector<double>(whole.cells.size(), 4.0));
    EXPECT_EQ(session.execute(1, 1), "");
    EXPECT_EQ(session.finish(), "");
  });
  const auto files = files_of(folder / "out");
  EXPECT_EQ(files.size(), 1u);
  const std::string table = read_file(folder / "out/first.csv");
  EXPECT_NE(table.find("cycle,time,point,cell,process,r,s,t,f"), std::string::npos) << table;
  EXPECT_NE(table.find("\n1,1,0,"), std::string::npos) << table;
  EXPECT_EQ(table.substr(table.size() - 3), ",4\n") << table;
}

/// A gap of 1e-4 of a cell between two processes: told by the scene's tolerance alone, and once.
TEST(ProcessFailures, AGapAtASeamIsToldByTheScenesTolerance) {
  const std::string tracer = "tracers: [{name: t, velocity: u, seeds: [[0.5, 0.5, 0.5]]}]\n";
  for (const std::string tolerance : {"", "seam_tolerance: 0\n", "seam_tolerance: 1e-3\n"})
    run(tolerance + tracer, [&](PartSession& process, parallel::World& world) {
      std::vector<Vec3d> moved = jittered_cubes(3).vertices;
      for (Vec3d& x : moved)
        x += 1e-4 * world.rank() * Vec3d{1, 1, 1};
      process.part().move(process.mesh().mesh(), moved);
      EXPECT_EQ(process.execute(0), "");
      EXPECT_EQ(process.execute(1), "");
      const bool told = tolerance.find("1e-3") != std::string::npos && world.is_root();
      ASSERT_EQ(process.messages().size(), told ? 1u : 0u);
      if (!told)
        return;
      EXPECT_NE(process.messages()[0].find("faces on seams lie within 0.001 of their size "
                                           "(seam_tolerance) of another process's face"),
                std::string::npos)
          << process.messages()[0];
    });
}
