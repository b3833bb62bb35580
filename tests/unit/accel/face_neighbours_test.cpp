// Cells across faces against a map of all faces.
#include <cstring>
#include <gtest/gtest.h>
#include <map>
#include <utility>

#include "accel/faces/face_neighbours.h"
#include "cells/kernels/faces.h"
#include "face_key.h"
#include "fixtures/committed.h"
#include "odd_mesh.h"

using namespace insitu;
using accel::FaceNeighbours;
using test::Key;
using test::key_of;
using test::MeshKind;
using test::TestMesh;

namespace {

constexpr MeshKind all_kinds[] = {MeshKind::hexahedra, MeshKind::voxels,     MeshKind::wedges,
                                  MeshKind::pyramids,  MeshKind::tetrahedra, MeshKind::mixed};

struct HalfFace {
  std::int64_t cell;
  int face;
  std::int64_t other = -1;
};

/// The first two with the same vertices, in the order of the cells, are neighbours.
void expect_neighbours(const mesh::MeshView& view, const core::Threads& threads,
                       const std::string& what) {
  core::Memory memory;
  FaceNeighbours table(memory);
  ASSERT_TRUE(FaceNeighbours::fits(view)) << what;
  table.build(view, threads);
  EXPECT_EQ(memory.current(INSITU_MEMORY_NEIGHBOURS), FaceNeighbours::bytes(view, threads)) << what;
  EXPECT_EQ(memory.current(), memory.current(INSITU_MEMORY_NEIGHBOURS)) << what;
  std::map<Key, std::vector<HalfFace>> faces;
  int most = 0;
  for (std::int64_t flat = 0; flat < view.cell_count(); ++flat) {
    mesh::CellVertices cell;
    mesh::gather(view, flat, cell);
    const cells::FaceTable& of = cells::face_table(cell.shape);
    most = std::max(most, of.face_count);
    for (int f = 0; f < of.face_count; ++f) {
      std::vector<std::uint32_t> cycle;
      for (int k = 0; k < of.faces[f].vertex_count; ++k)
        cycle.push_back(
            std::uint32_t(view.first_vertex[cell.piece] + cell.ids[of.faces[f].vertices[k]]));
      Key key;
      if (view.pieces[cell.piece].owns(flat - view.first_cell[cell.piece]) && key_of(cycle, key))
        faces[key].push_back({flat, f});
      else
        EXPECT_EQ(table.across(flat, f), -1) << what;
    }
  }
  EXPECT_EQ(memory.current(), 4 * most * view.cell_count()) << what;
  std::int64_t wrong = 0, paired = 0;
  for (auto& [key, of] : faces) {
    if (of.size() > 1) {
      of[0].other = of[1].cell;
      of[1].other = of[0].cell;
      ++paired;
    }
    for (const HalfFace& h : of)
      wrong += table.across(h.cell, h.face) != h.other;
  }
  EXPECT_EQ(wrong, 0) << what;
  EXPECT_GT(paired, 0) << what;
}

} // namespace

TEST(FaceNeighbours, AreThoseOfAMapOfAllFaces) {
  for (const MeshKind kind : all_kinds) {
    const fixtures::Committed m(test::make_mesh({.kind = kind, .size = 6}, 5));
    expect_neighbours(m.mesh.mesh().view(), m.threads, "kind " + std::to_string(int(kind)));
  }
}

/// Collapsed cells, some twice or three times, ghosts, and a second piece.
TEST(FaceNeighbours, OfOddMeshes) {
  test::Random random(23);
  for (const MeshKind kind : all_kinds) {
    test::OddMesh odd(test::make_mesh({.kind = kind, .size = 5}, 6), random);
    odd.set_ghosts();
    odd.add_piece(1);
    odd.mesh.update();
    expect_neighbours(odd.mesh.view(), core::Threads(2), "kind " + std::to_string(int(kind)));
  }
}

TEST(FaceNeighbours, AreTheSameForAnyThreadCount) {
  const fixtures::Committed m(test::make_mesh({.kind = MeshKind::mixed, .size = 28}, 7));
  const mesh::MeshView& view = m.mesh.mesh().view();
  ASSERT_GT(view.cell_count(), 2 * 16384) << "more than a chunk";
  core::Memory memory;
  FaceNeighbours one(memory), many(memory);
  one.build(view, core::Threads(1));
  many.build(view, core::Threads(4));
  std::int64_t different = 0;
  for (std::int64_t c = 0; c < view.cell_count(); ++c)
    for (int f = 0; f < 4; ++f)
      different += one.across(c, f) != many.across(c, f);
  EXPECT_EQ(different, 0);
}
