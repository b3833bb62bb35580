// Frames in longitude and latitude: each place of a chart once, against closed forms.
#include <cmath>
#include <functional>
#include <utility>

#include "fixtures/earth_meshes.h"
#include "images.h"

using namespace insitu;
using namespace insitu::test;

namespace {

/// Heights are kilometres.
const geo::ChartUnits units{false, true, false};
constexpr double south = -80, north = 80;

struct Ring {
  const char* name;
  bool wraps;
  double turn; ///< degrees by which each row of vertices stands east of that before
};
const Ring rings[] = {{"upright, with a column at either end", false, 0},
                      {"upright, wrapping on one side", true, 0},
                      {"turned by 7.3 degrees a row, wrapping on both sides", true, 7.3}};

TestMesh mesh_of(const Ring& ring) {
  fixtures::Lattice l;
  l.units = units;
  l.wraps = ring.wraps;
  l.west = 0, l.east = 360;
  l.south = south, l.north = north;
  l.across = 18, l.along = 8;
  TestMesh mesh = lattice(l);
  for (Vec3d& x : mesh.vertices)
    if (ring.turn != 0)
      x.x = geo::longitude_from(0, units, x.x + ring.turn * (x.y - south) / 20);
  return mesh;
}

/// Zero at the longitude 2 and each 60 degrees on: near the seam, in cells that wrap.
double wave(double longitude) {
  return std::sin(3 * (longitude - 2) * std::numbers::pi / 180);
}
std::vector<double> waves(const TestMesh& mesh) {
  std::vector<double> q;
  for (const Vec3d& x : mesh.vertices)
    q.push_back(wave(x.x));
  return q;
}
/// The same of cells, at their middles.
std::vector<double> waves_of_cells(const TestMesh& mesh) {
  std::vector<double> q;
  for (const MeshCell& cell : mesh.cells) {
    const double first = mesh.vertices[std::size_t(cell.vertices[0])].x;
    double sum = 0;
    for (const int v : cell.vertices)
      sum += std::remainder(mesh.vertices[std::size_t(v)].x - first, 360.0);
    q.push_back(wave(first + sum / 8));
  }
  return q;
}

/// The same each 120 degrees on an upright ring, with a valley at longitude 0.
std::vector<double> valleys(const TestMesh& mesh) {
  constexpr double at[] = {0, 1, 5, 6, 5, 1};
  std::vector<double> q;
  for (const Vec3d& x : mesh.vertices)
    q.push_back(at[std::lround(x.x / 20) % 6] + 0.02 * x.y);
  return q;
}

std::map<std::string, std::string> drawn(const TestMesh& mesh, const std::string& frames,
                                         const fixtures::Partition& partition) {
  PartSession::Options options;
  options.scene = "insitu: 1\npage: false\nframes:\n" + frames;
  options.frame = fixtures::frame_of(units);
  return run_parts(mesh, partition, options, [&](PartSession& process, parallel::World&) {
    if (!process.part().empty()) {
      process.part().give_field(process.mesh().mesh(), "q", INSITU_VERTEX, 1, waves(mesh));
      process.part().give_field(process.mesh().mesh(), "s", INSITU_VERTEX, 1, valleys(mesh));
      process.part().give_field(process.mesh().mesh(), "d", INSITU_CELL, 1, waves_of_cells(mesh));
    }
    EXPECT_EQ(process.execute(0), "");
  });
}

/// Rays along parallels of 360 degrees, some aslant, that meet no side of the ring but its ends.
const char* const looks = "size: [6, 6], background: transparent, cameras: {\n"
                          "      equator: {position: [-100, 10, -2], look_at: [0, 10, -2], "
                          "orthographic: 3},\n"
                          "      far: {position: [-100, -47, -2], look_at: [0, -47, -2], "
                          "orthographic: 3},\n"
                          "      back: {position: [460, 31, -2], look_at: [0, 31, -2], "
                          "orthographic: 3},\n"
                          "      aslant: {position: [-100, -30, -2], look_at: [0, -20, -2], "
                          "orthographic: 3}}";

/// The opacity of each pixel.
void expect_opacity(const std::string& name, const std::string& bytes, double wanted,
                    double codes) {
  const output::PngImage image = image_of(bytes);
  ASSERT_EQ(image.channels, 4);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      EXPECT_NEAR(image.pixel(x, y)[3], 255 * wanted, codes) << name << " " << x << " " << y;
}

/// The same of images that ought to be of one opacity, within so many codes.
void expect_opacity(const std::map<std::string, std::string>& files, const std::string& frame,
                    double straight, double aslant, double codes) {
  int images = 0;
  for (const auto& [name, bytes] : files) {
    if (name.rfind(frame, 0) != 0 || name.find(".png") == std::string::npos)
      continue;
    ++images;
    expect_opacity(name, bytes, name.find("aslant") == std::string::npos ? straight : aslant,
                   codes);
  }
  EXPECT_EQ(images, 4) << frame;
}

/// check(ring, files): of frames of each ring, in one process.
template <class Check>
void on_each_ring(const std::string& frames, Check&& check) {
  for (const Ring& ring : rings) {
    SCOPED_TRACE(ring.name);
    const TestMesh mesh = mesh_of(ring);
    check(ring, drawn(mesh, frames, fixtures::slabs(mesh, 1)));
  }
}

} // namespace

