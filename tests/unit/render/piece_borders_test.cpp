// Meshes of several pieces of one process: what lies on their borders is one, and pieces that lie
// apart answer as one mesh does.
#include <list>
#include <map>

#include "cells/exact/decide.h"
#include "commit/checks/overlaps.h"
#include "mesh/piece_borders.h"
#include "render/structures/vertex_average.h"
#include "unit/render/same_frames.h"

namespace insitu::test {
namespace {

/// Meshes as pieces of one, with the blob at vertices ("f") and in cells ("c").
struct Pieces {
  explicit Pieces(const std::vector<TestMesh>& parts) {
    for (const TestMesh& part : parts)
      add(part);
    committed.commit();
  }

  void add(const TestMesh& part) {
    const auto p = std::int32_t(arrays.size());
    arrays.emplace_back(part);
    std::vector<double>&at_vertices = values.emplace_back(), &in_cells = values.emplace_back();
    for (const Vec3d& v : part.vertices)
      at_vertices.push_back(blob(v));
    for (const MeshCell& cell : part.cells) {
      Vec3d middle;
      const int count = mesh::vertex_count(cell.shape);
      for (int v = 0; v < count; ++v)
        middle += part.vertices[std::size_t(cell.vertices[std::size_t(v)])] / double(count);
      in_cells.push_back(blob(middle));
    }
    mesh::Mesh& mesh = committed.mesh.mesh();
    const insitu_array x = arrays.back().point_array();
    const insitu_cells c = arrays.back().cells();
    mesh.set_points(p, &x, 1);
    mesh.set_cells(p, &c);
    const auto field = [&](const char* name, insitu_association of, std::vector<double>& from) {
      const insitu_array a =
          insitu_array_of(from.data(), INSITU_FLOAT64, std::int64_t(from.size()), 1);
      mesh.set_field(p, name, of, &a, 1);
    };
    field("f", INSITU_VERTEX, at_vertices);
    field("c", INSITU_CELL, in_cells);
  }
  const mesh::MeshView& view() const { return committed.mesh.mesh().view(); }
  ScalarField field(const char* name) { return {committed.mesh.mesh().field(name), -1}; }

