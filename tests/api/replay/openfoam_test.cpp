// insitu-replay on cases of OpenFOAM: whole, and in the folders of processors.
#include "fixtures/foam_mesh.h"
#include "replay.h"

using insitu::fixtures::FoamMesh;
using insitu::fixtures::FoamPart;
namespace foam = insitu::fixtures::foam;

namespace {

struct OpenFoamCases : Replay {
  const FoamMesh dual = FoamMesh::read(POLY_DUAL);
  const std::vector<FoamMesh::Point> centres = dual.centres();

  void control(const std::string& name) const {
    foam::write(folder / name / "system" / "controlDict",
                foam::header("dictionary", "controlDict") +
                    "application icoFoam; startFrom startTime; startTime 0; stopAt endTime; "
                    "endTime 0.5;\ndeltaT 0.5; writeControl timeStep; writeInterval 1; "
                    "writeFormat ascii;\n");
  }
  /// The fields p and U of some cells at a time.
  void fields(const std::string& to, const std::string& time, const std::vector<int>& cells) const {
    const double t = std::stod(time);
    foam::write(folder / to / time / "p",
                foam::header("volScalarField", "p") +
                    "dimensions [0 2 -2 0 0 0 0]; internalField nonuniform List<scalar> " +
                    foam::list(cells,
                               [&](int c) {
                                 const FoamMesh::Point& x = centres[std::size_t(c)];
                                 return foam::number(1 + x[0] + 2 * x[1] - x[2] + 10 * t);
                               }) +
                    "; boundaryField { \".*\" { type zeroGradient; } }\n");
    foam::write(folder / to / time / "U",
                foam::header("volVectorField", "U") +
                    "dimensions [0 1 -1 0 0 0 0]; internalField nonuniform List<vector> " +
                    foam::list(cells,
                               [&](int c) {
                                 const FoamMesh::Point& x = centres[std::size_t(c)];
                                 return "(" + foam::number(x[1] - 1.5) + " " +
                                        foam::number(1.5 - x[0]) + " 0.25)";
                               }) +
                    "; boundaryField { \".*\" { type zeroGradient; } }\n");
  }
  void whole(const std::string& name, const std::vector<std::string>& times) const {
    control(name);
    dual.write(path(name), {{"walls", "wall;", int(dual.faces.size() - dual.neighbour.size())}});
    std::vector<int> all(centres.size());
    for (std::size_t c = 0; c < all.size(); ++c)
      all[c] = int(c);
    for (const std::string& time : times)
      fields(name, time, all);
  }
  bool idle = false; ///< processor 1 has no cells
  /// Slabs of the case along a slanted direction, dealt to three processors.
  std::vector<FoamPart> parts() const {
    std::vector<int> processor;
    for (const FoamMesh::Point& x : centres)
      processor.push_back(std::min(2, (idle ? 2 : 1) * int((x[0] + 0.3 * x[1]) / 1.4)));
    return decomposed(dual, processor);
  }
  void decompose(const std::string& name, const std::vector<std::string>& times) const {
    control(name);
    int p = 0;
    for (const FoamPart& part : parts()) {
      const std::string to = name + "/processor" + std::to_string(p++);
      part.mesh.write(path(to), part.patches);
      addressing(to, "cellProcAddressing", part.cells, false);
      addressing(to, "pointProcAddressing", part.points, p == 2);
      for (const std::string& time : times)
        fields(to, time, part.cells);
    }
  }
  void addressing(const std::string& to, const std::string& name, const std::vector<int>& labels,
                  bool binary) const {
    std::string text = foam::header("labelList", name, binary ? "binary" : "ascii");
    if (binary)
      text += std::to_string(labels.size()) + "\n(" +
              std::string(reinterpret_cast<const char*>(labels.data()), 4 * labels.size()) + ")\n";
    else
      text += "// a comment (1 2)\n" + foam::list(labels, foam::label);
    foam::write(folder / to / "constant" / "polyMesh" / name, text);
  }
  void put_scene() const {
    std::vector<double> xyz;
    vtk_meshes::Random random(5);
    for (int i = 0; i < 900; ++i)
      xyz.push_back(3 * random());
    for (const FoamMesh::Point& x : dual.points) // on faces, edges and vertices
      xyz.insert(xyz.end(), x.begin(), x.end());
    put_points("points.csv", xyz);
    put("scene.yaml",
        "insitu: 1\nprobes:\n  - {name: g, points: points.csv}\n"
        "tracers:\n  - {name: t, velocity: U, seeds: [[0.8, 1.5, 1], [2, 2, 0.5]]}\n"
        "frames:\n  - {name: f, size: [64, 64], isosurfaces: [{field: p, values: [4], normals: "
        "smooth}], boundary: {color: {field: p, range: [0, 10]}, opacity: 0.5}}\n");
  }
  std::string err_of(const std::string& name) const {
    const Outcome o = run("--scene scene.yaml --out out " + name);
    EXPECT_EQ(o.code, 1) << o.out;
    return o.err;
  }
};

} // namespace