/// Half of the light is left after a turn, by samples, pre-integrated, with a tolerance and lit.
TEST(EarthVolume, ATurnHasTheLengthOfATurn) {
  const auto frame = [](const std::string& name, const std::string& more) {
    return "  - {name: " + name + ", " + looks +
           ",\n     volume: {field: p, colors: gray, range: [-9, 9], opacity: [[-999, 0.5], [999, "
           "0.5]], unit_distance: 360" +
           more + "}}\n";
  };
  const std::string frames = frame("samples", ", preintegrated: false") + frame("integrals", "") +
                             frame("held", ", tolerance: 0.002") + frame("lit", ", shading: true");
  const double longer = std::sqrt(1 + 0.1 * 0.1);
  on_each_ring(frames, [&](const Ring&, const auto& files) {
    for (const char* const name : {"samples", "integrals", "held", "lit"})
      expect_opacity(files, name, 0.5, 1 - std::pow(0.5, longer), 1);
  });
}

/// Six levels a turn, though cells with one of them are there twice, of vertices and of averages
/// over the seam.
TEST(EarthVolume, SurfacesOfATurnAreMetOnce) {
  const std::string frames = std::string("  - {name: levels, ") + looks +
                             ",\n     isosurfaces: [{field: q, values: [0], opacity: 0.1}]}\n"
                             "  - {name: rays, " +
                             looks +
                             ",\n     isosurfaces: [{field: q, values: [0], opacity: 0.1, search: "
                             "cubic}]}\n  - {name: averages, " +
                             looks +
                             ",\n     isosurfaces: [{field: d, values: [0], opacity: 0.1, normals: "
                             "smooth}]}\n";
  on_each_ring(frames, [&](const Ring& ring, const auto& files) {
    const double six = 1 - std::pow(0.9, 6);
    expect_opacity(files, "levels", six, six, 1);
    expect_opacity(files, "rays", six, six, 1);
    if (ring.wraps) // the column at the other end is another one
      expect_opacity(files, "averages", six, six, 1);
  });
}

/// A surface 10 degrees east of the seam is lit as one 120 degrees further on, in the same cells.
TEST(EarthVolume, SmoothNormalsGoOverTheSeam) {
  const std::string frames =
      "  - {name: lit, size: [12, 12], isosurfaces: [{field: s, values: [0.5], normals: smooth}],\n"
      "     cameras: {seam: {position: [-5, 0, -2], look_at: [0, 0, -2], orthographic: 3},\n"
      "       inside: {position: [115, 0, -2], look_at: [120, 0, -2], orthographic: 3}}}\n";
  const TestMesh mesh = mesh_of(rings[1]);
  const auto files = drawn(mesh, frames, fixtures::slabs(mesh, 1));
  const output::PngImage seam = image_of(files.at("lit_seam_000000.png"));
  const output::PngImage inside = image_of(files.at("lit_inside_000000.png"));
  for (int y = 0; y < seam.height; ++y)
    for (int x = 0; x < seam.width; ++x)
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(seam.pixel(x, y)[c], inside.pixel(x, y)[c], 1) << x << " " << y;
        EXPECT_LT(seam.pixel(x, y)[c], 250); // not the white background
      }
}

