// Frames of several meshes: what a session writes of them.
#include <gtest/gtest.h>

#include "coupled.h"

namespace {

/// A box of n cells a side with x at its vertices, as a mesh of a session.
struct BoxMesh {
  BoxMesh(insitu::Session& session, const std::string& name, double from, double to, int n = 4)
      : mesh(session.mesh(name)) {
    const int m = n + 1;
    for (int v = 0; v < m * m * m; ++v) {
      points.insert(points.end(), {double(v % m) / n, double(v / m % m) / n,
                                   from + (to - from) * (v / (m * m)) / n});
      values.push_back(double(v % m) / n);
    }
    for (int c = 0; c < n * n * n; ++c) {
      const int at = c % n + m * (c / n % n) + m * m * (c / (n * n));
      for (const int v : {0, 1, m + 1, m, m * m, m * m + 1, m * m + m + 1, m * m + m})
        cells.push_back(at + v);
    }
    mesh.points(points.data(), std::int64_t(values.size()));
    mesh.hexahedra(cells.data(), std::int64_t(cells.size() / 8));
    mesh.vertex_field("p", values.data());
  }
  std::vector<double> points, values;
  std::vector<int> cells;
  insitu::Mesh mesh;
};

insitu::Session session_of(const std::string& scene, const test::Folder& folder) {
  return insitu::Session({.scene_text = scene, .output = folder.path(), .threads = 2});
}

const char* const water_and_steel = R"(insitu: 1
page: true
frames:
  - name: both
    size: [48, 36]
    outline: {ticks: true}
    scalar_bar: true
    effects: [shadows, volume_shadows, ambient_occlusion]
    meshes:
      - mesh: water
        volume: {field: p}
      - mesh: steel
        boundary: {color: {field: p, range: [0, 2]}}
        isosurfaces: [{field: p, values: [0.5], opacity: 0.5}]
)";

TEST(FramesOfMeshes, ImagesTableAndPlanNameAll) {
  const test::Folder folder;
  insitu::Session session = session_of(water_and_steel, folder);
  const BoxMesh water(session, "water", 0, 1), steel(session, "steel", 1, 1.5);
  session.execute(3, 0.5);
  EXPECT_TRUE(std::filesystem::exists(folder / "both_000003.png"));
  const runs::Table table = runs::parse_table(test::content(folder / "data.csv"));
  ASSERT_EQ(table.rows.size(), 1u);
  EXPECT_EQ(table.number(0, "water_p_low"), 0);
  EXPECT_EQ(table.number(0, "water_p_high"), 1);
  EXPECT_EQ(table.number(0, "steel_p_high"), 2);
  const std::string plan = session.plan(), page = test::content(folder / "run.js");
  for (const std::string mesh : {"water", "steel"}) {
    EXPECT_NE(plan.find("frame 'both' of mesh '" + mesh + "'"), std::string::npos) << plan;
    EXPECT_NE(page.find("frame 'both' of mesh '" + mesh + "'"), std::string::npos);
  }
  EXPECT_NE(plan.find("ray marching of 'p'"), std::string::npos);
  EXPECT_NE(plan.find("boundary faces"), std::string::npos);
}

/// Of images of cells each mesh has one, which holds the cells of that mesh.
TEST(FramesOfMeshes, ImagesOfCellsAreOfOneMeshEach) {
  const test::Folder folder;
  insitu::Session session = session_of(
      "insitu: 1\nframes:\n  - {name: f, size: [32, 24], images: [color, cell], camera: {azimuth: "
      "0, "
      "elevation: 0}, meshes: [{mesh: a, boundary: {}}, {mesh: b, volume: {field: p}}, {mesh: a, "
      "isosurfaces: [{field: p, values: [0.5]}]}]}\n",
      folder);
  const BoxMesh a(session, "a", 0, 1), b(session, "b", 2, 3);
  const auto cells = [&](const std::string& mesh) {
    return test::content(folder / ("f_" + mesh + "_cell_000000.png"));
  };
  session.execute(0, 0);
  const runs::Table table = runs::parse_table(test::content(folder / "data.csv"));
  ASSERT_EQ(table.rows.size(), 3u);
  EXPECT_EQ(table.text(1, "mesh"), "a");
  EXPECT_EQ(table.text(2, "mesh"), "b");
  EXPECT_EQ(table.text(2, "FILE"), "f_b_cell_000000.png");
  EXPECT_FALSE(cells("a").empty());
  EXPECT_NE(cells("a"), cells("b"));
  EXPECT_FALSE(std::filesystem::exists(folder / "f_cell_000000.png"));
}

