/// VTK's polyhedra come in as cells given by faces.

#include <cmath>
#include <gtest/gtest.h>
#include <vtkCellArray.h>
#include <vtkIdList.h>
#include <vtkIdTypeArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridReader.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include "insitu/vtk.hpp"

#include "meshes.h"

using namespace vtk_meshes;

namespace {

std::vector<double> some_points() {
  std::vector<double> points;
  Random random(7);
  for (int i = 0; i < 3 * 400; ++i)
    points.push_back(2.0 * random());
  return points;
}

} // namespace

TEST(Polyhedra, AreTheCellsThatTheyAre) {
  for (const std::vector<int>& types :
       {std::vector<int>{VTK_HEXAHEDRON}, std::vector<int>{VTK_VOXEL},
        std::vector<int>{VTK_TETRA, VTK_WEDGE, VTK_PYRAMID}})
    for (const int step : {1, 2}) {
      const auto grid = as_polyhedra(types, step), shapes = unstructured(2, types, 0.1);
      add_fields(shapes);
      insitu::Session session;
      insitu::Mesh mesh = session.mesh("m"), plain = session.mesh("plain");
      auto attached = insitu::vtk::attach(mesh, grid);
      const auto alone = insitu::vtk::attach(plain, shapes);
      mesh.commit();
      plain.commit();
      ASSERT_EQ(attached.converted().size(), 1u);
      EXPECT_EQ(attached.converted()[0].array, "faces");
      const std::vector<double> points = some_points();
      const auto a = mesh.sample("linear", insitu::Points(points));
      const auto b = plain.sample("linear", insitu::Points(points));
      EXPECT_EQ(a.cells, b.cells);
      for (std::size_t i = 0; i < a.values.size(); ++i)
        if (a.cells[i] >= 0) { // else in the gaps between the cells of the mixture
          EXPECT_NEAR(a.values[i], b.values[i], 1e-13); // a few roundings of numbers up to 8
        }
      EXPECT_EQ(int(attached.update(grid)), 0) << "nothing changed";
      grid->GetPoints()->Modified();
      EXPECT_EQ(int(attached.update(grid)), int(insitu::geometry));
    }
}

TEST(Polyhedra, OfFiles) {
  const auto grid = as_polyhedra({VTK_HEXAHEDRON}, 2);
  vtkNew<vtkXMLUnstructuredGridWriter> writer;
  writer->SetInputData(grid);
  writer->WriteToOutputStringOn();
  writer->Write();
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  reader->ReadFromInputStringOn();
  reader->SetInputString(writer->GetOutputString());
  reader->Update();
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
  const auto attached = insitu::vtk::attach(mesh, reader->GetOutput());
  EXPECT_EQ(mesh.commit().cells, 8);
  const std::vector<double> points{0.5, 0.5, 0.5, 1.5, 0.5, 0.5};
  EXPECT_EQ(mesh.locate(insitu::Points(points)).cells, (std::vector<std::int64_t>{0, 1}));
}

TEST(Polyhedra, WithFacesThatLieNowhereAreRefused) {
  const auto grid = as_polyhedra({VTK_HEXAHEDRON}, 1);
  grid->GetFaces()->SetValue(1, 1000000);
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
  try {
    (void)insitu::vtk::attach(mesh, grid);
    FAIL() << "accepted";
  } catch (const insitu::Error& e) {
    EXPECT_EQ(e.status(), INSITU_ERROR_MESH);
    EXPECT_NE(std::string(e.what()).find("cell 0: its faces lie at "), std::string::npos)
        << e.what();
  }
}
