#include <gtest/gtest.h>
#include <map>
#include <set>

#include "process_of_whole.h"

using namespace insitu;
using math::Vec3d;
using test::Answer;
using test::answers_of;
using test::hard_points;
using test::mesh_of;
using test::Process;

namespace {

std::set<int> vertices_of(const test::MeshCell& cell) {
  return {cell.vertices.begin(), cell.vertices.begin() + mesh::vertex_count(cell.shape)};
}

/// Every cell that shares a vertex with one of this process's own is there, own or in the halo, and
/// is that of the whole mesh, with its values.
void expect_whole_about_own_cells(const test::TestMesh& whole, const fixtures::Partition& partition,
                                  const Process& p, double factor, const std::string& which) {
  const mesh::MeshView& view = p.mesh.mesh().own_view();
  const mesh::FieldView of_cells =
      p.mesh.mesh().has_field("cell") ? p.mesh.mesh().own_field("cell") : mesh::FieldView{};
  std::set<std::int64_t> here;
  std::set<int> own_vertices;
  for (std::int64_t flat = 0; flat < view.cell_count(); ++flat) {
    const std::int32_t piece = view.piece_of(flat);
    const std::int64_t cell = flat - view.first_cell[piece];
    if (!view.pieces[piece].exists(cell))
      continue;
    const bool own = view.pieces[piece].owns(cell);
    EXPECT_EQ(own, flat < view.own_cell_count()) << which;
    const mesh::CellName name = p.mesh.name(flat);
    ASSERT_GE(name.global, 0) << which;
    EXPECT_EQ(name.rank, partition.process[std::size_t(name.global)]) << which;
    EXPECT_TRUE(here.insert(name.global).second) << which << ": twice cell " << name.global;
    mesh::CellVertices vertices;
    mesh::gather(view, flat, vertices);
    const test::MeshCell& of_whole = whole.cells[std::size_t(name.global)];
    ASSERT_EQ(vertices.shape, of_whole.shape) << which;
    for (int v = 0; v < vertices.count; ++v)
      EXPECT_EQ(vertices.x[v], whole.vertices[std::size_t(of_whole.vertices[std::size_t(v)])])
          << which;
    EXPECT_EQ(of_cells.pieces[piece].load(cell, 0), factor * double(name.global)) << which;
    if (own)
      own_vertices.merge(vertices_of(of_whole));
  }
  for (std::size_t c = 0; c < whole.cells.size(); ++c)
    for (const int v : vertices_of(whole.cells[c]))
      EXPECT_TRUE(here.contains(std::int64_t(c)) || !own_vertices.contains(v))
          << which << ": lacks cell " << c;
}

} // namespace

TEST(Halo, HoldsTheCellsThatTouch) {
  for (const std::uint64_t seed : {0, 1, 2, 3, 4, 5})
    for (const int processes : {1, 2, 3, 4, 8}) {
      const test::TestMesh whole = mesh_of(seed);
      for (const fixtures::Partition& partition : fixtures::partitions(whole, processes))
        test::run_processes(processes, [&](parallel::World& world) {
          Process p(whole, partition, world);
          expect_whole_about_own_cells(whole, partition, p, 1.0,
                                       partition.name + " on " + std::to_string(processes));
        });
    }
}

/// To the bit: the answers of one process that has all cells.
TEST(Halo, SeamsAreOwnedOnceByTheLowestGlobalId) {
  for (const std::uint64_t seed : {0, 1, 3, 4, 5}) {
    const test::TestMesh whole = mesh_of(seed, seed == 1 ? 0.0 : 0.2);
    const std::vector<Vec3d> points = hard_points(whole);
    std::vector<Answer> truth;
    test::run_processes(1, [&](parallel::World& world) {
      truth = answers_of(Process(whole, fixtures::slabs(whole, 1), world), points, false);
    });
    for (const int processes : {2, 3, 8})
      for (const fixtures::Partition& partition : fixtures::partitions(whole, processes))
        for (const bool batch : {false, true}) {
          std::vector<Answer> merged(points.size());
          std::vector<int> owners(points.size());
          std::mutex mutex;
          test::run_processes(processes, [&](parallel::World& world) {
            const std::vector<Answer> own =
                answers_of(Process(whole, partition, world), points, batch);
            const std::lock_guard lock(mutex);
            for (std::size_t i = 0; i < points.size(); ++i)
              if (own[i].cell >= 0) {
                ++owners[i];
                merged[i] = own[i];
              }
          });
          for (std::size_t i = 0; i < points.size(); ++i) {
            const std::string which = partition.name + " on " + std::to_string(processes) +
                                      (batch ? ", batch" : "") + ", seed " + std::to_string(seed) +
                                      ", point " + std::to_string(i);
            EXPECT_EQ(owners[i], truth[i].cell >= 0) << which;
            EXPECT_EQ(merged[i].cell, truth[i].cell) << which;
            EXPECT_EQ(merged[i].parametric, truth[i].parametric) << which;
            for (int c = 0; c < 3; ++c)
              EXPECT_EQ(merged[i].values[c], truth[i].values[c]) << which;
          }
        }
  }
}

