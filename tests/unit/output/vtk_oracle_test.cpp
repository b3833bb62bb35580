// What we write, read by VTK.

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkFieldData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkXMLPolyDataReader.h>

#include "output/vtk/xml_vtk.h"
#include "unit/output/folder.h"

namespace {

using namespace insitu::output;
using test::Folder;

TEST(VtkOracle, Particles) {
  const Folder folder;
  const std::size_t count = 3000; // more than a chunk of the counted arrays
  std::vector<float> xyz;
  std::vector<std::int64_t> id;
  std::vector<double> velocity;
  std::vector<std::uint8_t> reason;
  for (std::size_t i = 0; i < count; ++i) {
    for (int k = 0; k < 3; ++k) {
      xyz.push_back(float(i) + 0.25f * float(k));
      velocity.push_back(-double(i) * k);
    }
    id.push_back(std::int64_t(i) + (std::int64_t(1) << 40));
    reason.push_back(std::uint8_t(i % 5));
  }
  velocity[3] = std::nan("");
  VtkPolyData data;
  data.points = vtk_array("whatever", xyz, 3);
  data.point_data = {vtk_array("id", id), vtk_array("velocity <m/s>", velocity, 3)};
  data.cell_data = {vtk_array("reason", reason)};
  data.has_time = true;
  data.time = 0.1;
  write_vtp(folder / "p.vtp", data);

  vtkNew<vtkXMLPolyDataReader> reader;
  reader->SetFileName((folder / "p.vtp").c_str());
  reader->Update();
  vtkPolyData* read = reader->GetOutput();
  ASSERT_EQ(read->GetNumberOfPoints(), vtkIdType(count));
  ASSERT_EQ(read->GetNumberOfVerts(), vtkIdType(count));
  ASSERT_EQ(read->GetNumberOfLines(), 0);
  vtkDataArray* ids = read->GetPointData()->GetArray("id");
  vtkDataArray* velocities = read->GetPointData()->GetArray("velocity <m/s>");
  vtkDataArray* reasons = read->GetCellData()->GetArray("reason");
  ASSERT_NE(ids, nullptr);
  ASSERT_NE(velocities, nullptr);
  ASSERT_NE(reasons, nullptr);
  for (std::size_t i = 0; i < count; ++i) {
    const vtkIdType v = vtkIdType(i);
    ASSERT_EQ(read->GetPoint(v)[2], xyz[3 * i + 2]);
    ASSERT_EQ(ids->GetTuple1(v), double(id[i]));
    ASSERT_EQ(velocities->GetComponent(v, 2), velocity[3 * i + 2]);
    ASSERT_EQ(reasons->GetTuple1(v), reason[i]);
    vtkIdType points = 0;
    const vtkIdType* cell = nullptr;
    read->GetCellPoints(v, points, cell);
    ASSERT_EQ(points, 1);
    ASSERT_EQ(cell[0], v);
  }
  EXPECT_TRUE(std::isnan(velocities->GetComponent(1, 0)));
  vtkDataArray* time = read->GetFieldData()->GetArray("TimeValue");
  ASSERT_NE(time, nullptr);
  EXPECT_EQ(time->GetTuple1(0), 0.1);
}

TEST(VtkOracle, Tracks) {
  const Folder folder;
  const std::vector<double> xyz{0, 0, 0, 1, 0, 0, 2, 0, 0, 9, 9, 9, 5, 5, 5, 6, 6, 6};
  const std::vector<std::int64_t> ends{3, 4, 6}, shuffled{2, 1, 0, 3, 5, 4};
  const std::vector<double> length{2, 0, std::sqrt(3.0)};
  for (const bool indexed : {false, true}) {
    VtkPolyData data;
    data.points = vtk_array("Points", xyz, 3);
    data.line_ends = ends;
    if (indexed) {
      data.line_points = shuffled;
    }
    data.cell_data = {vtk_array("length", length)};
    write_vtp(folder / "t.vtp", data);
    vtkNew<vtkXMLPolyDataReader> reader;
    reader->SetFileName((folder / "t.vtp").c_str());
    reader->Update();
    vtkPolyData* read = reader->GetOutput();
    ASSERT_EQ(read->GetNumberOfVerts(), 0);
    ASSERT_EQ(read->GetNumberOfLines(), 3);
    std::int64_t at = 0;
    for (vtkIdType line = 0; line < 3; ++line) {
      vtkIdType points = 0;
      const vtkIdType* cell = nullptr;
      read->GetCellPoints(line, points, cell);
      const std::int64_t given = ends[std::size_t(line)] - at;
      ASSERT_EQ(points,
                std::max<std::int64_t>(given, 2)); // VTK's polylines have two points or more
      for (vtkIdType k = 0; k < points; ++k) {
        const std::int64_t from = at + std::min<std::int64_t>(k, given - 1);
        EXPECT_EQ(cell[k], indexed ? shuffled[std::size_t(from)] : from);
      }
      at += given;
      EXPECT_EQ(read->GetCellData()->GetArray("length")->GetTuple1(line),
                length[std::size_t(line)]);
    }
  }
}

TEST(VtkOracle, Surfaces) {
  const Folder folder;
  const std::vector<double> xyz{0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 1, 0, 1, 1, 0, 2, 1, 0};
  const std::vector<std::int64_t> quads{0, 1, 4, 3, 1, 2, 5, 4}, line{3};
  const std::vector<double> value{7, 8, 9};
  VtkPolyData data;
  data.points = vtk_array("Points", xyz, 3);
  data.quads = quads;
  data.cell_data = {vtk_array("value", std::span<const double>(value).first(2))};
  for (const bool lines : {false, true}) {
    const std::vector<std::int64_t> ids{5, 4, 3};
    if (lines) {
      data.line_ends = line;
      data.line_points = ids;
      data.cell_data = {vtk_array("value", value)};
    }
    write_vtp(folder / "s.vtp", data);
    vtkNew<vtkXMLPolyDataReader> reader;
    reader->SetFileName((folder / "s.vtp").c_str());
    reader->Update();
    vtkPolyData* read = reader->GetOutput();
    ASSERT_EQ(read->GetNumberOfVerts(), 0);
    ASSERT_EQ(read->GetNumberOfLines(), lines ? 1 : 0);
    ASSERT_EQ(read->GetNumberOfPolys(), 2);
    for (vtkIdType q = 0; q < 2; ++q) {
      vtkIdType points = 0;
      const vtkIdType* cell = nullptr;
      read->GetCellPoints(q + (lines ? 1 : 0), points, cell);
      ASSERT_EQ(points, 4);
      for (vtkIdType k = 0; k < 4; ++k)
        EXPECT_EQ(cell[k], quads[std::size_t(4 * q + k)]);
    }
    EXPECT_EQ(read->GetCellData()->GetArray("value")->GetTuple1(1), 8);
  }
}

TEST(VtkOracle, Empty) {
  const Folder folder;
  VtkPolyData none;
  none.points = vtk_array("Points", std::span<const double>(), 3);
  write_vtp(folder / "e.vtp", none);
  vtkNew<vtkXMLPolyDataReader> reader;
  reader->SetFileName((folder / "e.vtp").c_str());
  reader->Update();
  EXPECT_EQ(reader->GetErrorCode(), 0u);
  EXPECT_EQ(reader->GetOutput()->GetNumberOfPoints(), 0);
}

} // namespace
