#pragma once

#include <array>
#include <string>
#include <vector>
#include <vtkSmartPointer.h>
#include <vtkUniformGrid.h>

#include "insitu/vtk.hpp"

#include "topology.h"

class vtkDataObject;

namespace insitu::vtk {

/// A grid of a vtkOverlappingAMR, without its layers of duplicate cells.
struct AdaptivePatch {
  int level = 0;
  std::array<std::int64_t, 3> lower{}, cells{};
  std::array<std::int64_t, 3> grid_cells{}, skipped{}; ///< of the grid, and before the patch in it
  vtkSmartPointer<vtkUniformGrid> grid;
  Watched ghosts;

  bool is_whole() const { return cells == grid_cells; }
};

/// The leaves of a vtkHyperTreeGrid that are neither masked nor ghosts; copies, as hyper trees keep
/// no corners.
struct AdaptiveLeaves {
  std::vector<std::uint8_t> levels;
  std::vector<std::int64_t> corners; ///< [leaves][3], in cells of the leaf's own level
  std::vector<vtkIdType> nodes;      ///< where in the cell arrays their values are
};

/// The cells of an adaptive data object, checked, apart from their values.
struct AdaptiveCells {
  AmrLevels levels;
  bool are_leaves = false;
  std::vector<AdaptivePatch> patches;
  AdaptiveLeaves leaves;
  std::vector<Note> notes;           ///< what of it is left out, and why
  const char* made_ghosts = nullptr; ///< why ghost values are a copy
};

/// Throws Error for what is not supported.
AdaptiveCells cells_of(vtkDataObject* data);

/// Whether both are the same cells, wherever they come from.
bool same(const AdaptiveCells& a, const AdaptiveCells& b);

} // namespace insitu::vtk