TEST(Halo, WithoutGlobalIdsSeamsAreOwnedOnceByTheLowestProcess) {
  const test::TestMesh whole = mesh_of(5);
  const std::vector<Vec3d> points = hard_points(whole);
  const fixtures::Partition partition = fixtures::boxes(whole, 4);
  std::vector<std::int64_t> owners(points.size()), lowest(points.size(), 99),
      answered(points.size(), 99);
  std::mutex mutex;
  test::run_processes(4, [&](parallel::World& world) {
    const Process p(whole, partition, world, false);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const query::Location at = p.mesh.sampler().locate(points[i]);
      const query::Location own = p.mesh.own_sampler().locate(points[i]);
      const std::int64_t own_cells = p.mesh.mesh().own_view().own_cell_count();
      const std::lock_guard lock(mutex);
      owners[i] += at && at.cell < own_cells;
      if (own && own.cell < own_cells)
        lowest[i] = std::min<std::int64_t>(lowest[i], world.rank());
      if (at && at.cell < own_cells)
        answered[i] = world.rank();
    }
  });
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(owners[i], lowest[i] < 99) << "point " << i;
    EXPECT_EQ(answered[i], lowest[i]) << "point " << i;
  }
}

TEST(Halo, FollowsVerticesAndValues) {
  test::TestMesh whole = mesh_of(7);
  const test::TestMesh before = whole;
  for (Vec3d& x : whole.vertices)
    x = {x.x + 0.1 * x.y, x.y - 0.05 * x.z, x.z + 0.3};
  for (const fixtures::Partition& partition : fixtures::partitions(before, 3))
    test::run_processes(3, [&](parallel::World& world) {
      Process p(before, partition, world);
      p.give_fields(before, 2.0);
      p.commit();
      expect_whole_about_own_cells(before, partition, p, 2.0, partition.name + ", values");
      p.part.move(p.mesh.mesh(), whole.vertices);
      p.give_fields(whole, 3.0);
      p.commit();
      expect_whole_about_own_cells(whole, partition, p, 3.0, partition.name + ", vertices");
    });
}

/// What a mesh says of itself is of its own cells.
TEST(Halo, IsNotCounted) {
  const test::TestMesh whole = mesh_of(8);
  const fixtures::Partition partition = fixtures::boxes(whole, 3);
  std::vector<std::int64_t> sums(2);
  test::run_processes(3, [&](parallel::World& world) {
    Process p(whole, partition, world);
    const std::int64_t own =
        std::count(partition.process.begin(), partition.process.end(), world.rank());
    EXPECT_GT(p.mesh.halo()->cell_count(), 0);
    EXPECT_EQ(p.mesh.sampler().facts().cells, own);
    p.mesh.mesh().set_changed(INSITU_CHANGED_FIELDS);
    EXPECT_EQ(p.mesh.commit(p.threads, p.log, p.memory, false).cells, own);
    EXPECT_GT(p.memory.current(INSITU_MEMORY_HALO), 0);
  });
}

/// A commit of other cells leaves it to that, or to who asks before.
TEST(Halo, TheTreeIsBuiltOnceWithIt) {
  const test::TestMesh whole = mesh_of(4);
  const std::vector<Vec3d> points = hard_points(whole);
  for (const fixtures::Partition& partition : fixtures::partitions(whole, 3))
    test::run_processes(3, [&](parallel::World& world) {
      Process p(whole, partition, world);
      const std::vector<Answer> truth = answers_of(p, points, true);
      const auto commit = [&] {
        p.mesh.mesh().set_changed(INSITU_CHANGED_ALL);
        return p.mesh.commit(p.threads, p.log, p.memory, false);
      };
      EXPECT_EQ(commit().action, INSITU_REBUILD);
      EXPECT_TRUE(p.mesh.standing_tree().empty()) << partition.name;
      p.mesh.update_halo(world, p.threads, p.log);
      EXPECT_EQ(p.mesh.fits_done().rebuilds, 0) << partition.name;
      commit();
      p.mesh.mesh().set_changed(INSITU_CHANGED_GEOMETRY); // with the tree still to be built
      p.mesh.commit(p.threads, p.log, p.memory, false);
      for (std::size_t i = 0; i < points.size(); ++i)
        EXPECT_TRUE(p.mesh.own_sampler().locate(points[i]) || truth[i].cell < 0)
            << partition.name << ", point " << i;
      EXPECT_EQ(p.mesh.fits_done().rebuilds, 1) << partition.name;
      EXPECT_EQ(p.mesh.locator_info().primitives, p.mesh.standing_tree().cell_count());
      p.mesh.update_halo(world, p.threads, p.log);
      const std::vector<Answer> again = answers_of(p, points, true);
      for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_EQ(again[i].cell, truth[i].cell) << partition.name << ", point " << i;
        EXPECT_EQ(again[i].parametric, truth[i].parametric) << partition.name << ", point " << i;
      }
    });
}
