#include "part_session.h"

using namespace insitu;
using namespace insitu::test;

namespace {

const std::vector<int> all_sizes = {1, 2, 3, 4, 8};

/// Frames with all that is there on several processes.
const char* const all_frames =
    "insitu: 1\n"
    "page: false\n"
    "frames:\n"
    "  - {name: smoke, size: [70, 66], images: [color, depth, cell], format: [png, exr],\n"
    "     volume: {field: p, opacity: [[0, 0], [1, 0.1], [5, 0.8]]}, scalar_bar: true, axes: "
    "true}\n"
    "  - {name: lit, size: [66, 70], volume: {field: c, smooth: true, shading: true,\n"
    "     opacity: [[-1, 0], [1, 0.5]]}, every: 2}\n"
    "  - {name: held, size: [40, 40], images: [color, cell], every: 2,\n"
    "     volume: {field: c, smooth: true, tolerance: 0.05, opacity: [[-1, 0], [1, 0.5]]}}\n"
    "  - {name: surfaces, size: [64, 64], images: [color, depth, cell], samples_per_pixel: 2,\n"
    "     isosurfaces: [{field: p, values: [1, 3], opacity: 0.6, normals: smooth,\n"
    "       color: {field: c}}, {field: c, values: [0.2], normals: smooth}],\n"
    "     boundary: {color: {field: u, component: 0}, opacity: 0.2}, outline: {ticks: true},\n"
    "     every: 2,\n"
    "     cameras: {side: {azimuth: 90}, top: {elevation: 80, orthographic: true, fit: box}}}\n"
    "  - {name: shadows, size: [40, 40], isosurfaces: [{field: p, values: [1], normals: "
    "central}],\n"
    "     every: 3,\n"
    "     volume: {field: p, opacity: [[0, 0], [5, 0.2]], shading: true},\n"
    "     lights: [{directional: [1, 1, 2]}, {point: [1.5, 0.4, 1.6], intensity: 0.5}],\n"
    "     effects: [shadows, volume_shadows, {ambient_occlusion: {samples: 4}}]}\n";

const Act two_cycles = [](PartSession& process, parallel::World&) {
  for (int cycle = 0; cycle < 3; ++cycle)
    EXPECT_EQ(process.execute(cycle), "");
};

} // namespace

/// With global ids, whatever the partition: images, depths, cells and ranges of colours.
TEST(ProcessFrames, FilesAreThoseOfOneProcessToTheByte) {
  const TestMesh whole = jittered_cubes();
  PartSession::Options options;
  options.scene = all_frames;
  const auto expected = run_parts(whole, fixtures::slabs(whole, 1), options, two_cycles);
  EXPECT_GE(expected.size(), 30u);
  for (const int processes : all_sizes)
    for (const fixtures::Partition& partition : fixtures::partitions(whole, processes))
      expect_same(expected, run_parts(whole, partition, options, two_cycles),
                  partition.name + " on " + std::to_string(processes));
}

/// Path traced volumes: alone, with samples that add up until something changes, and with surfaces
/// that light meets.
TEST(ProcessFrames, TracedPathsAreThoseOfOneProcessToTheByte) {
  const TestMesh whole = jittered_cubes();
  PartSession::Options options;
  options.scene = "insitu: 1\n"
                  "page: false\n"
                  "frames:\n"
                  "  - {name: light, size: [32, 30], images: [color, depth, cell],\n"
                  "     volume: {field: p, opacity: [[0, 0], [1, 0.3], [5, 0.8]]},\n"
                  "     lights: [{directional: [1, 1, 2]}, {dome: true}],\n"
                  "     effects: [multiple_scattering],\n"
                  "     path_tracing: {samples: 3, accumulate: true, anisotropy: 0.4}}\n"
                  "  - {name: walls, size: [20, 24], samples_per_pixel: 2,\n"
                  "     volume: {field: c, smooth: true, opacity: [[-1, 0], [1, 0.5]]},\n"
                  "     isosurfaces: [{field: p, values: [1], opacity: 0.7}],\n"
                  "     boundary: {color: {field: u, component: 0}, opacity: 0.2},\n"
                  "     lights: [{point: [1.5, 0.4, 1.6]}, {dome: true, intensity: 0.5}],\n"
                  "     effects: [single_scattering, volume_shadows], every: 3,\n"
                  "     path_tracing: {samples: 2}}\n";
  const Act act = [](PartSession& process, parallel::World& world) {
    EXPECT_EQ(process.execute(0), "");
    EXPECT_EQ(process.session().execute(1, 0.25), ""); // samples add up
    if (world.rank() == world.size() / 2)
      process.give_fields(0); // of one process alone
    EXPECT_EQ(process.session().execute(2, 0.5), "");
    EXPECT_EQ(process.execute(3), "");
  };
  const auto expected = run_parts(whole, fixtures::slabs(whole, 1), options, act);
  EXPECT_GE(expected.size(), 14u);
  EXPECT_NE(expected.at("light_000000.png"), expected.at("light_000001.png"));
  std::size_t kind = 0;
  for (const int processes : all_sizes) {
    const auto all = fixtures::partitions(whole, processes);
    const fixtures::Partition& partition = all[kind++ % all.size()];
    expect_same(expected, run_parts(whole, partition, options, act),
                partition.name + " on " + std::to_string(processes));
  }
}

