/// insitu-replay as a program: files in, files out, exit codes, messages.

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <map>
#include <sstream>
#include <sys/wait.h>
#include <unistd.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkIntArray.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include "insitu/vtk.hpp"

#include "replay.h"

using namespace vtk_meshes;

TEST_F(Replay, StepsBecomeRowsAndAPipeIsQuiet) {
  mesh("m_0.vtu", 0.0, 10, 0.5);
  mesh("m_1.vtu", 100.0, 20, 0.75);
  const Outcome o = run("--scene scene.yaml --out res m_0.vtu m_1.vtu");
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_EQ(o.out, "");
  EXPECT_EQ(o.err, "");
  const std::vector<Row> r = rows("res/g.csv");
  ASSERT_EQ(r.size(), 6u);
  EXPECT_EQ(r[0].at("cycle"), 10);
  EXPECT_EQ(r[0].at("time"), 0.5);
  EXPECT_EQ(r[5].at("cycle"), 20);
  EXPECT_EQ(r[5].at("time"), 0.75);
  EXPECT_NEAR(r[0].at("linear"), linear({0.4, 0.3, 0.2}), 1e-10);
  EXPECT_NEAR(r[4].at("linear"), linear({1.5, 1.5, 1.5}) + 100.0, 1e-10);
  EXPECT_EQ(r[1].at("cell"), 7);
  EXPECT_TRUE(std::isnan(r[2].at("linear")));
}

/// The grid's cells as plain arrays, given through insitu.hpp: a way of its own into the library.
struct PlainMesh {
  std::vector<double> xyz;
  std::vector<std::uint8_t> types;
  std::vector<std::int64_t> offsets, connectivity;
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("plain");

  explicit PlainMesh(vtkUnstructuredGrid* grid) {
    for (vtkIdType i = 0; i < grid->GetNumberOfPoints(); ++i)
      for (const double x : point_of(grid, i))
        xyz.push_back(x);
    for (vtkIdType c = 0; c < grid->GetNumberOfCells(); ++c) {
      offsets.push_back(std::int64_t(connectivity.size()));
      types.push_back(std::uint8_t(grid->GetCellType(c)));
      vtkIdType n = 0;
      const vtkIdType* ids = nullptr;
      grid->GetCellPoints(c, n, ids);
      connectivity.insert(connectivity.end(), ids, ids + n);
    }
    mesh.points(xyz);
    mesh.mixed_cells(types, offsets, connectivity);
    mesh.commit();
  }
};

/// Random points, inside and outside; then for many cells their vertices, and the middles of edges
/// and faces, each as it is and one step of the last digit off.
std::vector<double> places(vtkUnstructuredGrid* grid, int n) {
  Random random(4711);
  std::vector<double> out;
  for (int q = 0; q < 1200; ++q)
    out.push_back((n + 0.2) * random() - 0.1);
  const auto add = [&](const std::vector<vtkIdType>& ids) {
    double p[3] = {0, 0, 0};
    for (const vtkIdType id : ids)
      for (int a = 0; a < 3; ++a)
        p[a] += point_of(grid, id)[std::size_t(a)] / double(ids.size());
    out.insert(out.end(), p, p + 3);
    const auto axis = int(3 * random());
    p[axis] = std::nextafter(p[axis], random() < 0.5 ? -1e9 : 1e9);
    out.insert(out.end(), p, p + 3);
  };
  for (vtkIdType c = 0; c < grid->GetNumberOfCells(); c += 3) {
    vtkCell* cell = grid->GetCell(c);
    add({cell->GetPointId(int(random() * double(cell->GetNumberOfPoints())))});
    vtkCell* edge = cell->GetEdge(int(random() * cell->GetNumberOfEdges()));
    add({edge->GetPointId(0), edge->GetPointId(1)});
    vtkCell* face = cell->GetFace(int(random() * cell->GetNumberOfFaces()));
    std::vector<vtkIdType> ids;
    for (vtkIdType i = 0; i < face->GetNumberOfPoints(); ++i)
      ids.push_back(face->GetPointId(i));
    add(ids);
  }
  return out;
}