/// With the processors' addressing the pieces are the whole again: its files to the byte.
TEST_F(OpenFoamCases, ProcessorsPutTogetherAreTheWhole) {
  put_scene();
  whole("whole", {"0", "0.5"});
  decompose("parts", {"0", "0.5"});
  for (const std::string name : {"whole", "parts"}) {
    const Outcome o = run("--scene scene.yaml --out out_" + name + " " + name);
    ASSERT_EQ(o.code, 0) << o.err;
    EXPECT_EQ(o.err, "") << name;
  }
  for (const char* file : {"g.csv", "t.csv", "f_000000.png", "f_000001.png"}) {
    const std::string expected = contents(folder / "out_whole" / file);
    EXPECT_GT(expected.size(), 100u) << file;
    EXPECT_EQ(contents(folder / "out_parts" / file), expected) << file;
  }
  for (const Row& row : rows("out_parts/g.csv")) {
    const FoamMesh::Point& x = centres[std::size_t(row.at("cell"))];
    ASSERT_NEAR(row.at("p"), 1 + x[0] + 2 * x[1] - x[2] + 10 * row.at("time"), 1e-5);
  }
}

/// A dry run of a case, whole or in parts, says what is in its first time.
TEST_F(OpenFoamCases, CheckTellsFieldsAndTimes) {
  put_scene();
  whole("whole", {"0", "0.5"});
  decompose("parts", {"0", "0.5"});
  put("typo.yaml", "insitu: 1\nprobes:\n  - {name: g, points: [[1, 1, 1]], fields: [P]}\n");
  for (const std::string name : {"whole", "parts"}) {
    expect_checked("--scene scene.yaml " + name,
                   {"mesh 'mesh': " + std::to_string(centres.size()) + " cells, " +
                        std::to_string(dual.points.size()) + " vertices\n",
                    "  field 'p' on cells, 1 component\n", "  field 'U' on cells, 3 components\n",
                    "2 steps\n", "  nothing/g.csv (every cycle)\n", " are kept"});
    expect_checked("--scene typo.yaml " + name, {"2 steps\n"}, "did you mean 'p'?");
  }
}

TEST_F(OpenFoamCases, AProcessorWithoutCellsAddsNothing) {
  put_scene();
  whole("whole", {"0"});
  idle = true;
  decompose("parts", {"0"});
  ASSERT_EQ(parts()[1].cells.size(), 0u);
  for (const std::string name : {"whole", "parts"}) {
    const Outcome o = run("--scene scene.yaml --out out_" + name + " " + name);
    ASSERT_EQ(o.code, 0) << o.err;
    EXPECT_EQ(o.err, "");
  }
  for (const char* file : {"g.csv", "t.csv", "f_000000.png"})
    EXPECT_EQ(contents(folder / "out_parts" / file), contents(folder / "out_whole" / file)) << file;
}

/// Points that move lie in the times' folders, and so do meshes of other cells.
TEST_F(OpenFoamCases, PointsThatMoveAndCellsThatChange) {
  put_scene();
  whole("whole", {"0", "0.5"});
  decompose("parts", {"0", "0.5"});
  const auto moved = [](FoamMesh mesh) {
    for (FoamMesh::Point& x : mesh.points)
      x[2] *= 1 + 0.25 * x[0];
    return mesh;
  };
  moved(dual).write_points(path("whole/0.5/polyMesh"));
  int p = 0;
  for (const FoamPart& part : parts())
    moved(part.mesh).write_points(path("parts/processor" + std::to_string(p++) + "/0.5/polyMesh"));
  for (const std::string name : {"whole", "parts"}) {
    const Outcome o = run("--scene scene.yaml --out out_" + name + " " + name);
    ASSERT_EQ(o.code, 0) << o.err;
  }
  for (const char* file : {"g.csv", "t.csv", "f_000000.png", "f_000001.png"})
    EXPECT_EQ(contents(folder / "out_parts" / file), contents(folder / "out_whole" / file)) << file;
  EXPECT_NE(contents(path("out_whole/f_000000.png")), contents(path("out_whole/f_000001.png")));
  // Cells of a time of their own, which tell no numbers of the whole.
  const fs::path own = folder / "parts/processor1/0.5/polyMesh";
  fs::copy(folder / "parts/processor1/constant/polyMesh", own,
           fs::copy_options::recursive | fs::copy_options::skip_existing);
  fs::remove(own / "cellProcAddressing");
  const Outcome o = run("--scene scene.yaml --out out_other parts");
  ASSERT_EQ(o.code, 0) << o.err;
  EXPECT_NE(o.err.find("parts/processor1/0.5/polyMesh/cellProcAddressing is not there"),
            std::string::npos)
      << o.err;
}