  std::list<fixtures::SolverArrays> arrays;
  std::list<std::vector<double>> values;
  fixtures::Committed committed;
};

/// The cells whose first vertex's place says so, with vertices of their own, numbered anew.
template <class Takes>
TestMesh part_of(const TestMesh& whole, const Takes& takes) {
  TestMesh part;
  std::map<std::int32_t, std::int32_t> ids;
  for (MeshCell cell : whole.cells) {
    Vec3d middle;
    const int count = mesh::vertex_count(cell.shape);
    for (int v = 0; v < count; ++v)
      middle += whole.vertices[std::size_t(cell.vertices[std::size_t(v)])] / double(count);
    if (!takes(middle))
      continue;
    for (int v = 0; v < count; ++v) {
      std::int32_t& id = cell.vertices[std::size_t(v)];
      const auto [at, is_new] = ids.emplace(id, std::int32_t(part.vertices.size()));
      if (is_new)
        part.vertices.push_back(whole.vertices[std::size_t(id)]);
      id = at->second;
    }
    part.cells.push_back(cell);
  }
  return part;
}

/// Four slabs along x, each all cells of its quarter.
std::vector<TestMesh> slabs(const TestMesh& whole) {
  std::vector<TestMesh> parts;
  for (int p = 0; p < 4; ++p)
    parts.push_back(part_of(whole, [p](const Vec3d& middle) {
      return middle.x >= 0.25 * p && middle.x < 0.25 * (p + 1);
    }));
  return parts;
}

TestMesh moved(TestMesh mesh, const Vec3d& by) {
  for (Vec3d& v : mesh.vertices)
    v = v + by;
  return mesh;
}

float difference(const FrameImages& a, const FrameImages& b) {
  float most = 0;
  for (std::size_t i = 0; i < a.color.rgba.size(); ++i)
    most = std::max(most, std::abs(a.color.rgba[i] - b.color.rgba[i]));
  return most;
}

TEST(PieceBorders, FramesOfFourPiecesAreThoseOfOne) {
  for (const Shape shape : {Shape::hexahedron, Shape::tetrahedron, Shape::wedge, Shape::pyramid}) {
    const TestMesh whole = box_cells(8, shape, 0.2);
    Pieces one({whole}), four(slabs(whole));
    for (const char* name : {"f", "c"})
      for (const render::Normals normals : {render::Normals::cell, render::Normals::smooth}) {
        SCOPED_TRACE(testing::Message()
                     << "shape " << int(shape) << " " << name << " normals " << int(normals));
        const auto image = [&](Pieces& mesh) {
          FrameSettings s = box_frame(48);
          s.isosurfaces.push_back({mesh.field(name), {0.3, 0.6}, 0.5, render::Color{1, 1, 1}});
          s.isosurfaces[0].normals = normals;
          s.lighting.lights = {{render::Light::Kind::directional, {1, 1, 2}, {1, 1, 1}}};
          return draw(mesh.committed, s, mesh.committed.memory, 2);
        };
        EXPECT_LE(difference(image(one), image(four)), 1e-5f);
      }
  }
}

TEST(PieceBorders, SeparatePiecesStayApart) {
  const TestMesh whole = box_cells(4, Shape::hexahedron, 0.2);
  Pieces four(slabs(whole));
  EXPECT_TRUE(four.view().join_pieces);
  four.committed.mesh.mesh().set_separate_pieces(true);
  four.committed.commit();
  EXPECT_FALSE(four.view().join_pieces);
  // A vertex on a border then has its own piece's cells alone.
  const render::VertexCells around(four.view(), nullptr, nullptr, four.committed.threads,
                                   four.committed.memory);
  for (std::int64_t v = 0; v < four.view().vertex_count(); ++v)
    for (const std::uint32_t cell : around.of(v))
      EXPECT_EQ(four.view().piece_of(cell), mesh::piece_of_vertex(four.view(), v));
}

/// 0 and -0 are one place; each vertex on a border is joined with one of the other piece.
TEST(PieceBorders, VerticesOfEveryBorderAreJoined) {
  constexpr int n = 4;
  TestMesh whole = moved(box_cells(n, Shape::hexahedron, 0.0), {-0.5, 0.0, 0.0});
  std::vector<TestMesh> halves;
  for (const int side : {-1, 1})
    halves.push_back(part_of(whole, [&](const Vec3d& middle) { return middle.x * side > 0; }));
  for (Vec3d& v : halves[0].vertices)
    if (v.x == 0)
      v.x = -0.0;
  Pieces two(halves);
  const mesh::JoinedVertices joined = mesh::join_pieces(two.view(), two.committed.threads);
  EXPECT_EQ(joined.end.size(), std::size_t((n + 1) * (n + 1)));
  EXPECT_EQ(joined.flat.size(), 2 * joined.end.size());
}

/// A crack runs from one piece into the border: vertices of one place that a piece tells apart by
/// ids take no part, so both sides of the crack keep their own averages.
TEST(PieceBorders, CracksStay) {
  const TestMesh whole = box_cells(4, Shape::hexahedron, 0.0);
  TestMesh left = part_of(whole, [](const Vec3d& middle) { return middle.x < 0.5; });
  const TestMesh right = part_of(whole, [](const Vec3d& middle) { return middle.x > 0.5; });
  std::map<std::int32_t, std::int32_t> copies;
  int cracked_at_border = 0;
  for (MeshCell& cell : left.cells)
    for (int v = 0; v < 8; ++v) {
      const std::int32_t id = cell.vertices[std::size_t(v)];
      const Vec3d x = left.vertices[std::size_t(id)];
      const bool is_upper = v >= 4; // of the cells below the crack
      if (x.z != 0.5 || !is_upper)
        continue;
      const auto [at, is_new] = copies.emplace(id, std::int32_t(left.vertices.size()));
      if (is_new) {
        left.vertices.push_back(x);
        cracked_at_border += x.x == 0.5;
      }
      cell.vertices[std::size_t(v)] = at->second;
    }
  ASSERT_EQ(cracked_at_border, 5);
  Pieces two({left, right});
  const mesh::JoinedVertices joined = mesh::join_pieces(two.view(), two.committed.threads);
  EXPECT_EQ(joined.end.size(), std::size_t(5 * 5 - cracked_at_border));
}

std::int64_t lowest_owner(const mesh::MeshView& view, const Vec3d& p) {
  mesh::CellVertices cell;
  for (std::int64_t flat = 0; flat < view.cell_count(); ++flat) {
    mesh::gather(view, flat, cell);
    if (cells::decide(cell.shape, cell.x, p))
      return flat;
  }
  return -1;
}

void expect_lowest_owners(const Pieces& mesh, int points) {
  const query::Sampler sampler = mesh.committed.sampler();
  std::vector<Vec3d> asked;
  for (int i = 0; i < points; ++i) {
    Vec3d p;
    for (int a = 0; a < 3; ++a)
      p[a] = 1.6 * core::random_unit(11, std::uint64_t(i), std::uint64_t(a)) - 0.3;
    asked.push_back(p);
  }
  std::vector<query::Location> found(asked.size());
  sampler.locate(mesh.committed.threads, asked, found);
  for (std::size_t i = 0; i < asked.size(); ++i) {
    const std::int64_t owner = lowest_owner(mesh.view(), asked[i]);
    EXPECT_EQ(found[i] ? found[i].cell : -1, owner) << i;
    const query::Location alone = sampler.locate(asked[i]);
    EXPECT_EQ(alone ? alone.cell : -1, owner) << i;
  }
}

TEST(PieceBorders, PiecesThatConformAreAsGoodAsOne) {
  for (const Shape shape : {Shape::hexahedron, Shape::tetrahedron, Shape::wedge}) {
    Pieces four(slabs(box_cells(8, shape, 0.2)));
    EXPECT_TRUE(four.view().one_mesh);
    EXPECT_TRUE(four.view().free_of_folds);
    expect_lowest_owners(four, 1000);
  }
  // Blocks that meet in a plane, with other vertices on either side of it.
  Pieces blocks({box_cells(3, Shape::hexahedron, 0.2),
                 moved(box_cells(4, Shape::hexahedron, 0.2), {1.0, 0.0, 0.0})});
  EXPECT_TRUE(blocks.view().one_mesh);
  expect_lowest_owners(blocks, 1000);
}

TEST(PieceBorders, PiecesThatOverlapAnswerByTheLowestCell) {
  const TestMesh box = box_cells(4, Shape::hexahedron, 0.2);
  // Layers of cells that two pieces have without telling that these are ghosts.
  const TestMesh west = part_of(box, [](const Vec3d& middle) { return middle.x < 0.75; });
  const TestMesh east = part_of(box, [](const Vec3d& middle) { return middle.x > 0.25; });
  Pieces layered({west, east});
  EXPECT_FALSE(layered.view().one_mesh);
  expect_lowest_owners(layered, 500);
  TestMesh within = moved(box_cells(2, Shape::hexahedron, 0.0), {-0.5, -0.5, -0.5});
  for (Vec3d& v : within.vertices)
    v = 0.05 * v + Vec3d{0.51, 0.52, 0.53}; // no vertex of the box lies in it
  for (const TestMesh& other :
       {moved(box, {0.31, 0.17, 0.0}), moved(box, {1.0 - 1e-3, 0.0, 0.0}), within, box}) {
    for (const auto& order : {std::vector{box, other}, std::vector{other, box}}) {
      Pieces two(order);
      EXPECT_FALSE(two.view().one_mesh);
      expect_lowest_owners(two, 500);
    }
  }
}

/// The one warning of a commit; "" where there is none.
std::string warning_of(const fixtures::Committed& mesh) {
  EXPECT_LE(mesh.warnings.size(), 1u);
  return mesh.warnings.empty() ? "" : mesh.warnings[0];
}

/// Says which two cells share volume: cell `a` of piece 0 and cell `b` of piece 1.
std::string overlap(const std::string& a, const std::string& b) {
  return "mesh 'test': pieces 0 and 1 overlap: cell " + a + " of piece 0 and cell " + b +
         " of piece 1 share volume, the first such cells that were found; a point in cells of "
         "several pieces belongs to the lowest piece";
}

/// A commit names two pieces that overlap, and a cell of each, for any thread count; none where
/// they touch, and where their vertices lie in each other's cells by less than a twentieth.
TEST(PieceBorders, PiecesThatOverlapAreNamed) {
  const TestMesh box = box_cells(4, Shape::hexahedron, 0.0);
  TestMesh corner = box, within = box_cells(1, Shape::hexahedron, 0.0);
  for (Vec3d& v : corner.vertices) // the last cell's corner lies in the first cell of the box
    v = v + Vec3d{-0.9, -0.9, -0.9};
  for (Vec3d& v : within.vertices)
    v = 0.05 * v + Vec3d{0.51, 0.52, 0.53};
  const auto told = [](const std::vector<TestMesh>& parts) {
    return warning_of(Pieces(parts).committed);
  };
  EXPECT_EQ(told({box, box}), overlap("0", "0"));
  EXPECT_EQ(told({box, moved(box, {0.75, 0.0, 0.0})}), overlap("3", "0"));
  EXPECT_EQ(told({moved(box, {0.75, 0.0, 0.0}), box}), overlap("0", "3"));
  EXPECT_EQ(told({box, corner}), overlap("0", "63"));
  EXPECT_EQ(told({box, within}), overlap("42", "0"));
  EXPECT_EQ(told({box, moved(box, {1.0 - 0.06 / 4, 0.1, 0.1})}), overlap("3", "0"));
  for (const Vec3d& by : {Vec3d{1, 0, 0}, Vec3d{1, 0.1, 0.1}, Vec3d{1 - 0.04 / 4, 0.1, 0.1},
                          Vec3d{1, 1, 1}, Vec3d{2, 0, 0}})
    EXPECT_EQ(told({box, moved(box, by)}), "") << by.x << " " << by.y;
  EXPECT_EQ(told(slabs(box_cells(8, Shape::tetrahedron, 0.2))), "");

  for (const bool is_ghost : {false, true}) { // uniform blocks that share a layer of cells
    fixtures::Committed blocks(is_ghost ? 1 : 3);
    std::vector<std::uint8_t> layer;
    for (int cell = 0; cell < 4 * 4 * 4; ++cell)
      layer.push_back(is_ghost && cell % 4 == 0);
    for (int p = 0; p < 2; ++p) {
      insitu_block block = insitu_block_default();
      block.kind = INSITU_BLOCK_UNIFORM;
      for (int a = 0; a < 3; ++a) {
        block.vertices[a] = 5;
        block.origin[a] = p == 1 && a == 0 ? 0.75 : 0.0;
        block.spacing[a] = 0.25;
      }
      blocks.mesh.mesh().set_block(p, &block);
    }
    const insitu_array bits =
        insitu_array_of(layer.data(), INSITU_UINT8, std::int64_t(layer.size()), 1);
    blocks.mesh.mesh().set_ghosts(1, &bits, INSITU_GHOSTS_VTK);
    blocks.commit();
    EXPECT_EQ(warning_of(blocks), is_ghost ? "" : overlap("3", "0"));
    blocks.commit(INSITU_CHANGED_FIELDS);
    EXPECT_EQ(blocks.warnings.size(), std::size_t(!is_ghost)) << "once a change of cells";
  }
}

/// What lay apart is looked at anew when it moves.
TEST(PieceBorders, PiecesThatMoveIntoEachOther) {
  const TestMesh box = box_cells(3, Shape::hexahedron, 0.2);
  const TestMesh apart = moved(box, {1.5, 0.0, 0.0});
  fixtures::SolverArrays arrays(box);
  Pieces two({box, apart});
  EXPECT_TRUE(two.view().one_mesh);
  expect_lowest_owners(two, 500);
  const TestMesh into = moved(box, {0.4, 0.1, 0.0});
  fixtures::SolverArrays at(into);
  const insitu_array x = at.point_array();
  two.committed.mesh.mesh().set_points(1, &x, 1);
  for (int step = 0; step < 3; ++step) { // many points ask for folds to be known
    two.committed.commit(INSITU_CHANGED_GEOMETRY);
    EXPECT_FALSE(two.view().one_mesh);
    expect_lowest_owners(two, 500);
  }
}

} // namespace
} // namespace insitu::test
