#include "adaptive_cells.h"

#include <algorithm>
#include <cmath>
#include <vtkAMRBox.h>
#include <vtkCellData.h>
#include <vtkDataSetAttributes.h>
#include <vtkHyperTreeGrid.h>
#include <vtkHyperTreeGridNonOrientedCursor.h>
#include <vtkOverlappingAMR.h>
#include <vtkUnsignedCharArray.h>

#include "arrays.h"

namespace insitu::vtk {

namespace {

constexpr unsigned char duplicate_bit = 1, hidden_bit = 32;

[[noreturn]] void unsupported(const std::string& what) {
  throw Error(INSITU_ERROR_UNSUPPORTED, what);
}

std::string block_name(unsigned int level, unsigned int index) {
  return "vtkOverlappingAMR, level " + std::to_string(level) + ", grid " + std::to_string(index);
}

/// Whole multiples of the finer length, up to roundings of whoever divided; 0 if they are not.
int ratio_of(double coarse, double fine) {
  for (const int ratio : {2, 4})
    if (std::fabs(coarse - ratio * fine) <= 1e-9 * coarse)
      return ratio;
  return 0;
}

AmrLevels levels_of(vtkOverlappingAMR* amr) {
  AmrLevels out;
  out.count = static_cast<int>(amr->GetNumberOfLevels());
  if (out.count < 1)
    throw Error(INSITU_ERROR_ARGUMENT, "vtkOverlappingAMR: no levels");
  std::copy_n(amr->GetOrigin(), 3, out.origin.begin());
  out.dimensions = amr->GetGridDescription() == VTK_XY_PLANE ? 2 : 3;
  std::array<double, 3> coarse{}, fine{};
  amr->GetSpacing(0, out.spacing.data());
  coarse = out.spacing;
  for (int l = 1; l < out.count; ++l) {
    amr->GetSpacing(static_cast<unsigned int>(l), fine.data());
    const int ratio = ratio_of(coarse[0], fine[0]);
    for (std::size_t a = 0; a < std::size_t(out.dimensions); ++a)
      if (ratio == 0 || ratio_of(coarse[a], fine[a]) != ratio)
        unsupported("vtkOverlappingAMR: spacing " + std::to_string(fine[a]) + " of level " +
                    std::to_string(l) + " along axis " + std::to_string(a) + ", under " +
                    std::to_string(coarse[a]) + "; a half or a quarter along all axes expected");
    out.ratios.push_back(ratio);
    coarse = fine;
  }
  return out;
}

/// As bytes; a note if they are of another type.
vtkSmartPointer<vtkUnsignedCharArray> ghosts_of(vtkDataSetAttributes* data, AdaptiveCells& out) {
  const char* reason = nullptr;
  auto ghosts = ghost_bytes(data, &reason);
  if (reason)
    out.made_ghosts = reason;
  return ghosts;
}

/// Without layers of duplicates: what is left must be a box.
void trim(AdaptivePatch& p, vtkUnsignedCharArray* ghosts, const std::string& name) {
  const auto bits = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    return ghosts->GetValue(i + p.grid_cells[0] * (j + p.grid_cells[1] * k));
  };
  std::array<std::int64_t, 3> low = p.grid_cells, high{};
  std::int64_t own = 0;
  for (std::int64_t k = 0; k < p.grid_cells[2]; ++k)
    for (std::int64_t j = 0; j < p.grid_cells[1]; ++j)
      for (std::int64_t i = 0; i < p.grid_cells[0]; ++i) {
        if (bits(i, j, k) & hidden_bit)
          unsupported(name + ": cell (" + std::to_string(i) + ", " + std::to_string(j) + ", " +
                      std::to_string(k) + ") is hidden; a patch has all its cells");
        if (bits(i, j, k) & duplicate_bit)
          continue;
        ++own;
        const std::array<std::int64_t, 3> at{i, j, k};
        for (std::size_t a = 0; a < 3; ++a) {
          low[a] = std::min(low[a], at[a]);
          high[a] = std::max(high[a], at[a] + 1);
        }
      }
  for (std::size_t a = 0; a < 3; ++a) {
    p.cells[a] = own == 0 ? 0 : high[a] - low[a];
    p.skipped[a] = low[a];
    p.lower[a] += low[a];
  }
  if (own != p.cells[0] * p.cells[1] * p.cells[2])
    unsupported(name + ": its " + std::to_string(own) + " cells that are no duplicates are no box");
}

AdaptivePatch patch_of(vtkOverlappingAMR* amr, unsigned int level, unsigned int index,
                       AdaptiveCells& out) {
  AdaptivePatch p;
  p.grid = amr->GetDataSet(level, index);
  if (!p.grid)
    return p; // another process has it
  const std::string name = block_name(level, index);
  const vtkAMRBox& box = amr->GetAMRBox(level, index);
  p.level = static_cast<int>(level);
  int points[3];
  p.grid->GetDimensions(points);
  for (int a = 0; a < 3; ++a) {
    const auto at = static_cast<std::size_t>(a);
    if (a == out.levels.dimensions) { // one cell thick
      p.cells[at] = p.grid_cells[at] = 1;
      continue;
    }
    p.lower[at] = box.GetLoCorner()[a];
    p.cells[at] = std::int64_t(box.GetHiCorner()[a]) - box.GetLoCorner()[a] + 1;
    p.grid_cells[at] = points[a] - 1;
    if (p.grid_cells[at] < 1)
      unsupported(name + ": flat along axis " + std::to_string(a) +
                  "; grids of three dimensions, " +
                  "and of two in the plane of x and y, are supported");
    if (p.cells[at] != p.grid_cells[at])
      throw Error(INSITU_ERROR_ARGUMENT, name + ": " + std::to_string(p.grid_cells[at]) +
                                             " cells along axis " + std::to_string(a) +
                                             ", but its box has " + std::to_string(p.cells[at]));
  }
  if (const auto ghosts = ghosts_of(p.grid->GetCellData(), out)) {
    p.ghosts = Watched(ghosts);
    trim(p, ghosts, name);
  }
  return p;
}

AdaptiveCells cells_of(vtkOverlappingAMR* amr) {
  AdaptiveCells out;
  out.levels = levels_of(amr);
  for (unsigned int l = 0; l < amr->GetNumberOfLevels(); ++l)
    for (unsigned int i = 0; i < amr->GetNumberOfDataSets(l); ++i)
      if (AdaptivePatch p = patch_of(amr, l, i, out); p.grid && p.cells[0] > 0)
        out.patches.push_back(std::move(p));
  if (std::any_of(out.patches.begin(), out.patches.end(),
                  [](const AdaptivePatch& p) { return p.ghosts.array; }))
    out.notes.push_back({"cell array 'vtkGhostType'",
                         "cells under finer grids are masked by the library, duplicates are not "
                         "read"});
  return out;
}

/// Walks the trees of a grid.
class TreeWalk {
public:
  TreeWalk(vtkHyperTreeGrid* grid, AdaptiveCells& out) : grid_(grid), out_(out) {
    ghosts_ = ghosts_of(grid->GetCellData(), out);
  }

