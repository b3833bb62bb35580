/// insitu-replay on files whose fields have fill values and hidden points.

#include <vtkFloatArray.h>
#include <vtkIntArray.h>
#include <vtkSignedCharArray.h>

#include "replay.h"

using namespace vtk_meshes;

namespace {

struct Fills : Replay {
  /// [0, 4]^3 with velocity 1 along x and `linear`, which the fill value takes from x >= 3 on.
  vtkSmartPointer<vtkUnstructuredGrid> grid(bool filled) const {
    auto grid = unstructured(4, {VTK_HEXAHEDRON}, 0.0);
    vtkNew<vtkFloatArray> velocity;
    velocity->SetName("v");
    velocity->SetNumberOfComponents(3);
    auto* values = vtkDoubleArray::SafeDownCast(grid->GetPointData()->GetArray("linear"));
    for (vtkIdType i = 0; i < grid->GetNumberOfPoints(); ++i) {
      const bool land = filled && grid->GetPoint(i)[0] >= 3;
      velocity->InsertNextTuple3(land ? 1e20 : 1, 0, 0);
      if (land)
        values->SetValue(i, 1e20);
    }
    grid->GetPointData()->AddArray(velocity);
    return grid;
  }
  void SetUp() override {
    Replay::SetUp();
    put("scene.yaml",
        "insitu: 1\nprobes:\n  - {name: g, points: [[0.4, 0.3, 0.2], [2.5, 0.3, 0.2]], fields: "
        "[linear]}\ntracers:\n  - {name: t, kind: streamline, velocity: v, seeds: [[0.5, 0.5, "
        "0.5]]}\n");
  }
  void expect_blank(const std::string& arguments, bool other_fields = false) {
    fs::remove_all(folder / "res");
    const Outcome o = run("--scene scene.yaml --out res " + arguments);
    EXPECT_EQ(o.code, 0) << o.err;
    const std::vector<Row> probed = rows("res/g.csv");
    ASSERT_EQ(probed.size(), 2u);
    EXPECT_NEAR(probed[0].at("linear"), linear({0.4, 0.3, 0.2}), 1e-12);
    EXPECT_EQ(std::isnan(probed[1].at("linear")), !other_fields);
    const std::string lines = contents(folder / "res/t_000000.csv");
    EXPECT_NE(lines.find("blank"), std::string::npos) << lines;
    EXPECT_NEAR(rows("res/t_000000.csv").back().at("x"), 2.0, 1e-9);
  }
};

TEST_F(Fills, FillValuesOfTheFieldDataAreBlank) {
  for (const char* key : {"_FillValue", "missing_value"}) {
    auto filled = grid(true);
    vtkNew<vtkFloatArray> value;
    value->SetName(key);
    value->InsertNextValue(1e20f);
    filled->GetFieldData()->AddArray(value);
    write("filled.vtu", filled);
    fs::remove_all(folder / "res");
    expect_blank("filled.vtu");
  }
}

TEST_F(Fills, OfOneArrayByItsName) {
  auto filled = grid(true);
  vtkNew<vtkDoubleArray> value;
  value->SetName("v._FillValue");
  value->InsertNextValue(double(1e20f));
  filled->GetFieldData()->AddArray(value);
  write("filled.vtu", filled);
  expect_blank("filled.vtu", true);
}

TEST_F(Fills, TheCommandLineSaysSo) {
  write("filled.vtu", grid(true));
  expect_blank("--blank 1e20 filled.vtu");
  expect_blank("--blank v=1e20 --blank linear=1e20 filled.vtu");
  expect_blank("--blank=v=1e20 filled.vtu", true);
  EXPECT_EQ(run("--scene scene.yaml --blank v= filled.vtu").code, 2);
  EXPECT_EQ(run("--scene scene.yaml --blank 1e20x filled.vtu").code, 2);
  const Outcome o = run("--scene scene.yaml --blank u=1e20 filled.vtu");
  EXPECT_EQ(o.code, 1);
  EXPECT_NE(o.err.find("no field 'u'"), std::string::npos) << o.err;
}

TEST_F(Fills, HiddenPointsOfAnyType) {
  for (const bool bytes : {true, false}) {
    auto hidden = grid(false);
    vtkSmartPointer<vtkDataArray> ghosts;
    if (bytes)
      ghosts = vtkSmartPointer<vtkUnsignedCharArray>::New();
    else
      ghosts = vtkSmartPointer<vtkIntArray>::New();
    ghosts->SetName("vtkGhostType");
    for (vtkIdType i = 0; i < hidden->GetNumberOfPoints(); ++i)
      ghosts->InsertNextTuple1(hidden->GetPoint(i)[0] >= 3 ? 2 : 1);
    hidden->GetPointData()->AddArray(ghosts);
    write("hidden.vtu", hidden);
    expect_blank("hidden.vtu");
  }
}

} // namespace
