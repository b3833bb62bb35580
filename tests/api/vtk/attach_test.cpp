/// What attach() gives to the mesh: pointers, ghosts, conversions, refusals, updates.

#include <gtest/gtest.h>
#include <map>
#include <vtkCellArray.h>
#include <vtkDataSetAttributes.h>
#include <vtkGenericDataArray.h>
#include <vtkIntArray.h>
#include <vtkObjectFactory.h>
#include <vtkPolyData.h>
#include <vtkQuadraticTetra.h>
#include <vtkRectilinearGrid.h>
#include <vtkSOADataArrayTemplate.h>
#include <vtkStringArray.h>
#include <vtkTypeInt64Array.h>
#include <vtkUnsignedCharArray.h>

#include "insitu/vtk.hpp"

#include "meshes.h"

using namespace vtk_meshes;

namespace {

std::map<std::string, insitu::AuditEntry> audit_of(const insitu::Mesh& mesh) {
  std::map<std::string, insitu::AuditEntry> out;
  for (const insitu::AuditEntry& e : mesh.audit())
    out[e.name] = e;
  return out;
}

void expect_borrowed(const std::map<std::string, insitu::AuditEntry>& audit,
                     const std::string& name, const void* pointer) {
  const auto at = audit.find(name);
  ASSERT_NE(at, audit.end()) << name;
  EXPECT_EQ(at->second.data, pointer) << name;
  EXPECT_EQ(at->second.borrowed, 1) << name;
}

struct VtkAttach : testing::Test {
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
};

/// Twice the index, stored nowhere.
class Computed : public vtkGenericDataArray<Computed, double> {
public:
  using Base = vtkGenericDataArray<Computed, double>;
  vtkTemplateTypeMacro(Computed, Base) static Computed* New() { VTK_STANDARD_NEW_BODY(Computed); }
  double GetValue(vtkIdType i) const { return 2.0 * double(i); }
  void SetValue(vtkIdType, double) {}
  void GetTypedTuple(vtkIdType i, double* out) const { *out = GetValue(i); }
  void SetTypedTuple(vtkIdType, const double*) {}
  double GetTypedComponent(vtkIdType i, int) const { return GetValue(i); }
  void SetTypedComponent(vtkIdType, int, double) {}

protected:
  bool AllocateTuples(vtkIdType) { return true; }
  bool ReallocateTuples(vtkIdType) { return true; }
  friend class vtkGenericDataArray<Computed, double>;
};

insitu_status status_of(const std::function<void()>& call, std::string* what = nullptr) {
  try {
    call();
  } catch (const insitu::Error& e) {
    if (what)
      *what = e.what();
    return e.status();
  }
  return INSITU_OK;
}

} // namespace

TEST_F(VtkAttach, OneShapeIsReadInPlace) {
  for (const bool wide : {true, false}) {
    const auto grid = unstructured(3, {VTK_HEXAHEDRON}, 0.1);
    wide ? grid->GetCells()->ConvertTo64BitStorage() : grid->GetCells()->ConvertTo32BitStorage();
    const auto attachment = insitu::vtk::attach(mesh, grid);
    mesh.commit();
    const auto audit = audit_of(mesh);
    expect_borrowed(audit, "piece 0 points", grid->GetPoints()->GetVoidPointer(0));
    expect_borrowed(audit, "piece 0 connectivity",
                    grid->GetCells()->GetConnectivityArray()->GetVoidPointer(0));
    EXPECT_EQ(audit.at("piece 0 connectivity").bytes, 27 * 8 * (wide ? 8 : 4));
    EXPECT_EQ(audit.count("piece 0 types"), 0u);
    expect_borrowed(audit, "piece 0 field 'linear'",
                    grid->GetPointData()->GetArray("linear")->GetVoidPointer(0));
    expect_borrowed(audit, "piece 0 field 'velocity'",
                    grid->GetPointData()->GetArray("velocity")->GetVoidPointer(0));
    expect_borrowed(audit, "piece 0 field 'number'",
                    grid->GetCellData()->GetArray("number")->GetVoidPointer(0));
    EXPECT_TRUE(attachment.converted().empty());
    EXPECT_TRUE(attachment.skipped().empty());
  }
}

