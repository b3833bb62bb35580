// When cells that are alone are found and forgotten, and guesses at them.
#include "lone_cells_test.h"

using namespace insitu;
using namespace insitu::test;
using math::Vec3d;

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
