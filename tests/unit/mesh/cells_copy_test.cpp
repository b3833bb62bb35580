// Cells that outlive the solver's arrays.
#include <gtest/gtest.h>

#include "fixtures/committed.h"
#include "mesh/registered/cells_copy.h"

using namespace insitu;

namespace {

/// The copy says of every cell what the mesh says, and reads nothing of the mesh's.
void expect_same(const mesh::MeshView& own, mesh::CellsCopy& copy) {
  std::vector<math::Vec3d> points;
  for (std::int32_t p = 0; p < own.piece_count; ++p)
    for (std::int64_t v = 0; v < own.pieces[p].vertex_count; ++v)
      points.push_back(own.pieces[p].point(v));
  const mesh::MeshView& view = copy.on(points.data());
  ASSERT_EQ(view.piece_count, own.piece_count);
  ASSERT_EQ(view.cell_count(), own.cell_count());
  ASSERT_EQ(view.vertex_count(), own.vertex_count());
  for (std::int64_t c = 0; c < own.cell_count(); ++c) {
    mesh::CellVertices a, b;
    mesh::gather(own, c, a);
    mesh::gather(view, c, b);
    ASSERT_EQ(a.shape, b.shape) << c;
    ASSERT_EQ(a.count, b.count) << c;
    ASSERT_EQ(a.piece, b.piece) << c;
    for (int v = 0; v < a.count; ++v) {
      ASSERT_EQ(a.ids[v], b.ids[v]) << c;
      ASSERT_EQ(a.x[v], b.x[v]) << c;
    }
    const std::int64_t local = c - own.first_cell[a.piece];
    ASSERT_EQ(own.pieces[a.piece].owns(local), view.pieces[a.piece].owns(local)) << c;
  }
}

mesh::CellsCopy copy_of(fixtures::Committed& m) {
  mesh::CellsCopy copy(m.memory);
  const std::int64_t before = m.memory.current(INSITU_MEMORY_EARLIER);
  copy.copy(m.mesh.mesh().view(), m.threads);
  EXPECT_EQ(m.memory.current(INSITU_MEMORY_EARLIER) - before,
            mesh::CellsCopy::bytes_for(m.mesh.mesh().view(), m.threads));
  return copy;
}

} // namespace

TEST(CellsCopy, OfEveryKindOfCells) {
  for (const test::MeshKind kind :
       {test::MeshKind::hexahedra, test::MeshKind::voxels, test::MeshKind::wedges,
        test::MeshKind::pyramids, test::MeshKind::tetrahedra, test::MeshKind::mixed}) {
    fixtures::Committed m(test::make_mesh({.kind = kind, .size = 30}, 5)); // more than one task
    mesh::CellsCopy copy = copy_of(m);
    expect_same(m.mesh.mesh().view(), copy);
  }
}

TEST(CellsCopy, OfPiecesOfEveryLayout) {
  fixtures::Committed m;
  mesh::Mesh& mesh = m.mesh.mesh();
  // A block with ghosts.
  insitu_block block = insitu_block_default();
  block.kind = INSITU_BLOCK_UNIFORM;
  for (int a = 0; a < 3; ++a) {
    block.vertices[a] = 3 + a;
    block.spacing[a] = 0.5;
  }
  std::vector<std::uint8_t> ghosts(2 * 3 * 4, 0);
  ghosts[3] = ghosts[7] = 1;
  const insitu_array g =
      insitu_array_of(ghosts.data(), INSITU_UINT8, std::int64_t(ghosts.size()), 1);
  mesh.set_block(0, &block);
  mesh.set_ghosts(0, &g, INSITU_GHOSTS_VTK);
  // Padded ids from 1 on, in 64 bits: a hexahedron, and a wedge on it.
  const std::vector<double> xyz{9,  0, 0, 10, 0, 0, 10, 1, 0, 9,   1, 0, 9,   0, 1,
                                10, 0, 1, 10, 1, 1, 9,  1, 1, 9.5, 0, 2, 9.5, 1, 2};
  const std::vector<std::int64_t> ids{1, 2, 3, 4, 5, 6, 7, 8, 5, 9, 6, 8, 10, 7, -1, -1};
  const insitu_array points = insitu_array_of(xyz.data(), INSITU_FLOAT64, 10, 3);
  insitu_cells cells = insitu_cells_default();
  cells.layout = INSITU_LAYOUT_PADDED;
  cells.count = 2;
  cells.index_base = 1;
  cells.connectivity = insitu_array_of(ids.data(), INSITU_INT64, 2, 8);
  mesh.set_points(1, &points, 1);
  mesh.set_cells(1, &cells);
  m.commit();
  mesh::CellsCopy copy = copy_of(m);
  expect_same(mesh.view(), copy);
  copy.release();
  EXPECT_TRUE(copy.empty());
  EXPECT_EQ(m.memory.current(INSITU_MEMORY_EARLIER), 0);
}
