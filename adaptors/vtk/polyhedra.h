#pragma once

#include <vtkSmartPointer.h>
#include <vtkTypeInt64Array.h>

class vtkUnstructuredGrid;

namespace insitu::vtk {

/// The cells of a grid as lists of faces (INSITU_FACES_CELLS), all of it made here: VTK holds the
/// faces of polyhedra cell by cell, so one between two cells is there twice.
struct FaceLists {
  vtkSmartPointer<vtkTypeInt64Array> vertices, offsets, cell_faces, cell_offsets;
};

/// Cells of any shape with a volume; others have no faces. Throws Error for faces that do not lie
/// in the grid's arrays. Vertex ids are as they are.
FaceLists face_lists_of(vtkUnstructuredGrid* grid);

} // namespace insitu::vtk
