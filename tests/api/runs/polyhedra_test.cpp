// Hexahedra that are cut at planes, by their faces, show and tell what the same cube does whole.
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "coupled.h"
#include "cubes.h"
#include "fixtures/poly_dual.h"
#include "output/image/png.h"

namespace {

const char* const scene = R"(insitu: 1
page: false
probes:
  - {name: p, points: [[0.31, 0.47, 0.53], [0.72, 0.28, 0.61]], fields: [salt, number]}
frames:
  - {name: volume, size: [64, 64], volume: {field: salt, unit_distance: 1}}
  - {name: surface, size: [64, 64], isosurfaces: [{field: salt, values: [0.4], normals: smooth}]}
  - {name: boundary, size: [64, 64], boundary: {color: {field: salt, range: [0, 1]}}}
  - {name: paths, size: [32, 32], volume: {field: salt, unit_distance: 1}, path_tracing: {samples: 64}}
  - {name: averages, size: [64, 64], isosurfaces: [{field: ones, values: [0.5]}], boundary: {color: {field: ones, range: [0, 2]}}}
)";

/// The files of a run, of a cube that `give` hands over.
template <class Give>
void run(const std::string& output, Give&& give) {
  insitu::Options options;
  options.scene_text = scene;
  options.output = output;
  options.log = [](insitu::LogLevel level, const char* message) {
    if (level <= insitu::LogLevel::warning)
      ADD_FAILURE() << message;
  };
  insitu::Session session(options);
  insitu::Mesh mesh = session.mesh("m");
  give(mesh);
  ASSERT_TRUE(session.execute(0, 0.0)) << insitu_last_message();
  session.close();
}

void give_cells(insitu::Mesh& mesh, std::size_t cells, std::vector<double>& number,
                std::vector<double>& ones) {
  for (std::size_t c = 0; c < cells; ++c)
    number.push_back(double(c));
  ones.assign(cells, 1.0);
  mesh.cell_field("number", insitu::Array(number));
  mesh.cell_field("ones", insitu::Array(ones));
}

} // namespace

TEST(PolyhedralRuns, ShowWhatTheWholeCellsShow) {
  const test::Folder cut_folder, whole_folder;
  std::vector<double> number, ones, number_of_whole, ones_of_whole;
  runs::CutCube cut;
  insitu::test::TestMesh box = insitu::test::make_mesh(
      {.kind = insitu::test::MeshKind::hexahedra, .size = 4, .jitter = 0.0}, 3);
  for (auto& x : box.vertices)
    x = x / 4.0;
  runs::Arrays whole(box);
  const std::size_t cells = cut.faces.cell_offsets.size() - 1;
  run(cut_folder.path(), [&](insitu::Mesh& mesh) {
    cut.give(mesh);
    give_cells(mesh, cells, number, ones);
  });
  run(whole_folder.path(), [&](insitu::Mesh& mesh) {
    whole.give(mesh, false);
    give_cells(mesh, box.cells.size(), number_of_whole, ones_of_whole);
  });
  const runs::Table p = runs::parse_table(test::content(cut_folder / "p.csv"));
  for (std::size_t row = 0; row < 2; ++row) {
    EXPECT_NEAR(p.number(row, "salt"), row ? 0.72 : 0.31, 1e-14);
    EXPECT_EQ(p.number(row, "number"), p.number(row, "cell"));
    EXPECT_LT(p.number(row, "cell"), double(cells));
  }
  const auto image = [](const test::Folder& folder, const std::string& name) {
    return insitu::output::read_png(folder / (name + "_000000.png"));
  };
  for (const char* name : {"surface", "boundary", "averages"}) {
    const auto a = image(cut_folder, name), b = image(whole_folder, name);
    ASSERT_EQ(a.width, b.width);
    // The same field in other cells: single pixels at silhouettes, and codes next to each other.
    int others = 0, most = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) {
      const int differ = std::abs(int(a.pixels[i]) - int(b.pixels[i]));
      others += differ > 1;
      most = std::max(most, differ);
    }
    EXPECT_LE(others, int(a.pixels.size() / 500)) << name << ", at most " << most;
  }
  // A volume takes its steps, and paths their turns, by the size of the cells; light is the same.
  for (const char* name : {"volume", "paths"}) {
    const auto brightness = [&](const test::Folder& folder) {
      const auto a = image(folder, name);
      double sum = 0;
      for (const std::uint8_t code : a.pixels)
        sum += code;
      return sum / double(a.pixels.size());
    };
    EXPECT_NEAR(brightness(cut_folder), brightness(whole_folder), 2.0) << name;
  }
}

/// A steady vortex, linear in the coordinates, hence the same in all cells of a dual mesh: after a
/// turn each particle is back.
TEST(PolyhedralRuns, TracersOfAVortexComeBackInTheDualOfPolyDualMesh) {
  const test::Folder folder;
  insitu::fixtures::FaceArrays<> arrays(insitu::fixtures::poly_dual());
  std::vector<double> velocity;
  for (std::size_t v = 0; v < arrays.points.size(); v += 3)
    velocity.insert(velocity.end(), {1.5 - arrays.points[v + 1], arrays.points[v] - 1.5,
                                     0.1 * (arrays.points[v] - 1.5)});
  insitu::Options options;
  options.scene_text =
      "insitu: 1\npage: false\ntracers:\n  - {name: t, velocity: u, seeds: [[2.5, 1.5, 1.5], [1.5, "
      "0.3, 0.7], [0.2, 1.1, 2.4]], integrator: {method: dopri5, tolerance: 1e-11}}\n";
  options.output = folder.path();
  insitu::Session session(options);
  insitu::Mesh mesh = session.mesh("m");
  mesh.points(insitu::Array(arrays.points).components(3));
  mesh.faces(arrays.by_owner());
  mesh.vertex_field("u", insitu::Array(velocity).components(3));
  for (int cycle = 0; cycle <= 4; ++cycle)
    ASSERT_TRUE(session.execute(cycle, 0.5 * std::numbers::pi * cycle)) << insitu_last_message();
  session.close();
  const runs::Table t = runs::parse_table(test::content(folder / "t.csv"));
  const double seeds[3][3] = {{2.5, 1.5, 1.5}, {1.5, 0.3, 0.7}, {0.2, 1.1, 2.4}};
  int back = 0;
  for (std::size_t row = 0; row < t.rows.size(); ++row) {
    const double* const seed = seeds[std::size_t(t.number(row, "particle"))];
    const double x = t.number(row, "x"), y = t.number(row, "y"), z = t.number(row, "z");
    // The tolerance times the turns; z goes with the way that y has gone.
    EXPECT_NEAR(std::hypot(x - 1.5, y - 1.5), std::hypot(seed[0] - 1.5, seed[1] - 1.5), 1e-9);
    EXPECT_NEAR(z, seed[2] + 0.1 * (y - seed[1]), 1e-9);
    if (t.number(row, "cycle") != 4 || t.number(row, "cell") < 0)
      continue; // or the row that tells how it ended
    ++back;
    EXPECT_NEAR(x, seed[0], 1e-9);
    EXPECT_NEAR(y, seed[1], 1e-9);
  }
  EXPECT_EQ(back, 3);
}
