// The tree as a structure: what it holds, what its boxes hold, how it follows moving vertices.
#include <gtest/gtest.h>

#include "check_tree.h"
#include "core/status.h"
#include "fixtures/committed.h"

using namespace insitu;
using accel::Builder;
using accel::check_tree;
using accel::Node;
using accel::Tree;
using math::Vec3d;

namespace {

constexpr test::MeshKind all_kinds[] = {test::MeshKind::hexahedra,  test::MeshKind::voxels,
                                        test::MeshKind::wedges,     test::MeshKind::pyramids,
                                        test::MeshKind::tetrahedra, test::MeshKind::mixed};

test::TestMesh box(test::MeshKind kind, int size, double offset = 0, Vec3d scale = {1, 1, 1}) {
  return test::make_mesh({.kind = kind, .size = size, .offset = offset, .scale = scale}, 41);
}

std::vector<Vec3d> random_points(const Tree& tree, std::size_t count, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<Vec3d> points;
  for (std::size_t i = 0; i < count; ++i)
    points.push_back(random.uniform(tree.bounds_min(), tree.bounds_max()));
  return points;
}

void expect_same_answers(const query::Sampler& a, const query::Sampler& b,
                         const std::vector<Vec3d>& points) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const query::Location x = a.locate(points[i]), y = b.locate(points[i]);
    ASSERT_EQ(x.cell, y.cell) << "point " << i;
    ASSERT_EQ(std::memcmp(&x.parametric, &y.parametric, sizeof x.parametric), 0) << "point " << i;
  }
}

} // namespace

TEST(Tree, HoldsEveryOwningCellOnce) {
  for (const auto kind : all_kinds)
    for (const Builder builder : {Builder::morton, Builder::surface_area})
      for (const int threads : {1, 2}) {
        fixtures::Committed m(box(kind, 7), threads, builder);
        check_tree(m.mesh.tree(), m.mesh.mesh().view());
        EXPECT_EQ(m.mesh.tree().cell_count(), m.arrays.cell_count());
      }
}

TEST(Tree, OfFewCells) {
  for (const int count : {1, 2, 3, 4, 5, 8, 9, 33}) {
    test::TestMesh few = box(test::MeshKind::hexahedra, 4);
    few.cells.resize(std::size_t(count));
    for (const Builder builder : {Builder::morton, Builder::surface_area}) {
      fixtures::Committed m(few, 1, builder);
      check_tree(m.mesh.tree(), m.mesh.mesh().view());
      for (std::size_t c = 0; c < few.cells.size(); ++c) {
        Vec3d mean{};
        for (const int v : few.cells[c].vertices)
          mean += few.vertices[std::size_t(v)] / 8.0;
        EXPECT_EQ(m.sampler().locate(mean).cell, std::int64_t(c));
      }
    }
  }
}

// Equal Morton codes and equal centres: builders must not run deep, nor drop or repeat cells.
TEST(Tree, OfCellsInOnePlace) {
  test::TestMesh same = box(test::MeshKind::hexahedra, 1);
  same.cells.assign(3000, same.cells[0]);
  for (const Builder builder : {Builder::morton, Builder::surface_area}) {
    fixtures::Committed m(same, 0, builder);
    check_tree(m.mesh.tree(), m.mesh.mesh().view());
    EXPECT_LE(m.mesh.tree().levels().size(), 50u);
    query::LocateOptions options;
    options.accuracy = INSITU_EXACT;
    EXPECT_EQ(m.sampler().locate({0.5, 0.5, 0.5}, -1, options).cell, 0);
    EXPECT_GE(m.sampler().locate({0.5, 0.5, 0.5}).cell, 0);
  }
}