TEST_F(Replay, OwnersAndCoordinatesAreTheApis) {
  const struct {
    const char* name;
    std::vector<int> types;
    double jitter;
  } meshes[] = {{"tetrahedra", {VTK_TETRA}, 0.2},
                {"voxels", {VTK_VOXEL}, 0.0},
                {"hexahedra", {VTK_HEXAHEDRON}, 0.2},
                {"wedges", {VTK_WEDGE}, 0.15},
                {"pyramids", {VTK_PYRAMID}, 0.1},
                {"hexahedra_and_pyramids", {VTK_HEXAHEDRON, VTK_PYRAMID}, 0.15},
                {"all", {VTK_HEXAHEDRON, VTK_TETRA, VTK_VOXEL, VTK_PYRAMID, VTK_WEDGE}, 0.1}};
  constexpr int n = 4;
  for (const auto& of : meshes) {
    SCOPED_TRACE(of.name);
    const auto grid = unstructured(n, of.types, of.jitter);
    vtkNew<vtkXMLUnstructuredGridWriter> writer; // VTK's own, not the adaptor's
    writer->SetFileName(path("mesh.vtu").c_str());
    writer->SetInputData(grid);
    ASSERT_EQ(writer->Write(), 1);
    const std::vector<double> xyz = places(grid, n);
    put_points("points.csv", xyz);
    const PlainMesh plain(grid);
    for (const insitu::Accuracy accuracy : {insitu::Accuracy::standard, insitu::Accuracy::exact}) {
      const std::string word = accuracy == insitu::Accuracy::exact ? "exact" : "standard";
      put("scene.yaml", "insitu: 1\nprobes:\n  - {name: g, points: points.csv, fields: [number], "
                        "accuracy: " +
                            word + "}\n");
      const Outcome o = run("--scene scene.yaml --out " + word + " mesh.vtu");
      ASSERT_EQ(o.code, 0) << o.err;
      const std::vector<Row> r = rows(word + "/g.csv");
      insitu::LocateOptions options;
      options.accuracy = accuracy;
      const insitu::Locations expected = plain.mesh.locate(xyz, options);
      ASSERT_EQ(r.size(), expected.size());
      std::size_t inside = 0;
      for (std::size_t i = 0; i < r.size(); ++i) {
        ASSERT_EQ(r[i].at("cell"), double(expected.cells[i])) << "point " << i;
        inside += expected.found[i];
        if (!expected.found[i])
          continue;
        EXPECT_EQ(r[i].at("number"), 3.0 * double(expected.cells[i]) + 1.0);
        const char* const names[3] = {"r", "s", "t"}; // printed so that nothing is lost
        for (std::size_t a = 0; a < 3; ++a)
          EXPECT_EQ(r[i].at(names[a]), expected.parametric[3 * i + a]) << "point " << i;
      }
      EXPECT_GT(inside, r.size() / 2);
      EXPECT_LT(inside, r.size());
    }
    fs::remove_all(folder / "standard");
    fs::remove_all(folder / "exact");
  }
}

TEST_F(Replay, OrderCountsWhereFilesSayNothing) {
  mesh("a.vtu", 0.0);
  mesh("b.vtu", 1.0);
  EXPECT_EQ(run("--scene=scene.yaml --out=res a.vtu b.vtu").code, 0);
  const std::vector<Row> r = rows("res/g.csv");
  ASSERT_EQ(r.size(), 6u);
  EXPECT_EQ(r[0].at("cycle"), 0);
  EXPECT_EQ(r[3].at("cycle"), 1);
  EXPECT_EQ(r[3].at("time"), 1.0);
}

