#pragma once

#include <array>
#include <string>
#include <vector>
#include <vtkDataArray.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>

#include "insitu/insitu.hpp"

#include "polyhedra.h"

class vtkDataSet;

namespace insitu::vtk {

/// An array and its modification time when it was read: what tells later whether it changed.
struct Watched {
  vtkSmartPointer<vtkDataArray> array;
  vtkMTimeType time = 0;

  Watched() = default;
  /// owner: an object whose modification counts too, or null.
  explicit Watched(vtkDataArray* a, vtkObject* owner = nullptr)
      : array(a), time(a ? a->GetMTime() : 0) {
    if (owner && owner->GetMTime() > time)
      time = owner->GetMTime();
  }
};

bool same(const Watched& before, const Watched& now);

/// The cells of a data set, checked, as they are given to a piece, apart from the points' values.
struct Topology {
  enum class Kind { none, cells, faces, curvilinear, rectilinear, uniform };
  Kind kind = Kind::none;
  vtkIdType cells = 0;
  // Kind::cells
  Shape shape = Shape::hexahedron;
  bool one_shape = false;
  Watched connectivity, offsets, types;
  // Kind::faces, and the connectivity, offsets and types of that
  Watched given_faces;
  FaceLists faces;
  // blocks
  bool is_flat = false; ///< one vertex along k
  std::array<std::int64_t, 3> vertices{};
  std::array<double, 3> origin{}, spacing{};
  Watched axes[3];
  // all
  Watched ghosts;
  /// Not part of same(): why the ghosts are a copy, and cells that have no volume, in words.
  const char* made_ghosts = nullptr;
  std::string left_out;
  /// Not part of same(); made_points says why they are a copy.
  Watched points;
  const char* made_points = nullptr;
};

/// Cells of fewer dimensions beside cells of volume, or of a flat mesh (boundary faces, edges), are
/// kept in their places and hidden by ghost values. Throws Error for data sets and cells that are
/// not supported.
Topology topology_of(vtkDataSet* data);

bool same(const Topology& before, const Topology& now);

} // namespace insitu::vtk
