// Whose a place on a face, edge or vertex is, told by the cells about it instead of by the tree.
#include <algorithm>

#include "advect/field/owners.h"
#include "cells/exact/decide.h"
#include "mesh/piece_borders.h"
#include "unit/query/query_test.h"

namespace insitu::test {
namespace {

using advect::CellsBeyond;

/// The mesh moved, so that nothing is known of its folds and its tree is not fitted.
void shear(fixtures::Committed& m) {
  for (std::size_t v = 0; v < m.arrays.points.size(); v += 3)
    m.arrays.points[v] += 0.25 + 0.03125 * m.arrays.points[v + 2];
  m.commit(INSITU_CHANGED_GEOMETRY);
}

// From every cell that holds a place the owner is the one that the sampler finds.
TEST(Owners, FromAnyCellThatHoldsAPlaceAreThoseOfTheSampler) {
  for (const MeshKind kind : all_kinds) {
    fixtures::Committed asked(box(kind, 4, 0.15)), told(box(kind, 4, 0.15));
    shear(asked);
    shear(told);
    const mesh::MeshView& view = asked.sampler().mesh();
    std::vector<Vec3d> points = hard_points(view, 250, 51);
    for (const Vec3d& p : inner_points(view, 50, 52))
      points.push_back(p);
    const auto beyond = CellsBeyond::worth(asked.sampler(), std::int64_t(1) << 20);
    ASSERT_TRUE(asked.sampler().sound_cells(false)) << kind_name(kind);
    std::int64_t on_boundaries = 0;
    for (const Vec3d& p : points) {
      const query::Location want = told.sampler().locate(p);
      for (std::int64_t cell = 0; cell < view.cell_count(); ++cell) {
        mesh::CellVertices c;
        mesh::gather(view, cell, c);
        const cells::Decision how = cells::decide(c.shape, c.x, p);
        if (!how)
          continue;
        on_boundaries += how.is_on_boundary();
        const query::Location got =
            advect::owner_of(asked.sampler(), beyond.get(), cell, p, {INSITU_STANDARD, 1.0});
        ASSERT_EQ(got.cell, want.cell)
            << kind_name(kind) << ", from cell " << cell << " at " << text(p);
      }
    }
    EXPECT_GT(on_boundaries, 20) << kind_name(kind);
  }
}

// In the mesh's interior that needs no tree.
TEST(Owners, WithinAMeshAskForNoTree) {
  fixtures::Committed m(box(MeshKind::hexahedra, 4, 0.0));
  m.mesh.find_neighbours(m.threads);
  shear(m);
  const auto beyond = CellsBeyond::worth(m.sampler(), std::int64_t(1) << 20);
  ASSERT_TRUE(beyond);
  constexpr std::int64_t middle = 1 + 4 * (1 + 4 * 1);
  mesh::CellVertices c;
  mesh::gather(m.sampler().mesh(), middle, c);
  const Vec3d upper = c.x[6], edge = 0.5 * (c.x[2] + c.x[6]),
              face = 0.25 * ((c.x[1] + c.x[2]) + (c.x[5] + c.x[6]));
  for (const Vec3d& p : {mesh::middle_of(c), face, edge, upper}) {
    EXPECT_EQ(advect::owner_of(m.sampler(), beyond.get(), middle, p, {}).cell, middle) << text(p);
    EXPECT_EQ(m.mesh.fits_done().refits, 0) << text(p);
  }
  // From the cell across, too: of both the lower id is the owner.
  constexpr int upper_r = 1;
  const std::int64_t across = beyond->across(middle, mesh::Shape::hexahedron, upper_r);
  ASSERT_GE(across, 0);
  EXPECT_EQ(advect::owner_of(m.sampler(), beyond.get(), across, face, {}).cell,
            std::min(across, middle));
  EXPECT_EQ(m.mesh.fits_done().refits, 0);
}

} // namespace
} // namespace insitu::test
