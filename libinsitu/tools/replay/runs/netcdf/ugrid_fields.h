#pragma once

#include <string>
#include <vector>
#include <vtkSmartPointer.h>

#include "runs/netcdf/ugrid_topology.h"
#include "runs/netcdf/ugrid_vertical.h"

class vtkDataSet;

namespace insitu_replay {

/// A variable on the mesh.
struct UgridField {
  const NetcdfFile::Variable* v = nullptr;
  bool of_cells = false;
  std::vector<int> others; ///< its dimensions besides time and those of the mesh
  int level = -1;          ///< the dimension of layers or interfaces; -1: none
  int part = -1;           ///< the dimension of components; -1: one
};

/// The variables of the mesh, and what is left out as notes. Their levels and parts are not known
/// yet.
std::vector<UgridField> fields_of(const UgridDims& dims, std::vector<std::string>& notes);

/// Tells levels and parts (a dimension of 2 or 3) of the fields, and leaves out, with notes, those
/// with other dimensions.
void resolve_levels(const UgridDims& dims, const UgridVertical* vertical,
                    std::vector<UgridField>& fields, std::vector<std::string>& notes);

/// Heights of a step, where there are layers.
struct UgridColumn {
  const UgridVertical* vertical = nullptr; ///< null: flat, or volumes
  std::vector<double> interfaces, middles; ///< [level][node], made vertices among the nodes
  std::size_t nodes = 0;                   ///< with the made ones
};

/// Sets the values of a step as arrays of points and cells.
void set_fields(const UgridDims& dims, const CutFaces& faces, const UgridColumn& column,
                const std::vector<UgridField>& fields, std::size_t step, vtkDataSet* out);

/// Adds vectors of the arrays that are components by their standard names.
void add_vectors(const NetcdfFile& file, const std::vector<UgridField>& fields, bool flat,
                 vtkDataSet* out);

} // namespace insitu_replay
