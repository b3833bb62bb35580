// Cells that no other cell overlaps, found by degree, and what `exact` makes of them: the lowest id
// of all cells that hold a point, by brute force, whatever overlaps.
#include "lone_cells_test.h"

using namespace insitu;
using namespace insitu::test;
using math::Vec3d;

TEST(LoneCells, AreMostOfABox) {
  for (const auto kind : all_kinds)
    for (const double jitter : {0.0, 0.1}) {
      const fixtures::Committed m(upright(box(kind, 8, jitter, 3.0, {1, 0.1, 7})));
      ASSERT_TRUE(m.sampler().mesh().free_of_folds) << kind_name(kind);
      const std::int64_t alone = check(m, kind_name(kind), 100);
      EXPECT_GT(share(m, alone), kind == MeshKind::tetrahedra ? 0.2 : 0.25) << kind_name(kind);
    }
}

// All cells mirrored: one way round is as good as the other.
TEST(LoneCells, AreFoundInsideOut) {
  const TestMesh from = upright(box(MeshKind::hexahedra, 8, 0.1));
  const fixtures::Committed m(moved(from, [](const Vec3d& p) { return Vec3d{-p.x, p.y, p.z}; }));
  EXPECT_EQ(check(m, "mirrored"), find(fixtures::Committed(from)));
}

// The turns of a band lie in each other; its ends are the only sign of that.
TEST(LoneCells, OfABandWoundOneAndAHalfTimes) {
  for (const auto kind : {MeshKind::hexahedra, MeshKind::wedges, MeshKind::tetrahedra}) {
    const TestMesh from = upright(box(kind, 14, 0.0));
    const fixtures::Committed once(wound(from, 0.9)), overlapping(wound(from, 1.5)),
        twice(wound(from, 2.0));
    ASSERT_TRUE(overlapping.sampler().mesh().free_of_folds) << kind_name(kind);
    const std::int64_t all = check(once, "wound 0.9 times", 60),
                       some = check(overlapping, "wound 1.5 times", 150);
    EXPECT_GT(some, 0) << kind_name(kind);
    EXPECT_LT(some, all / 2) << kind_name(kind);
    EXPECT_EQ(check(twice, "wound twice", 30), 0) << kind_name(kind);
  }
}

TEST(LoneCells, OfTwoBlocksThatOverlap) {
  const TestMesh from = upright(box(MeshKind::hexahedra, 9, 0.1));
  const Vec3d edge = from.high - from.low;
  TestMesh both = from;
  add(both, moved(upright(box(MeshKind::tetrahedra, 9, 0.1, 0.0, {1, 1, 1}, 5)),
                  [&](const Vec3d& p) { return p + 0.5 * edge; }));
  const fixtures::Committed m(both);
  const std::int64_t alone = check(m, "two blocks", 600);
  EXPECT_GT(alone, 100);
  EXPECT_LT(share(m, alone), 0.6);
}

// What lies within another one leaves no trace on that one's boundary.
TEST(LoneCells, OfABlockWithinAnother) {
  const TestMesh outer = box(MeshKind::hexahedra, 14, 0.1);
  const Vec3d middle = 0.5 * (outer.low + outer.high);
  TestMesh both = outer;
  add(both, moved(box(MeshKind::hexahedra, 14, 0.1, 0.0, {1, 1, 1}, 6),
                  [&](const Vec3d& p) { return middle + 0.6 * (p - middle); }));
  const fixtures::Committed m(both), alone(outer);
  const std::int64_t found = check(m, "a block within", 600);
  EXPECT_GT(found, 300);
  EXPECT_LT(found, find(alone) - 500);
  for (std::int64_t c = std::int64_t(outer.cells.size()); c < m.sampler().mesh().cell_count(); ++c)
    EXPECT_FALSE(lone_cells(m).has(c)) << "cell " << c << " of the inner block";
}

