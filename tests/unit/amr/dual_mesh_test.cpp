// Dual meshes that are known by heart.
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>

#include "cells/kernels/kernels.h"
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

/// All bytes that a dual mesh holds and shows.
std::string bytes_of(AmrMesh& mesh, int threads) {
  core::Memory memory;
  amr::DualMesh dual(memory);
  dual.build(mesh.view(), core::Threads(threads));
  std::string bytes;
  const auto add = [&](const void* p, std::size_t n) {
    bytes.append(static_cast<const char*>(p), n);
  };
  const mesh::MeshView& view = dual.view();
  const mesh::GridletsView& g = *view.pieces[0].gridlets;
  add(g.gridlets, std::size_t(g.count) * sizeof *g.gridlets);
  add(g.full, std::size_t(g.count) * 64);
  add(g.leaves, std::size_t(view.pieces[0].vertex_count) * 4);
  const mesh::PieceView& s = view.pieces[1];
  add(s.connectivity.data, std::size_t(s.cell_count) * 32);
  add(s.points.component[0], std::size_t(s.vertex_count) * 24);
  for (std::int64_t v = 0; v < s.vertex_count; ++v) {
    const amr::DualMesh::Terms t = dual.terms(v);
    add(t.leaves, std::size_t(t.count) * 4);
    if (t.weights)
      add(t.weights, std::size_t(t.count) * 8);
    if (t.ghosts)
      add(t.ghosts, std::size_t(t.count));
  }
  const amr::DualCounts n = dual.counts();
  add(&n, sizeof n);
  return bytes;
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

TEST(DualMesh, OneCellRefinedFourTimesInPlace) {
  for (const std::int64_t wide : {3, 5}) {
    AmrMesh mesh;
    mesh.depth_of = {0, 4};
    mesh.add_patch(0, {0, 0, 0}, {wide, wide, wide});
    mesh.add_patch(1, {16 * (wide / 2), 16 * (wide / 2), 16 * (wide / 2)}, {16, 16, 16});
    const amr::DualCounts n = build(mesh);
    EXPECT_GT(n.folded, 0);
    EXPECT_GT(n.repaired, 0);
    EXPECT_EQ(n.still_folded, 0);
    std::printf("%lld folded, %lld virtual leaves\n", (long long)n.folded, (long long)n.repaired);
  }
}

TEST(DualMesh, SplitLeavesKeepTheirValues) {
  AmrMesh mesh;
  mesh.depth_of = {0, 2};
  mesh.add_patch(0, {0, 0, 0}, {3, 3, 3});
  mesh.add_patch(1, {4, 4, 4}, {4, 4, 4});
  core::Memory memory;
  amr::DualMesh dual(memory);
  dual.build(mesh.view(), core::Threads(1));
  const auto value = [](std::uint32_t leaf) { return core::random_unit(3, leaf, 0); };
  const mesh::PieceView& piece = dual.view().pieces[1];
  int found = 0;
  for (std::int64_t c = 0; c < piece.cell_count; ++c) {
    std::int64_t ids[8];
    math::Vec3d x[8];
    double f[8], n[8], at_middle = 0.0;
    bool split = piece.vertex_ids(c, ids) == 8;
    for (int v = 0; split && v < 8; ++v) {
      const amr::DualMesh::Terms t = dual.terms(ids[v]);
      split = t.weights != nullptr && t.leaves[0] == dual.terms(ids[0]).leaves[0];
      x[v] = piece.point(ids[v]);
      f[v] = 0.0;
      for (int m = 0; split && m < t.count; ++m)
        f[v] += t.weights[m] * value(t.leaves[m]);
    }
    const math::Vec3d middle = {0.5, 0.5, 0.5};
    if (!split)
      continue;
    const math::Vec3d p = cells::map_to_physical(piece.shape(c), x, middle);
    const amr::LeafMap::Leaf leaf = dual.leaves().find(p);
    bool centre = bool(leaf);
    for (int a = 0; a < 3; ++a)
      centre &=
          std::abs(p[a] - mesh.lattice.centre(a, leaf.cell.depth, leaf.cell.index[a])) < 1e-12;
    if (!centre)
      continue;
    ++found;
    cells::shape_functions(piece.shape(c), middle, n);
    for (int v = 0; v < 8; ++v)
      at_middle += n[v] * f[v];
    EXPECT_NEAR(at_middle, value(leaf.id), 1e-14);
  }
  EXPECT_GT(found, 0);
}

TEST(DualMesh, HolesAndSteps) {
  AmrMesh ring, stairs, touching, corner;
  for (std::int64_t n = 0; n < 27; ++n) // a cube without its middle
    if (n != 13)
      ring.add_leaf(0, {n % 3, n / 3 % 3, n / 9});
  {
    SCOPED_TRACE("ring");
    build(ring);
  }
  for (std::int64_t n = 0; n < 4; ++n)
    stairs.add_patch(0, {n, 0, 0}, {1, 4 - n, 2});
  {
    SCOPED_TRACE("stairs");
    build(stairs);
  }
  touching.add_leaf(0, {0, 0, 0}); // along an edge, and at a corner
  touching.add_leaf(0, {1, 1, 0});
  touching.add_leaf(0, {2, 2, 1});
  {
    SCOPED_TRACE("touching");
    build(touching);
  }
  corner.depth_of = {0, 1}; // fine leaves on part of a coarse one's face
  corner.add_leaf(0, {0, 0, 0});
  corner.add_leaf(1, {2, 0, 0});
  corner.add_leaf(1, {2, 1, 1});
  {
    SCOPED_TRACE("corner");
    // A plane face of the coarse leaf's cells meets two triangles: all of the leaf's value.
    build(corner, {.conforming = false});
  }
}

TEST(DualMesh, AnyThreadCountGivesTheSame) {
  for (int kind = 0; kind <= 5; ++kind)
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      AmrMesh mesh = test::make_mesh({seed, kind, 2, kind == 5 ? 6 : kind == 2 ? 3 : 4});
      EXPECT_EQ(bytes_of(mesh, 1) == bytes_of(mesh, 2), true) << kind << ", seed " << seed;
      mesh.give_ghosts();
      EXPECT_EQ(bytes_of(mesh, 1) == bytes_of(mesh, 2), true)
          << kind << ", seed " << seed << ", with ghosts";
    }
}

TEST(DualMesh, BlocksCompress) {
  // The paper's accounting (Zellmann 2023, table 1): hexahedra of 8 ids and vertices of 4 floats
  // against gridlets of 32 bytes and a scalar a vertex.
  AmrMesh mesh;
  mesh.depth_of = {0, 1};
  mesh.add_patch(0, {0, 0, 0}, {32, 32, 32});
  mesh.add_patch(1, {16, 16, 16}, {32, 32, 16});
  core::Memory memory;
  amr::DualMesh dual(memory);
  dual.build(mesh.view(), core::Threads(2));
  const amr::DualCounts& n = dual.counts();
  const double plain = 32.0 * double(n.cubes) + 16.0 * double(n.leaves);
  EXPECT_GT(plain / (32.0 * double(n.gridlets) + 4.0 * double(n.scalars)), 7.5);
}
