// Tracers of scenes over processes: the files of one process, to the byte.
#include "tracer_files.h"

using namespace insitu;
using namespace insitu::test;

namespace {

std::string scene_of(const std::string& more = "") {
  return std::string("insitu: 1\npage: false\ntracers:\n"
                     "  - {name: paths, velocity: u, kind: pathline, seeds: ") +
         seeds +
         ", fields: [p, u, c], output: [csv, vtp, netcdf], every: 2}\n"
         "  - {name: streaks, velocity: u, kind: streakline, seeds: {points: [[1, 1, 1], [3.1, "
         "2.2, "
         "2.7], [4, 4, 2]]}, times: {interval: 0.06}, fields: [p], output: [csv, vtp, netcdf]}\n" +
         more;
}

} // namespace

TEST(ProcessTracers, FilesAreThoseOfOneProcessToTheByte) {
  expect_files_of_one(scene_of(), {1, 2, 3, 4, 8});
}

TEST(ProcessTracers, FilesOnAMeshThatMovesAreThoseOfOneProcessToTheByte) {
  expect_files_of_one(scene_of(), {2, 4, 8}, five_cycles_of_moving);
}

/// Vertices of one process move, and those of others stand, as where one part of a machine turns.
TEST(ProcessTracers, VerticesThatMoveOnOneProcessAloneAreThoseOfOneProcessToTheByte) {
  const Act act = [](PartSession& process, parallel::World&) {
    const TestMesh whole = jittered_cubes();
    for (int cycle = 0; cycle < 5; ++cycle) {
      std::vector<Vec3d> points = whole.vertices;
      for (Vec3d& x : points)
        if (x.x > 3.5)
          x += 0.03 * cycle * Vec3d{x.x - 3.5, 0.5 * x.z, std::cos(x.x)};
      bool moves = false;
      for (const fixtures::Part::Piece& piece : process.part().pieces())
        for (const std::int64_t v : piece.vertices)
          moves = moves || points[std::size_t(v)] != whole.vertices[std::size_t(v)];
      if (cycle > 0 && moves)
        process.part().move(process.mesh().mesh(), points);
      EXPECT_EQ(process.execute(cycle), "");
    }
  };
  expect_files_of_one(scene_of(), {2, 4}, act, "killed", true);
}

/// Material that carries particles on vertices, edges and faces of its cells, in a grid whose
/// numbers of cells have factors in common with what is looked at to learn how cells are numbered:
/// whether a process knows the cells beside one must not show.
TEST(ProcessTracers, ParticlesOnEdgesOfMovingMaterialAreThoseOfOneProcessToTheByte) {
  MeshOptions grid;
  grid.size = 12;
  grid.jitter = 0.0;
  const TestMesh whole = make_mesh(grid, 1);
  const Act carried = [&](PartSession& process, parallel::World&) {
    std::vector<double> velocity; // steady, so that particles stay where they are in their cells
    for (const Vec3d& x : whole.vertices)
      velocity.insert(velocity.end(), {0.01 * x.x * x.y, 0.02 * std::sin(x.y), 0.01 * x.z});
    for (int cycle = 0; cycle < 5; ++cycle) {
      std::vector<Vec3d> now;
      for (std::size_t v = 0; v < whole.vertices.size(); ++v)
        now.push_back(whole.vertices[v] +
                      0.25 * cycle *
                          Vec3d{velocity[3 * v], velocity[3 * v + 1], velocity[3 * v + 2]});
      if (!process.part().empty()) {
        process.part().move(process.mesh().mesh(), now);
        process.part().give_field(process.mesh().mesh(), "material", INSITU_VERTEX, 3, velocity);
      }
      EXPECT_EQ(process.execute(cycle), "");
    }
  };
  PartSession::Options options;
  options.scene =
      "insitu: 1\npage: false\ntracers:\n"
      "  - {name: carried, velocity: material, kind: pathline, seeds: {box: {min: [0, 0, "
      "0], max: [12, 12, 12], counts: [25, 25, 5]}}, output: [csv]}\n";
  const auto expected = run_parts(whole, fixtures::slabs(whole, 1), options, carried);
  for (const int processes : {2, 3, 8})
    for (const fixtures::Partition& partition :
         {fixtures::slabs(whole, processes), fixtures::boxes(whole, processes)})
      expect_same(expected, run_parts(whole, partition, options, carried),
                  partition.name + " on " + std::to_string(processes));
}