/// Where cells wrap around there is no wall at the seam; a roof and a floor are there once.
TEST(EarthVolume, TheSeamIsNoBoundary) {
  const std::string frames =
      std::string("  - {name: walls, ") + looks +
      ", boundary: {opacity: 0.1}}\n"
      "  - {name: above, size: [35, 15], background: transparent, boundary: {opacity: 0.1},\n"
      "     camera: {position: [180, 0, 90], look_at: [180, 0, 0], up: [0, 1, 0], orthographic: "
      "150}}\n";
  on_each_ring(frames, [&](const Ring& ring, const auto& files) {
    const double walls = ring.wraps ? 0.0 : 1 - 0.9 * 0.9;
    expect_opacity(files, "walls", walls, walls, 1);
    expect_opacity("above", files.at("above_000000.png"), 1 - 0.9 * 0.9, 1);
  });
}

/// Of paths half go through: 3 standard deviations of 32,768 paths.
TEST(EarthVolume, PathsGoThroughATurn) {
  const std::string frames =
      "  - {name: paths, size: [16, 16], background: transparent,\n"
      "     camera: {position: [-100, 10, -2], look_at: [0, 10, -2], orthographic: 3},\n"
      "     volume: {field: p, range: [-9, 9], opacity: [[-999, 0.5], [999, 0.5]], "
      "unit_distance: 360},\n"
      "     effects: [multiple_scattering], path_tracing: {samples: 128}}\n";
  on_each_ring(frames, [&](const Ring&, const auto& files) {
    const output::PngImage image = image_of(files.at("paths_000000.png"));
    double sum = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        sum += image.pixel(x, y)[3] / 255.0;
    EXPECT_NEAR(sum / (16 * 16), 0.5, 3 * 0.5 / std::sqrt(128.0 * 16 * 16));
  });
}

namespace {

/// The ring's cells that are in one of two meshes, and the others, by where their columns are.
std::pair<TestMesh, TestMesh> cut(const TestMesh& ring, const std::function<bool(int)>& is_first) {
  std::pair<TestMesh, TestMesh> parts{ring, ring};
  parts.first.cells.clear();
  parts.second.cells.clear();
  for (std::size_t c = 0; c < ring.cells.size(); ++c)
    (is_first(int(c % 18)) ? parts.first : parts.second).cells.push_back(ring.cells[c]);
  return parts;
}

} // namespace

