#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <vector>
#include <vtkSmartPointer.h>

class vtkUnstructuredGrid;

namespace insitu_replay {

/// The numbers that the cells or points of a piece have in the whole mesh, and the file that says
/// so.
struct PieceNumbers {
  std::string file;
  std::vector<std::int64_t> numbers;
};

/// Those of each piece, as many as it has cells and points.
struct Numbers {
  std::vector<PieceNumbers> cells, points;
};

/// Puts the pieces of a mesh together: cells and points in the order of their numbers, with the
/// arrays that all pieces have. A point of several pieces is that of the first. Throws FileError
/// for numbers that are not each there once (of points: at least once).
/// left_out: gets the names of the other arrays.
vtkSmartPointer<vtkUnstructuredGrid>
put_together(const std::vector<vtkSmartPointer<vtkUnstructuredGrid>>& pieces,
             const Numbers& numbers, std::set<std::string>& left_out);

} // namespace insitu_replay