TEST(ProcessTracers, EffectsAreThoseOfOneProcessToTheByte) {
  expect_files_of_one(
      std::string("insitu: 1\npage: false\ntracers:\n"
                  "  - {name: walls, velocity: u, kind: pathline, seeds: ") +
          seeds +
          ", effects: [{boundary: {other: slide}}, {settling: {speed: 0.3}}, {diffusion: "
          "{horizontal: 0.02, vertical: 0.01}}], fields: [p], output: [csv]}\n"
          "  - {name: heavy, velocity: u, kind: pathline, seeds: " +
          seeds +
          ", effects: [{boundary: {other: reflect}}, {inertia: {response_time: 0.1, "
          "gravity: [0, 0, -1]}}], fields: [p], output: [csv]}\n"
          "  - {name: removed, velocity: u, kind: pathline, seeds: " +
          seeds + ", effects: [{remove: {when: 'p > 9'}}], output: [csv]}\n",
      {2, 4});
}

/// What leaves at a side of the box comes in at the opposite one, where another process has the
/// cells, and has its walls, its walk and its inertia there.
TEST(ProcessTracers, PeriodicSidesAreThoseOfOneProcessToTheByte) {
  const auto tracer = [](const std::string& name, const std::string& effects,
                         const std::string& more = "") {
    return "  - {name: " + name + ", velocity: u, kind: pathline, seeds: " + seeds +
           ", effects: [" + effects + "], fields: [p, c], output: [csv, netcdf]" + more + "}\n";
  };
  const std::string scene =
      "insitu: 1\npage: false\ntracers:\n" +
      tracer("one", "{boundary: {periodic: [x]}}", ", times: {interval: 0.1}") +
      tracer("all", "{boundary: {periodic: [x, y, z]}}, {settling: {speed: 2}}") +
      tracer("sliding", "{boundary: {periodic: [x], other: slide}}") +
      tracer("back", "{boundary: {periodic: [y], other: put_back}}") +
      tracer("walking",
             "{boundary: {periodic: [x, y], other: reflect}}, {diffusion: {horizontal: 0.05, "
             "vertical: 0.02}}") +
      tracer("heavy",
             "{boundary: {periodic: [x, y], other: reflect}}, {inertia: {response_time: 0.2, "
             "gravity: [0, 0, -1]}}");
  expect_files_of_one(scene, {2, 3, 4, 8}, five_cycles, "killed", true);
}

TEST(ProcessTracers, PeriodicSidesOfAMeshThatMovesAreThoseOfOneProcessToTheByte) {
  const Act act = [](PartSession& process, parallel::World&) {
    const TestMesh whole = jittered_cubes();
    for (int cycle = 0; cycle < 5; ++cycle) {
      std::vector<Vec3d> points; // sides stay planes, which go with the mesh
      for (const Vec3d& x : whole.vertices)
        points.push_back(x + 0.1 * cycle *
                                 Vec3d{0.2 * x.x + std::sin(0.4 * M_PI * x.x) * std::cos(x.y), 0.3,
                                       std::sin(0.4 * M_PI * x.z)});
      if (cycle > 0 && !process.part().empty())
        process.part().move(process.mesh().mesh(), points);
      EXPECT_EQ(process.execute(cycle), "");
    }
  };
  expect_files_of_one(std::string("insitu: 1\npage: false\ntracers:\n"
                                  "  - {name: paths, velocity: u, kind: pathline, seeds: ") +
                          seeds +
                          ", effects: [{boundary: {periodic: [x, z], other: slide}}], fields: "
                          "[p], output: [csv], times: {interval: 0.07}}\n",
                      {2, 8}, act, "killed", true);
}