TEST(Tree, FarFromZeroAndOfAnyAspectAndSize) {
  for (const double offset : {1e7, -1e12, 1e-20, 0.0})
    for (const Vec3d scale : {Vec3d{1, 1, 1}, Vec3d{1, 1e-4, 1e4}, Vec3d{1e-3, 1e-3, 1e-3},
                              Vec3d{1e26, 1e26, 1e26}, Vec3d{1e-26, 1e-26, 1e-26}}) {
      if (offset != 0 && scale.x < 1e-20)
        continue; // below the offset's rounding
      fixtures::Committed m(box(test::MeshKind::hexahedra, 5, offset, scale));
      check_tree(m.mesh.tree(), m.mesh.mesh().view());
      EXPECT_EQ(m.commit().cost_ratio, 1.0); // whether floats hold the boxes' areas or not
      EXPECT_EQ(m.commit(INSITU_CHANGED_GEOMETRY).action, INSITU_REFIT);
      check_tree(m.mesh.tree(), m.mesh.mesh().view());
    }
}

TEST(Tree, LeavesGhostsOut) {
  fixtures::Committed m(box(test::MeshKind::mixed, 6));
  std::vector<std::uint8_t> ghosts(m.arrays.types.size());
  test::Random random(42);
  for (std::uint8_t& g : ghosts)
    g = random.below(3) == 0 ? 32 : 0;
  const insitu_array bits = insitu_array_of(ghosts.data(), INSITU_UINT8, m.arrays.cell_count(), 1);
  m.mesh.mesh().set_ghosts(0, &bits, INSITU_GHOSTS_VTK);
  m.commit();
  check_tree(m.mesh.tree(), m.mesh.mesh().view());
  m.commit(INSITU_CHANGED_GEOMETRY);
  check_tree(m.mesh.tree(), m.mesh.mesh().view());
}

TEST(Refit, AnswersAsARebuildWould) {
  for (const auto kind : all_kinds)
    for (const Builder builder : {Builder::morton, Builder::surface_area}) {
      fixtures::Committed m(box(kind, 6), 2, builder);
      for (int step = 1; step <= 3; ++step) {
        // Shear, stretch and shift: cells stay what they are.
        for (std::size_t v = 0; v < m.arrays.points.size(); v += 3) {
          double* x = &m.arrays.points[v];
          x[0] += kind == test::MeshKind::voxels ? 0.7 : 0.1 * x[1] + 0.7;
          x[2] *= 1.25;
        }
        m.mesh.mesh().set_changed(INSITU_CHANGED_GEOMETRY);
        Tree refitted(m.memory), rebuilt(m.memory);
        ASSERT_EQ(m.commit().action, INSITU_REFIT);
        check_tree(m.mesh.tree(), m.mesh.mesh().view());
        rebuilt.build(m.mesh.mesh().view(), m.threads, builder);
        auto points = random_points(rebuilt, 2000, 43);
        for (std::size_t v = 0; v < m.arrays.points.size(); v += 3)
          points.push_back({m.arrays.points[v], m.arrays.points[v + 1], m.arrays.points[v + 2]});
        expect_same_answers(m.sampler(), {m.mesh.mesh().view(), rebuilt}, points);
        EXPECT_EQ(m.mesh.tree().bounds_min(), m.mesh.tree().bounds_min());
      }
    }
}

TEST(Refit, IsTheSameForAnyThreadCount) {
  std::vector<std::byte> first;
  for (const int threads : {1, 2, 4}) {
    fixtures::Committed m(box(test::MeshKind::hexahedra, 20), 1, Builder::surface_area);
    for (double& x : m.arrays.points)
      x *= 1.5;
    const core::Threads some(threads);
    Tree tree(m.memory);
    tree.build(m.mesh.mesh().view(), core::Threads(1), Builder::surface_area);
    tree.refit(m.mesh.mesh().view(), some);
    const auto* bytes = reinterpret_cast<const std::byte*>(tree.nodes());
    const std::vector<std::byte> now(bytes, bytes + sizeof(Node) * tree.node_count());
    if (first.empty())
      first = now;
    EXPECT_TRUE(now == first) << threads << " threads";
  }
}

