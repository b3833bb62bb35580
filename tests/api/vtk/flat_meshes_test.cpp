/// Triangles, pixels and quads in one plane as VTK has them, and VTK's own probe beside them.
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <vtkCellArray.h>
#include <vtkImageData.h>
#include <vtkPolyData.h>
#include <vtkProbeFilter.h>
#include <vtkRectilinearGrid.h>
#include <vtkStructuredGrid.h>

#include "insitu/vtk.hpp"

#include "meshes.h"

using namespace vtk_meshes;

namespace {

constexpr int n = 4;

vtkIdType at(int i, int j) {
  return i + (n + 1) * j;
}

vtkSmartPointer<vtkPoints> flat_points(double jitter, double plane) {
  auto points = vtkSmartPointer<vtkPoints>::New();
  points->SetDataTypeToDouble();
  Random random(5);
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const bool inner = i > 0 && j > 0 && i < n && j < n;
      const double x = i + (inner ? jitter * (2 * random() - 1) : 0.0);
      points->InsertNextPoint(x, j + (inner ? jitter * (2 * random() - 1) : 0.0), plane);
    }
  return points;
}

/// Linear at the points, and a vector; the cells' numbers.
void add_flat_fields(vtkDataSet* data) {
  vtkNew<vtkDoubleArray> f, u, number;
  f->SetName("linear");
  u->SetName("velocity");
  u->SetNumberOfComponents(3);
  number->SetName("number");
  for (vtkIdType p = 0; p < data->GetNumberOfPoints(); ++p) {
    double x[3];
    data->GetPoint(p, x);
    f->InsertNextValue(linear({x[0], x[1], 0}));
    u->InsertNextTuple3(-x[1], x[0], 0);
  }
  for (vtkIdType c = 0; c < data->GetNumberOfCells(); ++c)
    number->InsertNextValue(double(c));
  data->GetPointData()->AddArray(f);
  data->GetPointData()->AddArray(u);
  data->GetCellData()->AddArray(number);
}

/// quads: or else each square is two triangles, and every third one a quad.
void add_squares(bool quads, const std::function<void(int, std::vector<vtkIdType>)>& insert) {
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const vtkIdType a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
      if (quads || (i + j) % 3 == 0) {
        insert(VTK_QUAD, {a, b, c, d});
      } else {
        insert(VTK_TRIANGLE, {a, b, c});
        insert(VTK_TRIANGLE, {a, d, c}); // the other way round
      }
    }
}

/// Inner points, at which VTK and the library find the same cells and values, and points outside.
void compare_with_vtk(vtkDataSet* data, double plane, std::size_t skipped = 0) {
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
  const insitu::vtk::Attachment attachment = insitu::vtk::attach(mesh, data);
  EXPECT_EQ(attachment.skipped().size(), skipped);
  mesh.commit();
  Random random(9);
  std::vector<double> xyz;
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (int k = 0; k < 400; ++k) {
    const double p[3] = {1.2 * n * random() - 0.1 * n, 1.2 * n * random() - 0.1 * n, plane};
    points->InsertNextPoint(p);
    xyz.insert(xyz.end(), {p[0], p[1], 100 * random()}); // of no account
  }
  vtkNew<vtkPolyData> input;
  input->SetPoints(points);
  vtkNew<vtkProbeFilter> probe;
  probe->SetInputData(input);
  probe->SetSourceData(data);
  probe->Update();
  vtkPointData* theirs = probe->GetOutput()->GetPointData();
  vtkDataArray* valid = theirs->GetArray(probe->GetValidPointMaskArrayName());
  const insitu::FieldSamples ours = mesh.sample_fields({"linear", "velocity", "number"}, xyz);
  int found = 0, others = 0;
  for (std::size_t q = 0; q < ours.size(); ++q) {
    const double x = xyz[3 * q], y = xyz[3 * q + 1];
    const bool inside = x >= 0 && y >= 0 && x <= n && y <= n;
    ASSERT_EQ(ours.found[q] != 0, inside) << x << " " << y;
    if (!inside || valid->GetTuple1(vtkIdType(q)) == 0.0) // VTK's tolerance loses few
      continue;
    ++found;
    EXPECT_NEAR(ours.values[0].values[q], linear({x, y, 0}), 1e-13);
    EXPECT_NEAR(ours.values[1].values[3 * q], -y, 1e-13);
    EXPECT_NEAR(ours.values[1].values[3 * q + 1], x, 1e-13);
    others += ours.values[2].values[q] != theirs->GetArray("number")->GetTuple1(vtkIdType(q));
  }
  EXPECT_GT(found, 200);
  EXPECT_LE(others, 2); // VTK's tolerance takes the cell beside an edge, too
}

} // namespace