TEST(ProcessTracers, EffectsOnStreamlinesAreThoseOfOneProcessToTheByte) {
  const auto lines = [](const std::string& name, const std::string& effects,
                        const std::string& more = "") {
    return "  - {name: " + name +
           ", velocity: u, kind: streamline, seeds: {box: {min: [0.5, 0.5, 0.5], max: [5.5, 4.5, "
           "4.5], counts: [4, 3, 1]}}, until: {duration: 2}, effects: [" +
           effects + "], fields: [p, c], output: [csv, vtp], every: 4" + more + "}\n";
  };
  expect_files_of_one(
      "insitu: 1\npage: false\ntracers:\n" +
          lines("slide", "{boundary: {other: slide}}, {settling: {speed: 0.3}}") +
          lines("around", "{boundary: {periodic: [x, y]}}, {settling: {speed: 0.3}}",
                ", direction: both") +
          lines("even", "{boundary: {periodic: [x, y, z], other: slide}}",
                ", spacing: {length: 0.1}") +
          lines("timed", "{boundary: {periodic: [x], other: slide}}", ", spacing: {time: 0.05}") +
          lines("removed", "{remove: {when: 'p > 9'}}", ", spacing: {length: 0.2}") +
          lines("heavy", "{boundary: {periodic: [y], other: reflect}}, {inertia: {response_time: "
                         "0.1, gravity: [0, 0, -1]}}"),
      {1, 2, 3, 4, 8}, five_cycles, "left", true);
}

TEST(ProcessTracers, StreamlinesAreThoseOfOneProcessToTheByte) {
  const std::string more =
      std::string(", until: {duration: 3}, fields: [p, c], output: [csv, vtp], "
                  "every: 2}\n");
  const auto lines = [&](const std::string& name, const std::string& options) {
    return "  - {name: " + name + ", velocity: u, kind: streamline, seeds: " + seeds + options +
           more;
  };
  expect_files_of_one("insitu: 1\npage: false\ntracers:\n" + lines("both", ", direction: both") +
                          lines("even", ", spacing: {length: 0.1}") +
                          lines("back", ", direction: backward, spacing: {time: 0.05}") +
                          lines("kutta", ", integrator: {method: rk4}"),
                      {1, 2, 3, 4, 8}, five_cycles, "left");
}

/// Particles that the material carries keep their cells, also those that another process has by
/// the time that they end; where cells become others they are found where they are.
TEST(ProcessTracers, ParticlesOfTheMaterialAreThoseOfOneProcessToTheByte) {
  const std::string scene =
      std::string("insitu: 1\npage: false\ntracers:\n"
                  "  - {name: carried, attached: body, kind: pathline, seeds: ") +
      seeds +
      ", fields: [p, c], output: [csv, vtp, netcdf], times: {interval: 0.1}}\n"
      "  - {name: released, attached: body, kind: streakline, seeds: " +
      seeds + ", until: {duration: 0.6}, fields: [p], output: [csv]}\n";
  expect_files_of_one(scene, {2, 3, 8}, five_cycles_of_moving, "killed", true);
}

