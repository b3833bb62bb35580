#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>
#include <vtkStructuredGrid.h>
#include <vtkUnstructuredGrid.h>

/// Small VTK meshes over the box [0, n]^3, jittered inside, with fields of known values.
namespace vtk_meshes {

using Point = std::array<double, 3>;

/// Uniform in [0, 1), the same on every machine (SplitMix64).
class Random {
public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  double operator()() {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return double((z ^ (z >> 31)) >> 11) * 0x1p-53;
  }

private:
  std::uint64_t state_;
};

/// What the vertex fields are: linear, hence reproduced by every shape.
inline double linear(const Point& p) {
  return 1.0 + 2.0 * p[0] - 3.0 * p[1] + 0.5 * p[2];
}

inline vtkIdType grid_id(int n, int i, int j, int k) {
  return i + (n + 1) * (j + (n + 1) * k);
}

/// (n + 1)^3 points, those inside moved by up to jitter along each axis.
inline vtkSmartPointer<vtkPoints> grid_points(int n, double jitter, int precision = VTK_DOUBLE) {
  auto points = vtkSmartPointer<vtkPoints>::New();
  points->SetDataType(precision);
  Random random(20240607);
  for (int k = 0; k <= n; ++k)
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        Point p{double(i), double(j), double(k)};
        for (std::size_t a = 0; a < 3; ++a) {
          const double move = jitter * (2.0 * random() - 1.0);
          if (p[a] > 0.0 && p[a] < n)
            p[a] += move;
        }
        points->InsertNextPoint(p.data());
      }
  return points;
}

/// The 8 vertices of cell (i, j, k) in the hexahedron's order.
inline std::array<vtkIdType, 8> corners(int n, int i, int j, int k) {
  return {grid_id(n, i, j, k),
          grid_id(n, i + 1, j, k),
          grid_id(n, i + 1, j + 1, k),
          grid_id(n, i, j + 1, k),
          grid_id(n, i, j, k + 1),
          grid_id(n, i + 1, j, k + 1),
          grid_id(n, i + 1, j + 1, k + 1),
          grid_id(n, i, j + 1, k + 1)};
}

/// Inserts the box (i, j, k) as cells of one VTK type.
inline void insert_box(vtkUnstructuredGrid* grid, int type, int n, int i, int j, int k) {
  const std::array<vtkIdType, 8> v = corners(n, i, j, k);
  const auto insert = [&](std::vector<int> of) {
    std::vector<vtkIdType> ids;
    for (const int o : of)
      ids.push_back(v[std::size_t(o)]);
    grid->InsertNextCell(type, vtkIdType(ids.size()), ids.data());
  };
  switch (type) {
  case VTK_HEXAHEDRON:
    insert({0, 1, 2, 3, 4, 5, 6, 7});
    break;
  case VTK_VOXEL:
    insert({0, 1, 3, 2, 4, 5, 7, 6});
    break;
  case VTK_WEDGE: // cut along the diagonal 0-2 of the lower and 4-6 of the upper face
    insert({0, 2, 1, 4, 6, 5});
    insert({0, 3, 2, 4, 7, 6});
    break;
  case VTK_TETRA: // six around the diagonal 0-6
    for (const auto& [a, b] :
         std::array<std::array<int, 2>, 6>{{{1, 2}, {2, 3}, {3, 7}, {7, 4}, {4, 5}, {5, 1}}})
      insert({0, a, b, 6});
    break;
  case VTK_PYRAMID: { // six over the faces, apex in the middle
    double middle[3] = {0, 0, 0}, p[3];
    for (const vtkIdType id : v) {
      grid->GetPoints()->GetPoint(id, p);
      for (int a = 0; a < 3; ++a)
        middle[a] += p[a] / 8.0;
    }
    const vtkIdType apex = grid->GetPoints()->InsertNextPoint(middle);
    for (const std::array<int, 4>& f : std::array<std::array<int, 4>, 6>{{{0, 1, 2, 3},
                                                                          {4, 7, 6, 5},
                                                                          {0, 4, 5, 1},
                                                                          {1, 5, 6, 2},
                                                                          {2, 6, 7, 3},
                                                                          {3, 7, 4, 0}}}) {
      const vtkIdType ids[5] = {v[std::size_t(f[0])], v[std::size_t(f[1])], v[std::size_t(f[2])],
                                v[std::size_t(f[3])], apex};
      grid->InsertNextCell(type, 5, ids);
    }
    break;
  }
  default:
    break;
  }
}

