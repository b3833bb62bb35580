/// Samples of attached data sets against vtkProbeFilter and against the known fields.

#include <gtest/gtest.h>
#include <vtkCellLocator.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkPolyData.h>
#include <vtkProbeFilter.h>
#include <vtkRectilinearGrid.h>
#include <vtkSOADataArrayTemplate.h>

#include "insitu/vtk.hpp"

#include "meshes.h"

using namespace vtk_meshes;

namespace {

/// How far VTK's own answer may lie from ours: its inverse map stops at 1e-3 in parametric
/// coordinates, one quadratic step from the answer. Cell values are equal, or the cell is another.
constexpr double vtk_newton = 2e-5;

void compare_with_vtk(vtkDataSet* data, double own_error) {
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
  const insitu::vtk::Attachment attachment = insitu::vtk::attach(mesh, data);
  EXPECT_TRUE(attachment.converted().empty());
  mesh.commit();

  const std::vector<double> xyz = query_points(data, 600);
  const insitu::FieldSamples ours = mesh.sample_fields({"linear", "velocity", "number"}, xyz);

  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (std::size_t i = 0; i < xyz.size(); i += 3)
    points->InsertNextPoint(&xyz[i]);
  vtkNew<vtkPolyData> input;
  input->SetPoints(points);
  vtkNew<vtkProbeFilter> probe;
  probe->SetInputData(input);
  probe->SetSourceData(data);
  probe->Update();
  vtkPointData* theirs = probe->GetOutput()->GetPointData();
  vtkDataArray* valid = theirs->GetArray(probe->GetValidPointMaskArrayName());
  ASSERT_NE(valid, nullptr);

  int found = 0;
  for (std::size_t q = 0; q < ours.size(); ++q) {
    const auto id = vtkIdType(q);
    ASSERT_EQ(ours.found[q] != 0, valid->GetTuple1(id) != 0.0) << "point " << q;
    if (!ours.found[q]) {
      EXPECT_TRUE(std::isnan(ours.values[0].values[q]));
      EXPECT_TRUE(std::isnan(ours.values[1].values[3 * q + 2]));
      continue;
    }
    ++found;
    const Point p{xyz[3 * q], xyz[3 * q + 1], xyz[3 * q + 2]};
    const double scale = 20.0;
    EXPECT_NEAR(ours.values[0].values[q], linear(p), own_error * scale) << "point " << q;
    EXPECT_NEAR(ours.values[0].values[q], theirs->GetArray("linear")->GetTuple1(id),
                vtk_newton * scale);
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(ours.values[1].values[3 * q + std::size_t(c)],
                  theirs->GetArray("velocity")->GetComponent(id, c), vtk_newton * scale);
    EXPECT_EQ(ours.values[2].values[q], theirs->GetArray("number")->GetTuple1(id));
    EXPECT_EQ(ours.values[2].values[q], 3.0 * double(ours.cells[q]) + 1.0);
  }
  EXPECT_EQ(found, 540);
}

} // namespace

TEST(VtkProbe, Tetrahedra) {
  compare_with_vtk(unstructured(4, {VTK_TETRA}, 0.15), 1e-12);
}
TEST(VtkProbe, Voxels) {
  compare_with_vtk(unstructured(4, {VTK_VOXEL}, 0.0), 1e-12);
}
TEST(VtkProbe, Hexahedra) {
  compare_with_vtk(unstructured(4, {VTK_HEXAHEDRON}, 0.2), 1e-10);
}
TEST(VtkProbe, Wedges) {
  compare_with_vtk(unstructured(4, {VTK_WEDGE}, 0.15), 1e-10);
}
TEST(VtkProbe, Pyramids) {
  compare_with_vtk(unstructured(3, {VTK_PYRAMID}, 0.1), 1e-10);
}
TEST(VtkProbe, MixedShapes) {
  compare_with_vtk(unstructured(4, {VTK_HEXAHEDRON, VTK_PYRAMID}, 0.15), 1e-10);
}
TEST(VtkProbe, StructuredGrid) {
  compare_with_vtk(structured(4, 0.2), 1e-10);
}

TEST(VtkProbe, RectilinearGrid) {
  vtkNew<vtkRectilinearGrid> grid;
  grid->SetDimensions(4, 5, 3);
  vtkNew<vtkDoubleArray> axes[3];
  for (int a = 0; a < 3; ++a)
    for (int i = 0; i < grid->GetDimensions()[a]; ++i)
      axes[a]->InsertNextValue(0.3 * i + 0.1 * i * i + a);
  grid->SetXCoordinates(axes[0]);
  grid->SetYCoordinates(axes[1]);
  grid->SetZCoordinates(axes[2]);
  add_fields(grid);
  compare_with_vtk(grid, 1e-12);
}

TEST(VtkProbe, ImageDataWithExtent) {
  vtkNew<vtkImageData> image;
  image->SetExtent(2, 6, -1, 3, 5, 8);
  image->SetOrigin(-1.0, 0.5, -2.0);
  image->SetSpacing(0.5, 0.25, 0.75);
  add_fields(image);
  compare_with_vtk(image, 1e-12);
}

