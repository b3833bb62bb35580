// Frames of several meshes over several processes, beside those of one process.
#include <cmath>

#include "images.h"

using namespace insitu;
using namespace insitu::test;

namespace {

using Files = std::map<std::string, std::string>;

/// Cubes from 0 to 4 (mesh 'm'), tetrahedra that stand in a part of them ('n'), and a few wedges
/// within both ('k').
struct Wholes {
  TestMesh m = jittered_cubes(4), n = placed(MeshKind::tetrahedra, 3, {1.3, 1.1, 0.9}, 1.4, 5),
           k = placed(MeshKind::wedges, 2, {2.1, 1.9, 2.3}, 0.6, 9);

  static TestMesh placed(MeshKind kind, int size, const Vec3d& at, double scale, int seed) {
    MeshOptions options;
    options.size = size;
    options.jitter = 0.1;
    options.kind = kind;
    TestMesh mesh = make_mesh(options, std::uint64_t(seed));
    for (Vec3d& x : mesh.vertices)
      x = at + scale * x;
    return mesh;
  }
};

/// How the meshes are cut, each in its own way.
struct Cut {
  fixtures::Partition m, n, k;
};

std::vector<Cut> cuts(const Wholes& w, int processes) {
  using namespace fixtures;
  if (processes == 1)
    return {{slabs(w.m, 1), in_pieces(slabs(w.n, 1), 2), slabs(w.k, 1)}};
  // All of a mesh on one process; others lack it.
  const auto on = [&](const TestMesh& mesh, int process) {
    return Partition{"on one", processes, std::vector<int>(mesh.cells.size(), process)};
  };
  return {{slabs(w.m, processes), boxes(w.n, processes), on(w.k, processes - 1)},
          {boxes(w.m, processes), empty_root(w.n, processes), dealt(w.k, processes)},
          {dealt(w.m, processes), in_pieces(slabs(w.n, processes), 2), on(w.k, 0)},
          {on(w.m, 0), on(w.n, processes - 1), boxes(w.k, processes)}};
}

Files run(const Wholes& wholes, const Cut& cut, const std::string& frames,
          std::vector<std::string>* told = nullptr) {
  PartSession::Options options;
  options.scene = "insitu: 1\npage: false\nframes:\n" + frames;
  std::mutex mutex;
  return run_parts(wholes.m, cut.m, options, [&](PartSession& process, parallel::World& world) {
    FurtherMesh n(process, "n", wholes.n, cut.n, world.rank());
    FurtherMesh k(process, "k", wholes.k, cut.k, world.rank());
    for (int cycle = 0; cycle < 2; ++cycle) {
      n.give_fields(cycle);
      k.give_fields(cycle);
      EXPECT_EQ(process.execute(cycle), "");
    }
    const std::lock_guard lock(mutex);
    for (const std::string& message : process.messages())
      if (told && message.find("frame") != std::string::npos)
        told->push_back(message);
  });
}

void expect_same_on_all(const std::string& frames, std::size_t least_files) {
  const Wholes wholes;
  const Files one = run(wholes, cuts(wholes, 1)[0], frames);
  EXPECT_GE(one.size(), least_files);
  for (const int processes : {2, 3, 4}) {
    int number = 0;
    for (const Cut& cut : cuts(wholes, processes))
      expect_same(one, run(wholes, cut, frames),
                  std::to_string(processes) + " processes, cut " + std::to_string(number++));
  }
}

/// Of images of 8 bits, in codes.
int greatest_step(const output::PngImage& a, const output::PngImage& b) {
  int most = 0;
  EXPECT_EQ(a.pixels.size(), b.pixels.size());
  for (std::size_t i = 0; i < std::min(a.pixels.size(), b.pixels.size()); ++i)
    most = std::max(most, std::abs(int(a.pixels[i]) - int(b.pixels[i])));
  return most;
}

TEST(ProcessFramesOfMeshes, VolumesThatOverlap) {
  expect_same_on_all(
      "  - name: integrals\n    size: [70, 66]\n    images: [color, depth, cell]\n    format: "
      "[png, "
      "exr]\n"
      "    scalar_bar: true\n    outline: {ticks: true}\n    meshes:\n"
      "      - {mesh: m, volume: {field: p, opacity: [[0, 0], [16, 0.05]]}}\n"
      "      - {mesh: n, volume: {field: c, smooth: true, shading: true, colors: inferno, opacity: "
      "[[-1, 0], [1, 0.05]]}, isosurfaces: [{field: p, values: [2.5], opacity: 0.5}]}\n"
      "      - {mesh: k, boundary: {color: [0.2, 0.4, 0.9]}}\n"
      "  - name: samples\n    size: [40, 40]\n    samples_per_pixel: 2\n    accuracy: fast\n"
      "    format: [png, exr]\n    clip: [{plane: {point: [2, 2, 2], normal: [1, 0.2, 0.1]}}]\n"
      "    meshes:\n"
      "      - {mesh: n, volume: {field: c, opacity: [[-1, 0], [1, 0.05]]}}\n"
      "      - {mesh: m, volume: {field: p, tolerance: 0.05, opacity: [[0, 0], [16, 0.05]]}}\n"
      "      - {mesh: k, volume: {field: p, unit_distance: 0.3}}\n",
      8);
}

TEST(ProcessFramesOfMeshes, SurfacesInOneOrder) {
  expect_same_on_all(
      "  - name: one_volume\n    size: [66, 70]\n    images: [color, depth, cell]\n    format: "
      "[png, "
      "exr]\n"
      "    cameras: {side: {azimuth: 90}, top: {elevation: 80, orthographic: true, fit: box}}\n"
      "    meshes:\n"
      "      - {mesh: n, isosurfaces: [{field: c, values: [0.2], normals: smooth, opacity: 0.7},\n"
      "          {field: p, values: [2, 3], normals: central, color: {field: c}}]}\n"
      "      - {mesh: m, volume: {field: p, opacity: [[0, 0], [16, 0.05]]}}\n"
      "      - {mesh: k, boundary: {color: {field: c}, opacity: 0.6}}\n"
      "  - name: twice\n    size: [48, 48]\n    format: [png, exr]\n    effects: []\n    meshes:\n"
      "      - {mesh: m, isosurfaces: [{field: p, values: [1], color: {field: c}}]}\n"
      "      - {mesh: m, boundary: {color: {field: p}, opacity: 0.2}, isosurfaces: [{field: p, "
      "values: [1], opacity: 0.5}]}\n",
      9);
}

/// Rays of light meet what all meshes have: surfaces, boundaries, bodies, volumes.
TEST(ProcessFramesOfMeshes, LightAndShadows) {
  const OwnFolder folder;
  std::ofstream(folder / "body.stl")
      << "solid body\nfacet normal 0 0 1\nouter loop\nvertex 0.5 0.5 3.4\nvertex 3 0.5 3.4\nvertex "
         "1 3 3.6\nendloop\nendfacet\nendsolid body\n";
  const std::string lights =
      "    lights: [{directional: [1, 1, 2]}, {point: [1.5, 0.4, 6], intensity: 20}]\n"
      "    bodies: [{file: '" +
      folder / "body.stl" + "', opacity: 0.8}]\n";
  const std::string effects =
      "    effects: [shadows, volume_shadows, {ambient_occlusion: {samples: 3}}]\n";
  expect_same_on_all(
      "  - name: lit\n    size: [36, 40]\n    format: [png, exr]\n" + lights + effects +
          "    meshes:\n"
          "      - {mesh: n, isosurfaces: [{field: p, values: [2.5], opacity: 0.9}],\n"
          "          volume: {field: p, colors: inferno, opacity: [[0, 0], [16, 0.03]]}}\n"
          "      - {mesh: m, volume: {field: p, opacity: [[0, 0], [16, 0.03]], shading: true}}\n"
          "      - {mesh: k, boundary: {opacity: 0.8}}\n"
          "  - name: shadows\n    size: [36, 36]\n    format: [png, exr]\n    effects: "
          "[shadows]\n" +
          lights +
          "    meshes:\n"
          "      - {mesh: m, isosurfaces: [{field: p, values: [1], normals: cell}]}\n"
          "      - {mesh: n, isosurfaces: [{field: c, values: [0.2], opacity: 0.5}]}\n"
          "      - {mesh: k, boundary: {}}\n",
      5);
}

/// Media of several meshes, one of which some processes lack; surfaces that light meets on its way,
/// or does not; samples of pixels, and those that add up from cycle to cycle.
TEST(ProcessFramesOfMeshes, TracedPaths) {
  const std::string lights =
      "    lights: [{dome: true, color: [0.3, 0.4, 0.5]}, {directional: [1, 1, 2]}, "
      "{point: [1.5, 0.4, 6]}]\n";
  expect_same_on_all(
      "  - name: walls\n    size: [20, 18]\n    every: 2\n    format: [png, exr]\n    images: "
      "[color, depth, cell]\n" +
          lights +
          "    effects: [multiple_scattering, shadows, volume_shadows]\n"
          "    path_tracing: {samples: 2, anisotropy: 0.3}\n    meshes:\n"
          "      - {mesh: k, boundary: {opacity: 0.6}}\n"
          "      - {mesh: n, volume: {field: p, colors: inferno, opacity: [[0, 0], [16, 0.4]]},\n"
          "          isosurfaces: [{field: p, values: [2.5], opacity: 0.7, normals: central}]}\n"
          "      - {mesh: m, volume: {field: p, opacity: [[0, 0], [16, 0.2]]}}\n"
          "  - name: sums\n    size: [20, 18]\n    format: [png, exr]\n" +
          lights +
          "    effects: [single_scattering]\n"
          "    path_tracing: {samples: 3, accumulate: true, dome_visible: true}\n    meshes:\n"
          "      - {mesh: m, volume: {field: c, opacity: [[-1, 0], [1, 0.2]]}}\n"
          "      - {mesh: k, volume: {field: p, unit_distance: 0.3}}\n"
          "      - {mesh: n, isosurfaces: [{field: p, values: [2], opacity: 0.5}]}\n"
          "  - name: pixels\n    size: [18, 20]\n    every: 2\n    format: [exr]\n    "
          "samples_per_pixel: 2\n"
          "    clip: [{plane: {point: [2, 2, 2], normal: [1, 0.2, 0.1]}}]\n"
          "    path_tracing: {samples: 4}\n    meshes:\n"
          "      - {mesh: m, volume: {field: p, opacity: [[0, 0], [16, 0.2]]}}\n"
          "      - {mesh: m, volume: {field: c, smooth: true, opacity: [[-1, 0], [1, 0.1]]}}\n"
          "      - {mesh: k, boundary: {}}\n",
      8);
}

/// With one volume surfaces of other meshes part it; several volumes are exact in any case, and a
/// warning of the root says so once.
TEST(ProcessFramesOfMeshes, StandardCompositing) {
  const Wholes wholes;
  const std::string one_volume =
      "  - name: f\n    size: [70, 66]\n    meshes:\n"
      "      - {mesh: n, isosurfaces: [{field: p, values: [2.5], opacity: 0.4}]}\n"
      "      - {mesh: m, volume: {field: p, opacity: [[0, 0], [1, 0.1], [5, 0.8]]}}\n"
      "      - {mesh: k, boundary: {opacity: 0.5}}\n";
  const std::string two_volumes =
      "  - name: f\n    size: [40, 40]\n    meshes:\n"
      "      - {mesh: n, volume: {field: p}}\n      - {mesh: m, volume: {field: p}}\n";
  const std::string standard = "    compositing: standard\n";
  const Files one = run(wholes, cuts(wholes, 1)[0], one_volume);
  const Files two = run(wholes, cuts(wholes, 1)[0], two_volumes);
  for (const int processes : {2, 4}) {
    const Cut cut = cuts(wholes, processes)[0];
    std::vector<std::string> told;
    const Files found = run(wholes, cut, one_volume + standard, &told);
    EXPECT_TRUE(told.empty());
    for (const char* name : {"f_000000.png", "f_000001.png"})
      EXPECT_LE(greatest_step(image_of(one.at(name)), image_of(found.at(name))), 1);
    expect_same(two, run(wholes, cut, two_volumes + standard, &told), "two volumes");
    EXPECT_EQ(told, std::vector<std::string>{"cycle 0: frame 'f': its compositing is 'exact', as "
                                             "volumes of several meshes are blended sample by "
                                             "sample"});
  }
}

/// A mesh that no process has is an error, alike on all; one without cells is left out until it has
/// some, and a warning of the root says so once.
TEST(ProcessFramesOfMeshes, AMeshMayComeLater) {
  const Wholes wholes;
  PartSession::Options options;
  options.scene = "insitu: 1\npage: false\nframes:\n"
                  "  - {name: f, size: [40, 40], format: [png, exr], meshes: [\n"
                  "     {mesh: m, volume: {field: p}},\n"
                  "     {mesh: n, volume: {field: p}, isosurfaces: [{field: p, values: [2]}]}]}\n";
  Files expected;
  for (const int processes : {1, 2, 3}) {
    std::mutex mutex;
    int warnings = 0;
    const Cut cut = cuts(wholes, processes)[0];
    const Files files =
        run_parts(wholes.m, cut.m, options, [&](PartSession& process, parallel::World& world) {
          const std::string failures = process.execute(0);
          EXPECT_NE(failures.find("the session has no mesh 'n'"), std::string::npos) << failures;
          if (world.rank() == world.size() - 1)
            process.session().mesh("n"); // without cells
          EXPECT_EQ(process.execute(1), "");
          EXPECT_EQ(process.execute(2), "");
          FurtherMesh n(process, "n", wholes.n, cut.n, world.rank());
          n.give_fields(3);
          EXPECT_EQ(process.execute(3), "");
          const std::lock_guard lock(mutex);
          for (const std::string& message : process.messages())
            warnings += message.find("it is left out until it has") != std::string::npos;
        });
    EXPECT_EQ(warnings, 1);
    EXPECT_FALSE(files.contains("f_000000.exr"));
    EXPECT_TRUE(files.contains("f_000001.exr") && files.contains("f_000003.exr"));
    if (processes == 1)
      expected = files;
    expect_same(expected, files, std::to_string(processes));
  }
}

/// A field that one of the meshes lacks fails on all processes alike.
TEST(ProcessFramesOfMeshes, FailuresAreAlike) {
  const Wholes wholes;
  PartSession::Options options;
  options.scene = "insitu: 1\npage: false\nframes:\n"
                  "  - {name: f, size: [8, 8], meshes: [{mesh: m, boundary: {}}, {mesh: n, volume: "
                  "{field: q}}]}\n"
                  "  - {name: g, size: [8, 8], meshes: [{mesh: m, boundary: {}}, {mesh: n, volume: "
                  "{field: p}}]}\n";
  const Cut cut = cuts(wholes, 3)[1];
  const Files files =
      run_parts(wholes.m, cut.m, options, [&](PartSession& process, parallel::World& world) {
        FurtherMesh n(process, "n", wholes.n, cut.n, world.rank());
        n.give_fields(0);
        const std::string failures = process.execute(0);
        EXPECT_NE(failures.find("'q'"), std::string::npos) << failures;
        EXPECT_EQ(failures.find("frame 'g'"), std::string::npos) << failures;
      });
  EXPECT_TRUE(files.contains("g_000000.png"));
  EXPECT_FALSE(files.contains("f_000000.png"));
}

} // namespace
