// Hexahedra that are cut at planes, by their faces, show and tell what the same cube does whole.
#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <map>
#include <numbers>

#include "coupled.h"
#include "cubes.h"
#include "fixtures/poly_dual.h"
#include "fixtures/subdivided.h"
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

namespace {

const char* const methods[] = {"euler", "rk4", "bs32", "dopri5"};

/// A tracer of each method, with steps that end at faces and that do not.
std::string tracers_of_all_methods() {
  std::string text = "insitu: 1\npage: false\ntracers:\n";
  for (const std::string method : methods)
    for (const bool face_aware : {false, true}) {
      const bool is_fixed = method == "euler" || method == "rk4";
      text += "  - {name: " + method + (face_aware ? "_faces" : "") +
              ", velocity: u, seeds: {box: {min: [0.3, 0.4, 0.5], max: [3.6, 3.5, 3.3], counts: "
              "[4, 4, 3]}}, fields: [f], integrator: {method: " +
              method + ", face_aware: " + (face_aware ? "true" : "false") +
              (is_fixed           ? ", step: 0.04"
               : method == "bs32" ? ", tolerance: 1e-6"
                                  : ", tolerance: 1e-9") +
              "}}\n";
    }
  return text;
}

/// The tables of a run of some cycles. give: the cells of the mesh.
std::map<std::string, runs::Table> tables_of(const std::vector<double>& points,
                                             const std::vector<double>& velocity,
                                             const std::vector<double>& field,
                                             const std::function<void(insitu::Mesh&)>& give) {
  const test::Folder folder;
  insitu::Options options;
  options.scene_text = tracers_of_all_methods();
  options.output = folder.path();
  insitu::Session session(options);
  insitu::Mesh mesh = session.mesh("m");
  mesh.points(insitu::Array(points).components(3));
  give(mesh);
  mesh.vertex_field("u", insitu::Array(velocity).components(3));
  mesh.vertex_field("f", insitu::Array(field));
  for (int cycle = 0; cycle < 3; ++cycle)
    EXPECT_TRUE(session.execute(cycle, 0.4 * cycle)) << insitu_last_message();
  session.close();
  std::map<std::string, runs::Table> tables;
  for (const std::string method : methods)
    for (const std::string end : {"", "_faces"})
      tables[method + end] = runs::parse_table(test::content(folder / (method + end + ".csv")));
  return tables;
}

/// A velocity that is linear nowhere, and a field.
void put_flow(const insitu::test::Vec3d& x, std::vector<double>& velocity,
              std::vector<double>& field) {
  velocity.insert(velocity.end(), {2 - x.y + 0.3 * std::sin(2 * x.x), x.x - 2 + 0.2 * x.z * x.z,
                                   0.4 * std::cos(x.x + x.y)});
  field.push_back(std::sin(x.x) * x.y + 0.1 * x.z * x.z);
}

/// The same rows; cells by cell_of.
void expect_same_tables(const std::map<std::string, runs::Table>& is,
                        const std::map<std::string, runs::Table>& expected,
                        const std::function<double(double)>& cell_of) {
  for (const auto& [name, want] : expected) {
    const runs::Table& table = is.at(name);
    ASSERT_EQ(table.rows.size(), want.rows.size()) << name;
    EXPECT_GT(table.rows.size(), 80u);
    double most = 0;
    for (std::size_t row = 0; row < want.rows.size(); ++row) {
      for (const char* const column : {"cycle", "particle", "ending"})
        ASSERT_EQ(table.text(row, column), want.text(row, column)) << name << ", row " << row;
      for (const char* const column : {"time", "x", "y", "z", "f"}) {
        const double a = table.number(row, column), b = want.number(row, column);
        ASSERT_EQ(std::isnan(a), std::isnan(b));
        if (!std::isnan(a))
          most = std::max(most, std::abs(a - b));
      }
      EXPECT_EQ(table.number(row, "cell"), cell_of(want.number(row, "cell")))
          << name << ", row " << row;
    }
    // Places add up some hundred roundings. Where an error over faces within a step is estimated
    // from roundings that differ, other steps are taken, and both keep the tolerance.
    EXPECT_LE(most, name == "bs32" ? 1e-6 : name == "dopri5" ? 1e-9 : 1e-12) << name;
  }
}

} // namespace

/// By every method, with steps that end at faces and that do not.
TEST(PolyhedralRuns, TracersGoAsInTheSameCellsByShapes) {
  const insitu::test::TestMesh box = insitu::test::make_mesh(
      {.kind = insitu::test::MeshKind::mixed, .size = 4, .jitter = 0.15}, 3);
  const insitu::fixtures::SolverArrays shapes(box);
  const insitu::fixtures::FaceArrays<> faces(insitu::fixtures::faces_of(box));
  std::vector<double> u, f;
  for (const auto& x : box.vertices)
    put_flow(x, u, f);
  expect_same_tables(
      tables_of(faces.points, u, f, [&](insitu::Mesh& mesh) { mesh.faces(faces.by_owner()); }),
      tables_of(
          shapes.points, u, f,
          [&](insitu::Mesh& mesh) { mesh.mixed_cells(shapes.types, shapes.offsets, shapes.ids); }),
      [](double cell) { return cell; });
}

TEST(PolyhedralRuns, TracersGoAsInTheCellsThatOctahedraAreCutInto) {
  const insitu::fixtures::FaceMesh mesh = insitu::fixtures::octahedra(2, 0.1);
  const insitu::fixtures::Subdivided parts(mesh);
  const insitu::fixtures::SolverArrays shapes(parts.mesh);
  const insitu::fixtures::FaceArrays<> faces(mesh);
  std::vector<double> u, f;
  for (const auto& x : mesh.vertices)
    put_flow(x, u, f);
  const std::vector<double> u_made = parts.with_made(u, 3), f_made = parts.with_made(f);
  expect_same_tables(
      tables_of(faces.points, u, f, [&](insitu::Mesh& to) { to.faces(faces.by_owner()); }),
      tables_of(
          shapes.points, u_made, f_made,
          [&](insitu::Mesh& to) { to.mixed_cells(shapes.types, shapes.offsets, shapes.ids); }),
      [&](double part) { return part < 0 ? part : double(parts.cell[std::size_t(part)]); });
}
