#include <gtest/gtest.h>

#include "commit/committed_mesh.h"
#include "fixtures/parts.h"
#include "threaded_world.h"

using namespace insitu;

namespace {

test::TestMesh cubes() {
  test::MeshOptions options;
  options.size = 4;
  return test::make_mesh(options, 7);
}

} // namespace

/// Every cell of the whole is one process's own, whatever the partition, and a field's value at a
/// place is that of the whole.
TEST(Parts, HoldEveryCellOnce) {
  const test::TestMesh whole = cubes();
  std::vector<double> ids(whole.cells.size());
  for (std::size_t c = 0; c < ids.size(); ++c)
    ids[c] = double(c);
  for (const int processes : {1, 2, 3, 8})
    for (const fixtures::Partition& partition : fixtures::partitions(whole, processes))
      test::run_processes(processes, [&](parallel::World& world) {
        core::Memory memory;
        const core::Threads threads(1);
        const core::Log log{insitu_log_level(0), nullptr, nullptr};
        commit::CommittedMesh mesh("part", memory);
        fixtures::Part part(whole, partition, world.rank());
        part.give(mesh.mesh());
        part.give_field(mesh.mesh(), "id", INSITU_CELL, 1, ids);
        mesh.commit(threads, log, memory, false);
        std::vector<std::int64_t> owners(whole.cells.size());
        const query::Sampler sampler = mesh.sampler();
        const auto middles = fixtures::detail::middles(whole);
        for (std::size_t c = 0; c < middles.size(); ++c) {
          const query::Location at = sampler.locate(middles[c], -1, {});
          owners[c] = bool(at);
          double value = -1;
          if (at)
            sampler.interpolate(mesh.mesh().field("id"), at, &value);
          EXPECT_EQ(value, at ? double(c) : -1.0);
        }
        world.reduce(std::span(owners), parallel::Reduction::sum);
        for (std::size_t c = 0; c < owners.size(); ++c)
          EXPECT_EQ(owners[c], 1) << partition.name << " on " << processes << ", cell " << c;
      });
}