  void visit(vtkIdType tree) {
    unsigned int at[3];
    grid_->GetLevelZeroCoordinatesFromIndex(tree, at[0], at[1], at[2]);
    place(tree, at);
    grid_->InitializeNonOrientedCursor(cursor_, tree);
    descend({at[0], at[1], at[2]}, 0);
  }

  /// Whether leaves were masked or ghosts.
  bool left_out() const { return left_out_; }

private:
  /// All trees are of one size, on one lattice.
  void place(vtkIdType tree, const unsigned int (&at)[3]) {
    double origin[3], size[3];
    grid_->GetLevelZeroOriginAndSizeFromIndex(tree, origin, size);
    for (std::size_t a = 0; a < std::size_t(out_.levels.dimensions); ++a) {
      if (first_) {
        out_.levels.spacing[a] = size[a];
        out_.levels.origin[a] = origin[a] - at[a] * size[a];
      }
      const double h = out_.levels.spacing[a], expected = out_.levels.origin[a] + at[a] * h;
      if (!(std::fabs(size[a] - h) <= 1e-9 * h && std::fabs(origin[a] - expected) <= 1e-9 * h))
        unsupported("vtkHyperTreeGrid: tree " + std::to_string(tree) + " is " +
                    std::to_string(size[a]) + " long at " + std::to_string(origin[a]) +
                    " along axis " + std::to_string(a) + ", " + std::to_string(h) + " at " +
                    std::to_string(expected) + " expected: trees must be equal");
    }
    first_ = false;
  }