// Cells on the same side of the faces that they share turn these the same way.
TEST(LoneCells, OfTwoBlocksOnOneSideOfAFace) {
  const TestMesh from = box(MeshKind::hexahedra, 8, 0.0);
  TestMesh both = from;
  add(both, from);
  const int vertices = int(from.vertices.size());
  for (std::size_t c = from.cells.size(); c < both.cells.size(); ++c)
    for (int& v : both.cells[c].vertices)
      if (both.vertices[std::size_t(v)].x == from.low.x)
        v -= vertices;
  for (int v = vertices; v < 2 * vertices; ++v) // or the cells would lie in each other's places
    both.vertices[std::size_t(v)].x =
        from.low.x + 1.21 * (both.vertices[std::size_t(v)].x - from.low.x);
  EXPECT_EQ(check(fixtures::Committed(both), "on one side"), 0);
  // A block through that face is alone on its other side, and there alone.
  const Vec3d middle = 0.5 * (from.low + from.high);
  add(both, moved(from, [&](const Vec3d& p) {
        const Vec3d by = 0.7 * (p - middle);
        return Vec3d{from.low.x, middle.y, middle.z} + by;
      }));
  const std::int64_t found = check(fixtures::Committed(both), "and one through the face", 900);
  EXPECT_GT(found, 50);
  EXPECT_LT(found, 200);
}

TEST(LoneCells, BesideOddCells) {
  TestMesh folded = box(MeshKind::hexahedra, 12, 0.1);
  const auto middle = folded.cells[folded.cells.size() / 2 + 72 + 6].vertices;
  folded.vertices[std::size_t(middle[0])] += Vec3d{2.3, 1.7, 1.6};
  const fixtures::Committed m(folded), sound(box(MeshKind::hexahedra, 12, 0.1));
  ASSERT_FALSE(m.sampler().mesh().free_of_folds || m.sampler().odd().empty());
  const std::int64_t found = check(m, "folded", 900);
  EXPECT_GT(found, 0);
  EXPECT_LT(found, find(sound));
  TestMesh every = box(MeshKind::hexahedra, 6, 0.0);
  for (std::size_t c = 0; c < every.cells.size(); c += 3)
    std::swap_ranges(every.cells[c].vertices.begin(), every.cells[c].vertices.begin() + 4,
                     every.cells[c].vertices.begin() + 4);
  const fixtures::Committed turned(every);
  EXPECT_EQ(check(turned, "every third turned over"), 0) << "proofs do not count there";
}

// Quads that meet two triangles: slivers between them are in no cell, or in two.
TEST(LoneCells, BesideQuadsThatMeetTriangles) {
  const TestMesh from = upright(box(MeshKind::hexahedra, 10, 0.2));
  constexpr int of_tetrahedra[6][4] = {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6},
                                       {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}};
  TestMesh half = from;
  half.cells.clear();
  std::vector<bool> at_seam;
  for (const test::MeshCell& cell : from.cells) {
    double x = 0.0;
    for (int v = 0; v < 8; ++v)
      x += parts(from, from.vertices[std::size_t(cell.vertices[std::size_t(v)])]).x / 8;
    if (x < 0.5) {
      half.cells.push_back(cell);
      at_seam.push_back(x > 0.4);
      continue;
    }
    for (const auto& corners : of_tetrahedra) {
      test::MeshCell part = cell;
      part.shape = mesh::Shape::tetrahedron;
      for (int v = 0; v < 4; ++v)
        part.vertices[std::size_t(v)] = cell.vertices[std::size_t(corners[v])];
      half.cells.push_back(part);
      at_seam.push_back(false);
    }
  }
  const fixtures::Committed m(upright(half));
  ASSERT_TRUE(m.sampler().mesh().free_of_folds);
  EXPECT_GT(check(m, "quads and triangles", 900), 200);
  for (std::size_t c = 0; c < at_seam.size(); ++c)
    EXPECT_FALSE(at_seam[c] && lone_cells(m).has(std::int64_t(c))) << "cell " << c;
}