TEST_F(Replay, EqualCellsAreNotRebuilt) {
  for (int i = 0; i < 4; ++i)
    mesh("m_" + std::to_string(i) + ".vtu", i, i, i, i < 3 ? VTK_HEXAHEDRON : VTK_WEDGE);
  const Outcome o = run("--scene scene.yaml --summary sum.json m_0.vtu m_1.vtu m_2.vtu m_3.vtu");
  EXPECT_EQ(o.code, 0) << o.err;
  const std::string summary = contents(path("sum.json"));
  EXPECT_NE(summary.find("\"rebuild\": 2"), std::string::npos) << summary;
  EXPECT_NE(summary.find("\"keep\": 2"), std::string::npos) << summary;
}

TEST_F(Replay, IndexFilesWithParts) {
  mesh("left.vtu", 0.0);
  const auto right = structured(2, 0.1);
  for (vtkIdType i = 0; i < right->GetNumberOfPoints(); ++i) {
    Point p = point_of(right, i);
    p[0] += 2.0;
    right->GetPoints()->SetPoint(i, p.data());
  }
  insitu::vtk::write(path("right.vts"), right);
  insitu::vtk::Series series(path("run.pvd"));
  for (const double time : {0.25, 0.5}) {
    series.add(time, "left.vtu", 0);
    series.add(time, "right.vts", 1);
  }
  put("points.csv", "x,y,z\n0.4,0.3,0.2\n2.4,0.3,0.2\n");
  const Outcome o = run("--probe points.csv --out res run.pvd");
  EXPECT_EQ(o.code, 0) << o.err;
  const std::vector<Row> r = rows("res/probe.csv");
  ASSERT_EQ(r.size(), 4u);
  EXPECT_EQ(r[2].at("time"), 0.5);
  EXPECT_EQ(r[2].at("cycle"), 1);
  EXPECT_EQ(r[3].at("piece"), 1);
  EXPECT_EQ(r[3].at("cell"), 0);
  EXPECT_NEAR(r[3].at("linear"), linear({0.4, 0.3, 0.2}), 1e-10); // its own field, not moved
}

TEST_F(Replay, ErrorsNameTheFile) {
  mesh("good.vtu", 0.0);
  EXPECT_EQ(run("--scene scene.yaml absent.vtu").code, 1);
  EXPECT_EQ(contents(path("err.txt")), "insitu-replay: absent.vtu: no such file\n");

  const std::string whole = contents(path("good.vtu"));
  put("half.vtu", whole.substr(0, whole.size() / 2));
  Outcome o = run("--scene scene.yaml good.vtu half.vtu");
  EXPECT_EQ(o.code, 1);
  EXPECT_EQ(o.err.rfind("insitu-replay: half.vtu: cannot be read", 0), 0u) << o.err;
  put("words.vtu", "not XML");
  o = run("--scene scene.yaml words.vtu");
  EXPECT_EQ(o.code, 1);
  EXPECT_EQ(o.err.rfind("insitu-replay: words.vtu: ", 0), 0u) << o.err;

  const auto bad = unstructured(2, {VTK_HEXAHEDRON}, 0.1);
  const vtkIdType ids[10] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
  bad->InsertNextCell(VTK_QUADRATIC_TETRA, 10, ids);
  vtkDoubleArray::SafeDownCast(bad->GetCellData()->GetArray("number"))->InsertNextValue(0);
  insitu::vtk::write(path("quadratic.vtu"), bad);
  o = run("--scene scene.yaml quadratic.vtu");
  EXPECT_EQ(o.code, 1);
  EXPECT_NE(o.err.find("quadratic.vtu: cell 8 is a vtkQuadraticTetra"), std::string::npos) << o.err;

  o = run("--scene scene.yaml notes.txt");
  EXPECT_EQ(o.code, 1);
  EXPECT_NE(o.err.find("notes.txt: unknown kind of file"), std::string::npos) << o.err;
  put("empty.pvd", "<VTKFile type=\"Collection\"><Collection/></VTKFile>");
  EXPECT_EQ(run("--scene scene.yaml empty.pvd").code, 1);

  put("typo.yaml", "insitu: 1\nprobs: []\n");
  o = run("--scene typo.yaml good.vtu");
  EXPECT_EQ(o.code, 1);
  EXPECT_NE(o.err.find("typo.yaml"), std::string::npos) << o.err;
  EXPECT_NE(o.err.find("probes"), std::string::npos) << o.err;
}