TEST(FlatVtk, UnstructuredGrids) {
  for (const bool quads : {true, false}) {
    vtkNew<vtkUnstructuredGrid> grid;
    grid->SetPoints(flat_points(0.2, 3.0));
    add_squares(quads, [&](int type, const std::vector<vtkIdType>& ids) {
      grid->InsertNextCell(type, vtkIdType(ids.size()), ids.data());
    });
    add_flat_fields(grid);
    compare_with_vtk(grid, 3.0);
  }
}

TEST(FlatVtk, LinesAndVerticesBesideThemAreLeftOut) {
  vtkNew<vtkUnstructuredGrid> grid;
  grid->SetPoints(flat_points(0.2, 0.0));
  const vtkIdType line[2] = {0, 1};
  grid->InsertNextCell(VTK_LINE, 2, line);
  add_squares(true, [&](int type, const std::vector<vtkIdType>& ids) {
    grid->InsertNextCell(type, vtkIdType(ids.size()), ids.data());
  });
  grid->InsertNextCell(VTK_VERTEX, 1, line);
  add_flat_fields(grid);
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
  const auto attachment = insitu::vtk::attach(mesh, grid);
  ASSERT_EQ(attachment.skipped().size(), 1u);
  EXPECT_NE(attachment.skipped()[0].array.find("1 vtkLine"), std::string::npos);
  mesh.commit();
  const insitu::Samples s = mesh.sample("number", std::vector<double>{0.5, 0, 0, 3.5, 3.75, 0});
  EXPECT_EQ(s.values, (std::vector<double>{1, 16}));
}

TEST(FlatVtk, Surfaces) {
  for (const bool quads : {true, false}) {
    vtkNew<vtkPolyData> surface;
    surface->SetPoints(flat_points(0.2, -1.0));
    vtkNew<vtkCellArray> polys;
    add_squares(quads, [&](int, const std::vector<vtkIdType>& ids) {
      polys->InsertNextCell(vtkIdType(ids.size()), ids.data());
    });
    surface->SetPolys(polys);
    add_flat_fields(surface);
    compare_with_vtk(surface, -1.0);
  }
  vtkNew<vtkPolyData> curved;
  curved->SetPoints(flat_points(0.0, 0.0));
  curved->GetPoints()->SetPoint(7, 2, 1, 0.5);
  vtkNew<vtkCellArray> polys, lines;
  const vtkIdType line[2] = {0, 1};
  lines->InsertNextCell(2, line);
  add_squares(true, [&](int, const std::vector<vtkIdType>& ids) {
    polys->InsertNextCell(vtkIdType(ids.size()), ids.data());
  });
  curved->SetLines(lines);
  curved->SetPolys(polys);
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
  const auto attachment = insitu::vtk::attach(mesh, curved);
  try {
    mesh.commit();
    FAIL();
  } catch (const insitu::Error& e) {
    EXPECT_EQ(e.status(), INSITU_ERROR_MESH);
    EXPECT_NE(std::string(e.what()).find("cell 2: vertex id 7 lies 0.5 out of the plane"),
              std::string::npos)
        << e.what(); // the line is cell 0
  }
}

TEST(FlatVtk, GridsOfOneLayer) {
  vtkNew<vtkImageData> image;
  image->SetDimensions(n + 1, n + 1, 1);
  add_flat_fields(image);
  compare_with_vtk(image, 0.0);
  vtkNew<vtkRectilinearGrid> rectilinear;
  vtkNew<vtkDoubleArray> axis, z;
  for (int i = 0; i <= n; ++i)
    axis->InsertNextValue(0.25 * i * i);
  z->InsertNextValue(0);
  rectilinear->SetDimensions(n + 1, n + 1, 1);
  rectilinear->SetXCoordinates(axis);
  rectilinear->SetYCoordinates(axis);
  rectilinear->SetZCoordinates(z);
  add_flat_fields(rectilinear);
  compare_with_vtk(rectilinear, 0.0);
  vtkNew<vtkStructuredGrid> structured;
  structured->SetDimensions(n + 1, n + 1, 1);
  structured->SetPoints(flat_points(0.2, 7.0));
  add_flat_fields(structured);
  compare_with_vtk(structured, 7.0);
}