/// Without it they are pieces, on which each place has the value that it has on the whole.
TEST_F(OpenFoamCases, ProcessorsWithoutAddressingArePieces) {
  put_scene();
  whole("whole", {"0", "0.5"});
  decompose("parts", {"0", "0.5"});
  fs::remove(folder / "parts/processor1/constant/polyMesh/cellProcAddressing");
  ASSERT_EQ(run("--scene scene.yaml --out out_whole whole").code, 0);
  const Outcome o = run("--scene scene.yaml --out out_parts parts");
  ASSERT_EQ(o.code, 0) << o.err;
  EXPECT_NE(o.err.find("parts/processor1/constant/polyMesh/cellProcAddressing is not there: the "
                       "processors' meshes are pieces"),
            std::string::npos)
      << o.err;
  const std::vector<Row> expected = rows("out_whole/g.csv"), table = rows("out_parts/g.csv");
  ASSERT_EQ(table.size(), expected.size());
  const std::vector<FoamPart> pieces = parts();
  for (std::size_t i = 0; i < 300; ++i) { // of the places within cells
    const auto& cells = pieces[std::size_t(table[i].at("piece"))].cells;
    EXPECT_EQ(cells[std::size_t(table[i].at("cell"))], int(expected[i].at("cell")));
    EXPECT_EQ(table[i].at("p"), expected[i].at("p"));
  }
}

/// What has more times is read: the processors of a run that is not put together, or the whole.
TEST_F(OpenFoamCases, WholeOrProcessorsByTheirTimes) {
  put("scene.yaml", "insitu: 1\nprobes:\n  - {name: g, points: [[1.5, 1.5, 1.5]], fields: [p]}\n");
  whole("case", {"0"});
  decompose("case", {"0", "0.5"});
  ASSERT_EQ(run("--scene scene.yaml --out out case").code, 0);
  EXPECT_EQ(rows("out/g.csv").size(), 2u);
  whole("case", {"0", "0.5"});
  fs::remove_all(folder / "case/processor1"); // of no account
  ASSERT_EQ(run("--scene scene.yaml --out out2 case").code, 0);
  EXPECT_EQ(rows("out2/g.csv").size(), 2u);
}

TEST_F(OpenFoamCases, WhatIsWrongIsNamed) {
  put_scene();
  const auto has = [&](const std::string& message) {
    const std::string err = err_of("parts");
    EXPECT_NE(err.find(message), std::string::npos) << err;
  };
  for (const std::string last : {"1", "2"}) {
    decompose("parts", {"0"});
    fs::remove_all(folder / ("parts/processor" + last));
    has("parts: the folder processor" + last + " is missing, of processor0 to processor2");
    fs::remove_all(folder / "parts");
  }
  decompose("parts", {"0"});
  std::vector<int> labels = parts()[1].cells;
  labels[3] = 64;
  addressing("parts/processor1", "cellProcAddressing", labels, false);
  has("parts/processor1/constant/polyMesh/cellProcAddressing: label 3 is 64, 0 to 63 expected");
  labels[3] = parts()[0].cells[5];
  addressing("parts/processor1", "cellProcAddressing", labels, true);
  has("cellProcAddressing: label 3 is " + std::to_string(labels[3]) + ", as label 5 of ");
  foam::write(folder / "parts/processor1/constant/polyMesh/cellProcAddressing",
              foam::header("labelList", "cellProcAddressing") + "20\n(\n1 2 x 4");
  has("cellProcAddressing: 'x' stands where a label is expected");
  foam::write(folder / "parts/processor1/constant/polyMesh/cellProcAddressing",
              foam::header("labelList", "cellProcAddressing") + "20\n(\n1 2 ");
  has("cellProcAddressing: ends within");
  addressing("parts/processor1", "cellProcAddressing", parts()[1].cells, false);
  fs::remove_all(folder / "parts/processor2/0");
  has("parts/processor2: has ");
  has("but processor0 has 1 times, the last '0'");
  fs::remove_all(folder / "parts");
  control("parts");
  fs::create_directories(folder / "parts/processors3");
  has("parts: processors3 has the files of several processors in one");
}
