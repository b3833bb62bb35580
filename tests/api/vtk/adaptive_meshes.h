// Small adaptive data objects.
#pragma once

#include <array>
#include <vtkAMRBox.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkHyperTree.h>
#include <vtkHyperTreeGrid.h>
#include <vtkHyperTreeGridNonOrientedCursor.h>
#include <vtkNew.h>
#include <vtkOverlappingAMR.h>
#include <vtkUniformGrid.h>

#include "meshes.h"

namespace vtk_meshes {

/// n^3 cells of a level from `lower` on, with the linear field at their centres.
inline vtkSmartPointer<vtkUniformGrid> grid_of(int n, const std::array<int, 3>& lower, double h) {
  auto grid = vtkSmartPointer<vtkUniformGrid>::New();
  grid->SetDimensions(n + 1, n + 1, n + 1);
  grid->SetSpacing(h, h, h);
  grid->SetOrigin(h * lower[0], h * lower[1], h * lower[2]);
  vtkNew<vtkDoubleArray> values;
  values->SetName("f");
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i)
        values->InsertNextValue(
            linear({h * (lower[0] + i + 0.5), h * (lower[1] + j + 0.5), h * (lower[2] + k + 0.5)}));
  grid->GetCellData()->AddArray(values);
  return grid;
}

/// 4^3 cells, and 4^3 of half their edge over the middle eight of them.
inline vtkSmartPointer<vtkOverlappingAMR> some_levels(unsigned int levels,
                                                      double fine_spacing = 0.5) {
  auto amr = vtkSmartPointer<vtkOverlappingAMR>::New();
  const int blocks[] = {1, 1};
  amr->Initialize(int(levels), blocks);
  amr->SetGridDescription(VTK_XYZ_GRID);
  const double origin[3] = {0, 0, 0};
  amr->SetOrigin(origin);
  for (unsigned int l = 0; l < levels; ++l) {
    const double h = l == 0 ? 1.0 : fine_spacing;
    const double spacing[3] = {h, h, h};
    const int first = l == 0 ? 0 : 2;
    const int low[3] = {first, first, first}, high[3] = {first + 3, first + 3, first + 3};
    amr->SetSpacing(l, spacing);
    amr->SetAMRBox(l, 0, vtkAMRBox(low, high));
    amr->SetDataSet(l, 0, grid_of(4, {first, first, first}, h));
  }
  return amr;
}

inline vtkSmartPointer<vtkOverlappingAMR> two_levels() {
  return some_levels(2);
}

inline vtkDoubleArray* values_of(vtkOverlappingAMR* amr, unsigned int level) {
  return vtkDoubleArray::SafeDownCast(amr->GetDataSet(level, 0)->GetCellData()->GetArray("f"));
}

/// The same of 4^2 cells in two dimensions.
inline vtkSmartPointer<vtkOverlappingAMR> two_flat_levels() {
  auto amr = vtkSmartPointer<vtkOverlappingAMR>::New();
  const int blocks[] = {1, 1};
  amr->Initialize(2, blocks);
  amr->SetGridDescription(VTK_XY_PLANE);
  const double origin[3] = {0, 0, 0};
  amr->SetOrigin(origin);
  for (unsigned int l = 0; l < 2; ++l) {
    const double h = l == 0 ? 1.0 : 0.5;
    const double spacing[3] = {h, h, h};
    const int first = l == 0 ? 0 : 2;
    auto grid = vtkSmartPointer<vtkUniformGrid>::New();
    grid->SetDimensions(5, 5, 1);
    grid->SetSpacing(h, h, h);
    grid->SetOrigin(h * first, h * first, 0);
    vtkNew<vtkDoubleArray> values;
    values->SetName("f");
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 4; ++i)
        values->InsertNextValue(linear({h * (first + i + 0.5), h * (first + j + 0.5), 0}));
    grid->GetCellData()->AddArray(values);
    amr->SetSpacing(l, spacing);
    const vtkAMRBox box(grid->GetOrigin(), grid->GetDimensions(), spacing, origin, VTK_XY_PLANE);
    amr->SetAMRBox(l, 0, box);
    amr->SetDataSet(l, 0, grid);
  }
  return amr;
}

/// Two trees side by side along x; the second is refined, and the first of its children again.
struct Trees {
  explicit Trees(bool are_flat = false) {
    grid->SetDimensions(3, 2, are_flat ? 1 : 2);
    grid->SetBranchFactor(2);
    vtkNew<vtkDoubleArray> x, y;
    for (const double c : {0.0, 1.0, 2.0})
      x->InsertNextValue(c);
    for (const double c : {0.0, 1.0})
      y->InsertNextValue(c);
    grid->SetXCoordinates(x);
    grid->SetYCoordinates(y);
    vtkNew<vtkDoubleArray> z;
    z->InsertNextValue(0.0);
    grid->SetZCoordinates(are_flat ? z : y);
    vtkNew<vtkHyperTreeGridNonOrientedCursor> cursor;
    vtkIdType nodes = 0;
    for (vtkIdType tree = 0; tree < 2; ++tree) {
      grid->InitializeNonOrientedCursor(cursor, tree, true);
      cursor->SetGlobalIndexStart(nodes);
      if (tree == 1) {
        cursor->SubdivideLeaf();
        cursor->ToChild(0);
        cursor->SubdivideLeaf();
        cursor->ToParent();
      }
      nodes += cursor->GetTree()->GetNumberOfVertices();
    }
    values->SetName("f");
    values->SetNumberOfTuples(nodes);
    for (vtkIdType n = 0; n < nodes; ++n)
      values->SetValue(n, double(n));
    grid->GetCellData()->AddArray(values);
  }
  vtkNew<vtkHyperTreeGrid> grid;
  vtkNew<vtkDoubleArray> values;
};

} // namespace vtk_meshes
