// Ghost cells in frames: what other processes' cells lend, and what is never read of them.
#include "mesh/registered/cells_copy.h"
#include "render/structures/vertex_average.h"
#include "unit/render/same_frames.h"

namespace insitu::test {
namespace {

constexpr int blocks = 6;

/// The halves of a box along y, each with some layers of the other's cells as ghosts.
struct TwoPieces {
  TwoPieces(const TestMesh& whole, int layers, std::uint8_t ghost) {
    for (int p = 0; p < 2; ++p) {
      TestMesh part;
      part.vertices = whole.vertices;
      for (const MeshCell& cell : whole.cells) {
        Vec3d middle;
        const int count = mesh::vertex_count(cell.shape);
        for (int v = 0; v < count; ++v)
          middle += whole.vertices[std::size_t(cell.vertices[std::size_t(v)])] / double(count);
        const double beyond = p == 0 ? middle.y - 0.5 : 0.5 - middle.y;
        if (beyond > double(layers) / blocks)
          continue;
        part.cells.push_back(cell);
        ghosts[p].push_back(beyond > 0 ? ghost : 0);
        cell_values[p].push_back(blob(middle));
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
      const insitu_array of_cells = insitu_array_of(cell_values[p].data(), INSITU_FLOAT64,
                                                    std::int64_t(cell_values[p].size()), 1);
      mesh.set_points(p, &x, 1);
      mesh.set_cells(p, &c);
      mesh.set_ghosts(p, &g, INSITU_GHOSTS_VTK);
      mesh.set_field(p, "f", INSITU_VERTEX, &f, 1);
      mesh.set_field(p, "c", INSITU_CELL, &of_cells, 1);
    }
    committed.commit();
  }
  ScalarField field(const char* name) { return {committed.mesh.mesh().field(name), -1}; }

  fixtures::SolverArrays arrays[2];
  std::vector<std::uint8_t> ghosts[2];
  std::vector<double> values[2], cell_values[2];
  fixtures::Committed committed;
};

/// The greatest difference of their colours.
float difference(const FrameImages& a, const FrameImages& b) {
  float most = 0;
  for (std::size_t i = 0; i < a.color.rgba.size(); ++i)
    most = std::max(most, std::abs(a.color.rgba[i] - b.color.rgba[i]));
  return most;
}

TEST(SameFramesOf, TwoPiecesWithGhosts) {
  const TestMesh whole = box_cells(blocks, Shape::hexahedron, 0.2);
  TwoPieces pieces(whole, 1, 1);
  EXPECT_EQ(std::count(pieces.ghosts[0].begin(), pieces.ghosts[0].end(), 1), 36);
  expect_same_by_all(pieces.committed, [&] { return pieces.field("f"); });
  // And what is seen is the whole, but for rounding: boxes' origins differ, and sums' orders. At
  // the border smooth normals are averaged over the cells of both, the other's being lent.
  RenderMesh mesh(whole);
  const ScalarField f = mesh.field("f", INSITU_VERTEX, blob);
  const FrameSettings frame = box_frame(24);
  pieces.committed.mesh.set_locator({accel::Method::bvh, accel::Backend::cpu});
  pieces.committed.commit();
  for (const Technique& technique : techniques) {
    SCOPED_TRACE(technique.name);
    const FrameImages parts =
        draw(pieces.committed, technique.ask(frame, pieces.field("f")), pieces.committed.memory, 2);
    const FrameImages one = draw(mesh.committed, technique.ask(frame, f), mesh.committed.memory, 2);
    EXPECT_LE(difference(parts, one), 1e-6f);
  }
}

/// A cell field's surface is one of averages at vertices, and its smooth normals average the
/// gradients of these: two layers of ghosts.
TEST(GhostCells, LendTheValuesOfCellFields) {
  for (const Shape shape : {Shape::hexahedron, Shape::tetrahedron}) {
    SCOPED_TRACE(testing::Message() << "shape " << int(shape));
    const TestMesh whole = box_cells(blocks, shape, 0.2);
    TwoPieces pieces(whole, 2, 1), alone(whole, 2, 32);
    RenderMesh mesh(whole);
    const ScalarField c = mesh.field("c", INSITU_CELL, blob);
    for (const render::Normals normals : {render::Normals::cell, render::Normals::smooth}) {
      SCOPED_TRACE(testing::Message() << "normals " << int(normals));
      const auto ask = [&](const ScalarField& field) {
        FrameSettings s = box_frame(48);
        s.isosurfaces.push_back({field, {0.3, 0.6}, 0.5, render::Color{1, 1, 1}});
        s.isosurfaces[0].normals = normals;
        s.lighting.lights = {{render::Light::Kind::directional, {1, 1, 2}, {1, 1, 1}}};
        return s;
      };
      const FrameImages one = draw(mesh.committed, ask(c), mesh.committed.memory, 2);
      EXPECT_LE(
          difference(draw(pieces.committed, ask(pieces.field("c")), pieces.committed.memory, 2),
                     one),
          1e-5f);
      // Hidden cells lend nothing: there is a seam, unless vertices of both pieces that coincide
      // are one.
      alone.committed.mesh.mesh().set_separate_pieces(true);
      alone.committed.commit();
      EXPECT_GE(
          difference(draw(alone.committed, ask(alone.field("c")), alone.committed.memory, 2), one),
          1e-2f);
      alone.committed.mesh.mesh().set_separate_pieces(false);
      alone.committed.commit();
      EXPECT_LE(
          difference(draw(alone.committed, ask(alone.field("c")), alone.committed.memory, 2), one),
          1e-5f);
    }
  }
}

/// Values that are not finite and numbers out of range are left out; the solver's own cells' not.
TEST(GhostCells, MayHoldGarbage) {
  TestMesh cells = make_mesh({.kind = MeshKind::mixed, .size = 4}, 5);
  fixtures::SolverArrays arrays(cells);
  ASSERT_FALSE(arrays.uniform);
  const std::int64_t count = arrays.cell_count();
  std::vector<std::uint8_t> ghosts(static_cast<std::size_t>(count), 0);
  std::vector<double> values(static_cast<std::size_t>(count), 2.0);
  // Every fifth cell is a ghost, in turn: sound; ids out of range; unknown type; offsets anywhere;
  // a value that is none; sound, but refined.
  const std::int64_t far[] = {-1, std::int64_t(1) << 62, -(std::int64_t(1) << 62),
                              std::int64_t(arrays.ids.size()) - 1};
  std::vector<std::int64_t> lending;
  for (std::int64_t c = 0, n = 0; c < count - 1; c += 5, ++n) {
    const auto at = std::size_t(c);
    ghosts[at] = 1;
    values[at] = 5.0;
    switch (n % 6) {
    case 0:
      lending.push_back(c);
      break;
    case 1:
      arrays.ids[std::size_t(arrays.offsets[at])] = n % 4 < 2 ? -7 : 1 << 30;
      break;
    case 2:
      arrays.types[at] = n % 4 < 2 ? 200 : 0;
      break;
    case 3: // which the cell before is checked by as well
      arrays.offsets[at] = far[n / 6 % 4];
      ghosts[at - 1] = 32;
      break;
    case 4:
      values[at] = n % 4 < 2 ? std::numeric_limits<double>::quiet_NaN()
                             : std::numeric_limits<double>::infinity();
      break;
    default:
      ghosts[at] = 1 | 8;
    }
  }
  ASSERT_GE(lending.size(), 4u);
  fixtures::Committed committed;
  mesh::Mesh& mesh = committed.mesh.mesh();
  const insitu_array x = arrays.point_array();
  const insitu_cells c = arrays.cells();
  const insitu_array g = insitu_array_of(ghosts.data(), INSITU_UINT8, count, 1);
  const insitu_array f = insitu_array_of(values.data(), INSITU_FLOAT64, count, 1);
  mesh.set_points(0, &x, 1);
  mesh.set_cells(0, &c);
  mesh.set_ghosts(0, &g, INSITU_GHOSTS_VTK);
  mesh.set_field(0, "c", INSITU_CELL, &f, 1);
  committed.commit();

  const mesh::MeshView& view = committed.sampler().mesh();
  const render::VertexCells around(view, nullptr, nullptr, committed.threads, committed.memory);
  const render::VertexAverage average(view, {mesh.field("c"), -1}, around, committed.threads,
                                      committed.memory);
  std::vector<std::vector<double>> expected(cells.vertices.size());
  for (std::int64_t i = 0; i < count; ++i) {
    const bool lends = std::find(lending.begin(), lending.end(), i) != lending.end();
    if (ghosts[std::size_t(i)] && !lends)
      continue;
    const MeshCell& cell = cells.cells[std::size_t(i)];
    for (int v = 0; v < mesh::vertex_count(cell.shape); ++v)
      expected[std::size_t(cell.vertices[std::size_t(v)])].push_back(values[std::size_t(i)]);
  }
  for (std::size_t v = 0; v < expected.size(); ++v) {
    const double found = average.field().load(0, std::int64_t(v));
    double sum = 0;
    for (const double value : expected[v])
      sum += value;
    if (expected[v].empty()) {
      EXPECT_TRUE(std::isnan(found)) << v;
    } else {
      EXPECT_NEAR(found, sum / double(expected[v].size()), 1e-14) << v;
    }
  }

  // A copy of the cells knows which own points, and nothing of the others.
  mesh::CellsCopy copy(committed.memory);
  copy.copy(view, committed.threads);
  std::vector<Vec3d> points = cells.vertices;
  const mesh::MeshView& kept = copy.on(points.data());
  for (std::int64_t i = 0; i < count; ++i) {
    ASSERT_EQ(kept.pieces[0].owns(i), ghosts[std::size_t(i)] == 0) << i;
    if (ghosts[std::size_t(i)] == 0) {
      mesh::CellVertices a, b;
      mesh::gather(view, i, a);
      mesh::gather(kept, i, b);
      ASSERT_EQ(a.shape, b.shape);
      for (int v = 0; v < a.count; ++v)
        ASSERT_EQ(a.ids[v], b.ids[v]);
    }
  }
}

} // namespace
} // namespace insitu::test
