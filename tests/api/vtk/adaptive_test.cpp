/// What attach_adaptive() gives to the mesh: patches and leaves, values in place, ghosts, refusals,
/// updates.

#include <functional>
#include <gtest/gtest.h>
#include <vtkAMRBox.h>
#include <vtkBitArray.h>
#include <vtkCellData.h>
#include <vtkDataSetAttributes.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkHyperTree.h>
#include <vtkHyperTreeGrid.h>
#include <vtkHyperTreeGridNonOrientedCursor.h>
#include <vtkImageData.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkOverlappingAMR.h>
#include <vtkUniformGrid.h>
#include <vtkUnsignedCharArray.h>

#include "insitu/vtk.hpp"

#include "adaptive_meshes.h"

using namespace vtk_meshes;

namespace {

struct VtkAdaptive : testing::Test {
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("amr");

  const void* address_of(const std::string& name) const {
    for (const insitu::AuditEntry& e : mesh.audit())
      if (e.name == name && e.borrowed)
        return e.data;
    return nullptr;
  }
  double at(const std::string& field, const std::array<double, 3>& point) const {
    double value = 0.0;
    EXPECT_TRUE(mesh.sample_point(field, point, {&value, 1})) << point[0];
    return value;
  }
};

void expect_refused(insitu_status status, const char* words, const std::function<void()>& call) {
  try {
    call();
    FAIL() << "not refused";
  } catch (const insitu::Error& e) {
    EXPECT_EQ(e.status(), status) << e.what();
    EXPECT_NE(std::string(e.what()).find(words), std::string::npos) << e.what();
  }
}

} // namespace

TEST_F(VtkAdaptive, GridsOfLevelsAreReadInPlace) {
  const auto amr = two_levels();
  auto attached = insitu::vtk::attach_adaptive(mesh, amr);
  mesh.commit();
  EXPECT_EQ(address_of("piece 0 field 'f'"), values_of(amr, 0)->GetPointer(0));
  EXPECT_EQ(address_of("piece 1 field 'f'"), values_of(amr, 1)->GetPointer(0));
  EXPECT_TRUE(attached.converted().empty());
  for (const std::array<double, 3>& p :
       {std::array<double, 3>{0.5, 0.5, 0.5}, {1.25, 1.75, 2.75}, {3.5, 1.5, 0.5}, {2, 2, 2}})
    EXPECT_NEAR(at("f", p), vtk_meshes::linear(p), 1e-14);
  EXPECT_EQ(attached.update(amr), insitu::Change{});
  values_of(amr, 1)->SetValue(0, 7.0);
  values_of(amr, 1)->Modified();
  EXPECT_EQ(attached.update(amr), insitu::fields);
  mesh.commit();
  EXPECT_DOUBLE_EQ(at("f", {1.25, 1.25, 1.25}), 7.0);
}

TEST_F(VtkAdaptive, LayersOfDuplicatesAreLeftOut) {
  const auto amr = two_levels();
  // The fine grid with a layer around it, as solvers keep them.
  const int low[3] = {1, 1, 1}, high[3] = {6, 6, 6};
  amr->SetAMRBox(1, 0, vtkAMRBox(low, high));
  const auto wide = grid_of(6, {1, 1, 1}, 0.5);
  vtkNew<vtkUnsignedCharArray> ghosts;
  ghosts->SetName(vtkDataSetAttributes::GhostArrayName());
  for (int c = 0; c < 216; ++c) {
    const int i = c % 6, j = c / 6 % 6, k = c / 36;
    const bool inside = i % 5 != 0 && j % 5 != 0 && k % 5 != 0;
    ghosts->InsertNextValue(inside ? 0 : vtkDataSetAttributes::DUPLICATECELL);
  }
  wide->GetCellData()->AddArray(ghosts);
  amr->SetDataSet(1, 0, wide);
  auto attached = insitu::vtk::attach_adaptive(mesh, amr);
  mesh.commit();
  EXPECT_EQ(address_of("piece 1 field 'f'"), values_of(amr, 1)->GetPointer(1 + 6 + 36));
  EXPECT_NEAR(at("f", {1.25, 2.75, 1.75}), vtk_meshes::linear({1.25, 2.75, 1.75}), 1e-14);
  EXPECT_FALSE(attached.skipped().empty());
  ghosts->SetValue(43 + 1, vtkDataSetAttributes::DUPLICATECELL);
  expect_refused(INSITU_ERROR_UNSUPPORTED, "63 cells that are no duplicates",
                 [&] { (void)attached.update(amr); });
  ghosts->SetValue(43 + 1, vtkDataSetAttributes::HIDDENCELL);
  expect_refused(INSITU_ERROR_UNSUPPORTED, "cell (2, 1, 1) is hidden",
                 [&] { (void)attached.update(amr); });
}

