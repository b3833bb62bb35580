/// insitu-replay on series whose parts, cells and fields come and go, and whose cycles are all 0.

#include <vtkUnstructuredGridWriter.h>

#include "replay.h"

using namespace vtk_meshes;

namespace {

struct Series : Replay {
  /// [x, x + 2] x [0, 2]^2, with `linear` on vertices and velocity 1 along x.
  vtkSmartPointer<vtkUnstructuredGrid> part(double x) const {
    auto grid = unstructured(2, {VTK_HEXAHEDRON}, 0.0);
    vtkNew<vtkDoubleArray> velocity;
    velocity->SetName("v");
    velocity->SetNumberOfComponents(3);
    auto* values = vtkDoubleArray::SafeDownCast(grid->GetPointData()->GetArray("linear"));
    for (vtkIdType i = 0; i < grid->GetNumberOfPoints(); ++i) {
      double* const p = grid->GetPoint(i);
      grid->GetPoints()->SetPoint(i, p[0] + x, p[1], p[2]);
      values->SetValue(i, linear({p[0] + x, p[1], p[2]}));
      velocity->InsertNextTuple3(1, 0, 0);
    }
    grid->GetPointData()->AddArray(velocity);
    return grid;
  }
  void index(const std::string& name,
             const std::vector<std::pair<double, std::vector<std::string>>>& steps) const {
    std::string text = "<VTKFile type=\"Collection\"><Collection>";
    for (const auto& [time, files] : steps)
      for (std::size_t p = 0; p < files.size(); ++p)
        text += "<DataSet timestep=\"" + std::to_string(time) + "\" part=\"" + std::to_string(p) +
                "\" file=\"" + files[p] + "\"/>";
    put(name, text + "</Collection></VTKFile>");
  }
  void SetUp() override {
    Replay::SetUp();
    put("scene.yaml",
        "insitu: 1\nprobes:\n  - {name: g, points: [[0.4, 0.3, 0.2], [2.5, 0.3, 0.2]], fields: "
        "[linear], output: [csv, netcdf, json, vtp]}\ntracers:\n  - {name: t, velocity: v, seeds: "
        "[[0.5, 0.5, 0.5]], output: [csv, netcdf, vtp]}\nframes:\n  - {name: f, size: [16, 16], "
        "volume: {field: linear}}\n");
    write("left.vtu", part(0));
    write("right.vtu", part(2));
    vtkNew<vtkUnstructuredGrid> nothing;
    write("bare.vtu", nothing);
    auto arrays = vtkSmartPointer<vtkUnstructuredGrid>::New();
    vtkNew<vtkDoubleArray> empty;
    empty->SetName("linear");
    arrays->GetPointData()->AddArray(empty);
    write("empty.vtu", arrays);
    auto lacking = part(2);
    lacking->GetPointData()->RemoveArray("linear");
    write("lacking.vtu", lacking);
  }
  Row at(const std::string& table, double time, int point) const {
    for (const Row& row : rows(table))
      if (row.at("time") == time && row.at("point") == point)
        return row;
    ADD_FAILURE() << "no row of point " << point << " at time " << time;
    return {{"linear", NAN}, {"piece", NAN}};
  }
};

/// A dry run of an index says what is in the first step, of all its parts.
TEST_F(Series, CheckTellsPartsAndSteps) {
  index("i.pvd", {{0.5, {"left.vtu", "right.vtu"}}, {1.5, {"left.vtu"}}, {2.5, {"right.vtu"}}});
  expect_checked(
      "--scene scene.yaml i.pvd",
      {"mesh 'mesh': 16 cells, 54 vertices\n", "  field 'linear' on vertices, 1 component\n",
       "  field 'v' on vertices, 3 components\n", "3 steps\n", "  nothing/g.nc (every cycle)\n",
       "  nothing/t_*.vtp (every cycle)\n", "  nothing/f_*.png (every cycle)\n", " are kept"});
  put("typo.yaml",
      "insitu: 1\ntracers:\n  - {name: t, velocity: velocty, seeds: [[0.5, 0.5, 0.5]]}\n");
  expect_checked("--scene typo.yaml i.pvd", {"3 steps\n"}, "did you mean 'velocity'?");
}

TEST_F(Series, PartsWithoutCellsAddNothing) {
  for (const char* none : {"bare.vtu", "empty.vtu"})
    for (const bool first : {true, false}) {
      SCOPED_TRACE(std::string(none) + (first ? " first" : " last"));
      index("i.pvd", {{1.0, first ? std::vector<std::string>{none, "left.vtu"}
                                  : std::vector<std::string>{"left.vtu", none}}});
      fs::remove_all(folder / "res");
      const Outcome o = run("--scene scene.yaml --out res i.pvd");
      ASSERT_EQ(o.code, 0) << o.err;
      EXPECT_EQ(o.err, "");
      EXPECT_NEAR(at("res/g.csv", 1, 0).at("linear"), linear({0.4, 0.3, 0.2}), 1e-12);
      EXPECT_TRUE(std::isnan(at("res/g.csv", 1, 1).at("linear")));
    }
}

TEST_F(Series, PartsThatComeAndGoLeaveTheColumns) {
  index("more.pvd", {{0, {"left.vtu"}}, {1, {"left.vtu", "right.vtu"}}});
  index("fewer.pvd", {{0, {"left.vtu", "right.vtu"}},
                      {1, {"left.vtu"}},
                      {2, {"bare.vtu"}},
                      {3, {"left.vtu", "right.vtu"}}});
  for (const char* name : {"more", "fewer"}) {
    SCOPED_TRACE(name);
    const Outcome o = run(std::string("--scene scene.yaml --out ") + name + " " + name + ".pvd");
    ASSERT_EQ(o.code, 0) << o.err;
    const std::string g = std::string(name) + "/g.csv";
    EXPECT_NEAR(at(g, 0, 0).at("linear"), linear({0.4, 0.3, 0.2}), 1e-12);
    EXPECT_NEAR(at(g, 1, 0).at("linear"), linear({0.4, 0.3, 0.2}), 1e-12);
    EXPECT_EQ(at(g, 1, 0).at("piece"), 0);
    EXPECT_EQ(rows(std::string(name) + "/t.csv").back().at("piece"), -1); // killed, or has left
  }
  EXPECT_EQ(at("more/g.csv", 1, 1).at("piece"), 1);
  EXPECT_TRUE(std::isnan(at("fewer/g.csv", 1, 1).at("linear")));
  EXPECT_TRUE(std::isnan(at("fewer/g.csv", 2, 0).at("linear")));
  EXPECT_NEAR(at("fewer/g.csv", 3, 1).at("linear"), linear({2.5, 0.3, 0.2}), 1e-12);
}

TEST_F(Series, AFieldThatAPartLacksIsNamedAndComesBack) {
  index("i.pvd", {{0, {"left.vtu", "right.vtu"}},
                  {1, {"left.vtu", "lacking.vtu"}},
                  {2, {"left.vtu", "right.vtu"}}});
  const Outcome o = run("--scene scene.yaml --out res i.pvd");
  EXPECT_EQ(o.code, 3) << o.err;
  EXPECT_NE(o.err.find("left.vtu: point array 'linear' is left out: 1 of 2 parts have it"),
            std::string::npos)
      << o.err;
  EXPECT_NEAR(at("res/g.csv", 0, 1).at("linear"), linear({2.5, 0.3, 0.2}), 1e-12);
  EXPECT_NEAR(at("res/g.csv", 2, 1).at("linear"), linear({2.5, 0.3, 0.2}), 1e-12);
}

TEST_F(Series, CyclesThatRepeatAreCountedOn) {
  for (int i = 0; i < 3; ++i)
    mesh("z" + std::to_string(i) + ".vtu", 0.0, 0, double(i));
  put("scene.yaml", "insitu: 1\nprobes:\n  - {name: g, points: [[0.4, 0.3, 0.2]], fields: "
                    "[linear], output: [csv, json]}\nframes:\n  - {name: f, size: [8, 8], volume: "
                    "{field: linear}}\n");
  const Outcome o = run("--scene scene.yaml --out res z0.vtu z1.vtu z2.vtu");
  ASSERT_EQ(o.code, 0) << o.err;
  EXPECT_EQ(o.err, "insitu-replay: note: z1.vtu: cycle 0 was there before; from here on steps are "
                   "counted on\n");
  for (const char* file : {"f_000000.png", "f_000001.png", "f_000002.png", "g_000002.json"})
    EXPECT_TRUE(fs::exists(folder / "res" / file)) << file;
  EXPECT_EQ(rows("res/g.csv").size(), 3u);
}

// Ghost values hold rubbish in two files that overlap; exporters write them in any type.
TEST_F(Series, GhostValuesOfAnyTypeAreTaken) {
  put("scene.yaml", "insitu: 1\nprobes:\n  - {name: g, points: [[1.5, 0.5, 0.5], [2.5, 0.5, 0.5]], "
                    "fields: [q]}\n");
  for (const int type : {VTK_UNSIGNED_CHAR, VTK_SIGNED_CHAR, VTK_INT, VTK_LONG_LONG, VTK_DOUBLE}) {
    SCOPED_TRACE(type);
    for (int p = 0; p < 2; ++p) { // [0, 3] and [1, 4] of unit cells; the overlap's outer ones
      vtkNew<vtkUnstructuredGrid> grid;
      const auto points = grid_points(3, 0.0);
      for (vtkIdType i = 0; i < points->GetNumberOfPoints(); ++i) {
        double* const x = points->GetPoint(i);
        points->SetPoint(i, x[0] + p, x[1], x[2]);
      }
      grid->SetPoints(points);
      vtkNew<vtkDoubleArray> q;
      q->SetName("q");
      const auto ghosts = vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(type));
      ghosts->SetName("vtkGhostType");
      for (int i = 0; i < 3; ++i) {
        insert_box(grid, VTK_HEXAHEDRON, 3, i, 0, 0);
        const bool ghost = p == 0 ? i == 2 : i == 0;
        q->InsertNextValue(ghost ? -999 : i + p);
        ghosts->InsertNextTuple1(ghost);
      }
      grid->GetCellData()->AddArray(q);
      grid->GetCellData()->AddArray(ghosts);
      write("p" + std::to_string(p) + ".vtu", grid);
    }
    index("i.pvd", {{0, {"p0.vtu", "p1.vtu"}}});
    fs::remove_all(folder / "res");
    const Outcome o = run("--scene scene.yaml --out res i.pvd");
    ASSERT_EQ(o.code, 0) << o.err;
    const std::size_t said = o.err.find("cell array 'vtkGhostType' is converted");
    EXPECT_EQ(said == std::string::npos, type == VTK_UNSIGNED_CHAR) << o.err;
    EXPECT_EQ(o.err.find("vtkGhostType", said == std::string::npos ? said : said + 20),
              std::string::npos)
        << "said twice: " << o.err;
    EXPECT_EQ(at("res/g.csv", 0, 0).at("q"), 1);
    EXPECT_EQ(at("res/g.csv", 0, 1).at("q"), 2);
  }
}

} // namespace
