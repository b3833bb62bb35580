// The same frame to the byte by all locators and threads, on meshes of several shapes and pieces,
// of cell fields and by the nearest leaf.
#include "unit/render/block_mesh.h"
#include "unit/render/same_frames.h"

namespace insitu::test {
namespace {

/// n^3 blocks, which fit together: hexahedra, beside them pyramids, beside these columns of wedges,
/// and at the side x = 0 pairs of tetrahedra in place of the pyramids that stand there.
TestMesh mixed_box(int n) {
  TestMesh mesh = box_cells(n, Shape::hexahedron, 0.2);
  const std::vector<MeshCell> blocks = std::move(mesh.cells);
  mesh.cells.clear();
  const auto add = [&](Shape shape, std::initializer_list<std::int32_t> ids) {
    MeshCell cell;
    cell.shape = shape;
    std::copy(ids.begin(), ids.end(), cell.vertices.begin());
    mesh.cells.push_back(cell);
  };
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const int i = int(b) % n;
    const auto& c = blocks[b].vertices;
    if (i >= n / 3 && i < 2 * n / 3) {
      mesh.cells.push_back(blocks[b]);
    } else if (i >= 2 * n / 3) {
      add(Shape::wedge, {c[0], c[1], c[2], c[4], c[5], c[6]});
      add(Shape::wedge, {c[0], c[2], c[3], c[4], c[6], c[7]});
    } else {
      Vec3d centre;
      for (int v = 0; v < 8; ++v)
        centre += 0.125 * mesh.vertices[std::size_t(c[std::size_t(v)])];
      const auto apex = std::int32_t(mesh.vertices.size());
      mesh.vertices.push_back(centre);
      add(Shape::pyramid, {c[0], c[3], c[2], c[1], apex});
      add(Shape::pyramid, {c[4], c[5], c[6], c[7], apex});
      add(Shape::pyramid, {c[0], c[1], c[5], c[4], apex});
      add(Shape::pyramid, {c[3], c[7], c[6], c[2], apex});
      add(Shape::pyramid, {c[1], c[2], c[6], c[5], apex});
      if (i > 0) {
        add(Shape::pyramid, {c[0], c[4], c[7], c[3], apex});
      } else {
        add(Shape::tetrahedron, {c[0], c[4], c[7], apex});
        add(Shape::tetrahedron, {c[0], c[7], c[3], apex});
      }
    }
  }
  return mesh;
}

TEST(SameFramesOf, MixedShapes) {
  const TestMesh cells = mixed_box(6);
  int of_shape[16] = {};
  for (const MeshCell& cell : cells.cells)
    ++of_shape[int(cell.shape)];
  for (const Shape shape : {Shape::hexahedron, Shape::tetrahedron, Shape::wedge, Shape::pyramid})
    EXPECT_GT(of_shape[int(shape)], 50);
  RenderMesh mesh(cells);
  mesh.field("f", INSITU_VERTEX, blob);
  expect_same_by_all(mesh.committed, [&] {
    return ScalarField{mesh.committed.mesh.mesh().field("f"), -1};
  });
}

TEST(SameFramesOf, CellFields) {
  for (const Shape shape : {Shape::hexahedron, Shape::tetrahedron}) {
    SCOPED_TRACE(testing::Message() << "shape " << int(shape));
    RenderMesh mesh(6, shape, 0.2);
    mesh.field("c", INSITU_CELL, blob);
    expect_same_by_all(mesh.committed, [&] {
      return ScalarField{mesh.committed.mesh.mesh().field("c"), -1};
    });
  }
}

/// Blocks know their cells without looking, and have no other locator.
TEST(SameFramesOf, StructuredBlocksByEveryNumberOfThreads) {
  for (const insitu_block_kind kind : block_kinds) {
    SCOPED_TRACE(testing::Message() << "kind " << int(kind));
    BlockMesh block(kind, 7, blob);
    FrameSettings frame = box_frame(24);
    frame.depth = frame.cell = true;
    // The same points as hexahedra.
    TestMesh cells = box_cells(6, Shape::hexahedron, 0);
    for (std::size_t v = 0; v < cells.vertices.size(); ++v)
      cells.vertices[v] = {block.points[3 * v], block.points[3 * v + 1], block.points[3 * v + 2]};
    RenderMesh hexahedra(cells);
    const ScalarField f = hexahedra.field("f", INSITU_VERTEX, blob);
    for (const Technique& technique : techniques) {
      SCOPED_TRACE(technique.name);
      const FrameSettings s = technique.ask(frame, block.field);
      const FrameImages one = draw(block.committed, s, block.committed.memory, 1);
      expect_same(one, draw(block.committed, s, block.committed.memory, 4));
      expect_same(
          one, draw(hexahedra.committed, technique.ask(frame, f), hexahedra.committed.memory, 2));
    }
  }
}

} // namespace
} // namespace insitu::test
