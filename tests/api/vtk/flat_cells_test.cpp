/// Cells without volume beside cells of volume, ghosts of other types than bytes, and data sets
/// without cells.

#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>
#include <unistd.h>
#include <vtkCellData.h>
#include <vtkImageData.h>
#include <vtkSignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include "insitu/vtk.hpp"

#include "meshes.h"

using namespace vtk_meshes;

namespace {

/// A 2^3 mesh with faces before, lines among and a vertex behind the cells of volume; `number` is
/// the cell's number in the file.
vtkSmartPointer<vtkUnstructuredGrid> with_flat_cells(const std::vector<int>& types) {
  const auto volume = unstructured(2, types, 0.1);
  auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  grid->SetPoints(volume->GetPoints());
  grid->GetPointData()->ShallowCopy(volume->GetPointData());
  const vtkIdType quad[4] = {0, 1, 4, 3}, far_away[2] = {0, 26};
  grid->InsertNextCell(VTK_QUAD, 4, quad);
  grid->InsertNextCell(VTK_TRIANGLE, 3, quad);
  for (vtkIdType c = 0; c < volume->GetNumberOfCells(); ++c) {
    vtkIdType n = 0;
    const vtkIdType* ids = nullptr;
    volume->GetCellPoints(c, n, ids);
    grid->InsertNextCell(volume->GetCellType(c), n, ids);
    if (c % 3 == 1)
      grid->InsertNextCell(VTK_LINE, 2, far_away);
  }
  grid->InsertNextCell(VTK_VERTEX, 1, far_away);
  vtkNew<vtkDoubleArray> number;
  number->SetName("number");
  for (vtkIdType c = 0; c < grid->GetNumberOfCells(); ++c)
    number->InsertNextValue(grid->GetCell(c)->GetCellDimension() < 3 ? 1e30 : double(c));
  grid->GetCellData()->AddArray(number);
  return grid;
}

TEST(FlatCells, BesideVolumesAreLeftOutWithTheirCounts) {
  for (const std::vector<int>& types :
       {std::vector<int>{VTK_HEXAHEDRON}, std::vector<int>{VTK_TETRA, VTK_WEDGE, VTK_PYRAMID}}) {
    const auto grid = with_flat_cells(types);
    insitu::Session session;
    insitu::Mesh mesh = session.mesh("m"), plain = session.mesh("plain");
    auto attached = insitu::vtk::attach(mesh, grid);
    const auto volume = unstructured(2, types, 0.1);
    const auto alone = insitu::vtk::attach(plain, volume);
    mesh.commit();
    plain.commit();
    ASSERT_EQ(attached.skipped().size(), 1u);
    EXPECT_NE(attached.skipped()[0].array.find("1 vtkQuad"), std::string::npos)
        << attached.skipped()[0].array;
    EXPECT_NE(attached.skipped()[0].array.find("1 vtkTriangle"), std::string::npos);
    Random random(3);
    std::vector<double> xyz;
    for (int i = 0; i < 900; ++i)
      xyz.push_back(2.2 * random() - 0.1);
    xyz.insert(xyz.end(), {0, 0, 0, 0.5, 0.5, 0, 2, 2, 2}); // on what is left out
    const insitu::Samples with = mesh.sample("linear", xyz), without = plain.sample("linear", xyz);
    const insitu::Samples numbers = mesh.sample("number", xyz);
    for (std::size_t i = 0; i < xyz.size() / 3; ++i) {
      ASSERT_EQ(bool(with.found[i]), bool(without.found[i])) << i;
      if (!with.found[i])
        continue;
      EXPECT_EQ(with.values[i], without.values[i]) << i;
      EXPECT_EQ(numbers.values[i], double(with.cells[i])) << i; // numbers are the file's
    }
    EXPECT_FALSE(attached.update(grid)); // the same again: nothing changed
    EXPECT_TRUE(mesh.validate().accepted);
  }
}

TEST(FlatCells, AreNotDrawnFollowedOrAveraged) {
  const auto folder =
      std::filesystem::path(testing::TempDir()) / ("insitu_flat_" + std::to_string(getpid()));
  insitu::Options options;
  options.output = folder.string();
  options.scene_text =
      "insitu: 1\nprobes:\n  - {name: p, points: [[0.5, 0.5, 0.5]]}\n"
      "frames:\n  - {name: v, size: [16, 16], volume: {field: number}}\n"
      "  - {name: i, size: [16, 16], isosurfaces: [{field: number, values: [4]}]}\n"
      "  - {name: b, size: [16, 16], boundary: {color: {field: number}}}\n"
      "  - {name: w, size: [16, 16], volume: {field: linear}, when: max(number) > "
      "1e20}\n";
  insitu::Session session(options);
  insitu::Mesh mesh = session.mesh("m");
  const auto attached = insitu::vtk::attach(mesh, with_flat_cells({VTK_HEXAHEDRON}));
  EXPECT_TRUE(session.execute(0, 0.0)) << insitu_last_message();
  EXPECT_EQ(session.report().frames, 3); // that of the condition is not due
  session.close();
  std::filesystem::remove_all(folder);
}

TEST(FlatCells, WithoutAreaAloneAreRefused) {
  vtkNew<vtkUnstructuredGrid> grid;
  grid->SetPoints(grid_points(1, 0.0));
  const vtkIdType ids[3] = {0, 1, 2};
  grid->InsertNextCell(VTK_LINE, 2, ids);
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
  try {
    (void)insitu::vtk::attach(mesh, grid);
    FAIL();
  } catch (const insitu::Error& e) {
    EXPECT_EQ(e.status(), INSITU_ERROR_UNSUPPORTED);
    EXPECT_NE(std::string(e.what()).find("cell 0 is a vtkLine"), std::string::npos) << e.what();
  }
}

TEST(Ghosts, OfAnotherTypeAreConverted) {
  const auto grid = unstructured(2, {VTK_HEXAHEDRON}, 0.0);
  vtkNew<vtkSignedCharArray> ghosts;
  ghosts->SetName("vtkGhostType");
  for (vtkIdType c = 0; c < grid->GetNumberOfCells(); ++c)
    ghosts->InsertNextValue(c == 0 ? 1 : 0);
  grid->GetCellData()->AddArray(ghosts);
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
  auto attached = insitu::vtk::attach(mesh, grid);
  mesh.commit();
  ASSERT_EQ(attached.converted().size(), 1u);
  EXPECT_EQ(attached.converted()[0].array, "cell array 'vtkGhostType'");
  const std::vector<double> xyz{0.5, 0.5, 0.5, 1.5, 0.5, 0.5};
  EXPECT_EQ(mesh.locate(xyz).found[0], 0);
  EXPECT_EQ(mesh.locate(xyz).found[1], 1);
  EXPECT_FALSE(attached.update(grid));
  vtkNew<vtkDoubleArray> no_bits;
  no_bits->SetName("vtkGhostType");
  for (vtkIdType c = 0; c < grid->GetNumberOfCells(); ++c)
    no_bits->InsertNextValue(0.5);
  grid->GetCellData()->AddArray(no_bits);
  EXPECT_THROW(attached.update(grid), insitu::Error);
}

TEST(NoCells, AreNoErrorAndKeepTheOthersFields) {
  vtkNew<vtkUnstructuredGrid> nothing;
  vtkNew<vtkImageData> no_image;
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
  const auto full = unstructured(2, {VTK_HEXAHEDRON}, 0.0);
  auto first = insitu::vtk::attach(mesh, no_image);
  insitu::vtk::AttachOptions second_piece;
  second_piece.piece = 1;
  auto second = insitu::vtk::attach(mesh, full, second_piece);
  mesh.commit();
  const std::vector<double> at{0.5, 0.5, 0.5};
  EXPECT_NEAR(mesh.sample("linear", at).values[0], linear({0.5, 0.5, 0.5}), 1e-12);
  first.update(full);
  second.update(nothing);
  mesh.commit();
  EXPECT_NEAR(mesh.sample("linear", at).values[0], linear({0.5, 0.5, 0.5}), 1e-12);
  EXPECT_EQ(mesh.sample("linear", at).pieces[0], 0);
  first.update(nothing);
  mesh.commit();
  EXPECT_EQ(mesh.locate(at).found[0], 0);
  second.update(full);
  mesh.commit();
  EXPECT_EQ(mesh.sample("linear", at).pieces[0], 1);
}

} // namespace