TEST_F(VtkAttach, SeveralShapesAreReadInPlace) {
  const auto grid = unstructured(3, {VTK_HEXAHEDRON, VTK_WEDGE}, 0.1);
  const auto attachment = insitu::vtk::attach(mesh, grid);
  mesh.commit();
  const auto audit = audit_of(mesh);
  expect_borrowed(audit, "piece 0 connectivity",
                  grid->GetCells()->GetConnectivityArray()->GetVoidPointer(0));
  expect_borrowed(audit, "piece 0 offsets", grid->GetCells()->GetOffsetsArray()->GetVoidPointer(0));
  expect_borrowed(audit, "piece 0 types", grid->GetCellTypesArray()->GetPointer(0));
}

TEST_F(VtkAttach, OneArrayAComponentIsReadInPlace) {
  const auto grid = structured(2, 0.0);
  vtkNew<vtkSOADataArrayTemplate<float>> field;
  field->SetName("w");
  field->SetNumberOfComponents(3);
  field->SetNumberOfTuples(grid->GetNumberOfPoints());
  field->Fill(1.0);
  grid->GetPointData()->AddArray(field);
  const auto attachment = insitu::vtk::attach(mesh, grid);
  mesh.commit();
  const auto audit = audit_of(mesh);
  for (int c = 0; c < 3; ++c)
    expect_borrowed(audit, "piece 0 field 'w' component " + std::to_string(c),
                    field->GetComponentArrayPointer(c));
}

TEST_F(VtkAttach, AxesOfTwoTypesAreConverted) {
  vtkNew<vtkRectilinearGrid> grid;
  grid->SetDimensions(3, 3, 3);
  vtkSmartPointer<vtkDataArray> axes[3];
  for (int a = 0; a < 3; ++a) {
    axes[a].TakeReference(vtkDataArray::CreateDataArray(a == 1 ? VTK_FLOAT : VTK_DOUBLE));
    for (int i = 0; i < 3; ++i)
      axes[a]->InsertNextTuple1(i);
  }
  grid->SetXCoordinates(axes[0]);
  grid->SetYCoordinates(axes[1]);
  grid->SetZCoordinates(axes[2]);
  const auto attachment = insitu::vtk::attach(mesh, grid);
  mesh.commit();
  const auto audit = audit_of(mesh);
  expect_borrowed(audit, "piece 0 axis 0", axes[0]->GetVoidPointer(0));
  expect_borrowed(audit, "piece 0 axis 2", axes[2]->GetVoidPointer(0));
  EXPECT_EQ(audit.at("piece 0 axis 1").borrowed, 0);
  ASSERT_EQ(attachment.converted().size(), 1u);
  EXPECT_EQ(attachment.converted()[0].array, "axis 1");
}

TEST_F(VtkAttach, GhostCellsOwnNothing) {
  const auto grid = unstructured(2, {VTK_HEXAHEDRON}, 0.0);
  vtkNew<vtkUnsignedCharArray> ghosts;
  ghosts->SetName(vtkDataSetAttributes::GhostArrayName());
  ghosts->SetNumberOfValues(8);
  ghosts->FillValue(0);
  ghosts->SetValue(0, vtkDataSetAttributes::DUPLICATECELL);
  ghosts->SetValue(3, vtkDataSetAttributes::HIDDENCELL);
  ghosts->SetValue(5, vtkDataSetAttributes::LOWCONNECTIVITYCELL); // no ghost
  grid->GetCellData()->AddArray(ghosts);
  const auto attachment = insitu::vtk::attach(mesh, grid);
  mesh.commit();
  expect_borrowed(audit_of(mesh), "piece 0 ghosts", ghosts->GetPointer(0));
  std::vector<double> middles;
  for (int c = 0; c < 8; ++c)
    for (const int i : {c % 2, c / 2 % 2, c / 4})
      middles.push_back(i + 0.5);
  const insitu::Locations at = mesh.locate(middles);
  const std::vector<std::int64_t> expected{-1, 1, 2, -1, 4, 5, 6, 7};
  EXPECT_EQ(at.cells, expected);
}

