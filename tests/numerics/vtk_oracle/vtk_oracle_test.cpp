// VTK as an oracle: vtkStaticCellLocator and the cells' EvaluatePosition on jittered meshes of
// every shape. Where the two name different cells, exact containment says who is right.
#include <cstdio>
#include <vtkCell.h>
#include <vtkCellArray.h>
#include <vtkDoubleArray.h>
#include <vtkGenericCell.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkStaticCellLocator.h>
#include <vtkUnstructuredGrid.h>

#include "../../unit/query/query_test.h"
#include "cells/kernels/faces.h"

using namespace insitu;
using cells::Containment;
using math::Vec3d;

namespace {

vtkNew<vtkUnstructuredGrid> grid_of(const test::TestMesh& mesh) {
  vtkNew<vtkUnstructuredGrid> grid;
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (const Vec3d& p : mesh.vertices)
    points->InsertNextPoint(p.x, p.y, p.z);
  grid->SetPoints(points);
  grid->Allocate(vtkIdType(mesh.cells.size()));
  for (const test::MeshCell& cell : mesh.cells) {
    vtkIdType ids[8];
    const int n = mesh::vertex_count(cell.shape);
    std::copy_n(cell.vertices.begin(), n, ids);
    grid->InsertNextCell(int(cell.shape), n, ids);
  }
  return grid;
}

/// Not linear, and of order one.
double field(const Vec3d& p) {
  return std::sin(p.x) + std::cos(1.3 * p.y) * p.z;
}

Containment where(const mesh::MeshView& view, std::int64_t c, const Vec3d& p) {
  mesh::CellVertices cell;
  mesh::gather(view, c, cell);
  return cells::contain_exact(cell.shape, cell.x, p).where;
}

struct Comparison {
  int points = 0, same = 0;
  int ties = 0;      ///< VTK names another cell that holds the point as well, on its boundary
  int vtk_wrong = 0; ///< VTK names a cell that does not hold the point
  int vtk_lost = 0;  ///< VTK finds nothing
  double worst = 0;  ///< difference of values, where the cells are the same
  double worst_vtk_map = 0, worst_our_map = 0; ///< distance from the point to where r, s, t lead
};

Comparison compare(test::MeshKind kind, double jitter, const std::string& what) {
  const test::TestMesh from = test::box(kind, 12, jitter);
  fixtures::Committed m(from);
  std::vector<double> f;
  for (const Vec3d& p : from.vertices)
    f.push_back(field(p));
  const insitu_array a = insitu_array_of(f.data(), INSITU_FLOAT64, m.arrays.vertex_count(), 1);
  m.mesh.mesh().set_field(0, "f", INSITU_VERTEX, &a, 1);
  m.commit();
  const mesh::MeshView& view = m.mesh.mesh().view();
  const mesh::FieldView values = m.mesh.mesh().field("f");

  const vtkNew<vtkUnstructuredGrid> grid = grid_of(from);
  vtkNew<vtkStaticCellLocator> locator;
  locator->SetDataSet(grid);
  locator->BuildLocator();
  vtkNew<vtkGenericCell> cell;

  Comparison c;
  std::vector<Vec3d> points = test::inner_points(view, 20000, 81);
  const std::vector<Vec3d> hard = test::hard_points(view, 5000, 82);
  const std::size_t generic = points.size();
  points.insert(points.end(), hard.begin(), hard.end());
  std::vector<query::Location> ours(points.size());
  m.sampler().locate(m.threads, points, ours);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3d& p = points[i];
    double x[3] = {p.x, p.y, p.z}, r[3], weights[8];
    const vtkIdType theirs = locator->FindCell(x, 0.0, cell, r, weights);
    const bool is_generic = i < generic; // the counts are of generic points
    c.points += is_generic;
    if (theirs < 0) {
      c.vtk_lost += is_generic && ours[i];
      continue;
    }
    if (!ours[i] || theirs != ours[i].cell) {
      const Containment in_theirs = where(view, theirs, p);
      c.ties += is_generic && cells::holds(in_theirs);
      c.vtk_wrong += is_generic && !cells::holds(in_theirs);
      // Theirs may hold it on its boundary, but then not with the lowest id; or not hold it.
      EXPECT_NE(in_theirs, Containment::inside) << what << " " << test::text(p);
      if (cells::holds(in_theirs)) {
        EXPECT_TRUE(ours[i] && ours[i].cell < theirs) << what << " " << test::text(p);
      }
      continue;
    }
    c.same += is_generic;
    double sum = 0, own_sum = 0, value = 0, own_weights[8];
    double own[3] = {ours[i].parametric.x, ours[i].parametric.y, ours[i].parametric.z};
    cell->InterpolateFunctions(own, own_weights);
    const vtkIdType* ids = nullptr;
    vtkIdType n = 0;
    grid->GetCells()->GetCellAtId(theirs, n, ids);
    for (vtkIdType v = 0; v < n; ++v) {
      sum += weights[v] * f[std::size_t(ids[v])];
      own_sum += own_weights[v] * f[std::size_t(ids[v])];
    }
    m.sampler().interpolate(values, ours[i], &value);
    // VTK's interpolation at our place is ours; at VTK's own place it differs as its Newton does,
    // which stops at steps of 1e-3. The field's slope is 16 at most, a cell's map steeper.
    EXPECT_NEAR(value, own_sum, 1e-12) << what << " " << test::text(p);
    mesh::CellVertices vertices;
    mesh::gather(view, theirs, vertices);
    const auto miss = [&](const Vec3d& at) {
      const Vec3d e = cells::map_to_physical(vertices.shape, vertices.x, at) - p;
      return std::sqrt(dot(e, e));
    };
    const double vtk_miss = miss({r[0], r[1], r[2]});
    c.worst_our_map = std::max(c.worst_our_map, miss(ours[i].parametric));
    if (vertices.shape == mesh::Shape::pyramid && ours[i].parametric.z > 0.99)
      continue; // r and s mean little near the apex, and VTK's Newton stops short of it
    EXPECT_LE(std::fabs(value - sum), 1e-12 + 200 * vtk_miss) << what << " " << test::text(p);
    c.worst = std::max(c.worst, std::fabs(value - sum));
    c.worst_vtk_map = std::max(c.worst_vtk_map, vtk_miss);
  }
  std::printf("%-22s %d points: same cell %d, VTK another that holds it %d, VTK one that does not "
              "%d, VTK none %d; values differ by %.2g; r, s, t miss the point by %.2g (VTK), %.2g "
              "(here)\n",
              what.c_str(), c.points, c.same, c.ties, c.vtk_wrong, c.vtk_lost, c.worst,
              c.worst_vtk_map, c.worst_our_map);
  return c;
}

} // namespace