/// A mesh that is not there is an error as for a frame of that mesh; one without cells is left out.
TEST(FramesOfMeshes, AMeshMayComeLater) {
  const test::Folder folder;
  insitu::Session session = session_of(water_and_steel, folder);
  const BoxMesh water(session, "water", 0, 1);
  session.execute(0, 0);
  EXPECT_NE(test::content(folder / "run.js").find("the session has no mesh 'steel'"),
            std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder / "both_000000.png"));
  session.mesh("steel"); // no cells
  session.execute(1, 1);
  const std::string alone = test::content(folder / "both_000001.png");
  const BoxMesh steel(session, "steel", 1, 1.5);
  session.execute(2, 2);
  const std::string both = test::content(folder / "both_000002.png");
  EXPECT_FALSE(alone.empty());
  EXPECT_FALSE(both.empty());
  EXPECT_NE(alone, both);
}

/// Lengths that a frame does not give follow from the box of all: a mesh that is cut in two looks
/// like the whole, its surfaces to the byte.
TEST(FramesOfMeshes, ACutMeshIsTheWhole) {
  const std::string surfaces = "isosurfaces: [{field: p, values: [0.3, 0.7], opacity: 0.5}]";
  const std::string frame = "insitu: 1\nframes:\n  - name: f\n    size: [64, 64]\n    outline: {}\n"
                            "    effects: [lighting, ambient_occlusion]\n    ";
  const test::Folder one, two;
  insitu::Session whole = session_of(frame + surfaces, one);
  const BoxMesh all(whole, "all", 0, 2, 8);
  whole.execute(0, 0);
  insitu::Session parts =
      session_of(frame + "meshes: [{mesh: a, " + surfaces + "}, {mesh: b, " + surfaces + "}]", two);
  // Of the same cells along z: 8 layers in all.
  struct Half : BoxMesh {
    Half(insitu::Session& session, const std::string& name, bool upper)
        : BoxMesh(session, name, 0, 2, 8) {
      std::vector<int> kept(cells.begin() + (upper ? 8 * 256 : 0),
                            cells.begin() + (upper ? 8 * 512 : 8 * 256));
      cells = kept;
      mesh.hexahedra(cells.data(), std::int64_t(cells.size() / 8));
    }
  };
  const Half a(parts, "a", false), b(parts, "b", true);
  parts.execute(0, 0);
  EXPECT_EQ(test::content(one / "f_000000.png"), test::content(two / "f_000000.png"));
}

/// Samples of paths add up until one of the meshes changes, whichever; the plan names their sums
/// once.
TEST(FramesOfMeshes, SamplesOfPathsAddUpUntilAMeshChanges) {
  const test::Folder folder;
  const std::string drawn =
      "size: [16, 16], format: [exr], effects: [multiple_scattering], meshes: "
      "[{mesh: a, volume: {field: p}}, {mesh: b, volume: {field: p}}]";
  insitu::Session session = session_of(
      "insitu: 1\nframes:\n  - {name: sums, path_tracing: {samples: 2, accumulate: true}, " +
          drawn + "}\n  - {name: one, path_tracing: {samples: 2}, " + drawn + "}\n",
      folder);
  const BoxMesh a(session, "a", 0, 1);
  BoxMesh b(session, "b", 0.5, 1.5);
  const auto is_one = [&](int cycle) {
    const std::string of = "_00000" + std::to_string(cycle) + ".exr";
    session.execute(cycle, cycle);
    return test::content(folder / ("sums" + of)) == test::content(folder / ("one" + of));
  };
  EXPECT_TRUE(is_one(0));
  EXPECT_FALSE(is_one(1));
  b.values[7] += 0.25;
  b.mesh.vertex_field("p", b.values.data());
  EXPECT_TRUE(is_one(2));
  EXPECT_FALSE(is_one(3));
  const std::string plan = session.plan(), sums = "sums of samples of frame 'sums'";
  ASSERT_NE(plan.find(sums), std::string::npos) << plan;
  EXPECT_EQ(plan.find(sums), plan.rfind(sums)) << plan;
}

/// Two fields of one mesh.
TEST(FramesOfMeshes, OneMeshTwice) {
  const test::Folder folder;
  insitu::Session session =
      session_of("insitu: 1\nframes:\n  - {name: f, size: [16, 16], meshes: [{mesh: m, volume: "
                 "{field: p}}, {mesh: m, volume: {field: p, range: [0, 3]}, boundary: {opacity: "
                 "0.1}}]}\n",
                 folder);
  const BoxMesh m(session, "m", 0, 1);
  session.execute(0, 0);
  session.execute(1, 1);
  EXPECT_EQ(test::content(folder / "f_000000.png"), test::content(folder / "f_000001.png"));
}

} // namespace
