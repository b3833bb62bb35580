// Points that follow each other: cells guessed by number, with the tree's answers to the bit.
#include <limits>
#include <utility>

#include "query/batch/guessed_batches.h"
#include "query_test.h"

using namespace insitu;
using math::Vec3d;
using query::GuessedBatches;
using test::all_kinds;
using test::box;
using test::same_bits;

namespace {

/// A point in each cell, in the cells' order, near its middle.
std::vector<Vec3d> centres(const mesh::MeshView& view) {
  std::vector<Vec3d> points;
  for (std::int64_t c = 0; c < view.cell_count(); ++c) {
    mesh::CellVertices cell;
    mesh::gather(view, c, cell);
    Vec3d sum;
    for (int v = 0; v < cell.count; ++v)
      sum += cell.x[v];
    points.push_back(sum / double(cell.count));
  }
  return points;
}

/// The fixtures' tetrahedra are mirrored by halves, which proofs take for folds.
test::TestMesh unfolded(test::MeshKind kind, int size) {
  test::TestMesh mesh = box(kind, size, 0.1);
  for (auto& cell : mesh.cells) {
    const auto x = mesh.cell_vertices(cell);
    if (cell.shape == mesh::Shape::tetrahedron &&
        dot(x[1] - x[0], cross(x[2] - x[0], x[3] - x[0])) < 0)
      std::swap(cell.vertices[2], cell.vertices[3]);
  }
  return mesh;
}

/// n points of a raster over the unit box and a little beyond, x fastest.
std::vector<Vec3d> raster(int columns, int rows, std::size_t n) {
  std::vector<Vec3d> points;
  for (std::size_t i = 0; i < n; ++i) {
    const double x = double(i % std::size_t(columns)), y = double(i / std::size_t(columns));
    points.push_back({-0.02 + 1.04 * x / columns, 1.02 * y / rows, 0.377});
  }
  return points;
}

/// Grains of at most GuessedBatches::grain points; holds the answers against single points'.
/// Returns how many points guesses answered.
std::int64_t check(const fixtures::Committed& m, const std::vector<Vec3d>& points,
                   const std::string& what) {
  const query::Sampler sampler = m.sampler();
  const query::PointQuery query{sampler.mesh(), sampler.tree(), {}};
  EXPECT_TRUE(GuessedBatches::may_pay(query)) << what;
  query::BatchScratch scratch;
  query::BatchLocator tree(query, scratch);
  query::BatchAnswers answers;
  GuessedBatches guessed(query, scratch, tree, answers);
  std::vector<int> visits(points.size());
  for (std::size_t begin = 0; begin < points.size(); begin += GuessedBatches::grain) {
    const std::size_t n = std::min(GuessedBatches::grain, points.size() - begin);
    guessed.run(std::span(points).subspan(begin), n, [&](std::size_t first, const auto& answered) {
      for (std::size_t k = 0; k < answered.locations.size(); ++k) {
        const std::size_t i = begin + first + answered.item(k);
        ++visits[i];
        query::Reason why;
        const query::Location one = sampler.locate(points[i], -1, {}, &why);
        ASSERT_TRUE(same_bits(one, answered.locations[k]))
            << what << ", point " << i << " " << test::text(points[i]) << ": cell "
            << answered.locations[k].cell << ", alone " << one.cell;
        ASSERT_EQ(answered.reasons[k] == query::Reason::outside, why == query::Reason::outside);
      }
    });
  }
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_EQ(visits[i], 1) << what << ", point " << i;
  return guessed.proven();
}

} // namespace

TEST(Guessed, CellCentresInOrderAreMostlyProvenWithoutTheTree) {
  for (const auto kind : all_kinds) {
    const fixtures::Committed m(unfolded(kind, 24), 1);
    const std::vector<Vec3d> points = centres(m.mesh.mesh().view());
    const std::int64_t proven = check(m, points, kind_name(kind));
    // All but the trials, a sixteenth, and those whose cells are known, one in 32.
    EXPECT_GT(double(proven), 0.85 * double(points.size())) << kind_name(kind);
  }
}

