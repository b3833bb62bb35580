// insitu-replay on the pieces of structured files, as VTK writes them: .pvti, .pvtr and .pvts.
#include <array>
#include <vtkImageData.h>
#include <vtkRectilinearGrid.h>
#include <vtkStructuredGrid.h>
#include <vtkXMLImageDataWriter.h>
#include <vtkXMLPImageDataWriter.h>
#include <vtkXMLPRectilinearGridWriter.h>
#include <vtkXMLPStructuredGridWriter.h>
#include <vtkXMLRectilinearGridWriter.h>
#include <vtkXMLStructuredGridWriter.h>

#include "replay.h"

namespace {

struct ParallelFiles : Replay {
  static constexpr std::array<int, 3> n{7, 5, 4}; ///< points along each axis

  /// Any values on points and cells.
  static void add_fields(vtkDataSet* data) {
    vtk_meshes::Random random(7);
    for (vtkDataSetAttributes* to : {static_cast<vtkDataSetAttributes*>(data->GetPointData()),
                                     static_cast<vtkDataSetAttributes*>(data->GetCellData())}) {
      vtkNew<vtkDoubleArray> values;
      const bool on_points = to == data->GetPointData();
      values->SetName(on_points ? "f" : "c");
      for (vtkIdType i = on_points ? data->GetNumberOfPoints() : data->GetNumberOfCells(); i > 0;
           --i)
        values->InsertNextValue(random());
      to->AddArray(values);
    }
  }
  /// Points anywhere, within and without, and all points of the data, those of the seam among them.
  void put_points_of(vtkDataSet* data) const {
    std::vector<double> xyz;
    vtk_meshes::Random random(11);
    for (int i = 0; i < 300; ++i)
      for (const int points : n)
        xyz.push_back((points + 0.5) * random() - 0.5);
    for (vtkIdType i = 0; i < data->GetNumberOfPoints(); ++i)
      xyz.insert(xyz.end(), data->GetPoint(i), data->GetPoint(i) + 3);
    put_points("points.csv", xyz);
    put("scene.yaml", "insitu: 1\nprobes:\n  - {name: g, points: points.csv, fields: [f, c]}\n");
  }
  /// In one file and in two pieces, which may overlap by a layer of ghosts: the same table, with an
  /// owner of each of the data's points.
  template <class Writer, class ParallelWriter>
  void expect_same(vtkDataSet* data, const std::string& kind) const {
    put_points_of(data);
    vtkNew<Writer> writer;
    writer->SetInputData(data);
    writer->SetFileName(path("whole." + kind).c_str());
    ASSERT_EQ(writer->Write(), 1);
    const Outcome whole = run("--scene scene.yaml --out out whole." + kind);
    ASSERT_EQ(whole.code, 0) << whole.err;
    const std::string expected = contents(path("out/g.csv"));
    const std::vector<Row> table = rows("out/g.csv");
    ASSERT_EQ(table.size(), 300u + std::size_t(data->GetNumberOfPoints()));
    for (const Row& row : table)
      EXPECT_TRUE(row.at("point") < 300 || row.at("cell") >= 0) << row.at("point");
    for (const int ghosts : {0, 1}) {
      const std::string name = std::to_string(ghosts) + ".p" + kind;
      vtkNew<ParallelWriter> parallel;
      parallel->SetInputData(data);
      parallel->SetNumberOfPieces(2);
      parallel->SetStartPiece(0);
      parallel->SetEndPiece(1);
      parallel->SetGhostLevel(ghosts);
      parallel->SetFileName(path(name).c_str());
      ASSERT_EQ(parallel->Write(), 1);
      ASSERT_TRUE(fs::exists(path(std::to_string(ghosts) + "_1." + kind)));
      const Outcome pieces = run("--scene scene.yaml --out out_" + name + " " + name);
      ASSERT_EQ(pieces.code, 0) << pieces.err;
      EXPECT_EQ(pieces.err, "");
      EXPECT_EQ(contents(path("out_" + name + "/g.csv")), expected) << name;
    }
  }
};

TEST_F(ParallelFiles, OfImages) {
  vtkNew<vtkImageData> image;
  image->SetDimensions(n.data());
  image->SetSpacing(1, 0.75, 1.25);
  add_fields(image);
  expect_same<vtkXMLImageDataWriter, vtkXMLPImageDataWriter>(image, "vti");
}

TEST_F(ParallelFiles, OfRectilinearGrids) {
  vtkNew<vtkRectilinearGrid> grid;
  grid->SetDimensions(n.data());
  for (std::size_t a = 0; a < 3; ++a) {
    vtkNew<vtkDoubleArray> axis;
    for (int i = 0; i < n[a]; ++i)
      axis->InsertNextValue(i + 0.05 * i * i);
    a == 0   ? grid->SetXCoordinates(axis)
    : a == 1 ? grid->SetYCoordinates(axis)
             : grid->SetZCoordinates(axis);
  }
  add_fields(grid);
  expect_same<vtkXMLRectilinearGridWriter, vtkXMLPRectilinearGridWriter>(grid, "vtr");
}

TEST_F(ParallelFiles, OfStructuredGrids) {
  vtkNew<vtkStructuredGrid> grid;
  grid->SetDimensions(n.data());
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i)
        points->InsertNextPoint(i + 0.1 * std::sin(j + 2.0 * k), j + 0.1 * std::cos(i + k),
                                k + 0.1 * std::sin(2.0 * i - j));
  grid->SetPoints(points);
  add_fields(grid);
  expect_same<vtkXMLStructuredGridWriter, vtkXMLPStructuredGridWriter>(grid, "vts");
}

} // namespace
