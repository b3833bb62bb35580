/// Files that VTK reads back.

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <unistd.h>
#include <vtkCellArray.h>
#include <vtkPolyData.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLPolyDataReader.h>
#include <vtkXMLUnstructuredGridReader.h>
#include <vtkXMLUtilities.h>

#include "insitu/vtk.hpp"

#include "meshes.h"

namespace fs = std::filesystem;
using namespace vtk_meshes;

namespace {

struct VtkWrite : testing::Test {
  fs::path folder = fs::path(testing::TempDir()) / ("insitu_vtk_write_" + std::to_string(getpid()));
  void SetUp() override {
    fs::remove_all(folder);
    fs::create_directories(folder);
  }
  void TearDown() override { fs::remove_all(folder); }
  std::string file(const std::string& name) const { return (folder / name).string(); }
  std::size_t files() const {
    return std::size_t(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
  }
};

insitu_status status_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const insitu::Error& e) {
    return e.status();
  }
  return INSITU_OK;
}

} // namespace

TEST_F(VtkWrite, SampledPoints) {
  const auto grid = unstructured(3, {VTK_HEXAHEDRON}, 0.1);
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
  const auto attachment = insitu::vtk::attach(mesh, grid);
  mesh.commit();
  const std::vector<double> xyz = query_points(grid, 40);
  const insitu::FieldSamples samples = mesh.sample_fields({"linear", "velocity"}, xyz);
  insitu::vtk::write(file("points.vtp"), insitu::vtk::sampled_points(xyz, samples));
  EXPECT_EQ(files(), 1u);

  vtkNew<vtkXMLPolyDataReader> reader;
  reader->SetFileName(file("points.vtp").c_str());
  reader->Update();
  vtkPolyData* read = reader->GetOutput();
  ASSERT_EQ(read->GetNumberOfPoints(), 40);
  EXPECT_EQ(read->GetNumberOfVerts(), 40);
  vtkPointData* data = read->GetPointData();
  for (vtkIdType i = 0; i < 40; ++i) {
    const auto q = std::size_t(i);
    for (int c = 0; c < 3; ++c)
      EXPECT_EQ(read->GetPoint(i)[c], xyz[3 * q + std::size_t(c)]);
    EXPECT_EQ(data->GetArray("found")->GetTuple1(i), samples.found[q]);
    EXPECT_EQ(data->GetArray("cell")->GetTuple1(i), double(samples.cells[q]));
    if (samples.found[q]) {
      EXPECT_EQ(data->GetArray("linear")->GetTuple1(i), samples.values[0].values[q]);
      EXPECT_EQ(data->GetArray("velocity")->GetComponent(i, 2),
                samples.values[1].values[3 * q + 2]);
    } else {
      EXPECT_TRUE(std::isnan(data->GetArray("linear")->GetTuple1(i)));
    }
  }
}

TEST_F(VtkWrite, Tracks) {
  // Lines of three points, none, one and two.
  const std::vector<double> xyz{0, 0, 0, 1, 0, 0, 2, 1, 0, 9, 9, 9, 5, 5, 5, 6, 5, 5};
  const std::vector<std::int64_t> ends{3, 3, 4, 6};
  insitu::vtk::write(file("tracks.vtp"),
                     insitu::vtk::tracks(xyz, ends, {{"time", 1, {0, 0.5, 1, 0, 0, 0.5}}}));
  vtkNew<vtkXMLPolyDataReader> reader;
  reader->SetFileName(file("tracks.vtp").c_str());
  reader->Update();
  vtkPolyData* read = reader->GetOutput();
  ASSERT_EQ(read->GetNumberOfLines(), 2);
  vtkNew<vtkIdList> ids;
  read->GetLines()->GetCellAtId(1, ids);
  ASSERT_EQ(ids->GetNumberOfIds(), 2);
  EXPECT_EQ(ids->GetId(0), 4);
  ASSERT_EQ(read->GetNumberOfVerts(), 1);
  read->GetVerts()->GetCellAtId(0, ids);
  EXPECT_EQ(ids->GetId(0), 3);
  EXPECT_EQ(read->GetPointData()->GetArray("time")->GetTuple1(2), 1.0);

  const std::vector<std::int64_t> backwards{3, 2, 6}, few{3};
  EXPECT_EQ(status_of([&] { insitu::vtk::tracks(xyz, backwards); }), INSITU_ERROR_ARGUMENT);
  EXPECT_EQ(status_of([&] { insitu::vtk::tracks(xyz, few); }), INSITU_ERROR_ARGUMENT);
  EXPECT_EQ(status_of([&] {
              insitu::vtk::tracks(xyz, ends, {{"t", 1, {0, 1}}});
            }),
            INSITU_ERROR_ARGUMENT);
}

TEST_F(VtkWrite, MeshesAndTheirExtensions) {
  const auto grid = unstructured(2, {VTK_TETRA}, 0.1);
  insitu::vtk::write(file("mesh.vtu"), grid);
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  reader->SetFileName(file("mesh.vtu").c_str());
  reader->Update();
  EXPECT_EQ(reader->GetOutput()->GetNumberOfCells(), grid->GetNumberOfCells());
  EXPECT_EQ(status_of([&] { insitu::vtk::write(file("mesh.vts"), grid); }), INSITU_ERROR_ARGUMENT);
  EXPECT_EQ(status_of([&] { insitu::vtk::write(file("absent/mesh.vtu"), grid); }),
            INSITU_ERROR_FILE);
  fs::create_directory(folder / "folder.vtu");
  EXPECT_EQ(status_of([&] { insitu::vtk::write(file("folder.vtu"), grid); }), INSITU_ERROR_FILE);
  EXPECT_EQ(files(), 2u); // no unfinished files
}

TEST_F(VtkWrite, SeriesInTime) {
  insitu::vtk::Series series(file("run.pvd"));
  series.add(0.0, "a & b.vtu");
  series.add(0.1, "c.vtu", 1);
  const auto root = vtkSmartPointer<vtkXMLDataElement>::Take(
      vtkXMLUtilities::ReadElementFromFile(file("run.pvd").c_str()));
  ASSERT_TRUE(root);
  vtkXMLDataElement* collection = root->FindNestedElementWithName("Collection");
  ASSERT_EQ(collection->GetNumberOfNestedElements(), 2);
  EXPECT_STREQ(collection->GetNestedElement(0)->GetAttribute("file"), "a & b.vtu");
  EXPECT_STREQ(collection->GetNestedElement(1)->GetAttribute("timestep"), "0.1");
  EXPECT_STREQ(collection->GetNestedElement(1)->GetAttribute("part"), "1");
  EXPECT_EQ(files(), 1u);
  insitu::vtk::Series nowhere(file("absent/run.pvd"));
  EXPECT_EQ(status_of([&] { nowhere.add(0, "x.vtu"); }), INSITU_ERROR_FILE);
}