TEST(Tree, RefusesWhatIsNotFiniteByTheLowestCell) {
  fixtures::Committed m(box(test::MeshKind::hexahedra, 16));
  const std::vector<double> good = m.arrays.points;
  for (const double bad : {double(NAN), double(INFINITY), 1e38})
    for (const bool rebuild : {false, true}) {
      m.arrays.points = good;
      for (const std::size_t cell : {3000u, 777u, 4000u})
        m.arrays.points[3 * std::size_t(m.arrays.ids[8 * cell + 6]) + 1] = bad;
      Tree tree(m.memory);
      const auto attempt = [&] {
        std::string message;
        try {
          rebuild ? tree.build(m.mesh.mesh().view(), m.threads, Builder::automatic)
                  : tree.refit(m.mesh.mesh().view(), m.threads);
        } catch (const core::Error& e) {
          EXPECT_EQ(e.status(), INSITU_ERROR_MESH);
          message = e.what();
        }
        EXPECT_NE(message.find("piece 0, cell 777: a vertex coordinate"), std::string::npos)
            << message;
      };
      if (!rebuild) {
        const std::vector<double> spoiled = m.arrays.points;
        m.arrays.points = good;
        tree.build(m.mesh.mesh().view(), m.threads, Builder::automatic);
        std::copy(spoiled.begin(), spoiled.end(), m.arrays.points.begin());
      }
      attempt();
    }
}

// A refit that was refused leaves a tree that the next refit puts right.
TEST(Commit, RecoversFromARefusedRefit) {
  fixtures::Committed m(box(test::MeshKind::hexahedra, 8));
  const std::vector<double> good = m.arrays.points;
  std::fill(m.arrays.points.begin(), m.arrays.points.end(), NAN);
  EXPECT_THROW(m.commit(INSITU_CHANGED_GEOMETRY), core::Error);
  EXPECT_THROW(m.mesh.require_committed(), core::Error);
  std::copy(good.begin(), good.end(), m.arrays.points.begin());
  EXPECT_EQ(m.commit().action, INSITU_REFIT);
  check_tree(m.mesh.tree(), m.mesh.mesh().view());
}

TEST(Commit, RefitsUntilTheTreeCostsTooMuch) {
  fixtures::Committed m(box(test::MeshKind::hexahedra, 12));
  const std::vector<double> start = m.arrays.points;
  double last = 1.0;
  insitu_action action = INSITU_REFIT;
  int steps = 0;
  for (; steps < 100 && action == INSITU_REFIT; ++steps) {
    // Every second vertex drifts the other way: siblings come to overlap.
    for (std::size_t v = 0; v < start.size() / 3; ++v) {
      const double z = start[3 * v + 2];
      m.arrays.points[3 * v] = start[3 * v] + 0.1 * (steps + 1) * std::sin(3 * z);
    }
    EXPECT_EQ(m.commit(INSITU_CHANGED_GEOMETRY).action, INSITU_REFIT);
    const insitu_commit_report report = m.mesh.complete(m.memory);
    action = report.action;
    if (action == INSITU_REFIT) {
      EXPECT_GE(report.cost_ratio, last);
      EXPECT_LE(report.cost_ratio, commit::TreePolicy::rebuild_ratio);
      last = report.cost_ratio;
      // Nothing changed: nothing done, the ratio is still the refitted tree's.
      EXPECT_EQ(m.commit().action, INSITU_KEEP);
      EXPECT_EQ(m.commit().cost_ratio, last);
      EXPECT_EQ(m.commit(INSITU_CHANGED_FIELDS).action, INSITU_KEEP);
    }
  }
  EXPECT_GT(steps, 2);
  EXPECT_EQ(action, INSITU_REBUILD);
  EXPECT_EQ(m.mesh.tree().cost_ratio(), 1.0);
  check_tree(m.mesh.tree(), m.mesh.mesh().view());
}

// Memory is kept between builds and refits, and given back when builds become rare.
TEST(Commit, ReusesItsMemory) {
  fixtures::Committed m(box(test::MeshKind::hexahedra, 20));
  m.commit(INSITU_CHANGED_GEOMETRY);
  EXPECT_EQ(m.commit(INSITU_CHANGED_GEOMETRY).bytes_allocated, 0);
  const std::int64_t with_scratch = m.memory.current();
  for (int i = 0; i < 6; ++i)
    m.commit(INSITU_CHANGED_GEOMETRY);
  EXPECT_LT(m.memory.current(), with_scratch);
  EXPECT_EQ(m.memory.current(INSITU_MEMORY_EMBREE), 0);
}
