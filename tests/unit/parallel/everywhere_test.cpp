#include "commit/halo/everywhere.h"
#include "process_of_whole.h"

using namespace insitu;
using math::Vec3d;
using test::Answer;
using test::answers_of;
using test::hard_points;
using test::mesh_of;
using test::Process;

/// Each process asks some of the points; with a halo and without.
TEST(Everywhere, AnswersAsOneProcessDoes) {
  const std::vector<std::string> fields{"vertex", "cell"};
  for (const std::uint64_t seed : {0, 3, 5}) {
    const test::TestMesh whole = mesh_of(seed);
    const std::vector<Vec3d> points = hard_points(whole);
    std::vector<Answer> truth;
    test::run_processes(1, [&](parallel::World& world) {
      truth = answers_of(Process(whole, fixtures::slabs(whole, 1), world), points, true);
    });
    for (const int processes : {1, 2, 3, 8})
      for (const fixtures::Partition& partition : fixtures::partitions(whole, processes))
        test::run_processes(processes, [&](parallel::World& world) {
          const Process p(whole, partition, world);
          std::vector<std::size_t> mine;
          std::vector<Vec3d> asked;
          for (std::size_t i = 0; i < points.size(); ++i)
            if (world.size() == 1 || int(i % 3) == world.rank()) { // some processes ask nothing
              mine.push_back(i);
              asked.push_back(points[i]);
            }
          std::size_t answered = 0;
          commit::Everywhere(p.mesh, world)
              .sample(asked, fields, {}, p.threads,
                      [&](std::size_t first, std::span<const commit::OwnerOfAll> owners,
                          std::span<const double> values) {
                        for (std::size_t k = 0; k < owners.size(); ++k) {
                          const Answer& a = truth[mine[first + k]];
                          const std::string which = partition.name + " on " +
                                                    std::to_string(processes) + ", point " +
                                                    std::to_string(mine[first + k]);
                          ASSERT_EQ(bool(owners[k]), a.cell >= 0) << which;
                          ++answered;
                          if (!owners[k]) {
                            EXPECT_TRUE(std::isnan(values[3 * k])) << which;
                            continue;
                          }
                          EXPECT_EQ(owners[k].cell.global, a.cell) << which;
                          EXPECT_EQ(owners[k].cell.rank, partition.process[std::size_t(a.cell)]);
                          EXPECT_EQ(owners[k].parametric, a.parametric) << which;
                          EXPECT_EQ(values[3 * k], a.values[1]) << which;
                          EXPECT_EQ(values[3 * k + 1], a.values[2]) << which;
                          EXPECT_EQ(values[3 * k + 2], a.values[0]) << which;
                        }
                      });
          EXPECT_EQ(answered, asked.size());
        });
  }
}