inline Point point_of(vtkDataSet* data, vtkIdType id) {
  Point p;
  data->GetPoint(id, p.data());
  return p;
}

/// "linear" on points, "velocity" (x, -y, 2z) on points, "number" (3 c + 1) on cells; double.
inline void add_fields(vtkDataSet* data) {
  vtkNew<vtkDoubleArray> scalar, vector, cell;
  scalar->SetName("linear");
  vector->SetName("velocity");
  vector->SetNumberOfComponents(3);
  cell->SetName("number");
  for (vtkIdType i = 0; i < data->GetNumberOfPoints(); ++i) {
    const Point p = point_of(data, i);
    scalar->InsertNextValue(linear(p));
    vector->InsertNextTuple3(p[0], -p[1], 2.0 * p[2]);
  }
  for (vtkIdType c = 0; c < data->GetNumberOfCells(); ++c)
    cell->InsertNextValue(3.0 * double(c) + 1.0);
  data->GetPointData()->AddArray(scalar);
  data->GetPointData()->AddArray(vector);
  data->GetCellData()->AddArray(cell);
}

/// n^3 boxes of one type, or of the types in turn.
inline vtkSmartPointer<vtkUnstructuredGrid>
unstructured(int n, const std::vector<int>& types, double jitter, int precision = VTK_DOUBLE) {
  auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  grid->SetPoints(grid_points(n, jitter, precision));
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i)
        insert_box(grid, types[std::size_t(i + j + k) % types.size()], n, i, j, k);
  add_fields(grid);
  return grid;
}

inline vtkSmartPointer<vtkStructuredGrid> structured(int n, double jitter) {
  auto grid = vtkSmartPointer<vtkStructuredGrid>::New();
  grid->SetDimensions(n + 1, n + 1, n + 1);
  grid->SetPoints(grid_points(n, jitter));
  add_fields(grid);
  return grid;
}

/// Points well inside random cells (parametric coordinates from 0.1 to 0.3, inside all shapes), and
/// every tenth outside the mesh.
inline std::vector<double> query_points(vtkDataSet* data, int count) {
  Random random(77);
  std::vector<double> out;
  for (int q = 0; q < count; ++q) {
    const auto c = vtkIdType(random() * double(data->GetNumberOfCells()));
    vtkCell* cell = data->GetCell(c);
    const double r[3] = {0.1 + 0.2 * random(), 0.1 + 0.2 * random(), 0.1 + 0.2 * random()};
    double x[3], weights[8];
    int sub = 0;
    cell->EvaluateLocation(sub, r, x, weights);
    if (q % 10 == 9)
      x[q % 3] += 1e3;
    out.insert(out.end(), x, x + 3);
  }
  return out;
}

/// The mesh of 2^3 boxes with every second cell, or all, as a polyhedron.
inline vtkSmartPointer<vtkUnstructuredGrid> as_polyhedra(const std::vector<int>& types, int step) {
  const auto from = unstructured(2, types, 0.1);
  auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  grid->SetPoints(from->GetPoints());
  for (vtkIdType c = 0; c < from->GetNumberOfCells(); ++c) {
    vtkCell* cell = from->GetCell(c);
    if (c % step != 0) {
      grid->InsertNextCell(cell->GetCellType(), cell->GetPointIds());
      continue;
    }
    vtkNew<vtkIdList> faces;
    faces->InsertNextId(cell->GetNumberOfFaces());
    for (int f = 0; f < cell->GetNumberOfFaces(); ++f) {
      vtkIdList* ids = cell->GetFace(f)->GetPointIds();
      faces->InsertNextId(ids->GetNumberOfIds());
      // A voxel's faces are pixels, whose points run by rows.
      const bool pixel = cell->GetFace(f)->GetCellType() == VTK_PIXEL;
      for (const int k : pixel ? std::vector<int>{0, 1, 3, 2} : std::vector<int>{0, 1, 2, 3})
        if (k < ids->GetNumberOfIds())
          faces->InsertNextId(ids->GetId(k));
    }
    grid->InsertNextCell(VTK_POLYHEDRON, faces);
  }
  add_fields(grid);
  return grid;
}

} // namespace vtk_meshes
