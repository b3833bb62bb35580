// When trees are built anew, and how: by what was measured and asked.
#include <cstring>
#include <gtest/gtest.h>

#include "commit/tree_policy.h"
#include "fixtures/committed.h"

using namespace insitu;
using accel::Builder;
using commit::TreePolicy;

namespace {

constexpr std::int64_t cell_total = 1000000;

/// One that has seen a build in Morton order of a second.
TreePolicy built_once() {
  TreePolicy policy;
  policy.topology_changed();
  policy.built(Builder::morton, 1.0, cell_total, 100.0);
  return policy;
}

} // namespace

TEST(TreePolicy, StartsInMortonOrderAndRefits) {
  TreePolicy policy;
  EXPECT_EQ(policy.builder(), Builder::morton);
  EXPECT_FALSE(policy.surface_area_is_due());
  policy = built_once();
  EXPECT_EQ(policy.builder(), Builder::morton);
  EXPECT_FALSE(policy.rebuild_is_due(1.0));
  EXPECT_FALSE(policy.rebuild_is_due(TreePolicy::rebuild_ratio));
  EXPECT_TRUE(policy.rebuild_is_due(1.31)); // whatever was asked
  EXPECT_FALSE(policy.surface_area_is_due());
}

TEST(TreePolicy, RebuildsOnceQueriesLostWhatItCosts) {
  TreePolicy policy = built_once();
  // Half a million points spend a second; at a ratio of 1.2 they lose a fifth of it.
  int commits = 0;
  for (; commits < 100 && !policy.rebuild_is_due(1.2); ++commits)
    policy.served(cell_total / 2, 0, 1.2);
  EXPECT_NEAR(commits, 5, 1);
  policy.built(Builder::morton, 1.0, cell_total, 100.0);
  EXPECT_FALSE(policy.rebuild_is_due(1.2));
  TreePolicy idle = built_once();
  for (int i = 0; i < 1000; ++i)
    idle.served(0, 0, 1.29);
  EXPECT_FALSE(idle.rebuild_is_due(1.29));
}

TEST(TreePolicy, BuildsBySurfaceAreaOnceItWouldHavePaid) {
  TreePolicy policy = built_once();
  std::int64_t asked = 0;
  while (asked < 1000 * cell_total && !policy.surface_area_is_due()) {
    policy.served(cell_total, 0, 1.0);
    asked += cell_total;
  }
  EXPECT_GT(asked, 5 * cell_total);
  EXPECT_LT(asked, 100 * cell_total);
  EXPECT_EQ(policy.builder(), Builder::surface_area);
  policy.built(Builder::surface_area, 4.0, cell_total, 80.0);
  EXPECT_FALSE(policy.surface_area_is_due()); // it stands
  EXPECT_EQ(policy.builder(), Builder::surface_area);
  policy.topology_changed(); // all that is over
  EXPECT_EQ(policy.builder(), Builder::morton);
}

// Frames of new values never make a tree anew; but one that is made for other reasons is made for
// them too.
TEST(TreePolicy, FramesAloneMakeNoTreeAnew) {
  TreePolicy policy = built_once();
  policy.served(1000 * cell_total, 1000 * cell_total, 1.0);
  EXPECT_FALSE(policy.surface_area_is_due());
  EXPECT_EQ(policy.builder(), Builder::surface_area);
  policy.served(1000 * cell_total, 0, 1.0);
  EXPECT_TRUE(policy.surface_area_is_due());
  policy = built_once();
  policy.served(10 * cell_total, 10 * cell_total, 1.2);
  EXPECT_TRUE(policy.rebuild_is_due(1.2)); // of a refitted tree they lose as much as others
}

