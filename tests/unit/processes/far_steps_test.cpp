// Tracers over processes whose steps go over the cells of several of them: the files of one
// process, to the byte.
#include "tracer_files.h"

using namespace insitu;
using namespace insitu::test;

namespace {

std::string tracer(const std::string& name, const std::string& more) {
  return "  - {name: " + name + ", velocity: u, seeds: " + seeds + ", fields: [p, u, c]" + more +
         "}\n";
}
const std::string far = ", integrator: {method: rk4, step: 1.5}";

} // namespace

/// A step of these goes over three processes and more, out of the mesh, past walls and over sides;
/// times of their own lie along it.
TEST(ProcessFarSteps, PathlinesAreThoseOfOneProcessToTheByte) {
  const auto paths = [](const std::string& name, const std::string& effects) {
    return tracer(name, ", kind: pathline, output: [csv, netcdf], times: {interval: 0.06}" + far +
                            ", effects: [{windage: {field: u, factor: 2}}" + effects + "]");
  };
  const std::string scene =
      "insitu: 1\npage: false\ntracers:\n" +
      tracer("free", ", kind: pathline, output: [csv], times: {interval: 0.06}" + far) +
      paths("blown", "") +
      paths("sliding", ", {boundary: {other: slide}}, {settling: {speed: 3}}") +
      paths("around", ", {boundary: {periodic: [x, y], other: reflect}}") +
      paths("walking",
            ", {diffusion: {horizontal: 2, vertical: 1}}, {boundary: {other: reflect}}") +
      paths("heavy", ", {boundary: {other: slide}}, {inertia: {response_time: 0.5, gravity: [0, 0, "
                     "-5]}}") +
      paths("removed", ", {remove: {when: 'p > 9'}}");
  expect_files_of_one(scene, {2, 3, 4, 8}, five_cycles, "killed", true);
}

TEST(ProcessFarSteps, PathlinesOnAMeshThatMovesAreThoseOfOneProcessToTheByte) {
  expect_files_of_one(
      "insitu: 1\npage: false\ntracers:\n" +
          tracer("free", ", kind: pathline, output: [csv], times: {interval: 0.06}" + far),
      {3}, five_cycles_of_moving, "left", true);
}

TEST(ProcessFarSteps, StreamlinesAreThoseOfOneProcessToTheByte) {
  const auto lines = [](const std::string& name, const std::string& more) {
    return tracer(name, ", kind: streamline, until: {duration: 6}, output: [csv, vtp], every: 4" +
                            far + more);
  };
  expect_files_of_one("insitu: 1\npage: false\ntracers:\n" + lines("both", ", direction: both") +
                          lines("even", ", spacing: {length: 0.1}") +
                          lines("timed", ", direction: backward, spacing: {time: 0.05}") +
                          lines("slide", ", spacing: {length: 0.3}, effects: [{boundary: {other: "
                                         "slide}}, {settling: {speed: 0.3}}]") +
                          lines("around", ", effects: [{boundary: {periodic: [x, y]}}]") +
                          lines("removed", ", effects: [{remove: {when: 'p > 9'}}]"),
                      {1, 2, 3, 4, 8}, five_cycles, "left", true);
}

/// The solver moves cells from process to process, and makes others, under such steps.
TEST(ProcessFarSteps, OtherCellsAreThoseOfOneProcessToTheByte) {
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
        process.deal(fixtures::boxes(whole, processes), world.rank(), &whole);
      if (cycle == 3)
        process.deal(fixtures::slabs(other, processes), world.rank(), &other);
      if (cycle == 5)
        process.deal(fixtures::slabs(whole, processes), world.rank(), &whole);
      EXPECT_EQ(process.execute(cycle), "");
    }
  };
  expect_files_of_one("insitu: 1\npage: false\ntracers:\n" +
                          tracer("paths", ", kind: pathline, output: [csv, netcdf]" + far) +
                          tracer("timed", ", kind: pathline, output: [csv], times: {interval: "
                                          "0.06}" +
                                              far) +
                          tracer("blown", ", kind: pathline, output: [csv], effects: [{windage: "
                                          "{field: u, factor: 2}}]" +
                                              far) +
                          tracer("sliding", ", kind: pathline, output: [csv], effects: "
                                            "[{boundary: {other: slide}}, {settling: {speed: 3}}]" +
                                                far),
                      {2, 3, 4, 8}, act, "killed", true);
}
