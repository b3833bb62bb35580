// Cells that no other cell overlaps, found by degree, and what `exact` makes of them: the lowest id
// of all cells that hold a point, by brute force, whatever overlaps.
#include <atomic>
#include <cmath>
#include <functional>
#include <latch>
#include <thread>
#include <utility>

#include "mesh/box.h"
#include "mesh/piece_borders.h"
#include "query/batch/guessed_batches.h"
#include "query/on_demand.h"
#include "query_test.h"

using namespace insitu;
using math::Vec3d;
using test::all_kinds;
using test::box;
using test::kind_name;
using test::MeshKind;
using test::TestMesh;

namespace {

constexpr double pi = 3.14159265358979323846;

/// All cells the right way round; the fixtures' tetrahedra are mirrored by halves.
TestMesh upright(TestMesh mesh) {
  for (auto& cell : mesh.cells) {
    const auto x = mesh.cell_vertices(cell);
    if (cell.shape == mesh::Shape::tetrahedron &&
        dot(x[1] - x[0], cross(x[2] - x[0], x[3] - x[0])) < 0)
      std::swap(cell.vertices[2], cell.vertices[3]);
  }
  return mesh;
}

using Map = std::function<Vec3d(const Vec3d&)>;

TestMesh moved(TestMesh mesh, const Map& to) {
  for (Vec3d& v : mesh.vertices)
    v = to(v);
  return mesh;
}

/// Adds the other mesh's vertices and cells, which stay apart from those that are there.
void add(TestMesh& mesh, const TestMesh& other) {
  const int first = int(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (test::MeshCell cell : other.cells) {
    for (int v = 0; v < mesh::vertex_count(cell.shape); ++v)
      cell.vertices[std::size_t(v)] += first;
    mesh.cells.push_back(cell);
  }
}

/// The place in the box as parts of its edges.
Vec3d parts(const TestMesh& mesh, const Vec3d& p) {
  Vec3d part;
  for (int a = 0; a < 3; ++a)
    part[a] = (p[a] - mesh.low[a]) / (mesh.high[a] - mesh.low[a]);
  return part;
}

/// A band that is wound so many times round an axis, all turns at the same place.
TestMesh wound(const TestMesh& from, double turns) {
  return moved(from, [&](const Vec3d& p) {
    const Vec3d at = parts(from, p);
    const double angle = -2 * pi * turns * at.x, radius = 1.0 + at.y;
    return Vec3d{radius * std::cos(angle), radius * std::sin(angle), at.z};
  });
}

const query::LoneCells& lone_cells(const fixtures::Committed& m) {
  return *m.sampler().on_demand()->lone;
}

/// So many cells are found to be alone; 0 where none is known.
std::int64_t find(const fixtures::Committed& m) {
  const query::LoneCells& lone = lone_cells(m);
  const mesh::MeshView& view = m.mesh.mesh().view();
  m.sampler().tree();
  lone.find(view, m.threads);
  std::int64_t count = 0;
  for (std::int64_t c = 0; c < view.cell_count() && lone.are_known(); ++c)
    count += lone.has(c);
  return count;
}

/// By the definition: the lowest of the owning cells that hold the point, and how many there are.
struct Holding {
  std::int64_t lowest = -1, count = 0;
};
Holding cells_that_hold(const mesh::MeshView& view, const Vec3d& p) {
  Holding found;
  for (std::int64_t c = 0; c < view.cell_count(); ++c) {
    const std::int32_t piece = view.piece_of(c);
    if (!view.pieces[piece].owns(c - view.first_cell[piece]))
      continue;
    mesh::CellVertices cell;
    mesh::gather(view, c, cell);
    if (!mesh::box_of(cell).holds(p) ||
        !cells::holds(cells::contain_exact(cell.shape, cell.x, p).where))
      continue;
    found.lowest = found.count++ == 0 ? c : found.lowest;
  }
  return found;
}

/// Finds the cells that are alone, and holds them against all cells: a point within one is in no
/// other. `exact` then names the lowest id, in batches and one by one. Returns how many are alone.
std::int64_t check(const fixtures::Committed& m, const std::string& what, int count = 300,
                   std::uint64_t seed = 17) {
  const std::int64_t alone = find(m);
  const mesh::MeshView& view = m.mesh.mesh().view();
  const query::LoneCells& lone = lone_cells(m);
  std::vector<Vec3d> points = test::inner_points(view, count, seed);
  const std::vector<Vec3d> hard = test::hard_points(view, count / 3, seed + 1);
  points.insert(points.end(), hard.begin(), hard.end());
  std::vector<query::Location> batch(points.size());
  m.sampler().locate(m.threads, points, batch, {INSITU_EXACT, 1.0});
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::int64_t want = cells_that_hold(view, points[i]).lowest;
    EXPECT_EQ(batch[i].cell, want) << what << ", point " << test::text(points[i]);
    const query::Location one = m.sampler().locate(points[i], -1, {INSITU_EXACT, 1.0});
    EXPECT_TRUE(test::same_bits(one, batch[i])) << what << ", point " << test::text(points[i]);
    if (testing::Test::HasFailure())
      return alone;
  }
  test::Random random(seed);
  const std::int64_t cells = view.cell_count(), step = std::max<std::int64_t>(1, alone / count);
  std::int64_t turn = 0;
  for (std::int64_t c = 0; c < cells && alone > 0; ++c) {
    if (!lone.has(c) || ++turn % step != 0)
      continue;
    mesh::CellVertices cell;
    mesh::gather(view, c, cell);
    const Vec3d p = cells::map_to_physical(
        cell.shape, cell.x, fixtures::random_parametric(cell.shape, seed, std::uint64_t(c)));
    if (!cells::holds(cells::contain_exact(cell.shape, cell.x, p).where))
      continue; // by rounding
    EXPECT_EQ(cells_that_hold(view, p).count, 1)
        << what << ", cell " << c << " is not alone at " << test::text(p);
    if (testing::Test::HasFailure())
      return alone;
  }
  return alone;
}

double share(const fixtures::Committed& m, std::int64_t count) {
  return double(count) / double(m.mesh.mesh().view().cell_count());
}

} // namespace

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

