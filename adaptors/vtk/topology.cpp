#include "topology.h"

#include <algorithm>
#include <map>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCellTypes.h>
#include <vtkDataSetAttributes.h>
#include <vtkDoubleArray.h>
#include <vtkGenericCell.h>
#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkRectilinearGrid.h>
#include <vtkStructuredGrid.h>
#include <vtkUnstructuredGrid.h>

#include "arrays.h"

namespace insitu::vtk {

namespace {

[[noreturn]] void unsupported(const std::string& what) {
  throw Error(INSITU_ERROR_UNSUPPORTED, what);
}

Watched points_of(vtkPointSet* data) {
  vtkPoints* points = data->GetPoints();
  return points ? Watched(points->GetData(), points) : Watched();
}

template <class Offsets>
bool evenly_spaced(const Offsets* offsets, vtkIdType cells, int ids) {
  for (vtkIdType c = 0; c <= cells; ++c)
    if (offsets[c] != Offsets(c * ids))
      return false;
  return true;
}

bool has_volume(unsigned char type) {
  return (type >= VTK_TETRA && type <= VTK_PYRAMID) || type == VTK_POLYHEDRON;
}

bool is_surface(unsigned char type) {
  return type == VTK_TRIANGLE || type == VTK_PIXEL || type == VTK_QUAD;
}

/// Whether a VTK type is one of cells of fewer dimensions, or of nothing.
bool is_below(int dimensions, unsigned char type) {
  const auto cell = vtkSmartPointer<vtkCell>::Take(vtkGenericCell::InstantiateCell(type));
  return type == VTK_EMPTY_CELL || (cell && cell->GetCellDimension() < dimensions);
}

std::string class_name(unsigned char type) {
  const char* name = vtkCellTypes::GetClassNameFromTypeId(type);
  return name ? name : "cell";
}

/// The cells that count: those of volume, or those of a flat mesh.
using Counts = bool (*)(unsigned char type);

Counts counts_of(const unsigned char* type, vtkIdType cells) {
  const bool flat =
      std::none_of(type, type + cells, has_volume) && std::any_of(type, type + cells, is_surface);
  return flat ? is_surface : has_volume;
}

/// Hides cells of fewer dimensions than those that count, if there are such; refuses all others.
void hide_lower_cells(const unsigned char* type, Counts counts, Topology& t) {
  std::map<unsigned char, vtkIdType> others;
  std::map<unsigned char, vtkIdType> first;
  vtkIdType count = 0;
  for (vtkIdType c = 0; c < t.cells; ++c)
    if (!counts(type[c])) {
      ++others[type[c]];
      first.try_emplace(type[c], c);
      ++count;
    }
  for (const auto& [other, c] : first)
    if (count == t.cells || !is_below(counts == is_surface ? 2 : 3, other))
      unsupported("cell " + std::to_string(c) + " is a " + class_name(other) + " (VTK type " +
                  std::to_string(int(other)) +
                  "); tetrahedra, voxels, hexahedra, wedges and pyramids (10 to 14) and polyhedra "
                  "(42) are supported, or triangles, pixels and quads (5, 8, 9) in one plane");
  if (count == 0)
    return;
  for (const auto& [other, n] : others)
    t.left_out += (t.left_out.empty() ? "" : ", ") + std::to_string(n) + " " + class_name(other);
  constexpr unsigned char hidden = vtkDataSetAttributes::HIDDENCELL;
  auto ghosts = vtkSmartPointer<vtkUnsignedCharArray>::New();
  ghosts->SetNumberOfValues(t.cells);
  ghosts->FillValue(0);
  if (t.ghosts.array)
    ghosts->DeepCopy(t.ghosts.array);
  for (vtkIdType c = 0; c < std::min(t.cells, ghosts->GetNumberOfValues()); ++c)
    if (!counts(type[c]))
      ghosts->SetValue(c, ghosts->GetValue(c) | hidden);
  t.ghosts = Watched(ghosts);
  if (!t.made_ghosts)
    t.made_ghosts =
        counts == is_surface ? "cells without area are hidden" : "cells without volume are hidden";
}

/// All cells, once there is a polyhedron among them.
void read_faces(vtkUnstructuredGrid* grid, Topology& t) {
  t.kind = Topology::Kind::faces;
  t.given_faces = Watched(grid->GetFaces(), grid->GetFaceLocations());
  t.faces = face_lists_of(grid);
}

/// cells: whose offsets and connectivity are read in place.
void read_types(vtkCellArray* cells, vtkUnsignedCharArray* types, Topology& t) {
  t.kind = Topology::Kind::cells;
  if (!types || types->GetNumberOfValues() != t.cells)
    throw Error(INSITU_ERROR_MESH, std::to_string(types ? types->GetNumberOfValues() : 0) +
                                       " cell types for " + std::to_string(t.cells) + " cells");
  const unsigned char* type = types->GetPointer(0);
  const Counts counts = counts_of(type, t.cells);
  hide_lower_cells(type, counts, t);
  t.connectivity = Watched(cells->GetConnectivityArray(), cells);
  t.offsets = Watched(cells->GetOffsetsArray(), cells);
  t.types = Watched(types);
  if (std::find(type, type + t.cells, VTK_POLYHEDRON) != type + t.cells)
    return;
  t.shape = static_cast<Shape>(type[0]);
  const int ids = vertex_count(t.shape);
  t.one_shape = counts(type[0]) &&
                std::all_of(type, type + t.cells, [&](unsigned char s) { return s == type[0]; }) &&
                (cells->IsStorage64Bit()
                     ? evenly_spaced(cells->GetOffsetsArray64()->GetPointer(0), t.cells, ids)
                     : evenly_spaced(cells->GetOffsetsArray32()->GetPointer(0), t.cells, ids));
  const vtkIdType given = t.connectivity.array->GetNumberOfValues();
  if (t.one_shape && given < t.cells * ids)
    throw Error(INSITU_ERROR_MESH, std::to_string(t.cells) + " cells of " + std::to_string(ids) +
                                       " ids, but connectivity holds " + std::to_string(given));
}

void read_cells(vtkUnstructuredGrid* grid, Topology& t) {
  t.points = points_of(grid);
  vtkUnsignedCharArray* types = grid->GetCellTypesArray();
  read_types(grid->GetCells(), types, t);
  const unsigned char* type = types->GetPointer(0);
  if (std::find(type, type + t.cells, VTK_POLYHEDRON) != type + t.cells)
    read_faces(grid, t);
}

/// The cells of a surface: vertices and lines, which are hidden, triangles and quads. Polygons
/// alone stay where they are.
void read_surface(vtkPolyData* surface, Topology& t) {
  t.points = points_of(surface);
  auto types = vtkSmartPointer<vtkUnsignedCharArray>::New();
  types->SetNumberOfValues(t.cells);
  for (vtkIdType c = 0; c < t.cells; ++c)
    types->SetValue(c, static_cast<unsigned char>(surface->GetCellType(c)));
  vtkSmartPointer<vtkCellArray> cells = surface->GetPolys();
  if (cells->GetNumberOfCells() != t.cells) {
    cells = vtkSmartPointer<vtkCellArray>::New();
    for (vtkCellArray* some :
         {surface->GetVerts(), surface->GetLines(), surface->GetPolys(), surface->GetStrips()})
      if (some)
        cells->Append(some);
  }
  read_types(cells, types, t);
}

void set_vertices(Topology& t, const int* dimensions, vtkDataSet* data) {
  t.is_flat = dimensions[0] > 1 && dimensions[1] > 1 && dimensions[2] == 1;
  for (std::size_t a = 0; a < 3; ++a) {
    t.vertices[a] = dimensions[a];
    if (dimensions[a] < 2 && !t.is_flat)
      unsupported(
          std::string(data->GetClassName()) + ": " + std::to_string(dimensions[0]) + " x " +
          std::to_string(dimensions[1]) + " x " + std::to_string(dimensions[2]) +
          " points; at least 2 along each axis are needed, or along x and y of a flat grid");
  }
}

void read_image(vtkImageData* image, Topology& t) {
  set_vertices(t, image->GetDimensions(), image);
  const int* extent = image->GetExtent();
  const double* spacing = image->GetSpacing();
  const double* origin = image->GetOrigin();
  if (image->GetDirectionMatrix()->IsIdentity()) {
    t.kind = Topology::Kind::uniform;
    for (std::size_t a = 0; a < 3; ++a) {
      t.spacing[a] = spacing[a];
      t.origin[a] = origin[a] + extent[2 * a] * spacing[a];
    }
    return;
  }
  t.kind = Topology::Kind::curvilinear; // the library tells of a flat one out of its plane
  t.made_points = "points of a rotated vtkImageData";
  auto points = vtkSmartPointer<vtkDoubleArray>::New();
  points->SetNumberOfComponents(3);
  points->SetNumberOfTuples(image->GetNumberOfPoints());
  for (vtkIdType i = 0; i < image->GetNumberOfPoints(); ++i)
    points->SetTuple(i, image->GetPoint(i));
  t.points = Watched(points);
}

} // namespace

bool same(const Watched& before, const Watched& now) {
  if (before.array == now.array)
    return before.time == now.time;
  return same_values(before.array, now.array);
}

Topology topology_of(vtkDataSet* data) {
  if (!data)
    throw Error(INSITU_ERROR_ARGUMENT, "data: null");
  Topology t;
  t.cells = data->GetNumberOfCells();
  t.ghosts = Watched(ghost_bytes(data->GetCellData(), &t.made_ghosts));
  if (t.cells == 0 &&
      (vtkUnstructuredGrid::SafeDownCast(data) || vtkStructuredGrid::SafeDownCast(data) ||
       vtkRectilinearGrid::SafeDownCast(data) || vtkImageData::SafeDownCast(data) ||
       vtkPolyData::SafeDownCast(data))) {
    t = {}; // nothing of it counts
    t.kind = Topology::Kind::cells;
    t.one_shape = true;
  } else if (auto* unstructured = vtkUnstructuredGrid::SafeDownCast(data)) {
    read_cells(unstructured, t);
  } else if (auto* surface = vtkPolyData::SafeDownCast(data)) {
    read_surface(surface, t);
  } else if (auto* structured = vtkStructuredGrid::SafeDownCast(data)) {
    t.kind = Topology::Kind::curvilinear;
    set_vertices(t, structured->GetDimensions(), structured);
    t.points = points_of(structured);
  } else if (auto* rectilinear = vtkRectilinearGrid::SafeDownCast(data)) {
    t.kind = Topology::Kind::rectilinear;
    set_vertices(t, rectilinear->GetDimensions(), rectilinear);
    t.axes[0] = Watched(rectilinear->GetXCoordinates());
    t.axes[1] = Watched(rectilinear->GetYCoordinates());
    t.axes[2] = Watched(rectilinear->GetZCoordinates());
  } else if (auto* image = vtkImageData::SafeDownCast(data)) {
    read_image(image, t);
  } else {
    unsupported(std::string(data->GetClassName()) +
                ": vtkUnstructuredGrid, vtkPolyData, vtkStructuredGrid, vtkRectilinearGrid and "
                "vtkImageData are supported");
  }
  return t;
}

bool same(const Topology& before, const Topology& now) {
  bool equal = before.kind == now.kind && before.cells == now.cells &&
               before.one_shape == now.one_shape && before.shape == now.shape &&
               before.is_flat == now.is_flat && before.vertices == now.vertices &&
               before.origin == now.origin && before.spacing == now.spacing &&
               same(before.ghosts, now.ghosts) && same(before.connectivity, now.connectivity) &&
               same(before.offsets, now.offsets) && same(before.types, now.types) &&
               same(before.given_faces, now.given_faces);
  for (int a = 0; equal && a < 3; ++a)
    equal = same(before.axes[a], now.axes[a]);
  return equal;
}

} // namespace insitu::vtk