TEST_F(Replay, TimeMayNotRunBackwards) {
  mesh("m_9.vtu", 0.0, 9, 9.0);
  mesh("m_10.vtu", 0.0, 10, 10.0);
  const Outcome o = run("--scene scene.yaml m_10.vtu m_9.vtu");
  EXPECT_EQ(o.code, 1);
  EXPECT_NE(o.err.find("note: the numbers in the files' names do not ascend"), std::string::npos);
  EXPECT_NE(o.err.find("m_9.vtu: time 9"), std::string::npos) << o.err;
}

// A particle goes forward through the files, and one from its end back: the field grows with time.
TEST_F(Replay, InReverseTimeGoesBack) {
  const auto step = [&](int s) {
    const auto grid = vtk_meshes::unstructured(2, {VTK_HEXAHEDRON}, 0.1);
    vtkNew<vtkDoubleArray> u, time;
    u->SetName("u");
    u->SetNumberOfComponents(3);
    u->SetNumberOfTuples(grid->GetNumberOfPoints());
    for (vtkIdType i = 0; i < grid->GetNumberOfPoints(); ++i)
      u->SetTuple3(i, 0.1 * s, 0.05, 0.0);
    grid->GetPointData()->AddArray(u);
    time->SetName("TimeValue");
    time->InsertNextValue(0.5 * s);
    grid->GetFieldData()->AddArray(time);
    insitu::vtk::write(path("m_" + std::to_string(s) + ".vtu"), grid);
  };
  for (int s = 0; s < 4; ++s)
    step(s);
  const auto scene = [&](const std::string& name, const std::string& keys) {
    put(name,
        "insitu: 1\npage: false\ntracers:\n  - {name: t, velocity: u, every: 1, " + keys + "}\n");
  };
  scene("there.yaml", "seeds: [[0.5, 0.5, 0.5]]");
  ASSERT_EQ(run("--scene there.yaml --out there m_0.vtu m_1.vtu m_2.vtu m_3.vtu").code, 0);
  const Row there = rows("there/t.csv")[3];
  EXPECT_NEAR(there.at("x"), 0.5 + 0.1 * 1.5 * 1.5, 1e-12);
  char seed[120];
  std::snprintf(seed, sizeof seed, "seeds: [[%.17g, %.17g, 0.5]], direction: backward",
                there.at("x"), there.at("y"));
  scene("back.yaml", seed);
  const Outcome o = run("--reverse --scene back.yaml --out back m_0.vtu m_1.vtu m_2.vtu m_3.vtu");
  ASSERT_EQ(o.code, 0) << o.err;
  const std::vector<Row> back = rows("back/t.csv");
  ASSERT_GE(back.size(), 4u);
  for (int s = 0; s < 4; ++s) {
    EXPECT_EQ(back[std::size_t(s)].at("time"), 1.5 - 0.5 * s);
    EXPECT_EQ(back[std::size_t(s)].at("cycle"), 3 - s);
  }
  EXPECT_NEAR(back[3].at("x"), 0.5, 1e-12);
  EXPECT_NEAR(back[3].at("y"), 0.5, 1e-12);
  // A scene that goes forward has its particles wait, and says so.
  const Outcome waits = run("--reverse --scene there.yaml --out waits m_0.vtu m_1.vtu");
  EXPECT_EQ(waits.code, 3);
  EXPECT_NE(waits.err.find("time went back from 0.5"), std::string::npos) << waits.err;
  EXPECT_EQ(run("--reverse --scene back.yaml --out none m_1.vtu m_0.vtu").code, 1);
}