TEST_F(VtkAttach, IntegersAreConvertedAndSaySo) {
  const auto grid = unstructured(2, {VTK_HEXAHEDRON}, 0.0);
  vtkNew<vtkIntArray> material;
  material->SetName("material");
  for (int c = 0; c < 8; ++c)
    material->InsertNextValue(10 - c);
  grid->GetCellData()->AddArray(material);
  const auto attachment = insitu::vtk::attach(mesh, grid);
  mesh.commit();
  const insitu::AuditEntry entry = audit_of(mesh).at("piece 0 field 'material'");
  EXPECT_EQ(entry.borrowed, 0);
  EXPECT_STREQ(entry.reason, "integer values");
  ASSERT_EQ(attachment.converted().size(), 1u);
  EXPECT_EQ(attachment.converted()[0].array, "cell array 'material'");
  double value = 0;
  ASSERT_TRUE(mesh.sample_point("material", {1.5, 0.5, 1.5}, {&value, 1}));
  EXPECT_EQ(value, 5.0);

  insitu::Options strict;
  strict.strict = true;
  strict.log = [](insitu::LogLevel, const char*) {};
  insitu::Session strict_session(strict);
  insitu::Mesh strict_mesh = strict_session.mesh("m");
  const auto kept = insitu::vtk::attach(strict_mesh, grid);
  std::string what;
  EXPECT_EQ(status_of([&] { strict_mesh.commit(); }, &what), INSITU_ERROR_CONVERSION);
  EXPECT_NE(what.find("material"), std::string::npos) << what;

  insitu::vtk::AttachOptions in_place;
  in_place.convert = false;
  insitu::Session second(strict);
  insitu::Mesh other = second.mesh("m");
  const auto left = insitu::vtk::attach(other, grid, in_place);
  EXPECT_NO_THROW(other.commit());
  ASSERT_EQ(left.skipped().size(), 1u);
  EXPECT_EQ(left.skipped()[0].reason, "integer values");
}

TEST_F(VtkAttach, ImplicitArraysAreConverted) {
  const auto grid = unstructured(2, {VTK_HEXAHEDRON}, 0.0);
  vtkNew<Computed> scaled;
  scaled->SetName("scaled");
  scaled->SetNumberOfTuples(8);
  grid->GetCellData()->AddArray(scaled);
  const auto attachment = insitu::vtk::attach(mesh, grid);
  mesh.commit();
  EXPECT_EQ(audit_of(mesh).at("piece 0 field 'scaled'").borrowed, 0);
  double value = 0;
  ASSERT_TRUE(mesh.sample_point("scaled", {1.5, 1.5, 1.5}, {&value, 1}));
  EXPECT_EQ(value, 14.0);
  EXPECT_EQ(attachment.converted().size(), 1u);
}

TEST_F(VtkAttach, ArraysWithoutUseAreNamed) {
  const auto grid = unstructured(2, {VTK_HEXAHEDRON}, 0.0);
  vtkNew<vtkStringArray> words;
  words->SetName("words");
  words->SetNumberOfValues(8);
  grid->GetCellData()->AddArray(words);
  vtkNew<vtkDoubleArray> same_name;
  same_name->SetName("linear");
  same_name->SetNumberOfValues(8);
  grid->GetCellData()->AddArray(same_name);
  const auto attachment = insitu::vtk::attach(mesh, grid);
  ASSERT_EQ(attachment.skipped().size(), 2u);
  EXPECT_EQ(attachment.skipped()[0].array, "cell array 'words'");
  EXPECT_EQ(attachment.skipped()[1].array, "cell array 'linear'");
  mesh.commit();
  EXPECT_EQ(mesh.field_info("linear").association, insitu::Association::vertex);

  insitu::vtk::AttachOptions one;
  one.arrays = {"number"};
  insitu::Mesh few = session.mesh("few");
  const auto chosen = insitu::vtk::attach(few, grid, one);
  few.commit();
  EXPECT_EQ(few.field_info("number").association, insitu::Association::cell);
  EXPECT_EQ(status_of([&] { few.field_info("linear"); }), INSITU_ERROR_FIELD);
}

