#include "peers/vtk_mesh.h"

#include <cmath>
#include <filesystem>
#include <limits>
#include <span>
#include <vtkCellArray.h>
#include <vtkCellType.h>
#include <vtkDoubleArray.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkObject.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkTypeInt32Array.h>
#include <vtkUnsignedCharArray.h>
#include <vtkXMLUnstructuredGridReader.h>

#include "options.h"
#include "peers/vtk_parts.h"

namespace insitu::bench {

workload::Mesh read_vtu(const std::string& file) {
  const std::string what = "--mesh " + file + ": ";
  if (!std::filesystem::is_regular_file(file))
    throw UsageError(what + "no such file");
  vtkObject::GlobalWarningDisplayOff();
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  if (!reader->CanReadFile(file.c_str()))
    throw UsageError(what + "not a .vtu file");
  reader->SetFileName(file.c_str());
  reader->Update();
  vtkUnstructuredGrid* grid = reader->GetOutput();
  if (reader->GetErrorCode() != 0 || !grid)
    throw UsageError(what + "cannot be read");
  if (grid->GetNumberOfPoints() > std::numeric_limits<std::int32_t>::max())
    throw UsageError(what + "more than 2147483647 points");

  workload::Mesh mesh;
  mesh.offsets.push_back(0);
  double box_volume = 0.0;
  vtkNew<vtkIdList> ids;
  for (vtkIdType c = 0; c < grid->GetNumberOfCells(); ++c) {
    const int type = grid->GetCellType(c);
    if (!mesh::is_shape(type))
      throw UsageError(what + "cell " + std::to_string(c) + " has type " + std::to_string(type) +
                       ", 10 to 14 expected");
    grid->GetCellPoints(c, ids);
    for (vtkIdType v = 0; v < ids->GetNumberOfIds(); ++v)
      mesh.connectivity.push_back(std::int32_t(ids->GetId(v)));
    mesh.types.push_back(std::uint8_t(type));
    mesh.offsets.push_back(std::int64_t(mesh.connectivity.size()));
    double b[6];
    grid->GetCellBounds(c, b);
    box_volume += (b[1] - b[0]) * (b[3] - b[2]) * (b[5] - b[4]);
  }
  mesh.points.resize(std::size_t(3 * grid->GetNumberOfPoints()));
  for (vtkIdType v = 0; v < grid->GetNumberOfPoints(); ++v)
    grid->GetPoint(v, &mesh.points[std::size_t(3 * v)]);
  if (mesh.cell_count() > 0)
    mesh.cell_size = mesh.smallest_edge = std::cbrt(box_volume / double(mesh.cell_count()));

  bool uniform = mesh.cell_count() > 0;
  for (const std::uint8_t type : mesh.types)
    uniform &= type == mesh.types[0];
  if (uniform) {
    mesh.uniform_shape = mesh::Shape(mesh.types[0]);
    mesh.types.clear();
    mesh.offsets.clear();
  }
  return mesh;
}

namespace {

/// Each cell with its faces wound outward, as VTK wants them.
void add_polyhedra(const workload::Mesh& mesh, vtkUnstructuredGrid* grid) {
  vtkNew<vtkIdList> faces;
  for (std::int64_t c = 0; c < mesh.cell_count(); ++c) {
    const auto rings = std::span(mesh.cell_faces)
                           .subspan(std::size_t(mesh.cell_offsets[std::size_t(c)]),
                                    std::size_t(mesh.cell_offsets[std::size_t(c) + 1] -
                                                mesh.cell_offsets[std::size_t(c)]));
    const auto ring_of = [&](std::int32_t face) {
      const auto first = std::size_t(mesh.face_offsets[std::size_t(face)]);
      return std::span(mesh.face_vertices)
          .subspan(first, std::size_t(mesh.face_offsets[std::size_t(face) + 1]) - first);
    };
    math::Vec3d centre;
    std::int64_t count = 0;
    for (const std::int32_t face : rings)
      for (const std::int32_t v : ring_of(face)) {
        centre += mesh.point(v);
        ++count;
      }
    centre = centre / double(count);
    faces->Reset();
    faces->InsertNextId(vtkIdType(rings.size()));
    for (const std::int32_t face : rings) {
      const auto ring = ring_of(face);
      const math::Vec3d a = mesh.point(ring[0]), b = mesh.point(ring[1]), d = mesh.point(ring[2]);
      const bool outward = dot(cross(b - a, d - a), a - centre) > 0.0;
      faces->InsertNextId(vtkIdType(ring.size()));
      for (std::size_t k = 0; k < ring.size(); ++k)
        faces->InsertNextId(ring[outward ? k : ring.size() - 1 - k]);
    }
    grid->InsertNextCell(VTK_POLYHEDRON, faces);
  }
}

void add_cells(const workload::Mesh& mesh, vtkUnstructuredGrid* grid) {
  const vtkIdType cells = mesh.cell_count();
  vtkNew<vtkTypeInt32Array> connectivity, offsets;
  connectivity->SetArray(const_cast<std::int32_t*>(mesh.connectivity.data()),
                         vtkIdType(mesh.connectivity.size()), 1);
  offsets->SetNumberOfValues(cells + 1);
  vtkNew<vtkUnsignedCharArray> types;
  types->SetNumberOfValues(cells);
  vtkTypeInt32 at = 0;
  for (vtkIdType c = 0; c < cells; ++c) {
    offsets->SetValue(c, at);
    at += mesh::vertex_count(mesh.shape(c));
    types->SetValue(c, std::uint8_t(mesh.shape(c)));
  }
  offsets->SetValue(cells, at);
  vtkNew<vtkCellArray> cell_array;
  cell_array->SetData(offsets.Get(), connectivity.Get());
  grid->SetCells(types, cell_array);
}

} // namespace

vtkSmartPointer<vtkUnstructuredGrid> make_grid(const workload::Mesh& mesh,
                                               const std::vector<double>& field) {
  vtkNew<vtkDoubleArray> coordinates;
  coordinates->SetNumberOfComponents(3);
  coordinates->SetArray(const_cast<double*>(mesh.points.data()), vtkIdType(mesh.points.size()), 1);
  vtkNew<vtkPoints> points;
  points->SetData(coordinates);

  auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  grid->SetPoints(points);
  if (mesh.has_faces())
    add_polyhedra(mesh, grid);
  else
    add_cells(mesh, grid);
  vtkNew<vtkDoubleArray> values;
  values->SetName("f");
  values->SetArray(const_cast<double*>(field.data()), vtkIdType(field.size()), 1);
  grid->GetPointData()->SetScalars(values);
  return grid;
}

} // namespace insitu::bench