/// Without global ids the first process's cells come first, as a mesh of one process in that order
/// has them: colours and depths are the same; cells have other numbers.
TEST(ProcessFrames, WithoutGlobalIds) {
  const TestMesh whole = jittered_cubes(4);
  PartSession::Options options;
  options.scene = all_frames;
  options.ids = false;
  const fixtures::Partition partition = fixtures::boxes(whole, 3);
  TestMesh in_order = whole;
  std::stable_sort(
      in_order.cells.begin(), in_order.cells.end(), [&](const MeshCell& a, const MeshCell& b) {
        const auto process = [&](const MeshCell& cell) {
          const auto at =
              std::find_if(whole.cells.begin(), whole.cells.end(),
                           [&](const MeshCell& c) { return c.vertices == cell.vertices; });
          return partition.process[std::size_t(at - whole.cells.begin())];
        };
        return process(a) < process(b);
      });
  // Fields of cells go by their numbers: here by none.
  std::string plain = options.scene;
  for (std::size_t at; (at = plain.find("field: c")) != std::string::npos;)
    plain.replace(at, 8, "field: p");
  options.scene = plain;
  const auto expected = run_parts(in_order, fixtures::slabs(in_order, 1), options, two_cycles);
  expect_same(expected, run_parts(whole, partition, options, two_cycles), "boxes");
}

/// What `compositing: standard` cannot do is exact, and a warning of the root says so once; in one
/// process the key says nothing.
TEST(ProcessFrames, StandardWhereItHasToBeExact) {
  const TestMesh whole = jittered_cubes(4);
  PartSession::Options options;
  options.scene =
      "insitu: 1\npage: false\nframes:\n  - {name: f, size: [40, 40], images: [color, depth], "
      "volume: {field: p, opacity: [[0, 0], [5, 0.8]]}}\n";
  const auto expected = run_parts(whole, fixtures::slabs(whole, 1), options, two_cycles);
  options.scene.insert(options.scene.rfind('}'), ", compositing: standard");
  for (const int processes : {1, 3}) {
    std::mutex mutex;
    std::vector<std::string> told;
    const auto files = run_parts(whole, fixtures::slabs(whole, processes), options,
                                 [&](PartSession& process, parallel::World& world) {
                                   two_cycles(process, world);
                                   const std::lock_guard lock(mutex);
                                   for (const std::string& message : process.messages())
                                     if (message.find("compositing") != std::string::npos)
                                       told.push_back(message);
                                 });
    expect_same(expected, files, std::to_string(processes));
    EXPECT_EQ(told, processes == 1 ? std::vector<std::string>{}
                                   : std::vector<std::string>{
                                         "cycle 0: frame 'f': its compositing is 'exact', as "
                                         "images of depth and of cells need each sample"});
  }
}

/// What a frame does not find fails on all processes alike, and the session goes on.
TEST(ProcessFrames, FailuresAreAlike) {
  const TestMesh whole = jittered_cubes(3);
  PartSession::Options options;
  options.scene =
      "insitu: 1\npage: false\nframes:\n  - {name: f, size: [32, 32], volume: {field: q}}\n"
      "  - {name: g, size: [32, 32], boundary: {}}\n";
  const auto files = run_parts(whole, fixtures::empty_root(whole, 3), options,
                               [&](PartSession& process, parallel::World&) {
                                 const std::string failures = process.execute(0);
                                 EXPECT_NE(failures.find("'q'"), std::string::npos) << failures;
                               });
  EXPECT_TRUE(files.contains("g_000000.png"));
  EXPECT_FALSE(files.contains("f_000000.png"));
}