TEST_F(VtkAdaptive, ARegridMayLeaveFewerGrids) {
  auto attached = insitu::vtk::attach_adaptive(mesh, two_levels());
  mesh.commit();
  const auto coarse = some_levels(1);
  EXPECT_EQ(attached.update(coarse), insitu::everything);
  mesh.commit();
  EXPECT_EQ(address_of("piece 1 field 'f'"), nullptr);
  EXPECT_NEAR(at("f", {1.5, 1.5, 2.5}), vtk_meshes::linear({1.5, 1.5, 2.5}), 1e-14);
}

TEST_F(VtkAdaptive, ArraysThatSomeGridLacksAreLeftOut) {
  const auto amr = two_levels();
  vtkNew<vtkFloatArray> extra;
  extra->SetName("extra");
  extra->SetNumberOfTuples(64);
  extra->Fill(1.0);
  amr->GetDataSet(0, 0)->GetCellData()->AddArray(extra);
  vtkNew<vtkIntArray> numbers;
  numbers->SetName("number");
  numbers->SetNumberOfTuples(64);
  numbers->Fill(3);
  for (unsigned int l = 0; l < 2; ++l)
    amr->GetDataSet(l, 0)->GetCellData()->AddArray(numbers);
  auto attached = insitu::vtk::attach_adaptive(mesh, amr);
  mesh.commit();
  ASSERT_EQ(attached.skipped().size(), 1u);
  EXPECT_EQ(attached.skipped()[0].reason, "1 of 2 grids have it alike");
  ASSERT_EQ(attached.converted().size(), 1u);
  EXPECT_EQ(attached.converted()[0].reason, "integer values");
  EXPECT_DOUBLE_EQ(at("number", {2, 2, 2}), 3.0);
}

TEST_F(VtkAdaptive, LeavesOfHyperTrees) {
  Trees trees;
  auto attached = insitu::vtk::attach_adaptive(mesh, trees.grid);
  EXPECT_EQ(mesh.commit().action, INSITU_REBUILD);
  EXPECT_EQ(attached.converted().size(), 1u); // levels and corners
  // Nodes: 0, the first tree; 1, the second's root; its children 2 to 9; those of the first, 10 on.
  EXPECT_DOUBLE_EQ(at("f", {0.5, 0.5, 0.5}), 0.0);
  EXPECT_DOUBLE_EQ(at("f", {1.75, 0.25, 0.25}), 3.0);
  EXPECT_DOUBLE_EQ(at("f", {1.25, 0.25, 0.75}), 6.0);
  EXPECT_DOUBLE_EQ(at("f", {1.125, 0.125, 0.125}), 10.0);
  EXPECT_DOUBLE_EQ(at("f", {1.125, 0.375, 0.375}), 16.0);
  // Values are read where they are.
  EXPECT_EQ(attached.update(trees.grid), insitu::Change{});
  trees.values->SetValue(16, -2.0);
  mesh.changed(insitu::fields);
  mesh.commit();
  EXPECT_DOUBLE_EQ(at("f", {1.125, 0.375, 0.375}), -2.0);
}

/// Levels a quarter as wide, and values in float, read where they are.
TEST_F(VtkAdaptive, RatioOfFourInFloat) {
  const auto amr = two_levels();
  const double spacing[3] = {0.25, 0.25, 0.25};
  const int low[3] = {4, 4, 4}, high[3] = {11, 11, 11};
  amr->SetSpacing(1, spacing);
  amr->SetAMRBox(1, 0, vtkAMRBox(low, high));
  amr->SetDataSet(1, 0, grid_of(8, {4, 4, 4}, 0.25));
  const vtkFloatArray* floats[2];
  for (unsigned int l = 0; l < 2; ++l) {
    vtkDoubleArray* const doubles = values_of(amr, l);
    vtkNew<vtkFloatArray> values;
    values->SetName("f");
    for (vtkIdType c = 0; c < doubles->GetNumberOfTuples(); ++c)
      values->InsertNextValue(float(doubles->GetValue(c)));
    vtkCellData* const cells = amr->GetDataSet(l, 0)->GetCellData();
    cells->RemoveArray("f");
    cells->AddArray(values);
    floats[l] = values;
  }
  auto attached = insitu::vtk::attach_adaptive(mesh, amr);
  mesh.commit();
  for (int l = 0; l < 2; ++l)
    EXPECT_EQ(address_of("piece " + std::to_string(l) + " field 'f'"),
              const_cast<vtkFloatArray*>(floats[l])->GetPointer(0));
  EXPECT_TRUE(attached.converted().empty());
  for (const std::array<double, 3>& p : {std::array<double, 3>{0.5, 0.5, 0.5},
                                         {1.125, 1.625, 2.875},
                                         {3.5, 1.5, 0.5},
                                         {2, 2, 2},
                                         {0.9, 1.9, 2.1},
                                         {3.2, 2.9, 2.8}})
    EXPECT_NEAR(at("f", p), vtk_meshes::linear(p), 1e-5);
}

