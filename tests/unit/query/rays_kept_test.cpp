// That rays themselves find the cells: where they miss, the tree would answer rightly in their
// place.
#include "rays_test.h"

using namespace insitu;
using accel::Method;
using test::box;
using test::MeshKind;
using test::ray_methods;
using test::Shares;
using test::TestMesh;

namespace {

/// The share of random points that a method must keep, in cells whose quads are bent. What knows
/// the cell's map loses only what Newton's certificate cannot prove and the cracks of float, below
/// 0.001 of the points here. Flat triangles for quads lose the points between them and the patch.
double least(Method method, double of_flat_triangles) {
  return method == Method::user_geometry || method == Method::shared_bilinear_faces
             ? 0.99
             : of_flat_triangles;
}

/// Before and after a refit to a shear, which leaves shares as they are.
void check(const TestMesh& from, const std::string& what, double of_flat_triangles, double most) {
  for (const Method method : ray_methods) {
    fixtures::Committed m(from, 2);
    m.mesh.set_locator({method, accel::Backend::cpu});
    m.commit();
    for (const char* when : {"built", "refitted"}) {
      const std::string name = what + ", " + accel::name(method) + ", " + when;
      ASSERT_TRUE(m.sampler().mesh().free_of_folds && m.sampler().mesh().covers_once) << name;
      for (const insitu_accuracy accuracy : {INSITU_STANDARD, INSITU_EXACT}) {
        const Shares found = test::shares_of(m, accuracy);
        EXPECT_DOUBLE_EQ(found.kept + found.by_neighbour + found.by_tree, 1) << name;
        EXPECT_GT(found.kept, least(method, of_flat_triangles)) << name;
        if (method == Method::shared_faces || method == Method::replicated_faces) {
          EXPECT_LE(found.kept, most) << name;
        }
        if (method == Method::shared_faces && most < 1) {
          EXPECT_GT(found.by_neighbour, 0) << name;
        }
      }
      for (std::size_t i = 0; i < m.arrays.points.size(); i += 3)
        m.arrays.points[i] += 0.1 * m.arrays.points[i + 1];
      m.commit(INSITU_CHANGED_GEOMETRY);
    }
  }
}

/// How `fast` answers random points within cells, as shares.
struct Fast {
  double lost = 0;   ///< answered by none
  double beside = 0; ///< by a cell that does not hold them
};
Fast fast(fixtures::Committed& m, Method method) {
  m.mesh.set_locator({method, accel::Backend::cpu});
  m.commit();
  const mesh::MeshView& view = m.sampler().mesh();
  constexpr int count = 10000;
  const std::vector<math::Vec3d> points = test::inner_points(view, count, 71);
  const test::Answers found = test::ask(m, points, INSITU_FAST),
                      exact = test::ask(m, points, INSITU_EXACT);
  Fast shares;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!found.at[i]) {
      shares.lost += exact.at[i] ? 1.0 / count : 0.0;
      continue;
    }
    mesh::CellVertices cell;
    mesh::gather(view, found.at[i].cell, cell);
    shares.beside +=
        cells::holds(cells::contain_exact(cell.shape, cell.x, points[i]).where) ? 0.0 : 1.0 / count;
  }
  return shares;
}

/// Rays in float may take the cell beside, or none, for points that lie within rounding of a face:
/// which ones, and so how many of ten thousand, differs between processors.
constexpr double near_faces = 3e-4;

/// lost, beside: the most of shared_bilinear_faces, but for near_faces; others may answer as many
/// more by a cell beside as flat triangles miss (replicated_faces: by none).
void check_fast(fixtures::Committed& m, const std::string& what, double lost, double beside,
                double of_flat_triangles) {
  for (const Method method : ray_methods) {
    const Fast found = fast(m, method);
    const std::string name = what + ", " + accel::name(method);
    if (method == Method::user_geometry) { // asks the cells themselves
      EXPECT_EQ(found.lost + found.beside, 0) << name;
      continue;
    }
    const double more = method == Method::shared_bilinear_faces ? 0.0 : of_flat_triangles;
    const bool asks_the_cell = method == Method::replicated_faces; // whose it tells, or none
    EXPECT_LE(found.lost, lost + near_faces + (asks_the_cell ? more : 0.0)) << name;
    EXPECT_LE(found.beside, asks_the_cell ? 0.0 : beside + near_faces + more) << name;
  }
}

} // namespace

// Of flat triangles: measured shares less four standard deviations of 2000 points (0.02).
TEST(RaysKept, MostPointsOfEveryShape) {
  check(box(MeshKind::hexahedra, 6), "hexahedra", 0.93, 0.98);
  check(box(MeshKind::wedges, 6), "wedges", 0.92, 0.98);
  check(box(MeshKind::pyramids, 6), "pyramids", 0.96, 0.999);
  check(box(MeshKind::mixed, 6), "mixed", 0.95, 0.999);
  check(box(MeshKind::voxels, 6), "voxels", 0.99, 1); // flat
  check(test::upright(box(MeshKind::tetrahedra, 6)), "tetrahedra", 0.99, 1);
}

TEST(RaysKept, MostPointsOfTwistedCellsThatDoNotFold) {
  check(test::twisted_box(8, 0.25), "twisted by 0.25", 0.83, 0.91);
  check(test::twisted_box(8, 0.4), "twisted by 0.4", 0.77, 0.85); // a third of bent cells' volume
}

TEST(RaysKept, MostPointsOfLongFarAndFlatCells) {
  check(box(MeshKind::hexahedra, 3, 0.2, 0, {100, 1, 1}), "long", 0.94, 0.99);
  check(box(MeshKind::wedges, 3, 0.2, 0, {1, 1, 1e5}), "needles", 0.93, 0.98);
  check(box(MeshKind::hexahedra, 5, 0.2, 1e7), "far from zero", 0.93, 0.98);
  check(box(MeshKind::hexahedra, 5, 0.2, 0, {1, 1, 1e-6}), "sheets", 0.93, 0.98);
}

// A fifth of the vertices lie on their neighbours: half the cells have edges of no length, which
// bends their quads up to the diagonal. Bounds: measured shares and about a third more.
TEST(RaysKept, FastOnCollapsedCellsIsWithinBounds) {
  for (const double jitter : {0.0, 0.2}) {
    fixtures::Committed m(
        test::make_mesh({.kind = MeshKind::mixed, .size = 8, .jitter = jitter, .collapse = 0.2}, 3),
        2);
    check_fast(m, "jitter " + std::to_string(jitter), 0, 0.025, 0.07);
  }
}

// Apart, pieces are as one. Where they touch or overlap, a ray may hit the other piece's boundary,
// which tells no cell.
TEST(RaysKept, FastOnSeveralPiecesIsWithinBounds) {
  const TestMesh from = box(MeshKind::mixed, 8);
  for (const auto& [offset, lost] : {std::pair{9.0, 0.0}, {8.0, 0.006}, {7.5, 0.015}}) {
    fixtures::Committed m(from, 2);
    fixtures::SolverArrays second(from);
    for (std::size_t i = 0; i < second.points.size(); i += 3)
      second.points[i] += offset;
    const insitu_array p = second.point_array();
    const insitu_cells c = second.cells();
    m.mesh.mesh().set_points(1, &p, 1);
    m.mesh.mesh().set_cells(1, &c);
    m.commit(INSITU_CHANGED_ALL);
    check_fast(m, "offset " + std::to_string(offset), lost, 0, 0.04);
  }
}
