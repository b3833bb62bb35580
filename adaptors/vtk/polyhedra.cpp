#include "polyhedra.h"

#include <algorithm>
#include <map>
#include <string>
#include <vector>
#include <vtkCellArray.h>
#include <vtkCellType.h>
#include <vtkIdTypeArray.h>
#include <vtkUnstructuredGrid.h>

#include "insitu/insitu.hpp"

namespace insitu::vtk {

namespace {

using Rings = std::vector<std::vector<int>>;

/// The faces of a shape by places in the cell's points.
const Rings& rings_of(unsigned char type) {
  static const Rings none, tetrahedron{{0, 1, 3}, {1, 2, 3}, {2, 0, 3}, {0, 2, 1}},
      voxel{{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}},
      hexahedron{{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4},
                 {3, 7, 6, 2}, {0, 3, 2, 1}, {4, 5, 6, 7}},
      wedge{{0, 1, 2}, {3, 5, 4}, {0, 3, 4, 1}, {1, 4, 5, 2}, {2, 5, 3, 0}},
      pyramid{{0, 3, 2, 1}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  switch (type) {
  case VTK_TETRA:
    return tetrahedron;
  case VTK_VOXEL:
    return voxel;
  case VTK_HEXAHEDRON:
    return hexahedron;
  case VTK_WEDGE:
    return wedge;
  case VTK_PYRAMID:
    return pyramid;
  default:
    return none;
  }
}

/// Numbers faces, each by the set of its vertices.
class Faces {
public:
  explicit Faces(FaceLists& out) : out_(out) { out_.offsets->InsertNextValue(0); }

  void add(const std::vector<vtkIdType>& ring) {
    std::vector<vtkIdType> key = ring;
    std::sort(key.begin(), key.end());
    const auto [at, fresh] = numbers_.try_emplace(std::move(key), vtkIdType(numbers_.size()));
    if (fresh) {
      for (const vtkIdType id : ring)
        out_.vertices->InsertNextValue(id);
      out_.offsets->InsertNextValue(out_.vertices->GetNumberOfValues());
    }
    out_.cell_faces->InsertNextValue(at->second);
  }

private:
  FaceLists& out_;
  std::map<std::vector<vtkIdType>, vtkIdType> numbers_;
};

/// Reads a polyhedron's list: how many faces, and for each how many vertices and which.
void add_polyhedron(vtkUnstructuredGrid* grid, vtkIdType cell, Faces& faces) {
  vtkIdTypeArray *locations = grid->GetFaceLocations(), *lists = grid->GetFaces();
  const vtkIdType size = lists ? lists->GetNumberOfValues() : 0;
  vtkIdType at =
      locations && cell < locations->GetNumberOfValues() ? locations->GetValue(cell) : -1;
  const auto next = [&] {
    if (at < 0 || at >= size)
      throw Error(INSITU_ERROR_MESH, "cell " + std::to_string(cell) + ": its faces lie at " +
                                         std::to_string(at) + " of " + std::to_string(size) +
                                         " numbers");
    return lists->GetValue(at++);
  };
  std::vector<vtkIdType> ring;
  for (vtkIdType left = next(); left > 0; --left) {
    ring.clear();
    for (vtkIdType k = next(); k > 0; --k)
      ring.push_back(next());
    faces.add(ring);
  }
}

} // namespace

FaceLists face_lists_of(vtkUnstructuredGrid* grid) {
  FaceLists out;
  for (auto* array : {&out.vertices, &out.offsets, &out.cell_faces, &out.cell_offsets})
    *array = vtkSmartPointer<vtkTypeInt64Array>::New();
  Faces faces(out);
  out.cell_offsets->InsertNextValue(0);
  std::vector<vtkIdType> ring;
  for (vtkIdType cell = 0; cell < grid->GetNumberOfCells(); ++cell) {
    const auto type = static_cast<unsigned char>(grid->GetCellType(cell));
    if (type == VTK_POLYHEDRON) {
      add_polyhedron(grid, cell, faces);
    } else {
      vtkIdType n = 0;
      const vtkIdType* ids = nullptr;
      grid->GetCellPoints(cell, n, ids);
      for (const auto& places : rings_of(type)) {
        ring.clear();
        for (const int place : places)
          if (place < n)
            ring.push_back(ids[place]);
        faces.add(ring);
      }
    }
    out.cell_offsets->InsertNextValue(out.cell_faces->GetNumberOfValues());
  }
  return out;
}

} // namespace insitu::vtk