/// The mesh goes on under particles that have ended, so other processes have what is there.
TEST(ProcessTracers, ValuesOfEndedParticlesAreThoseOfOneProcessToTheByte) {
  const Act act = [](PartSession& process, parallel::World&) {
    const TestMesh whole = jittered_cubes();
    for (int cycle = 0; cycle < 5; ++cycle) {
      std::vector<Vec3d> points;
      for (const Vec3d& x : whole.vertices)
        points.push_back(x + 0.8 * cycle * Vec3d{1, 0.1, 0});
      if (cycle > 0 && !process.part().empty())
        process.part().move(process.mesh().mesh(), points);
      EXPECT_EQ(process.execute(cycle), "");
    }
  };
  expect_files_of_one(std::string("insitu: 1\npage: false\ntracers:\n"
                                  "  - {name: paths, velocity: u, kind: pathline, seeds: ") +
                          seeds + ", until: {duration: 0.3}, fields: [p, c], output: [csv, vtp]}\n",
                      {2, 8}, act, "expired", true);
}

/// The solver moves cells from process to process, and then makes others: particles go on, blended
/// between the step before, wherever its cells were, and the current one.
TEST(ProcessTracers, OtherCellsAreThoseOfOneProcessToTheByte) {
  const TestMesh other = [] {
    MeshOptions options;
    options.size = 5;
    options.jitter = 0.1;
    options.kind = MeshKind::tetrahedra;
    return make_mesh(options, 5);
  }();
  const TestMesh whole = jittered_cubes();
  const Act act = [&](PartSession& process, parallel::World& world) {
    const int processes = world.size();
    for (int cycle = 0; cycle < 6; ++cycle) {
      if (cycle == 2)
        process.deal(fixtures::dealt(whole, processes, 3), world.rank(), &whole);
      if (cycle == 3)
        process.deal(fixtures::boxes(other, processes), world.rank(), &other);
      if (cycle == 5)
        process.deal(fixtures::slabs(whole, processes), world.rank(), &whole);
      EXPECT_EQ(process.execute(cycle), "");
    }
  };
  const std::string scene =
      std::string("insitu: 1\npage: false\ntracers:\n"
                  "  - {name: paths, velocity: u, kind: pathline, seeds: ") +
      seeds +
      ", fields: [p, u, c], output: [csv, netcdf]}\n"
      "  - {name: streaks, velocity: u, kind: streakline, seeds: {points: [[1, 1, 1], [3.1, 2.2, "
      "2.7], [4, 4, 2]]}, times: {interval: 0.06}, fields: [p], output: [csv, netcdf]}\n"
      "  - {name: sliding, velocity: u, kind: pathline, seeds: " +
      seeds +
      ", effects: [{boundary: {other: slide}}, {settling: {speed: 0.3}}], fields: [p], output: "
      "[csv]}\n";
  expect_files_of_one(scene, {2, 3, 4, 8}, act, "killed", true);
}

/// Another mesh lies elsewhere: particles under effects come in to it by the flow, until its cells
/// hold them, or end between both.
TEST(ProcessTracers, EffectsBeginWhereTheNewCellsHoldAParticle) {
  const TestMesh whole = jittered_cubes();
  TestMesh other = whole;
  for (Vec3d& x : other.vertices)
    x += Vec3d{0.45, 0.3, 0.0};
  const Act act = [&](PartSession& process, parallel::World& world) {
    const int processes = world.size();
    for (int cycle = 0; cycle < 5; ++cycle) {
      if (cycle == 2)
        process.deal(fixtures::boxes(other, processes), world.rank(), &other);
      if (cycle == 4)
        process.deal(fixtures::slabs(whole, processes), world.rank(), &whole);
      EXPECT_EQ(process.execute(cycle), "");
    }
  };
  const std::string begin = std::string(", velocity: u, kind: pathline, seeds: ") + seeds +
                            ", fields: [p], output: [csv]";
  expect_files_of_one("insitu: 1\npage: false\ntracers:\n"
                      "  - {name: falling" +
                          begin +
                          ", effects: [{boundary: {other: slide}}, {settling: {speed: 0.3}}]}\n"
                          "  - {name: walking" +
                          begin +
                          ", effects: [{diffusion: {horizontal: 0.05, vertical: 0.05}}], times: "
                          "{interval: 0.1}}\n",
                      {2, 3, 4, 8}, act, "killed", true);
}