  void descend(const std::array<std::int64_t, 3>& at, int level) {
    if (cursor_->IsMasked()) {
      left_out_ = true;
      return;
    }
    if (cursor_->IsLeaf()) {
      add(at, level);
      return;
    }
    for (unsigned char c = 0; c < 1 << out_.levels.dimensions; ++c) {
      cursor_->ToChild(c);
      descend({2 * at[0] + (c & 1), 2 * at[1] + (c >> 1 & 1), 2 * at[2] + (c >> 2)}, level + 1);
      cursor_->ToParent();
    }
  }

  void add(const std::array<std::int64_t, 3>& at, int level) {
    const vtkIdType node = cursor_->GetGlobalNodeIndex();
    if (ghosts_ && (ghosts_->GetValue(node) & (duplicate_bit | hidden_bit))) {
      left_out_ = true;
      return;
    }
    out_.leaves.levels.push_back(static_cast<std::uint8_t>(level));
    out_.leaves.corners.insert(out_.leaves.corners.end(), at.begin(), at.end());
    out_.leaves.nodes.push_back(node);
    out_.levels.count = std::max(out_.levels.count, level + 1);
  }

  vtkHyperTreeGrid* grid_;
  AdaptiveCells& out_;
  vtkSmartPointer<vtkUnsignedCharArray> ghosts_;
  vtkNew<vtkHyperTreeGridNonOrientedCursor> cursor_;
  bool first_ = true, left_out_ = false;
};

AdaptiveCells cells_of(vtkHyperTreeGrid* grid) {
  const int dimensions = static_cast<int>(grid->GetDimension());
  const bool lies = dimensions == 2 && grid->GetOrientation() == 2; // across z
  if ((dimensions != 3 && !lies) || grid->GetBranchFactor() != 2)
    unsupported("vtkHyperTreeGrid: " + std::to_string(dimensions) + " dimensions, orientation " +
                std::to_string(grid->GetOrientation()) + ", branch factor " +
                std::to_string(grid->GetBranchFactor()) +
                "; octrees, and quadtrees in the plane of x and y, of branch factor 2 are "
                "supported");
  AdaptiveCells out;
  out.levels.dimensions = dimensions;
  out.are_leaves = true;
  TreeWalk walk(grid, out);
  vtkHyperTreeGrid::vtkHyperTreeGridIterator trees;
  grid->InitializeTreeIterator(trees);
  vtkIdType tree = 0;
  while (trees.GetNextTree(tree))
    walk.visit(tree);
  if (walk.left_out())
    out.notes.push_back({"what is masked or a ghost of the leaves", "holes in the mesh"});
  return out;
}

} // namespace

AdaptiveCells cells_of(vtkDataObject* data) {
  if (auto* amr = vtkOverlappingAMR::SafeDownCast(data))
    return cells_of(amr);
  if (auto* grid = vtkHyperTreeGrid::SafeDownCast(data))
    return cells_of(grid);
  if (!data)
    throw Error(INSITU_ERROR_ARGUMENT, "data: null");
  unsupported(std::string(data->GetClassName()) +
              ": vtkOverlappingAMR and vtkHyperTreeGrid are supported");
}

bool same(const AdaptiveCells& a, const AdaptiveCells& b) {
  const auto same_patch = [](const AdaptivePatch& p, const AdaptivePatch& q) {
    return p.level == q.level && p.lower == q.lower && p.cells == q.cells;
  };
  return a.levels.origin == b.levels.origin && a.levels.spacing == b.levels.spacing &&
         a.levels.dimensions == b.levels.dimensions && a.levels.ratios == b.levels.ratios &&
         a.levels.count == b.levels.count && a.are_leaves == b.are_leaves &&
         a.leaves.levels == b.leaves.levels && a.leaves.corners == b.leaves.corners &&
         std::equal(a.patches.begin(), a.patches.end(), b.patches.begin(), b.patches.end(),
                    same_patch);
}

} // namespace insitu::vtk
