/// insitu-replay on what solvers' results lie in: parallel and multi-block files, series, legacy
/// files, names in capital letters, hyper trees of version 2.

#include <vtkHyperTreeGrid.h>
#include <vtkHyperTreeGridNonOrientedCursor.h>
#include <vtkXMLHyperTreeGridWriter.h>

#include "../vtk/adaptive_meshes.h"
#include "replay.h"

using namespace vtk_meshes;

namespace {

std::string numbers(const std::vector<double>& values) {
  std::ostringstream text;
  for (const double v : values)
    text << v << ' ';
  return text.str();
}

/// A .vtu of one hexahedron [x, x + 1] x [0, 1]^2 with q = x + 5 y on vertices, in words.
std::string box(double x, const std::string& more = "") {
  std::vector<double> xyz, q;
  const int corner[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                            {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  for (const auto& c : corner) {
    xyz.insert(xyz.end(), {x + c[0], double(c[1]), double(c[2])});
    q.push_back(x + c[0] + 5 * c[1]);
  }
  const auto array = [](const char* type, const char* name, const std::string& values,
                        const char* extra = "") {
    return std::string("<DataArray type=\"") + type + "\" Name=\"" + name + "\" " + extra +
           " format=\"ascii\">" + values + "</DataArray>";
  };
  return "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\">"
         "<UnstructuredGrid>" +
         more + "<Piece NumberOfPoints=\"8\" NumberOfCells=\"1\"><PointData>" +
         array("Float64", "q", numbers(q)) + "</PointData><Points>" +
         array("Float64", "Points", numbers(xyz), "NumberOfComponents=\"3\"") + "</Points><Cells>" +
         array("Int64", "connectivity", "0 1 2 3 4 5 6 7") + array("Int64", "offsets", "8") +
         array("UInt8", "types", "12") + "</Cells></Piece></UnstructuredGrid></VTKFile>";
}

const char* const wall =
    "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\"><PolyData><Piece "
    "NumberOfPoints=\"3\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" "
    "NumberOfPolys=\"1\"><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" "
    "format=\"ascii\">0 0 0 1 0 0 0 1 0</DataArray></Points><Polys><DataArray type=\"Int64\" "
    "Name=\"connectivity\" format=\"ascii\">0 1 2</DataArray><DataArray type=\"Int64\" "
    "Name=\"offsets\" format=\"ascii\">3</DataArray></Polys></Piece></PolyData></VTKFile>";

std::string collection(const std::string& file) {
  return "<VTKFile type=\"Collection\"><Collection><DataSet timestep=\"0.5\" file=\"" + file +
         "\"/></Collection></VTKFile>";
}

struct Containers : Replay {
  void SetUp() override {
    Replay::SetUp();
    put("scene.yaml", "insitu: 1\nprobes:\n  - {name: g, points: [[0.3, 0.4, 0.6], [1.7, 0.5, "
                      "0.5]], fields: [q]}\n");
    fs::create_directories(folder / "vtk");
    put("vtk/a.vtu", box(0));
    put("vtk/b.vtu", box(1));
    put("vtk/wall.vtp", wall);
    put("m.pvtu", "<VTKFile type=\"PUnstructuredGrid\" version=\"0.1\"><PUnstructuredGrid "
                  "GhostLevel=\"0\"><PPointData><PDataArray type=\"Float64\" Name=\"q\"/>"
                  "</PPointData><PPoints><PDataArray type=\"Float64\" NumberOfComponents=\"3\"/>"
                  "</PPoints><Piece Source=\"vtk/a.vtu\"/><Piece Source=\"vtk/b.vtu\"/>"
                  "</PUnstructuredGrid></VTKFile>");
    put("m.vtm", "<VTKFile type=\"vtkMultiBlockDataSet\" version=\"1.0\"><vtkMultiBlockDataSet>"
                 "<DataSet index=\"0\" name=\"wall\" file=\"vtk/wall.vtp\"/>"
                 "<Block index=\"1\" name=\"inside\">"
                 "<DataSet index=\"0\" name=\"a\" file=\"vtk/a.vtu\"/>"
                 "<DataSet index=\"1\" name=\"b\" file=\"vtk/b.vtu\"/></Block>"
                 "</vtkMultiBlockDataSet></VTKFile>");
  }
  /// The two probed values; NaN outside.
  void expect_values(const std::string& file, bool second, const std::string& said = "") {
    SCOPED_TRACE(file);
    const Outcome o = run("--scene scene.yaml --out out_" + file + " " + file);
    ASSERT_EQ(o.code, 0) << o.err;
    if (said.empty())
      EXPECT_EQ(o.err, "");
    else
      EXPECT_NE(o.err.find(said), std::string::npos) << o.err;
    const std::vector<Row> r = rows("out_" + file + "/g.csv");
    ASSERT_EQ(r.size(), 2u);
    EXPECT_NEAR(r[0].at("q"), 2.3, 1e-12);
    if (second)
      EXPECT_NEAR(r[1].at("q"), 4.2, 1e-12);
    else
      EXPECT_TRUE(std::isnan(r[1].at("q")));
  }
};

TEST_F(Containers, ParallelAndMultiBlockFilesAndIndicesOfThem) {
  const std::string walls = "m.vtm, block 'wall', 1 cells without volume";
  expect_values("m.pvtu", true);
  expect_values("m.vtm", true, walls);
  put("pvtu.pvd", collection("m.pvtu"));
  put("vtm.pvd", collection("m.vtm"));
  expect_values("pvtu.pvd", true);
  expect_values("vtm.pvd", true, walls);
  EXPECT_EQ(rows("out_vtm.pvd/g.csv")[1].at("piece"), 1);
  EXPECT_EQ(rows("out_vtm.pvd/g.csv")[1].at("time"), 0.5);
}

TEST_F(Containers, CapitalLetters) {
  put("M.VTU", box(0));
  expect_values("M.VTU", false);
}

TEST_F(Containers, SeriesGoByTime) {
  put("s.vtu.series", "{\n\t\"file-series-version\" : \"1.0\",\n\t\"files\" : [\n\t\t{ \"name\" : "
                      "\"vtk/b.vtu\", \"time\" : 2.5e0 },\n\t\t{ \"name\" : \"vtk\\/a.vtu\", "
                      "\"time\" : 0.5 }\n\t]\n}\n");
  const Outcome o = run("--scene scene.yaml --out res s.vtu.series");
  ASSERT_EQ(o.code, 0) << o.err;
  const std::vector<Row> r = rows("res/g.csv");
  ASSERT_EQ(r.size(), 4u);
  EXPECT_EQ(r[0].at("time"), 0.5);
  EXPECT_NEAR(r[0].at("q"), 2.3, 1e-12);
  EXPECT_EQ(r[3].at("time"), 2.5);
  EXPECT_NEAR(r[3].at("q"), 4.2, 1e-12);
  EXPECT_TRUE(std::isnan(r[2].at("q")));
  for (const char* bad : {"{\"files\": []}", "{\"files\": 3}", "[", "{\"files\": [{\"time\": 1}]}",
                          "{\"files\": [{\"name\": \"a.vtu\", \"time\": \"soon\"}]}",
                          "{\"files\": [{\"name\": \"s.vtu.series\"}]}", ""}) {
    put("bad.series", bad);
    const Outcome refused = run("--scene scene.yaml bad.series");
    EXPECT_EQ(refused.code, 1) << bad;
    EXPECT_EQ(refused.err.rfind("insitu-replay: bad.series: ", 0), 0u) << refused.err;
  }
}

TEST_F(Containers, LegacyFilesWithAllTheirArrays) {
  put("m.vtk",
      "# vtk DataFile Version 2.0\na box\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 "
      "2\nORIGIN 0 0 0\nSPACING 1 1 1\nPOINT_DATA 8\nSCALARS other double 1\nLOOKUP_TABLE "
      "default\n0 0 0 0 0 0 0 0\nSCALARS q double 1\nLOOKUP_TABLE default\n0 1 5 6 0 1 5 "
      "6\n");
  expect_values("m.vtk", false);
  put("m.vtk", "# vtk DataFile Version 2.0\na box\nASCII\nDATASET NONSENSE\n");
  const Outcome o = run("--scene scene.yaml m.vtk");
  EXPECT_EQ(o.code, 1);
  EXPECT_EQ(o.err.rfind("insitu-replay: m.vtk: cannot be read as a legacy VTK file", 0), 0u)
      << o.err;
}

TEST_F(Containers, WithAFileMissingAreRefused) {
  fs::remove(folder / "vtk/b.vtu");
  for (const char* file : {"m.pvtu", "m.vtm"}) {
    const Outcome o = run(std::string("--scene scene.yaml ") + file);
    EXPECT_EQ(o.code, 1) << file;
    EXPECT_EQ(o.err.rfind(std::string("insitu-replay: ") + file, 0), 0u) << o.err;
  }
  const Outcome o = run("--scene scene.yaml vtk/wall.vtp");
  EXPECT_EQ(o.code, 1);
  EXPECT_NE(o.err.find("unknown kind of file; .vtu"), std::string::npos) << o.err;
}

// VTK 9.1's reader sets a third of a vector's numbers in files of version 2.
TEST_F(Containers, VectorsOfHyperTreesOfVersionTwo) {
  Trees trees;
  vtkHyperTreeGrid* const grid = trees.grid;
  vtkNew<vtkDoubleArray> vector;
  vector->SetName("v");
  vector->SetNumberOfComponents(3);
  const vtkIdType nodes = grid->GetCellData()->GetArray(0)->GetNumberOfTuples();
  for (vtkIdType i = 0; i < nodes; ++i)
    vector->InsertNextTuple3(1 + double(i), -2, 3);
  grid->GetCellData()->AddArray(vector);
  put("scene.yaml", "insitu: 1\nprobes:\n  - {name: g, points: {box: {min: [0, 0, 0], max: [3.9, "
                    "1.9, 1.9], counts: [6, 5, 5]}}, fields: [v]}\n");
  for (const int version : {1, 2}) {
    vtkNew<vtkXMLHyperTreeGridWriter> writer;
    writer->SetFileName(path("v" + std::to_string(version) + ".htg").c_str());
    writer->SetInputData(grid);
    writer->SetDataModeToBinary();
    writer->SetDataSetMajorVersion(version);
    ASSERT_EQ(writer->Write(), 1);
    const Outcome o = run("--scene scene.yaml --out v" + std::to_string(version) + " v" +
                          std::to_string(version) + ".htg");
    ASSERT_EQ(o.code, 0) << o.err;
  }
  const std::vector<Row> one = rows("v1/g.csv"), two = rows("v2/g.csv");
  ASSERT_EQ(one.size(), two.size());
  std::size_t inside = 0;
  for (std::size_t i = 0; i < one.size(); ++i) {
    if (std::isnan(one[i].at("v_x")))
      continue;
    ++inside;
    EXPECT_NEAR(one[i].at("v_y"), -2, 1e-12) << i;
    EXPECT_NEAR(two[i].at("v_y"), -2, 1e-12) << i;
    EXPECT_NEAR(two[i].at("v_z"), 3, 1e-12) << i;
  }
  EXPECT_GT(inside, 20u);
}

} // namespace

/// Polyhedra of VTK (type 42), all cells or every second one, in files of one part and of several:
/// the table of the same cells by their shapes, but for the last digits of values.
TEST_F(Containers, Polyhedra) {
  put("scene.yaml",
      "insitu: 1\nprobes:\n  - {name: g, points: {box: {min: [0.1, 0.2, 0.3], max: [1.9, 1.8, "
      "1.7], "
      "counts: [5, 4, 3]}}, fields: [linear, number]}\ntracers:\n  - {name: t, velocity: velocity, "
      "seeds: [[0.5, 1.5, 0.2], [1.1, 0.7, 0.3]]}\n");
  write("shapes.vtu", unstructured(2, {VTK_HEXAHEDRON}, 0.1));
  write("all.vtu", as_polyhedra({VTK_HEXAHEDRON}, 1));
  write("some.vtu", as_polyhedra({VTK_HEXAHEDRON}, 2));
  const auto table = [&](const std::string& file, const std::string& name) {
    const Outcome o = run("--scene scene.yaml --out out_" + file + " " + file + " " + file);
    EXPECT_EQ(o.code, 0) << o.err;
    EXPECT_EQ(o.err, "");
    return rows("out_" + file + "/" + name + ".csv");
  };
  for (const std::string name : {"g", "t"}) {
    const std::vector<Row> expected = table("shapes.vtu", name);
    ASSERT_GT(expected.size(), 3u);
    for (const char* file : {"all.vtu", "some.vtu"}) {
      const std::vector<Row> found = table(file, name);
      ASSERT_EQ(found.size(), expected.size()) << file;
      for (std::size_t row = 0; row < found.size(); ++row)
        for (const auto& [column, value] : expected[row]) {
          if (column == "r" || column == "s" ||
              column == "t") // places in a cell, from another vertex
            continue;
          const double is = found[row].at(column);
          EXPECT_TRUE(std::abs(is - value) < 1e-12 || (std::isnan(is) && std::isnan(value)))
              << file << ", " << column << ": " << is << " for " << value;
        }
    }
  }
  // Beside them the same, of which VTK makes one part.
  const auto beside = as_polyhedra({VTK_HEXAHEDRON}, 2);
  for (vtkIdType v = 0; v < beside->GetNumberOfPoints(); ++v) {
    double x[3];
    beside->GetPoint(v, x);
    beside->GetPoints()->SetPoint(v, x[0] + 2, x[1], x[2]);
  }
  write("beside.vtu", beside);
  put("two.pvtu", "<VTKFile type=\"PUnstructuredGrid\" version=\"0.1\"><PUnstructuredGrid "
                  "GhostLevel=\"0\"><PPointData><PDataArray type=\"Float64\" Name=\"linear\"/>"
                  "</PPointData><PPoints><PDataArray type=\"Float64\" NumberOfComponents=\"3\"/>"
                  "</PPoints><Piece Source=\"all.vtu\"/><Piece Source=\"beside.vtu\"/>"
                  "</PUnstructuredGrid></VTKFile>");
  put("points.csv", "x,y,z\n0.4,0.3,0.2\n2.4,0.3,0.2\n3.5,1.5,1.5\n");
  const Outcome o = run("--probe points.csv --out out_two two.pvtu");
  ASSERT_EQ(o.code, 0) << o.err;
  const std::vector<Row> two = rows("out_two/probe.csv");
  ASSERT_EQ(two.size(), 3u);
  for (std::size_t row = 0; row < 3; ++row)
    EXPECT_NEAR(two[row].at("linear"),
                linear(row < 2 ? Point{0.4, 0.3, 0.2} : Point{1.5, 1.5, 1.5}), 1e-12);
}
