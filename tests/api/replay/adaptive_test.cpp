/// insitu-replay on files of adaptive meshes that VTK's own writers made: the same samples as of
/// the data objects in memory.

#include <vtkXMLHyperTreeGridWriter.h>
#include <vtkXMLUniformGridAMRWriter.h>

#include "../vtk/adaptive_meshes.h"
#include "replay.h"

using namespace vtk_meshes;

namespace {

/// Points in the domains of two_levels() and Trees, near their boundaries and outside.
std::vector<double> points() {
  Random random(815);
  std::vector<double> out;
  for (int i = 0; i < 600; ++i)
    out.push_back((i % 2 ? 1.1 : 4.2) * random() - 0.05);
  return out;
}

struct ReplayAdaptive : Replay {
  void SetUp() override {
    Replay::SetUp();
    put_points("points.csv", xyz);
  }
  /// Rows [first, first + points) are the samples of the data object.
  void expect_samples(const std::vector<Row>& rows, std::size_t first, vtkDataObject* data) const {
    insitu::Session session;
    insitu::Mesh mesh = session.mesh("mesh");
    const auto attached = insitu::vtk::attach_adaptive(mesh, data);
    mesh.commit();
    const insitu::Samples expected = mesh.sample("f", xyz);
    std::size_t inside = 0;
    ASSERT_GE(rows.size(), first + xyz.size() / 3);
    for (std::size_t i = 0; i < xyz.size() / 3; ++i) {
      const Row& row = rows[first + i];
      ASSERT_EQ(std::isnan(row.at("f")), !expected.found[i]) << "point " << i;
      if (!expected.found[i])
        continue;
      ++inside;
      // Values of some units, interpolated in other batches: the last digit may differ.
      EXPECT_NEAR(row.at("f"), expected.values[i], 4e-15) << "point " << i;
      EXPECT_EQ(row.at("cell"), double(expected.cells[i])) << "point " << i;
      EXPECT_EQ(row.at("piece"), double(expected.pieces[i])) << "point " << i;
    }
    EXPECT_GT(inside, 20u);
    EXPECT_LT(inside, xyz.size() / 3);
  }
  template <class Writer>
  void write(const std::string& name, vtkDataObject* data) const {
    vtkNew<Writer> writer;
    writer->SetFileName(path(name).c_str());
    writer->SetInputDataObject(data);
    ASSERT_EQ(writer->Write(), 1);
  }

  const std::vector<double> xyz = points();
};

} // namespace

TEST_F(ReplayAdaptive, OverlappingGridsOfLevels) {
  const auto amr = two_levels();
  write<vtkXMLUniformGridAMRWriter>("blocks_0.vthb", amr);
  const auto again = two_levels();
  for (unsigned int level = 0; level < 2; ++level)
    for (vtkIdType i = 0; i < values_of(again, level)->GetNumberOfValues(); ++i)
      values_of(again, level)->SetValue(i, 3.0 - values_of(again, level)->GetValue(i));
  write<vtkXMLUniformGridAMRWriter>("blocks_1.vthb", again);
  const Outcome o =
      run("--probe points.csv --out res --summary sum.json blocks_0.vthb blocks_1.vthb");
  ASSERT_EQ(o.code, 0) << o.err;
  const std::vector<Row> r = rows("res/probe.csv");
  ASSERT_EQ(r.size(), 2 * xyz.size() / 3);
  expect_samples(r, 0, amr);
  expect_samples(r, xyz.size() / 3, again);
  const std::string summary = contents(path("sum.json")); // the same cells: built once
  EXPECT_NE(summary.find("\"rebuild\": 1"), std::string::npos) << summary;
  EXPECT_NE(summary.find("\"keep\": 1"), std::string::npos) << summary;
  const Outcome checked = run("--validate blocks_0.vthb");
  EXPECT_EQ(checked.code, 0) << checked.err;
  EXPECT_EQ(checked.out.rfind("blocks_0.vthb: accepted, 128 cells", 0), 0u) << checked.out;
}

/// A level goes and comes again: each step's samples are those of its own data, and it is built
/// anew.
TEST_F(ReplayAdaptive, OverARegrid) {
  const auto two = two_levels(), one = some_levels(1);
  write<vtkXMLUniformGridAMRWriter>("step_0.vthb", two);
  write<vtkXMLUniformGridAMRWriter>("step_1.vthb", one);
  write<vtkXMLUniformGridAMRWriter>("step_2.vthb", two);
  const Outcome o = run("--probe points.csv --out res --summary sum.json step_0.vthb step_1.vthb "
                        "step_2.vthb");
  ASSERT_EQ(o.code, 0) << o.err;
  const std::vector<Row> r = rows("res/probe.csv");
  const std::size_t points = xyz.size() / 3;
  ASSERT_EQ(r.size(), 3 * points);
  expect_samples(r, 0, two);
  expect_samples(r, points, one);
  expect_samples(r, 2 * points, two);
  const std::string summary = contents(path("sum.json"));
  EXPECT_NE(summary.find("\"rebuild\": 3"), std::string::npos) << summary;
}

TEST_F(ReplayAdaptive, HyperTrees) {
  Trees trees;
  write<vtkXMLHyperTreeGridWriter>("trees.htg", trees.grid);
  const Outcome o = run("--probe points.csv --out res trees.htg");
  ASSERT_EQ(o.code, 0) << o.err;
  expect_samples(rows("res/probe.csv"), 0, trees.grid);
}

TEST_F(ReplayAdaptive, FilesThatDoNotFitAreNamed) {
  mesh("m.vtu", 0.0);
  write<vtkXMLUniformGridAMRWriter>("blocks.vthb", two_levels());
  Outcome o = run("--probe points.csv m.vtu blocks.vthb");
  EXPECT_EQ(o.code, 1);
  EXPECT_NE(o.err.find("blocks.vthb: is an adaptive mesh"), std::string::npos) << o.err;
  o = run("--probe points.csv blocks.vthb m.vtu");
  EXPECT_EQ(o.code, 1);
  EXPECT_NE(o.err.find("m.vtu: is no adaptive mesh"), std::string::npos) << o.err;
  insitu::vtk::Series series(path("run.pvd"));
  series.add(0.0, "blocks.vthb", 0);
  series.add(0.0, "m.vtu", 1);
  o = run("--probe points.csv run.pvd");
  EXPECT_EQ(o.code, 1);
  EXPECT_NE(o.err.find("blocks.vthb: is an adaptive mesh"), std::string::npos) << o.err;
  for (const char* name : {"words.vthb", "words.vth", "words.htg"}) {
    put(name, "not XML");
    o = run(std::string("--probe points.csv ") + name);
    EXPECT_EQ(o.code, 1);
    EXPECT_EQ(o.err.rfind(std::string("insitu-replay: ") + name + ": cannot be read", 0), 0u)
        << o.err;
  }
}