TEST(VtkOracle, NamesTheSameCellsAndValues) {
  for (const auto kind : test::all_kinds) {
    const std::string what = test::kind_name(kind);
    SCOPED_TRACE(what);
    const Comparison c = compare(kind, 0.2, what);
    EXPECT_GE(c.same, c.points * 99 / 100);
    EXPECT_LE(c.worst_our_map, 64 * 12 * 0x1p-53); // coordinates up to 12
    const bool is_linear = kind == test::MeshKind::tetrahedra || kind == test::MeshKind::voxels;
    if (is_linear) {
      EXPECT_LE(c.worst, 1e-12);
    }
  }
}

namespace {

/// By the divergence theorem over triangles about the first vertex of each face: positive if the
/// faces turn outwards.
double volume(const std::vector<std::vector<Vec3d>>& faces) {
  double sum = 0;
  for (const auto& face : faces)
    for (std::size_t i = 2; i < face.size(); ++i)
      sum += dot(face[0], cross(face[i - 1], face[i])) / 6;
  return sum;
}

} // namespace

// VTK's faces turn outwards on a cell in its order: that fixes the order of every shape, the
// wedge's (whose triangle 0 1 2 faces away from 3 4 5) above all.
TEST(VtkOracle, CellsHaveTheSameOrderAndFaces) {
  for (const auto shape : test::all_shapes) {
    SCOPED_TRACE(mesh::shape_name(shape));
    test::TestMesh one;
    test::MeshCell only{shape, {}};
    const int n = mesh::vertex_count(shape);
    for (int v = 0; v < n; ++v) {
      one.vertices.push_back(test::unit_cell(shape)[std::size_t(v)]);
      only.vertices[std::size_t(v)] = v;
    }
    one.cells.push_back(only);
    const vtkNew<vtkUnstructuredGrid> grid = grid_of(one);
    vtkCell* cell = grid->GetCell(0);
    const cells::FaceTable table = cells::face_table(shape);
    ASSERT_EQ(cell->GetNumberOfFaces(), table.face_count);
    std::vector<std::vector<Vec3d>> theirs, ours;
    std::vector<std::vector<int>> their_ids, our_ids;
    for (int f = 0; f < table.face_count; ++f) {
      vtkCell* face = cell->GetFace(f);
      theirs.emplace_back();
      their_ids.emplace_back();
      for (vtkIdType v = 0; v < face->GetNumberOfPoints(); ++v) {
        // A pixel counts its third and fourth point the other way.
        const vtkIdType at = shape == mesh::Shape::voxel && v >= 2 ? 5 - v : v;
        their_ids.back().push_back(int(face->GetPointId(int(at))));
        theirs.back().push_back(one.vertices[std::size_t(their_ids.back().back())]);
      }
      ours.emplace_back();
      our_ids.emplace_back();
      for (int v = 0; v < table.faces[f].vertex_count; ++v) {
        our_ids.back().push_back(table.faces[f].vertices[v]);
        ours.back().push_back(one.vertices[table.faces[f].vertices[v]]);
      }
      std::sort(their_ids.back().begin(), their_ids.back().end());
      std::sort(our_ids.back().begin(), our_ids.back().end());
    }
    std::sort(their_ids.begin(), their_ids.end());
    std::sort(our_ids.begin(), our_ids.end());
    EXPECT_EQ(their_ids, our_ids);
    if (shape != mesh::Shape::voxel) { // VTK's pixels do not turn outwards
      EXPECT_GT(volume(theirs), 0.1);
      EXPECT_DOUBLE_EQ(volume(ours), volume(theirs));
    }
    EXPECT_GT(volume(ours), 0.1);
    fixtures::Committed m(one);
    EXPECT_TRUE(m.warnings.empty()) << m.warnings[0];
    EXPECT_EQ(m.mesh.validate(m.threads).counts.inverted_cells, 0);

    // And the same parametric coordinates.
    for (std::uint64_t i = 0; i < 50; ++i) {
      const Vec3d r = fixtures::random_parametric(shape, 83, i);
      double pcoords[3] = {r.x, r.y, r.z}, x[3], weights[8];
      int sub = 0;
      cell->EvaluateLocation(sub, pcoords, x, weights);
      const Vec3d p = cells::map_to_physical(shape, one.vertices.data(), r);
      double own[8];
      cells::shape_functions(shape, r, own);
      for (int a = 0; a < 3; ++a)
        EXPECT_NEAR(p[a], x[a], 1e-15);
      for (int v = 0; v < n; ++v)
        EXPECT_NEAR(own[v], weights[v], 1e-15);
    }
  }
}
