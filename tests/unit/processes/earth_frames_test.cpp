// Frames in longitude and latitude: each place of a chart once, against closed forms.
#include <cmath>

#include "fixtures/earth_meshes.h"
#include "output/image/png.h"
#include "part_session.h"

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
std::vector<double> waves(const TestMesh& mesh) {
  std::vector<double> q;
  for (const Vec3d& x : mesh.vertices)
    q.push_back(std::sin(3 * (x.x - 2) * std::numbers::pi / 180));
  return q;
}

std::map<std::string, std::string> drawn(const TestMesh& mesh, const std::string& frames,
                                         const fixtures::Partition& partition) {
  PartSession::Options options;
  options.scene = "insitu: 1\npage: false\nframes:\n" + frames;
  options.frame = fixtures::frame_of(units);
  return run_parts(mesh, partition, options, [&](PartSession& process, parallel::World&) {
    if (!process.part().empty())
      process.part().give_field(process.mesh().mesh(), "q", INSITU_VERTEX, 1, waves(mesh));
    EXPECT_EQ(process.execute(0), "");
  });
}

output::PngImage image_of(const std::string& bytes) {
  const OwnFolder folder;
  const std::string path = folder / "image.png";
  std::ofstream(path, std::ios::binary) << bytes;
  return output::read_png(path);
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

/// The opacity of each pixel of images that ought to be of one opacity, within so many codes.
void expect_opacity(const std::map<std::string, std::string>& files, const std::string& frame,
                    double straight, double aslant, double codes) {
  int images = 0;
  for (const auto& [name, bytes] : files) {
    if (name.rfind(frame, 0) != 0 || name.find(".png") == std::string::npos)
      continue;
    ++images;
    const double wanted = 255 * (name.find("aslant") == std::string::npos ? straight : aslant);
    const output::PngImage image = image_of(bytes);
    ASSERT_EQ(image.channels, 4);
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        EXPECT_NEAR(image.pixel(x, y)[3], wanted, codes) << name << " " << x << " " << y;
  }
  EXPECT_EQ(images, 4) << frame;
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
  for (const Ring& ring : rings) {
    SCOPED_TRACE(ring.name);
    const TestMesh mesh = mesh_of(ring);
    const auto files = drawn(mesh, frames, fixtures::slabs(mesh, 1));
    for (const char* const name : {"samples", "integrals", "held", "lit"})
      expect_opacity(files, name, 0.5, 1 - std::pow(0.5, longer), 1);
  }
}

/// Six levels a turn, though cells with one of them are there twice.
TEST(EarthVolume, SurfacesOfATurnAreMetOnce) {
  const std::string frames = std::string("  - {name: levels, ") + looks +
                             ",\n     isosurfaces: [{field: q, values: [0], opacity: 0.1}]}\n"
                             "  - {name: rays, " +
                             looks +
                             ",\n     isosurfaces: [{field: q, values: [0], opacity: 0.1, search: "
                             "cubic}]}\n";
  for (const Ring& ring : rings) {
    SCOPED_TRACE(ring.name);
    const TestMesh mesh = mesh_of(ring);
    const auto files = drawn(mesh, frames, fixtures::slabs(mesh, 1));
    const double six = 1 - std::pow(0.9, 6);
    expect_opacity(files, "levels", six, six, 1);
    expect_opacity(files, "rays", six, six, 1);
  }
}

/// Of paths half go through: 3 standard deviations of 32,768 paths.
TEST(EarthVolume, PathsGoThroughATurn) {
  const std::string frames =
      "  - {name: paths, size: [16, 16], background: transparent,\n"
      "     camera: {position: [-100, 10, -2], look_at: [0, 10, -2], orthographic: 3},\n"
      "     volume: {field: p, range: [-9, 9], opacity: [[-999, 0.5], [999, 0.5]], "
      "unit_distance: 360},\n"
      "     effects: [multiple_scattering], path_tracing: {samples: 128}}\n";
  for (const Ring& ring : rings) {
    SCOPED_TRACE(ring.name);
    const TestMesh mesh = mesh_of(ring);
    const auto files = drawn(mesh, frames, fixtures::slabs(mesh, 1));
    const output::PngImage image = image_of(files.at("paths_000000.png"));
    double sum = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        sum += image.pixel(x, y)[3] / 255.0;
    EXPECT_NEAR(sum / (16 * 16), 0.5, 3 * 0.5 / std::sqrt(128.0 * 16 * 16));
  }
}