/// Cells, distances, nearest places and values there are those of one process to the bit; of cells
/// at one distance, which processes may share, the lowest id. Cells too far away do not answer.
TEST(Everywhere, NearestCellsAreThoseOfOneProcess) {
  const std::vector<std::string> fields{"vertex", "cell"};
  struct Near {
    std::int64_t cell = -1;
    double squared = 0.0;
    Vec3d place;
    std::vector<double> values;
    bool operator==(const Near&) const = default;
  };
  for (const std::uint64_t seed : {0, 3, 5}) {
    const test::TestMesh whole = mesh_of(seed, seed == 0 ? 0.0 : 0.2);
    std::vector<Vec3d> points; // outside, beside vertices, edges and faces of the boundary
    for (int i = 0; i < 300; ++i) {
      Vec3d p;
      for (int a = 0; a < 3; ++a)
        p[a] =
            0.5 * std::floor(16.0 * core::random_unit(5, std::uint64_t(i), std::uint64_t(a))) - 2;
      if (std::min({p.x, p.y, p.z}) < 0 || std::max({p.x, p.y, p.z}) > 4)
        points.push_back(p);
    }
    ASSERT_GT(points.size(), 200u);
    const auto ask = [&](const fixtures::Partition& partition, parallel::World& world,
                         std::span<const Vec3d> asked) {
      const Process p(whole, partition, world);
      std::vector<Near> all(asked.size());
      commit::Everywhere(p.mesh, world)
          .nearest(asked, fields, 1.6, p.threads,
                   [&](std::size_t first, std::span<const commit::OwnerOfAll> owners,
                       std::span<const commit::NearnessOfAll> near,
                       std::span<const double> values) {
                     for (std::size_t k = 0; k < owners.size(); ++k)
                       if (owners[k]) {
                         EXPECT_FALSE(owners[k].holds());
                         all[first + k] = {owners[k].cell.global,
                                           near[k].squared,
                                           near[k].place,
                                           {values.begin() + std::ptrdiff_t(3 * k),
                                            values.begin() + std::ptrdiff_t(3 * k + 3)}};
                       }
                   });
      return all;
    };
    std::vector<Near> truth;
    test::run_processes(
        1, [&](parallel::World& world) { truth = ask(fixtures::slabs(whole, 1), world, points); });
    EXPECT_GT(std::ranges::count(truth, -1, &Near::cell), 20);
    EXPECT_LT(std::ranges::count(truth, -1, &Near::cell), 150);
    for (const int processes : {2, 4})
      for (const fixtures::Partition& partition : fixtures::partitions(whole, processes))
        test::run_processes(processes, [&](parallel::World& world) {
          const bool asks = world.rank() == world.size() - 1; // the others answer alone
          const std::vector<Near> found = ask(
              partition, world, asks ? std::span<const Vec3d>(points) : std::span<const Vec3d>());
          for (std::size_t i = 0; i < found.size(); ++i)
            EXPECT_EQ(found[i], truth[i])
                << partition.name << " on " << processes << ", point " << i << ": cell "
                << found[i].cell << " for " << truth[i].cell;
        });
  }
}

/// Of the vertices that processes share each counts once, with global ids.
TEST(Everywhere, NearestVerticesAreThoseOfOneProcess) {
  const test::TestMesh whole = mesh_of(3);
  const std::vector<Vec3d> points = hard_points(whole);
  using Found = std::vector<query::NearVertex>;
  for (const std::size_t most : {1u, 9u}) {
    std::vector<Found> truth(points.size());
    test::run_processes(1, [&](parallel::World& world) {
      const Process p(whole, fixtures::slabs(whole, 1), world);
      commit::Everywhere(p.mesh, world)
          .nearest_vertices(points, most, 3.0, p.threads,
                            [&](std::size_t i, const Found& found) { truth[i] = found; });
    });
    for (const fixtures::Partition& partition : fixtures::partitions(whole, 4))
      test::run_processes(4, [&](parallel::World& world) {
        const Process p(whole, partition, world);
        const std::span<const Vec3d> asked =
            world.rank() == 2 ? std::span<const Vec3d>(points) : std::span<const Vec3d>();
        commit::Everywhere(p.mesh, world)
            .nearest_vertices(asked, most, 3.0, p.threads, [&](std::size_t i, const Found& found) {
              ASSERT_EQ(found.size(), truth[i].size()) << partition.name << ", point " << i;
              for (std::size_t k = 0; k < found.size(); ++k) {
                EXPECT_EQ(found[k].global, truth[i][k].global) << partition.name << i;
                EXPECT_EQ(found[k].squared, truth[i][k].squared) << partition.name << i;
              }
            });
      });
  }
}

TEST(Everywhere, NamesAFieldThatNobodyHas) {
  const test::TestMesh whole = mesh_of(0);
  for (const fixtures::Partition& partition : fixtures::partitions(whole, 3))
    test::run_processes(3, [&](parallel::World& world) {
      const Process p(whole, partition, world);
      const std::vector<std::string> fields{"pressure"};
      commit::Everywhere everywhere(p.mesh, world);
      try {
        everywhere.components(fields);
        ADD_FAILURE() << "no error";
      } catch (const parallel::AgreedError& e) {
        EXPECT_EQ(e.status(), INSITU_ERROR_FIELD);
        EXPECT_NE(std::string(e.what()).find("'pressure'"), std::string::npos) << e.what();
      }
    });
}