TEST_F(Replay, FailedActionsAreTold) {
  mesh("m.vtu", 0.0);
  put("scene.yaml", "insitu: 1\nprobes:\n  - {name: g, points: points.csv, fields: [liner]}\n");
  const Outcome o = run("--scene scene.yaml m.vtu");
  EXPECT_EQ(o.code, 3);
  EXPECT_NE(o.err.find("liner"), std::string::npos) << o.err;
}

TEST_F(Replay, Validate) {
  mesh("good.vtu", 0.0);
  const auto grid = unstructured(2, {VTK_HEXAHEDRON}, 0.0);
  grid->GetPoints()->SetPoint(4, NAN, 0, 0);
  insitu::vtk::write(path("nan.vtu"), grid);
  EXPECT_EQ(run("--validate good.vtu").code, 0);
  const Outcome o = run("--validate good.vtu nan.vtu");
  EXPECT_EQ(o.code, 1);
  EXPECT_NE(o.out.find("good.vtu: accepted, 8 cells"), std::string::npos) << o.out;
  EXPECT_NE(o.out.find("nan.vtu: refused"), std::string::npos) << o.out;
}

/// What the scene needs of the first file's mesh; nothing is written.
TEST_F(Replay, Plan) {
  mesh("m.vtu", 0.0);
  put("scene.yaml", "insitu: 1\nframes:\n  - {name: f, size: [8, 8], isosurfaces: [{field: linear, "
                    "values: [0.5]}]}\n");
  const Outcome o = run("--plan --scene scene.yaml --out out m.vtu");
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_NE(o.out.find("frame 'f' of mesh 'mesh'"), std::string::npos) << o.out;
  EXPECT_NE(o.out.find("needed   value ranges of 'linear'"), std::string::npos) << o.out;
  EXPECT_NE(o.out.find("skipped  ray marching"), std::string::npos) << o.out;
  EXPECT_FALSE(fs::exists(folder / "out"));
}

/// Files in longitude, latitude and depth are drawn from space; the plan tells the bytes of that.
TEST_F(Replay, FilesMayBeOnEarth) {
  mesh("m.vtu", 0.0);
  put("scene.yaml", "insitu: 1\nframes:\n  - {name: f, size: [8, 8], geocentric: {exaggeration: "
                    "1000}, boundary: {}}\n");
  Outcome o = run("--plan --frame 'geodetic kilometres depth' --scene scene.yaml --out out m.vtu");
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_NE(o.out.find("needed   geocentric vertices, heights times 1000"), std::string::npos)
      << o.out;
  EXPECT_NE(o.out.find("648 B"), std::string::npos) << o.out; // 27 vertices of 24 bytes
  o = run("--frame=geodetic --scene scene.yaml --out out m.vtu");
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_TRUE(fs::exists(folder / "out" / "f_000000.png"));
  o = run("--scene scene.yaml --out out m.vtu"); // Cartesian files have no place on Earth
  EXPECT_EQ(o.code, 3);
  EXPECT_NE(o.err.find("Cartesian"), std::string::npos) << o.err;
}

TEST_F(Replay, Usage) {
  Outcome o = run("--help");
  EXPECT_EQ(o.code, 0);
  EXPECT_EQ(o.out.rfind("usage: insitu-replay", 0), 0u);
  EXPECT_EQ(run("--version").code, 0);
  for (const char* wrong : {"", "--scene", "--threads=x a.vtu", "--treads 3 a.vtu", "--help=1",
                            "--scene a --probe b c.vtu", "--frame lonlat a.vtu"}) {
    o = run(wrong);
    EXPECT_EQ(o.code, 2) << wrong;
    EXPECT_NE(o.err.find("--help"), std::string::npos) << o.err;
  }
}
