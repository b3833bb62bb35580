// Dual meshes that are known by heart.
#include <gtest/gtest.h>

#include "check_dual.h"

using namespace insitu;
using test::AmrMesh;
using test::Expect;

namespace {

/// Builds and checks; returns the counts.
amr::DualCounts build(AmrMesh& mesh, const Expect& expect = {}) {
  core::Memory memory;
  amr::DualMesh dual(memory);
  dual.build(mesh.view(), core::Threads(2));
  EXPECT_EQ(test::check_dual(mesh, dual, expect).problem, "");
  EXPECT_EQ(memory.current(INSITU_MEMORY_AMR), dual.bytes());
  return dual.counts();
}

} // namespace

TEST(DualMesh, Nothing) {
  AmrMesh mesh;
  EXPECT_EQ(build(mesh).stitching(), 0);
}

TEST(DualMesh, OneCell) {
  AmrMesh mesh;
  mesh.add_patch(0, {5, -3, 2}, {1, 1, 1});
  const amr::DualCounts n = build(mesh);
  EXPECT_EQ(n.gridlets, 0);
  EXPECT_EQ(n.hexahedra, 8);
  EXPECT_EQ(n.boundary, 8);
}

TEST(DualMesh, OneLevel) {
  AmrMesh mesh;
  mesh.add_patch(0, {-9, 4, 0}, {17, 9, 12});
  const amr::DualCounts n = build(mesh);
  EXPECT_EQ(n.cubes, 16 * 8 * 11);
  EXPECT_EQ(n.boundary, 18 * 10 * 13 - n.cubes);
  EXPECT_EQ(n.stitching(), n.boundary);
  EXPECT_EQ(n.empty, 0);
}

TEST(DualMesh, OneCellRefined) {
  AmrMesh mesh;
  mesh.depth_of = {0, 1};
  mesh.add_patch(0, {0, 0, 0}, {5, 5, 5});
  mesh.add_patch(1, {4, 4, 4}, {2, 2, 2});
  const amr::DualCounts n = build(mesh);
  EXPECT_EQ(n.masked, 1);
  // Of the 26 corners on the refined cell's surface, 8 have cells of seven coarse leaves and a fine
  // one; at the middles of 12 edges lie wedges, of 6 faces pyramids. The corner in it is a cube.
  EXPECT_EQ(n.pyramids, 6);
  EXPECT_EQ(n.wedges, 0);
  EXPECT_EQ(n.collapsed, 12);
  EXPECT_EQ(n.folded, 0);
}