// Ghost cells hold nothing: an overlap with one is none, and faces beside it are boundary.
TEST(LoneCells, BesideGhosts) {
  const TestMesh from = box(MeshKind::hexahedra, 10, 0.1);
  TestMesh twice = from;
  add(twice, moved(from, [](const Vec3d& p) { return p + Vec3d{0.3, 0.2, 0.1}; }));
  fixtures::Committed m(twice), alone(from);
  const auto cells = std::int64_t(twice.cells.size());
  EXPECT_EQ(check(m, "both"), 0);
  std::vector<std::uint8_t> ghosts(std::size_t(cells), 0);
  std::fill(ghosts.begin() + cells / 2, ghosts.end(), std::uint8_t(1)); // VTK's duplicate cell
  const insitu_array bits = insitu_array_of(ghosts.data(), INSITU_UINT8, cells, 1);
  m.mesh.mesh().set_ghosts(0, &bits, INSITU_GHOSTS_VTK);
  m.commit(INSITU_CHANGED_TOPOLOGY);
  const std::int64_t all = check(m, "one of ghosts");
  EXPECT_EQ(all, find(alone));
  for (std::int64_t c = 4; c < cells / 2; c += 61)
    ghosts[std::size_t(c)] = 1;
  m.commit(INSITU_CHANGED_TOPOLOGY);
  const std::int64_t some = check(m, "and some of the other");
  EXPECT_GT(some, 0);
  EXPECT_LT(some, all);
}

// Of two pieces the seam is boundary.
TEST(LoneCells, OfSeveralPieces) {
  const TestMesh from = box(MeshKind::hexahedra, 8, 0.0);
  const double edge = from.high.x - from.low.x;
  for (const double by : {1.0, 0.5}) {
    fixtures::Committed m(from);
    const fixtures::SolverArrays second(moved(from, [&](const Vec3d& p) {
      return p + Vec3d{by * edge, 0, 0};
    }));
    const insitu_array a = second.point_array();
    const insitu_cells c = second.cells();
    m.mesh.mesh().set_points(1, &a, 1);
    m.mesh.mesh().set_cells(1, &c);
    m.commit(INSITU_CHANGED_ALL);
    const std::int64_t found = check(m, "pieces " + std::to_string(by));
    EXPECT_EQ(found > 0, by == 1.0) << "pieces that overlap have no proofs";
  }
}

// Blocks bent, wound and laid over each other at random, some cells of them ghosts.
TEST(LoneCells, OfRandomHeapsOfBlocks) {
  for (int size = 2; size <= 9; ++size) // the smallest that fails comes first
    for (std::uint64_t seed = 0; seed < 6; ++seed) {
      test::Random random(1000 * std::uint64_t(size) + seed);
      TestMesh heap;
      const int blocks = 1 + random.below(3);
      for (int b = 0; b < blocks; ++b) {
        const TestMesh block =
            upright(box(all_kinds[random.below(6)], size, random.uniform(0.0, 0.15)));
        const Vec3d at = random.uniform({-0.7, -0.7, -0.7}, {0.7, 0.7, 0.7});
        const double turns = random.uniform(0.02, 0.13) * size, shear = random.uniform(-0.4, 0.4);
        const TestMesh bent = random.below(2)
                                  ? wound(block, turns)
                                  : moved(block, [&](const Vec3d& p) { return parts(block, p); });
        add(heap, moved(bent, [&](const Vec3d& p) {
              return at + Vec3d{p.x + shear * p.y, p.y, p.z - shear * p.x};
            }));
      }
      fixtures::Committed m(heap);
      std::vector<std::uint8_t> ghosts(heap.cells.size(), 0);
      if (random.below(2))
        for (int i = 0; i < size; ++i)
          ghosts[std::size_t(random.below(int(ghosts.size())))] = 1;
      const insitu_array bits =
          insitu_array_of(ghosts.data(), INSITU_UINT8, std::int64_t(ghosts.size()), 1);
      m.mesh.mesh().set_ghosts(0, &bits, INSITU_GHOSTS_VTK);
      m.commit(INSITU_CHANGED_TOPOLOGY);
      check(m, "size " + std::to_string(size) + ", seed " + std::to_string(seed), 60, seed);
      if (HasFailure())
        return;
    }
}