TEST_F(VtkAttach, OtherCellsAndDataSetsAreRefusedByName) {
  const auto grid = unstructured(2, {VTK_HEXAHEDRON}, 0.0);
  const vtkIdType ids[10] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
  grid->InsertNextCell(VTK_QUADRATIC_TETRA, 10, ids);
  std::string what;
  EXPECT_EQ(status_of([&] { (void)insitu::vtk::attach(mesh, grid); }, &what),
            INSITU_ERROR_UNSUPPORTED);
  EXPECT_NE(what.find("cell 8 is a vtkQuadraticTetra"), std::string::npos) << what;

  vtkNew<vtkPolyData> surface;
  surface->SetPoints(grid->GetPoints());
  vtkNew<vtkCellArray> polygons;
  polygons->InsertNextCell(5, ids);
  surface->SetPolys(polygons);
  EXPECT_EQ(status_of([&] { (void)insitu::vtk::attach(mesh, surface); }, &what),
            INSITU_ERROR_UNSUPPORTED);
  EXPECT_NE(what.find("cell 0 is a vtkPolygon"), std::string::npos) << what;

  vtkNew<vtkStructuredGrid> flat;
  flat->SetDimensions(3, 1, 3);
  vtkNew<vtkPoints> points;
  points->SetNumberOfPoints(9);
  flat->SetPoints(points);
  EXPECT_EQ(status_of([&] { (void)insitu::vtk::attach(mesh, flat); }, &what),
            INSITU_ERROR_UNSUPPORTED);
  EXPECT_NE(what.find("3 x 1 x 3"), std::string::npos) << what;
  EXPECT_EQ(status_of([&] { (void)insitu::vtk::attach(mesh, nullptr); }), INSITU_ERROR_ARGUMENT);
  EXPECT_TRUE(mesh.audit().empty()); // nothing of the refused sets was given
}

TEST_F(VtkAttach, ArraysThatAreTooShortAreRefused) {
  vtkNew<vtkUnstructuredGrid> grid;
  grid->SetPoints(grid_points(2, 0.0));
  vtkNew<vtkUnsignedCharArray> types;
  types->InsertNextValue(VTK_HEXAHEDRON);
  types->InsertNextValue(VTK_HEXAHEDRON);
  vtkNew<vtkTypeInt64Array> offsets, ids;
  for (const int o : {0, 8, 16})
    offsets->InsertNextValue(o);
  for (int i = 0; i < 12; ++i)
    ids->InsertNextValue(i);
  vtkNew<vtkCellArray> cells;
  cells->SetData(offsets, ids);
  grid->SetCells(types, cells);
  std::string what;
  EXPECT_EQ(status_of([&] { (void)insitu::vtk::attach(mesh, grid); }, &what), INSITU_ERROR_MESH);
  EXPECT_NE(what.find("connectivity holds 12"), std::string::npos) << what;
  types->SetNumberOfValues(1);
  EXPECT_EQ(status_of([&] { (void)insitu::vtk::attach(mesh, grid); }, &what), INSITU_ERROR_MESH);
  EXPECT_NE(what.find("1 cell types for 2 cells"), std::string::npos) << what;

  // Field values and ghosts are counted at the commit.
  const auto whole = unstructured(2, {VTK_HEXAHEDRON}, 0.0);
  whole->GetCellData()->GetArray("number")->SetNumberOfTuples(7);
  const auto attachment = insitu::vtk::attach(mesh, whole);
  EXPECT_EQ(status_of([&] { mesh.commit(); }, &what), INSITU_ERROR_FIELD);
  EXPECT_NE(what.find("7 values for 8 cells"), std::string::npos) << what;
}