TEST(LoneCells, AreForgottenWhenVerticesMove) {
  fixtures::Committed m(box(MeshKind::hexahedra, 12, 0.0));
  const std::vector<double> before = m.arrays.points;
  const double edge = before.back() - before[2];
  const std::int64_t all = check(m, "at first");
  EXPECT_GT(all, 0);
  for (const double turns : {0.8, 1.6, 0.8}) {
    for (std::size_t v = 0; v < before.size(); v += 3) {
      const double angle = -2 * pi * turns * (before[v] - before[0]) / edge,
                   radius = 1.0 + (before[v + 1] - before[1]) / edge;
      m.arrays.points[v] = radius * std::cos(angle);
      m.arrays.points[v + 1] = radius * std::sin(angle);
    }
    m.commit(INSITU_CHANGED_GEOMETRY);
    EXPECT_FALSE(lone_cells(m).are_known());
    m.sampler().tree();
    lone_cells(m).find(m.mesh.mesh().view(), m.threads);
    EXPECT_FALSE(lone_cells(m).are_known()) << "nobody knows what folds";
    m.mesh.look_for_folds(m.threads);
    ASSERT_TRUE(m.sampler().mesh().free_of_folds);
    const std::int64_t found = check(m, std::to_string(turns) + " turns");
    EXPECT_GT(found, 0) << turns;
    EXPECT_LT(found, turns > 1 ? all / 2 : all) << turns;
  }
  m.commit(INSITU_CHANGED_FIELDS);
  EXPECT_TRUE(lone_cells(m).are_known()) << "the cells are the same";
}