// What was measured replaces what was assumed: a tree that gained nothing is not built again.
TEST(TreePolicy, LearnsWhatItGained) {
  TreePolicy policy = built_once();
  policy.served(1000 * cell_total, 0, 1.0);
  ASSERT_EQ(policy.builder(), Builder::surface_area);
  policy.built(Builder::surface_area, 4.0, cell_total, 100.0);
  EXPECT_EQ(policy.builder(), Builder::morton);
  // And one that cost far more than was thought waits for longer.
  TreePolicy dear = built_once();
  dear.served(100 * cell_total, 0, 1.0);
  ASSERT_TRUE(dear.surface_area_is_due());
  dear.built(Builder::surface_area, 4000.0, cell_total, 90.0);
  EXPECT_EQ(dear.builder(), Builder::morton);
}

TEST(TreePolicy, IsOverruled) {
  TreePolicy policy = built_once();
  policy.served(1000 * cell_total, 0, 1.0);
  policy.set_builder(Builder::morton);
  EXPECT_EQ(policy.builder(), Builder::morton);
  EXPECT_FALSE(policy.surface_area_is_due());
  policy.set_builder(Builder::surface_area);
  EXPECT_EQ(policy.builder(), Builder::surface_area);
  EXPECT_FALSE(policy.surface_area_is_due()); // at the next build
  TreePolicy empty;
  empty.built(Builder::morton, 0.0, 0, 0.0);
  empty.served(100, 0, 1.0);
  EXPECT_FALSE(empty.rebuild_is_due(1.0));
  EXPECT_FALSE(empty.surface_area_is_due());
}

// The same through commits, with queries that are really asked.
TEST(Commit, ReportsTheBuilderAndChangesItWhenQueriesPayForIt) {
  test::Random random(74);
  test::MeshOptions options;
  options.kind = test::MeshKind::tetrahedra;
  options.size = 4;
  fixtures::Committed m(test::make_mesh(options, random));
  EXPECT_EQ(m.commit().builder, INSITU_BUILDER_MORTON);
  EXPECT_EQ(m.commit(INSITU_CHANGED_FIELDS).action, INSITU_KEEP);
  std::vector<math::Vec3d> points;
  for (int i = 0; i < 200 * int(m.arrays.cell_count()); ++i)
    points.push_back(random.uniform(m.mesh.tree().bounds_min(), m.mesh.tree().bounds_max()));
  std::vector<query::Location> before(points.size()), after(points.size());
  m.sampler().locate(m.threads, points, before);
  EXPECT_EQ(m.commit().action, INSITU_KEEP); // nothing was said to have changed
  const std::uint64_t version = m.mesh.tree_version();
  const insitu_commit_report report = m.commit(INSITU_CHANGED_FIELDS);
  EXPECT_EQ(report.action, INSITU_REBUILD);
  EXPECT_EQ(report.builder, INSITU_BUILDER_SURFACE_AREA);
  EXPECT_EQ(report.validated, 0);
  EXPECT_GT(m.mesh.tree_version(), version);
  m.sampler().locate(m.threads, points, after);
  for (std::size_t i = 0; i < points.size(); ++i) {
    ASSERT_EQ(before[i].cell, after[i].cell);
    ASSERT_EQ(std::memcmp(&before[i].parametric, &after[i].parametric, sizeof(math::Vec3d)), 0);
  }
  EXPECT_EQ(m.commit(INSITU_CHANGED_GEOMETRY).builder, INSITU_BUILDER_SURFACE_AREA);
  EXPECT_EQ(m.commit(INSITU_CHANGED_TOPOLOGY).builder, INSITU_BUILDER_MORTON);
  m.mesh.set_builder(Builder::surface_area);
  EXPECT_EQ(m.commit(INSITU_CHANGED_TOPOLOGY).builder, INSITU_BUILDER_SURFACE_AREA);
}

TEST(Commit, ReportsNoBuilderWhereNoCellMayOwnPoints) {
  fixtures::Committed m(test::make_mesh({.size = 2}, 75));
  const std::vector<std::uint8_t> bits(std::size_t(m.arrays.cell_count()), 1);
  const insitu_array ghosts =
      insitu_array_of(bits.data(), INSITU_UINT8, std::int64_t(bits.size()), 1);
  m.mesh.mesh().set_ghosts(0, &ghosts, INSITU_GHOSTS_VTK);
  EXPECT_EQ(m.commit().builder, INSITU_BUILDER_NONE);
}