TEST_F(VtkAttach, UpdateSaysWhatChanged) {
  auto grid = unstructured(3, {VTK_HEXAHEDRON}, 0.1);
  auto attachment = insitu::vtk::attach(mesh, grid);
  EXPECT_EQ(mesh.commit().action, INSITU_REBUILD);

  // An equal data set: nothing to do, and the arrays of the first stay alive and in use.
  vtkNew<vtkUnstructuredGrid> equal;
  equal->DeepCopy(grid);
  const void* first = grid->GetPoints()->GetVoidPointer(0);
  grid = nullptr;
  EXPECT_EQ(attachment.update(equal), insitu::Change{});
  EXPECT_EQ(mesh.commit().action, INSITU_KEEP);
  expect_borrowed(audit_of(mesh), "piece 0 points", first);

  // Moved points and a changed field in place, said by Modified().
  vtkNew<vtkUnstructuredGrid> moved;
  moved->DeepCopy(equal);
  moved->GetPoints()->SetPoint(21, 1.05, 1.02, 1.01);
  EXPECT_EQ(attachment.update(moved), insitu::geometry);
  EXPECT_EQ(mesh.commit().action, INSITU_REFIT);
  expect_borrowed(audit_of(mesh), "piece 0 points", moved->GetPoints()->GetVoidPointer(0));
  vtkDataArray* number = moved->GetCellData()->GetArray("number");
  EXPECT_EQ(attachment.update(moved), insitu::Change{});
  number->SetTuple1(0, -5.0);
  number->Modified();
  EXPECT_EQ(attachment.update(moved), insitu::fields);
  mesh.commit();
  double value = 0;
  ASSERT_TRUE(mesh.sample_point("number", {0.2, 0.2, 0.2}, {&value, 1}));
  EXPECT_EQ(value, -5.0);
  moved->GetPoints()->Modified();
  EXPECT_EQ(attachment.update(moved), insitu::geometry);

  // A field that goes, and cells that change.
  moved->GetPointData()->RemoveArray("velocity");
  EXPECT_EQ(attachment.update(moved), insitu::fields);
  mesh.commit();
  EXPECT_EQ(status_of([&] { mesh.field_info("velocity"); }), INSITU_ERROR_FIELD);
  const auto wedges = unstructured(3, {VTK_WEDGE}, 0.1);
  EXPECT_EQ(attachment.update(wedges), insitu::everything);
  EXPECT_EQ(mesh.commit().action, INSITU_REBUILD);
  EXPECT_EQ(mesh.locate(std::vector<double>{0.2, 0.1, 0.2}).found[0], 1);
}

TEST_F(VtkAttach, TheDataSetMayGo) {
  auto grid = unstructured(3, {VTK_TETRA}, 0.1);
  const std::vector<double> xyz = query_points(grid, 50);
  const auto attachment = insitu::vtk::attach(mesh, grid);
  grid = nullptr;
  mesh.commit();
  const insitu::Samples s = mesh.sample("linear", xyz);
  for (std::size_t q = 0; q < s.size(); ++q)
    if (s.found[q]) {
      EXPECT_NEAR(s(q), linear({xyz[3 * q], xyz[3 * q + 1], xyz[3 * q + 2]}), 1e-11);
    }
}

TEST_F(VtkAttach, PiecesFormOneMesh) {
  const auto left = unstructured(2, {VTK_HEXAHEDRON}, 0.1);
  const auto right = structured(2, 0.1);
  for (vtkIdType i = 0; i < right->GetNumberOfPoints(); ++i) {
    Point p = point_of(right, i);
    p[0] += 2.0;
    right->GetPoints()->SetPoint(i, p.data());
  }
  const auto first = insitu::vtk::attach(mesh, left);
  insitu::vtk::AttachOptions second;
  second.piece = 1;
  const auto other = insitu::vtk::attach(mesh, right, second);
  mesh.commit();
  const insitu::Locations at = mesh.locate(std::vector<double>{0.5, 0.5, 0.5, 3.5, 1.5, 1.5});
  EXPECT_EQ(at.pieces, (std::vector<std::int32_t>{0, 1}));
  EXPECT_EQ(at.cells, (std::vector<std::int64_t>{0, 7}));
}

TEST_F(VtkAttach, EmptyGrid) {
  vtkNew<vtkUnstructuredGrid> empty;
  const auto attachment = insitu::vtk::attach(mesh, empty);
  mesh.commit();
  EXPECT_EQ(mesh.locate(std::vector<double>{0, 0, 0}).found[0], 0);
}
