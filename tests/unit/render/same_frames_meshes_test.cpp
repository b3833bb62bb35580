// The same frame to the byte by all locators and threads, on meshes of several shapes and pieces,
// of cell fields and by the nearest leaf.
#include "unit/query/registered_amr.h"
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

/// The halves of a box along y, each with one layer of the other's cells as ghosts.
struct TwoPieces {
  explicit TwoPieces(const TestMesh& whole) {
    for (int p = 0; p < 2; ++p) {
      TestMesh part;
      part.vertices = whole.vertices;
      for (const MeshCell& cell : whole.cells) {
        double y = 0;
        const int count = mesh::vertex_count(cell.shape);
        for (int v = 0; v < count; ++v)
          y += whole.vertices[std::size_t(cell.vertices[std::size_t(v)])].y / count;
        const double beyond = p == 0 ? y - 0.5 : 0.5 - y;
        if (beyond > 1.0 / 6)
          continue;
        part.cells.push_back(cell);
        ghosts[p].push_back(beyond > 0 ? 1 : 0);
      }
      arrays[p] = fixtures::SolverArrays(part);
      for (const Vec3d& v : part.vertices)
        values[p].push_back(blob(v));
      mesh::Mesh& mesh = committed.mesh.mesh();
      const insitu_array x = arrays[p].point_array();
      const insitu_cells c = arrays[p].cells();
      const insitu_array g =
          insitu_array_of(ghosts[p].data(), INSITU_UINT8, std::int64_t(ghosts[p].size()), 1);
      const insitu_array f =
          insitu_array_of(values[p].data(), INSITU_FLOAT64, std::int64_t(values[p].size()), 1);
      mesh.set_points(p, &x, 1);
      mesh.set_cells(p, &c);
      mesh.set_ghosts(p, &g, INSITU_GHOSTS_VTK);
      mesh.set_field(p, "f", INSITU_VERTEX, &f, 1);
    }
    committed.commit();
  }
  fixtures::SolverArrays arrays[2];
  std::vector<std::uint8_t> ghosts[2];
  std::vector<double> values[2];
  fixtures::Committed committed;
};

TEST(SameFramesOf, TwoPiecesWithGhosts) {
  const TestMesh whole = box_cells(6, Shape::hexahedron, 0.2);
  TwoPieces pieces(whole);
  EXPECT_EQ(std::count(pieces.ghosts[0].begin(), pieces.ghosts[0].end(), 1), 36);
  const auto field = [&] { return ScalarField{pieces.committed.mesh.mesh().field("f"), -1}; };
  expect_same_by_all(pieces.committed, field);
  // And what is seen is the whole, but for rounding: boxes' origins differ. Smooth normals are
  // averaged over the cells of their own piece, ghosts aside, whose numbers may be anything.
  RenderMesh mesh(whole);
  const ScalarField f = mesh.field("f", INSITU_VERTEX, blob);
  const FrameSettings frame = box_frame(24);
  pieces.committed.mesh.set_locator({accel::Method::bvh, accel::Backend::cpu});
  pieces.committed.commit();
  for (const Technique& technique : techniques) {
    SCOPED_TRACE(technique.name);
    FrameSettings in_parts = technique.ask(frame, field()), in_one = technique.ask(frame, f);
    for (FrameSettings* s : {&in_parts, &in_one})
      for (render::IsosurfaceSettings& surface : s->isosurfaces)
        if (surface.normals == render::Normals::smooth)
          surface.normals = render::Normals::cell;
    const FrameImages parts = draw(pieces.committed, in_parts, pieces.committed.memory, 2);
    const FrameImages one = draw(mesh.committed, in_one, mesh.committed.memory, 2);
    for (std::size_t i = 0; i < one.color.rgba.size(); ++i)
      ASSERT_NEAR(parts.color.rgba[i], one.color.rgba[i], 1e-6) << i;
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

/// An adaptive mesh whose values are those of the nearest leaf.
TEST(SameFramesOf, NearestLeavesByEveryNumberOfThreads) {
  RegisteredAmr amr({.seed = 3, .kind = 0, .roots = 3, .levels = 3}, INSITU_NEAREST,
                    [](const Vec3d& p) { return 0.5 + 0.5 * std::sin(p.x) * std::cos(p.y); });
  const accel::Tree& tree = amr.committed.sampler().tree();
  FrameSettings frame = box_frame(24);
  frame.camera = render::Camera::around(tree.bounds_min(), tree.bounds_max(), 30, 20);
  frame.depth = frame.cell = true;
  for (const Technique& technique : techniques) {
    SCOPED_TRACE(technique.name);
    const FrameSettings s = technique.ask(frame, {amr.committed.mesh.mesh().field("f"), -1});
    const FrameImages one = draw(amr.committed, s, amr.committed.memory, 1);
    for (const int threads : {2, 5})
      expect_same(one, draw(amr.committed, s, amr.committed.memory, threads));
  }
}

} // namespace
} // namespace insitu::test