// Found when enough points were asked for, while other threads ask; answers are the same before.
TEST(LoneCells, AreFoundOnceItPays) {
  const fixtures::Committed m(box(MeshKind::hexahedra, 10, 0.1), 2);
  const std::vector<Vec3d> points = test::inner_points(m.mesh.mesh().view(), 3000, 8);
  const query::LocateOptions exact{INSITU_EXACT, 1.0};
  std::vector<query::Location> want(points.size());
  for (int i = 0; i < 40; ++i)
    m.sampler().locate(m.threads, points, want); // `standard` needs none
  EXPECT_FALSE(lone_cells(m).are_known());
  m.sampler().locate(m.threads, points, want, exact);
  EXPECT_FALSE(lone_cells(m).are_known());
  constexpr int count = 3;
  std::latch start(count + 1);
  std::atomic<int> wrong{0};
  std::vector<std::thread> pool;
  for (int t = 0; t < count; ++t)
    pool.emplace_back([&] {
      std::vector<query::Location> got(points.size());
      start.arrive_and_wait();
      for (int round = 0; round < 8; ++round) {
        m.sampler().locate_serial(points, got, exact);
        for (std::size_t i = 0; i < points.size(); ++i) {
          wrong += !test::same_bits(got[i], want[i]);
          wrong +=
              i % 10 == 0 && !test::same_bits(m.sampler().locate(points[i], -1, exact), want[i]);
        }
      }
    });
  start.arrive_and_wait();
  std::vector<query::Location> got(points.size());
  for (int round = 0; round < 8; ++round)
    m.sampler().locate(m.threads, points, got, exact);
  for (std::thread& t : pool)
    t.join();
  EXPECT_EQ(wrong, 0);
  EXPECT_TRUE(lone_cells(m).are_known());
  for (std::size_t i = 0; i < points.size(); ++i)
    ASSERT_TRUE(test::same_bits(got[i], want[i])) << i;
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

// Cells next to each other by number are guessed in `exact` as in `standard`, and not before.
TEST(LoneCells, AreGuessedByNumber) {
  for (const auto kind : {MeshKind::hexahedra, MeshKind::tetrahedra}) {
    const fixtures::Committed m(upright(box(kind, 20, 0.1)), 1);
    const mesh::MeshView& view = m.mesh.mesh().view();
    const query::LocateOptions exact{INSITU_EXACT, 1.0};
    std::vector<Vec3d> points;
    for (std::int64_t c = 0; c < view.cell_count(); ++c) {
      mesh::CellVertices cell;
      mesh::gather(view, c, cell);
      points.push_back(mesh::middle_of(cell));
    }
    EXPECT_FALSE(query::GuessedBatches::may_pay(m.sampler().point_query(exact)));
    std::vector<query::Location> before(points.size()), after(points.size());
    m.sampler().locate(m.threads, points, before, exact);
    EXPECT_GT(find(m), 0);
    const query::PointQuery query = m.sampler().point_query(exact);
    ASSERT_TRUE(query::GuessedBatches::may_pay(query));
    query::BatchScratch scratch;
    query::BatchLocator tree(query, scratch);
    query::BatchAnswers answers;
    query::GuessedBatches guessed(query, scratch, tree, answers);
    for (std::size_t begin = 0; begin < points.size(); begin += query::GuessedBatches::grain)
      guessed.run(std::span(points).subspan(begin),
                  std::min(query::GuessedBatches::grain, points.size() - begin),
                  [&](std::size_t first, const query::Answered& answered) {
                    for (std::size_t k = 0; k < answered.locations.size(); ++k)
                      after[begin + first + answered.item(k)] = answered.locations[k];
                  });
    for (std::size_t i = 0; i < points.size(); ++i)
      ASSERT_TRUE(test::same_bits(before[i], after[i])) << kind_name(kind) << ", point " << i;
    EXPECT_GT(guessed.proven(), std::int64_t(points.size() / 2)) << kind_name(kind);
  }
}