/// A ring that is cut into two meshes, whose charts would begin elsewhere, shows what the whole one
/// shows: surfaces to the byte, a homogeneous medium within a code, and paths by their mean. Charts
/// on which the solver's points are located stay as they are.
TEST(EarthVolume, ACutRingIsTheWhole) {
  const std::string surfaces = "isosurfaces: [{field: p, values: [-60, 15], opacity: 0.5, color: "
                               "{field: p, range: [-300, 300]}}]",
                    medium = "volume: {field: p, colors: gray, range: [-9, 9], opacity: [[-999, "
                             "0.5], [999, 0.5]], unit_distance: 360}";
  const std::string look = "size: [48, 32], cameras: {above: {azimuth: -70, elevation: 60}, seam: "
                           "{position: [-60, -80, 50], look_at: [0, 0, 0]}}, ";
  const auto parts = [](const std::string& what) {
    return "meshes: [{mesh: n, " + what + "}, {mesh: k, " + what + "}]}\n";
  };
  const std::string frames =
      "  - {name: whole, " + look + "mesh: m, " + surfaces + "}\n  - {name: parts, " + look +
      parts(surfaces) + "  - {name: turn, " + looks + ", " + parts(medium) +
      "  - {name: paths, size: [16, 16], background: transparent, path_tracing: {samples: 128},\n"
      "     camera: {position: [-100, 10, -2], look_at: [0, 10, -2], orthographic: 3}, " +
      parts(medium);
  const std::function<bool(int)> cuts[] = {[](int column) { return column < 9; },
                                           [](int column) { return column % 3 == 0; },
                                           [](int column) { return column == 17; }};
  for (const Ring& ring : rings)
    for (const auto& is_first : cuts) {
      SCOPED_TRACE(testing::Message() << ring.name << ", cut " << &is_first - cuts);
      const TestMesh whole = mesh_of(ring);
      const auto [first, second] = cut(whole, is_first);
      PartSession::Options options;
      options.scene = "insitu: 1\npage: false\nframes:\n" + frames;
      options.frame = fixtures::frame_of(units);
      const auto files =
          run_parts(whole, fixtures::slabs(whole, 1), options,
                    [&](PartSession& process, parallel::World& world) {
                      FurtherMesh n(process, "n", first, fixtures::slabs(first, 1), world.rank(),
                                    options.frame);
                      FurtherMesh k(process, "k", second, fixtures::slabs(second, 1), world.rank(),
                                    options.frame);
                      n.give_fields(0);
                      k.give_fields(0);
                      const auto west = [&](const char* name) {
                        return process.session().mesh(name).mesh.stand_in()->chart()->west;
                      };
                      EXPECT_EQ(process.execute(0), "");
                      if (ring.wraps && ring.turn == 0 && &is_first == cuts) {
                        EXPECT_EQ(west("n"), 0);
                        EXPECT_EQ(west("k"), 180);
                        EXPECT_NE(process.session().plan().find("on the chart of all meshes"),
                                  std::string::npos);
                      }
                    });
      for (const char* camera : {"above", "seam"}) {
        const std::string behind = std::string("_") + camera + "_000000.png";
        EXPECT_EQ(files.at("whole" + behind), files.at("parts" + behind)) << camera;
      }
      // Where the cells of a mesh end within its box is known to half a step.
      expect_opacity(files, "turn", 0.5, 1 - std::pow(0.5, std::sqrt(1 + 0.1 * 0.1)),
                     &is_first == cuts + 1 ? 2 : 1);
      const output::PngImage image = image_of(files.at("paths_000000.png"));
      double sum = 0;
      for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
          sum += image.pixel(x, y)[3] / 255.0;
      EXPECT_NEAR(sum / (16 * 16), 0.5, 3 * 0.5 / std::sqrt(128.0 * 16 * 16));
    }
}

/// Meshes of which each has a seam of its own, on a chart of both, and from space: those of one
/// process, however they are cut.
TEST(EarthVolume, SeveralMeshesOverTheSeam) {
  const TestMesh ocean = mesh_of(rings[2]);
  TestMesh air = mesh_of(rings[1]);
  for (Vec3d& x : air.vertices)
    x = {x.x - 180, x.y, x.z + 40};
  const std::string meshes =
      "    meshes:\n      - {mesh: m, isosurfaces: [{field: c, values: [0.3], normals: smooth}]}\n"
      "      - {mesh: n, volume: {field: p, opacity: [[-1, 0], [5, 0.3]], unit_distance: 400}, "
      "boundary: {opacity: 0.3}}\n";
  PartSession::Options options;
  options.scene =
      "insitu: 1\npage: false\nframes:\n  - name: chart\n    size: [48, 40]\n    format: "
      "[exr, png]\n    images: [color, cell]\n    camera: {azimuth: -60, elevation: 30}\n" +
      meshes +
      "  - name: space\n    size: [48, 40]\n    format: [exr, png]\n"
      "    geocentric: {exaggeration: 20}\n" +
      meshes;
  options.frame = fixtures::frame_of(units);
  std::map<std::string, std::string> expected;
  for (const int processes : {1, 2, 3, 4}) {
    const fixtures::Partition of_ocean = fixtures::boxes(ocean, processes);
    const fixtures::Partition of_air =
        processes == 1 ? fixtures::slabs(air, 1) : fixtures::empty_root(air, processes);
    const auto files =
        run_parts(ocean, of_ocean, options, [&](PartSession& process, parallel::World& world) {
          FurtherMesh n(process, "n", air, of_air, world.rank(), options.frame);
          for (const int cycle : {0, 1}) {
            n.give_fields(cycle);
            EXPECT_EQ(process.execute(cycle), "");
          }
        });
    EXPECT_TRUE(files.contains("chart_000001.exr"));
    EXPECT_TRUE(files.contains("space_000001.png"));
    if (processes == 1)
      expected = files;
    expect_same(expected, files, std::to_string(processes));
  }
}