TEST(Guessed, FineRastersAreMostlyProvenAndRandomPointsAreNotGuessed) {
  const fixtures::Committed m(box(test::MeshKind::hexahedra, 12), 1);
  EXPECT_GT(check(m, raster(400, 30, 12000), "fine"), 6000);
  check(m, raster(9, 2000, 12000), "coarse");
  const std::vector<Vec3d> random = test::inner_points(m.mesh.mesh().view(), 12000, 41);
  EXPECT_EQ(check(m, random, "random"), 0);
}

// What the first batch promises, the rest of the grain need not keep.
TEST(Guessed, RowsThatEndInAGrain) {
  const fixtures::Committed m(box(test::MeshKind::wedges, 12), 1);
  std::vector<Vec3d> points = centres(m.mesh.mesh().view());
  const std::vector<Vec3d> random = test::inner_points(m.mesh.mesh().view(), 2000, 42);
  points.resize(GuessedBatches::grain);
  std::copy(random.begin(), random.end(), points.begin() + 700);
  points[300].x = std::numeric_limits<double>::quiet_NaN();
  points[301].y = std::numeric_limits<double>::infinity();
  for (int i = 320; i < 400; ++i) // anchors among them
    points[std::size_t(i)].z += 50.0;
  check(m, points, "rows that end");
  for (const std::size_t n : {std::size_t(1), std::size_t(256), std::size_t(512), std::size_t(513),
                              std::size_t(777), std::size_t(1025)})
    check(m, {points.begin(), points.begin() + std::ptrdiff_t(n)}, std::to_string(n) + " points");
}

// Grains of a batch are the same for any threads.
TEST(Guessed, BatchesOfRowsAnswerAsOneByOneForAnyThreads) {
  for (const int threads : {1, 4}) {
    const fixtures::Committed m(box(test::MeshKind::hexahedra, 24), threads);
    const std::vector<Vec3d> points = raster(150, 110, 15001);
    std::vector<query::Location> found(points.size());
    m.sampler().locate(m.threads, points, found);
    for (std::size_t i = 0; i < points.size(); ++i)
      ASSERT_TRUE(same_bits(m.sampler().locate(points[i]), found[i]))
          << threads << " threads, point " << i << " " << test::text(points[i]);
  }
}

// A guess may hit upon a cell that owns nothing.
TEST(Guessed, GhostCellsAreNotGuessed) {
  fixtures::Committed m(box(test::MeshKind::hexahedra, 16), 1);
  const std::int64_t cells = m.mesh.mesh().view().cell_count();
  std::vector<std::uint8_t> ghosts(std::size_t(cells), 0);
  for (std::size_t c = 3; c < ghosts.size(); c += 29)
    ghosts[c] = 1; // VTK's duplicate cell
  const insitu_array bits = insitu_array_of(ghosts.data(), INSITU_UINT8, cells, 1);
  m.mesh.mesh().set_ghosts(0, &bits, INSITU_GHOSTS_VTK);
  m.commit(INSITU_CHANGED_TOPOLOGY);
  EXPECT_GT(check(m, centres(m.mesh.mesh().view()), "ghosts"), 2500);
}

// A few folded cells spoil the proofs about them alone.
TEST(Guessed, AroundFoldedCellsTheTreeAnswers) {
  test::TestMesh from = box(test::MeshKind::hexahedra, 16, 0.1);
  const auto& middle = from.cells[from.cells.size() / 2 + 8].vertices;
  from.vertices[std::size_t(middle[0])] = from.vertices[std::size_t(middle[6])];
  from.vertices[std::size_t(middle[0])].x += 0.03;
  const fixtures::Committed m(from, 1);
  ASSERT_FALSE(m.sampler().mesh().free_of_folds);
  EXPECT_GT(check(m, centres(m.mesh.mesh().view()), "folds"), 3000);
}

TEST(Guessed, OnlyWhereAProofIsEnough) {
  const fixtures::Committed m(box(test::MeshKind::hexahedra, 4), 1);
  const query::Sampler sampler = m.sampler();
  const query::LocateOptions exact{INSITU_EXACT, 1.0}, between{INSITU_STANDARD, 0.5};
  EXPECT_FALSE(GuessedBatches::may_pay({sampler.mesh(), sampler.tree(), exact}));
  EXPECT_FALSE(GuessedBatches::may_pay({sampler.mesh(), sampler.tree(), between}));
}
