#include "part_session.h"
#include "scene/expression/reduce.h"

using namespace insitu;
using namespace insitu::test;

namespace {

/// A whole mesh's field as one process reduces it.
struct Reduced {
  double least = 0, greatest = 0, mean = 0;
  friend bool operator==(const Reduced&, const Reduced&) = default;
};

using Values = std::vector<double>;

std::vector<Reduced> reduce(const TestMesh& whole, const fixtures::Partition& partition, bool ids,
                            const std::vector<std::pair<std::string, Values>>& fields) {
  std::vector<Reduced> found;
  std::mutex mutex;
  run_processes(partition.processes, [&](parallel::World& world) {
    core::Memory memory;
    const core::Threads threads(1);
    const core::Log log{insitu_log_level(0), nullptr, nullptr};
    commit::CommittedMesh mesh("m", memory);
    fixtures::Part part(whole, partition, world.rank());
    part.give(mesh.mesh(), ids);
    for (const auto& [name, values] : fields) {
      const bool vertices = name[0] == 'v';
      const std::size_t items = vertices ? whole.vertices.size() : whole.cells.size();
      part.give_field(mesh.mesh(), name, vertices ? INSITU_VERTEX : INSITU_CELL,
                      int(values.size() / items), values);
    }
    mesh.commit(threads, log, memory, false);
    scene::FieldReductions reductions(world, threads);
    std::vector<Reduced> mine;
    for (const auto& [name, values] : fields) {
      const auto of = [&](scene::Reduction r) { return reductions(mesh, {name, 0}, "", r); };
      mine.push_back(
          {of(scene::Reduction::min), of(scene::Reduction::max), of(scene::Reduction::mean)});
    }
    const std::lock_guard lock(mutex);
    if (found.empty())
      found = mine;
    EXPECT_TRUE(found == mine) << "process " << world.rank();
  });
  return found;
}

/// Values of all sizes, so that a sum of doubles would depend on its order.
Values numbers(std::size_t count, std::uint64_t seed) {
  Values all(count);
  for (std::size_t i = 0; i < count; ++i)
    all[i] = (core::random_unit(seed, i, 0) - 0.5) *
             std::pow(10.0, 40 * core::random_unit(seed, i, 1) - 20);
  return all;
}

} // namespace

/// To the bit, on any number of processes and any partition.
TEST(ProcessConditions, ReductionsAreThoseOfOneProcess) {
  for (const MeshKind kind : {MeshKind::hexahedra, MeshKind::mixed}) {
    MeshOptions options;
    options.size = 4;
    options.kind = kind;
    const TestMesh whole = make_mesh(options, 3);
    std::vector<std::pair<std::string, Values>> fields = {
        {"v", numbers(whole.vertices.size(), 1)},
        {"vector", numbers(3 * whole.vertices.size(), 2)},
        {"c", numbers(whole.cells.size(), 3)},
        {"cells of one value", Values(whole.cells.size(), 0.1)},
        {"vertices of one value", Values(whole.vertices.size(), 0.1)}};
    fields[0].second[7] = std::nan(""); // no value
    const std::vector<Reduced> expected = reduce(whole, fixtures::slabs(whole, 1), true, fields);
    EXPECT_EQ(expected[3].mean, 0.1); // sums are exact
    EXPECT_EQ(expected[4].mean, 0.1);
    for (const int processes : {1, 2, 3, 4, 8})
      for (const fixtures::Partition& partition : fixtures::partitions(whole, processes))
        for (const bool ids : {true, false}) {
          const std::vector<Reduced> found = reduce(whole, partition, ids, fields);
          for (std::size_t i = 0; i < fields.size(); ++i)
            EXPECT_TRUE(found[i] == expected[i])
                << partition.name << " on " << processes << (ids ? ", ids" : "") << ", "
                << fields[i].first << ": " << expected[i].mean << " " << found[i].mean << ", "
                << expected[i].least << " " << found[i].least;
        }
  }
}

/// Where copies of a vertex have other values, that of its lowest cell counts.
TEST(ProcessConditions, AVertexCountsOnceWhereItsLowestCellIs) {
  const TestMesh whole = jittered_cubes(2);
  for (const bool ids : {true, false})
    for (const int processes : {1, 2, 4}) {
      const fixtures::Partition partition =
          fixtures::in_pieces(fixtures::slabs(whole, processes), 2);
      double sum = -1;
      run_processes(processes, [&](parallel::World& world) {
        core::Memory memory;
        const core::Threads threads(1);
        const core::Log log{insitu_log_level(0), nullptr, nullptr};
        commit::CommittedMesh mesh("m", memory);
        const fixtures::Part part(whole, partition, world.rank());
        part.give(mesh.mesh(), ids);
        std::vector<Values> values; // 0 in the first piece of the root, 1 in all others
        for (std::size_t p = 0; p < part.pieces().size(); ++p) {
          const std::size_t n = part.pieces()[p].vertices.size();
          values.emplace_back(n, world.is_root() && p == 0 ? 0.0 : 1.0);
          const insitu_array array =
              insitu_array_of(values.back().data(), INSITU_FLOAT64, std::int64_t(n), 1);
          mesh.mesh().set_field(std::int32_t(p), "v", INSITU_VERTEX, &array, 1);
        }
        mesh.commit(threads, log, memory, false);
        scene::FieldReductions reductions(world, threads);
        const double mean = reductions(mesh, {"v", 0}, "", scene::Reduction::mean);
        if (world.is_root())
          sum = mean * double(whole.vertices.size());
      });
      // 27 vertices, of which the lowest cells' piece has those of its own cells.
      const fixtures::Part first(whole, partition, 0);
      EXPECT_NEAR(sum, 27.0 - double(first.pieces()[0].vertices.size()), 1e-12)
          << processes << (ids ? ", ids" : ""); // a mean times 27 is rounded twice
    }
}

/// Probes that are due by conditions write the same rows.
TEST(ProcessConditions, FireAtTheSameCycles) {
  const TestMesh whole = jittered_cubes(4);
  PartSession::Options options;
  options.scene = "insitu: 1\npage: false\nprobes:\n"
                  "  - {name: mean, points: [[0.5, 0.5, 0.5]], when: mean(p) > 4}\n"
                  "  - {name: cells, points: [[0.5, 0.5, 0.5]], when: mean(c) > 0 and max(u) > 1}\n"
                  "  - {name: low, points: [[0.5, 0.5, 0.5]], when: min(p) < -0.9 or cycle == 3}\n"
                  "  - {name: never, points: [[0.5, 0.5, 0.5]], when: max(c) > 2}\n";
  const Act cycles = [](PartSession& process, parallel::World&) {
    for (int cycle = 0; cycle < 8; ++cycle)
      EXPECT_EQ(process.execute(cycle), "");
  };
  const auto expected = run_parts(whole, fixtures::slabs(whole, 1), options, cycles);
  ASSERT_TRUE(expected.contains("mean.csv") && expected.contains("cells.csv") &&
              expected.contains("low.csv"));
  EXPECT_FALSE(expected.contains("never.csv"));
  for (const int processes : {2, 3, 8})
    for (const fixtures::Partition& partition : fixtures::partitions(whole, processes))
      expect_same(expected, run_parts(whole, partition, options, cycles),
                  partition.name + " on " + std::to_string(processes));
}