TEST(VtkProbe, RotatedImageDataIsConvertedAndSaysSo) {
  vtkNew<vtkImageData> image;
  image->SetDimensions(4, 4, 4);
  image->SetDirectionMatrix(0, -1, 0, 1, 0, 0, 0, 0, 1);
  add_fields(image);
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
  const auto attachment = insitu::vtk::attach(mesh, image);
  mesh.commit();
  ASSERT_EQ(attachment.converted().size(), 1u);
  EXPECT_EQ(attachment.converted()[0].array, "points");
  // i runs along y, j along -x.
  double value = 0;
  ASSERT_TRUE(mesh.sample_point("linear", {-1.25, 0.5, 2.5}, {&value, 1}));
  EXPECT_NEAR(value, linear({-1.25, 0.5, 2.5}), 1e-12);
  EXPECT_FALSE(mesh.sample_point("linear", {1.25, 0.5, 2.5}, {&value, 1}));
}

TEST(VtkProbe, FloatPointsAndFields) {
  const auto grid = unstructured(3, {VTK_HEXAHEDRON}, 0.2, VTK_FLOAT);
  vtkNew<vtkFloatArray> field;
  field->SetName("single");
  for (vtkIdType i = 0; i < grid->GetNumberOfPoints(); ++i)
    field->InsertNextValue(float(linear(point_of(grid, i))));
  grid->GetPointData()->AddArray(field);
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
  const auto attachment = insitu::vtk::attach(mesh, grid);
  mesh.commit();
  const std::vector<double> xyz = query_points(grid, 200);
  const insitu::Samples s = mesh.sample("single", xyz);
  for (std::size_t q = 0; q < s.size(); ++q)
    if (s.found[q]) {
      EXPECT_NEAR(s(q), linear({xyz[3 * q], xyz[3 * q + 1], xyz[3 * q + 2]}), 1e-5);
    }
}

TEST(VtkProbe, OneArrayAComponent) {
  const auto grid = structured(3, 0.2);
  vtkNew<vtkSOADataArrayTemplate<double>> points, velocity;
  for (auto* array : {points.Get(), velocity.Get()}) {
    array->SetNumberOfComponents(3);
    array->SetNumberOfTuples(grid->GetNumberOfPoints());
  }
  velocity->SetName("soa velocity");
  for (vtkIdType i = 0; i < grid->GetNumberOfPoints(); ++i)
    for (int c = 0; c < 3; ++c) {
      points->SetTypedComponent(i, c, grid->GetPoint(i)[c]);
      velocity->SetTypedComponent(i, c, (c + 1) * grid->GetPoint(i)[c]);
    }
  vtkNew<vtkPoints> holder;
  holder->SetData(points);
  grid->SetPoints(holder);
  grid->GetPointData()->AddArray(velocity);

  compare_with_vtk(grid, 1e-10);
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
  const auto attachment = insitu::vtk::attach(mesh, grid);
  mesh.commit();
  const std::vector<double> xyz = query_points(grid, 100);
  const insitu::Samples s = mesh.sample("soa velocity", xyz);
  ASSERT_EQ(s.components, 3);
  for (std::size_t q = 0; q < s.size(); ++q)
    for (int c = 0; s.found[q] && c < 3; ++c)
      EXPECT_NEAR(s(q, c), (c + 1) * xyz[3 * q + std::size_t(c)], 1e-10);
}

/// Of tetrahedra, whose faces are flat, VTK's distance is right to rounding; its cell is any of
/// those at that distance.
TEST(Nearest, AsVtksClosestPoint) {
  const int n = 4;
  vtkNew<vtkUnstructuredGrid> grid;
  const vtkSmartPointer<vtkPoints> vertices = grid_points(n, 0.25);
  grid->SetPoints(vertices);
  grid->Allocate(6 * n * n * n);
  constexpr int tetrahedra[6][4] = {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6},
                                    {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}};
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const auto c = corners(n, i, j, k);
        for (const auto& t : tetrahedra) {
          const vtkIdType ids[4] = {c[std::size_t(t[0])], c[std::size_t(t[1])],
                                    c[std::size_t(t[2])], c[std::size_t(t[3])]};
          grid->InsertNextCell(VTK_TETRA, 4, ids);
        }
      }
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
  const insitu::vtk::Attachment attachment = insitu::vtk::attach(mesh, grid);
  mesh.commit();
  std::vector<double> xyz;
  Random random(5);
  for (int i = 0; i < 300; ++i)
    for (int a = 0; a < 3; ++a)
      xyz.push_back(3.0 * n * random() - n);
  insitu::LocateOptions options;
  options.nearest = true;
  const insitu::Locations ours = mesh.locate(xyz, options);
  vtkNew<vtkCellLocator> locator;
  locator->SetDataSet(grid);
  locator->BuildLocator();
  for (std::size_t i = 0; i < ours.size(); ++i) {
    double closest[3], squared = 0.0;
    vtkIdType cell = -1;
    int part = -1;
    locator->FindClosestPoint(&xyz[3 * i], closest, cell, part, squared);
    EXPECT_NEAR(ours.distances[i], std::sqrt(squared), 1e-12) << i;
    for (std::size_t a = 0; a < 3; ++a)
      EXPECT_NEAR(ours.nearest[3 * i + a], closest[a], 1e-12) << i;
  }
}