/// VTK's own mask, a bit a node: one of the finest leaves is out.
TEST_F(VtkAdaptive, ATreesMaskIsAHole) {
  Trees trees;
  vtkNew<vtkBitArray> mask;
  mask->SetNumberOfTuples(trees.values->GetNumberOfTuples());
  for (vtkIdType n = 0; n < mask->GetNumberOfTuples(); ++n)
    mask->SetValue(n, n == 16);
  trees.grid->SetMask(mask);
  auto attached = insitu::vtk::attach_adaptive(mesh, trees.grid);
  mesh.commit();
  double value = 0.0;
  EXPECT_FALSE(mesh.sample_point("f", {1.125, 0.375, 0.375}, {&value, 1}));
  EXPECT_DOUBLE_EQ(at("f", {1.125, 0.125, 0.125}), 10.0);
  EXPECT_NEAR(at("f", {0.5, 0.5, 0.5}), 0.0, 1e-15);
}

TEST_F(VtkAdaptive, MaskedLeavesAndGhostsAreHoles) {
  Trees trees;
  vtkNew<vtkUnsignedCharArray> ghosts;
  ghosts->SetName(vtkDataSetAttributes::GhostArrayName());
  ghosts->SetNumberOfTuples(trees.values->GetNumberOfTuples());
  ghosts->Fill(0);
  ghosts->SetValue(0, vtkDataSetAttributes::DUPLICATECELL); // the whole first tree
  trees.grid->GetCellData()->AddArray(ghosts);
  auto attached = insitu::vtk::attach_adaptive(mesh, trees.grid);
  mesh.commit();
  double value = 0.0;
  EXPECT_FALSE(mesh.sample_point("f", {0.5, 0.5, 0.5}, {&value, 1}));
  EXPECT_DOUBLE_EQ(at("f", {1.75, 0.25, 0.25}), 3.0);
}

/// Grids and trees of two dimensions; the third coordinate is of no account.
TEST_F(VtkAdaptive, InTwoDimensions) {
  const auto amr = two_flat_levels();
  const auto of_grids = insitu::vtk::attach_adaptive(mesh, amr);
  mesh.commit();
  EXPECT_EQ(mesh.amr_info().masked, 4);
  for (const double z : {0.0, -3.0, 1e3}) {
    EXPECT_NEAR(at("f", {0.9, 2.2, z}), linear({0.9, 2.2, 0}), 1e-13);
    EXPECT_NEAR(at("f", {2.1, 1.4, z}), linear({2.1, 1.4, 0}), 1e-13);
  }
  Trees trees(true);
  insitu::Mesh other = session.mesh("trees");
  const auto of_trees = insitu::vtk::attach_adaptive(other, trees.grid);
  other.commit();
  // Nodes: 0, the first tree; 1, the second's root; its children 2 to 5; those of the first, 6 on.
  const std::vector<double> points{0.5, 0.5, 9, 1.75, 0.25, 0, 1.25, 0.75, 0, 1.375, 0.125, 0};
  const insitu::Samples f = other.sample("f", points);
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_NEAR(f.values[i], (std::array{0.0, 3.0, 4.0, 7.0})[i], 1e-13);
}

TEST_F(VtkAdaptive, WhatIsNotSupportedIsRefusedByName) {
  const auto refused = [&](vtkDataObject* data, insitu_status status, const char* words) {
    expect_refused(status, words, [&] { (void)insitu::vtk::attach_adaptive(mesh, data); });
  };
  vtkNew<vtkImageData> image;
  refused(image, INSITU_ERROR_UNSUPPORTED, "vtkImageData");
  refused(nullptr, INSITU_ERROR_ARGUMENT, "null");
  refused(some_levels(2, 1.0 / 3.0), INSITU_ERROR_UNSUPPORTED, "spacing 0.333333 of level 1");
  Trees trees;
  trees.grid->SetBranchFactor(3);
  refused(trees.grid, INSITU_ERROR_UNSUPPORTED, "branch factor 3");
  Trees stretched;
  vtkNew<vtkDoubleArray> x;
  for (const double c : {0.0, 1.0, 2.5})
    x->InsertNextValue(c);
  stretched.grid->SetXCoordinates(x);
  refused(stretched.grid, INSITU_ERROR_UNSUPPORTED, "trees must be equal");
  insitu::vtk::AttachOptions options;
  options.piece = 1;
  expect_refused(INSITU_ERROR_ARGUMENT, "piece: 1",
                 [&] { (void)insitu::vtk::attach_adaptive(mesh, two_levels(), options); });
}
