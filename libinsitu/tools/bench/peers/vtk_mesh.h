#pragma once

#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include "workload/mesh.h"

namespace insitu::bench {

/// A grid over the mesh's own points and connectivity, with the field as its active scalars. Both
/// must outlive it.
vtkSmartPointer<vtkUnstructuredGrid> make_grid(const workload::Mesh& mesh,
                                               const std::vector<double>& field);

} // namespace insitu::bench
