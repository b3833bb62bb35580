#include <gtest/gtest.h>
#include <set>

#include "commit/halo/everywhere.h"
#include "fixtures/earth_meshes.h"
#include "fixtures/parts.h"
#include "part_of_mesh.h"
#include "threaded_world.h"

using namespace insitu;
using math::Vec3d;

namespace {

struct Earth {
  std::string name;
  test::TestMesh mesh;
};

/// With cells that wrap, that hold poles, with vertices there; and none of these.
std::vector<Earth> earths() {
  fixtures::Lattice basin, ring, wrapping;
  basin.west = 100, basin.east = 260, basin.south = -40, basin.north = 40;
  basin.across = 16, basin.along = 8;
  wrapping.wraps = true;
  wrapping.jump = -360;
  wrapping.west = 0, wrapping.east = 360;
  fixtures::Globe on_vertices, within_cells;
  on_vertices.subdivisions = 2;
  within_cells.subdivisions = 2;
  within_cells.tilt = 0.3;
  return {{"basin", lattice(basin)},
          {"ring", lattice(ring)},
          {"wrapping ring", lattice(wrapping)},
          {"globe with vertices at the poles", globe(on_vertices)},
          {"globe with cells at the poles", globe(within_cells)}};
}

/// A process's part, committed, with a vector on vertices and a number on cells.
struct Process : test::PartOfMesh<fixtures::Part> {
  Process(const test::TestMesh& whole, const fixtures::Partition& partition,
          parallel::World& world_, bool with_halo)
      : PartOfMesh(world_, whole, partition) {
    mesh.reference_frame = fixtures::frame_of({});
    part.give(mesh.mesh(), true);
    std::vector<double> of_cells, of_vertices;
    for (std::size_t c = 0; c < whole.cells.size(); ++c)
      of_cells.push_back(double(c));
    for (const Vec3d& x : whole.vertices)
      of_vertices.insert(of_vertices.end(), {std::sin(x.x), x.y, 1e-3 * x.z});
    part.give_field(mesh.mesh(), "cell", INSITU_CELL, 1, of_cells);
    part.give_field(mesh.mesh(), "vertex", INSITU_VERTEX, 3, of_vertices);
    mesh.commit(threads, log, memory, false);
    if (with_halo)
      mesh.update_halo(world, threads, log);
    else
      mesh.update_chart(world, threads, log);
  }
};

/// Vertices, places on edges, within cells, on the seam, at the poles, and anywhere; turns away.
std::vector<Vec3d> hard_points(const test::TestMesh& mesh) {
  std::vector<Vec3d> points = mesh.vertices;
  for (std::size_t c = 0; c < mesh.cells.size(); c += 3) {
    const test::MeshCell& cell = mesh.cells[c];
    const int n = mesh::vertex_count(cell.shape);
    const Vec3d first = mesh.vertices[std::size_t(cell.vertices[0])];
    const auto x = [&](int v) {
      Vec3d at = mesh.vertices[std::size_t(cell.vertices[std::size_t(v % n)])];
      at.x += 360 * std::round((first.x - at.x) / 360);
      return at;
    };
    for (int v = 0; v < n; v += 2)
      points.push_back(0.5 * (x(v) + x(v + 1)));
    points.push_back(0.25 * (x(0) + x(1) + x(n - 2) + x(n - 1)));
  }
  for (const double lat : {-90.0, -89.9, -61.0, -7.0, 0.0, 33.0, 75.0, 89.9, 90.0})
    for (const double lon : {-360.0, -180.0, 0.0, 15.0, 180.0, 359.99, 360.0, 540.0})
      for (const double height : {0.0, -77.0, -100.0})
        points.push_back({lon, lat, height});
  for (std::uint64_t i = 0; i < 400; ++i)
    points.push_back({1000 * core::random_unit(3, i, 0) - 500,
                      180 * core::random_unit(3, i, 1) - 90, -4000 * core::random_unit(3, i, 2)});
  return points;
}

struct Answer {
  std::int64_t cell = -1;
  Vec3d parametric;
  double values[4] = {0, 0, 0, 0};
  bool operator==(const Answer& b) const {
    return cell == b.cell && parametric == b.parametric && std::ranges::equal(values, b.values);
  }
};

/// What this process owns.
std::vector<Answer> answers_of(const Process& p, const std::vector<Vec3d>& points, bool batch) {
  std::vector<Answer> all(points.size());
  const query::Sampler sampler = p.mesh.sampler();
  std::vector<query::Location> found(points.size());
  if (batch)
    sampler.locate(p.threads, points, found);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const query::Location at = batch ? found[i] : sampler.locate(points[i]);
    if (!at || !sampler.owns(at.cell))
      continue;
    const query::Location own = p.mesh.own(at, points[i]);
    all[i].cell = p.mesh.name(own.cell).global;
    all[i].parametric = own.parametric;
    sampler.interpolate(p.mesh.mesh().field("cell"), at, all[i].values);
    sampler.interpolate(p.mesh.mesh().field("vertex"), at, all[i].values + 1);
  }
  return all;
}

std::vector<Answer> answers_of_one(const test::TestMesh& whole, const std::vector<Vec3d>& points) {
  std::vector<Answer> truth;
  test::run_processes(1, [&](parallel::World& world) {
    truth = answers_of(Process(whole, fixtures::slabs(whole, 1), world, true), points, false);
  });
  return truth;
}

} // namespace

/// To the bit: the owners, coordinates and values of one process that has all cells, each owned
/// once.
TEST(ChartHalo, PlacesAreOwnedOnceAsInOneProcess) {
  for (const Earth& earth : earths()) {
    const std::vector<Vec3d> points = hard_points(earth.mesh);
    const std::vector<Answer> truth = answers_of_one(earth.mesh, points);
    for (const int processes : {2, 3, 8})
      for (const fixtures::Partition& partition : fixtures::partitions(earth.mesh, processes)) {
        const bool batch = processes != 3;
        std::vector<Answer> merged(points.size());
        std::vector<int> owners(points.size());
        std::mutex mutex;
        test::run_processes(processes, [&](parallel::World& world) {
          const std::vector<Answer> own =
              answers_of(Process(earth.mesh, partition, world, true), points, batch);
          const std::lock_guard lock(mutex);
          for (std::size_t i = 0; i < points.size(); ++i)
            if (own[i].cell >= 0) {
              ++owners[i];
              merged[i] = own[i];
            }
        });
        for (std::size_t i = 0; i < points.size(); ++i) {
          const std::string which = earth.name + ", " + partition.name + " on " +
                                    std::to_string(processes) + ", point " + std::to_string(i) +
                                    " at " + std::to_string(points[i].x) + ", " +
                                    std::to_string(points[i].y);
          ASSERT_EQ(owners[i], truth[i].cell >= 0) << which;
          ASSERT_EQ(merged[i].cell, truth[i].cell) << which;
          ASSERT_TRUE(merged[i] == truth[i]) << which;
        }
      }
  }
}

/// Cells that touch another process's over the seam of longitude are in its halo, too, and every
/// cell has one name in each of its places.
TEST(ChartHalo, ReachesOverTheSeamOfLongitude) {
  for (const Earth& earth : earths()) {
    const fixtures::Partition partition = fixtures::boxes(earth.mesh, 4);
    test::run_processes(4, [&](parallel::World& world) {
      const Process p(earth.mesh, partition, world, true);
      const mesh::MeshView& view = p.mesh.mesh().view();
      std::set<mesh::CellName> names;
      std::set<std::int64_t> here;
      for (std::int64_t flat = 0; flat < view.cell_count(); ++flat) {
        const mesh::CellName name = p.mesh.located_name(flat);
        EXPECT_EQ(p.mesh.find_located(name), flat) << earth.name;
        EXPECT_TRUE(names.insert(name).second) << earth.name;
        EXPECT_EQ(name.rank == world.rank(), flat < view.own_cell_count()) << earth.name;
        here.insert(name.global);
      }
      // Vertices are one where their longitudes are whole turns apart, or at a pole.
      const auto place = [&](int v) {
        const Vec3d x = earth.mesh.vertices[std::size_t(v)];
        const bool at_pole = std::abs(x.y) == 90;
        return std::array{at_pole ? 0.0 : x.x - 360 * std::floor((x.x + 1e-9) / 360), x.y, x.z};
      };
      std::set<std::array<double, 3>> own;
      const auto each = [&](std::size_t c, auto&& visit) {
        for (int v = 0; v < mesh::vertex_count(earth.mesh.cells[c].shape); ++v)
          visit(place(earth.mesh.cells[c].vertices[std::size_t(v)]));
      };
      const bool by_poles = earth.name.find("globe") != std::string::npos;
      for (std::size_t c = 0; c < partition.process.size(); ++c)
        if (partition.process[c] == world.rank())
          each(c, [&](const auto& x) {
            if (by_poles || std::abs(x[1]) != 90) // a lattice's columns do not know of each other
              own.insert(x);
          });
      for (std::size_t c = 0; c < partition.process.size(); ++c)
        each(c, [&](const auto& x) {
          EXPECT_TRUE(here.contains(std::int64_t(c)) || !own.contains(x))
              << earth.name << ": process " << world.rank() << " lacks cell " << c;
        });
    });
  }
}

/// Each process asks some of the points, without a halo.
TEST(ChartHalo, QueriesEverywhereAnswerAsOneProcessDoes) {
  const std::vector<std::string> fields{"cell", "vertex"};
  for (const Earth& earth : earths()) {
    const std::vector<Vec3d> points = hard_points(earth.mesh);
    const std::vector<Answer> truth = answers_of_one(earth.mesh, points);
    for (const int processes : {2, 4})
      for (const fixtures::Partition& partition : fixtures::partitions(earth.mesh, processes))
        test::run_processes(processes, [&](parallel::World& world) {
          const Process p(earth.mesh, partition, world, false);
          std::vector<std::size_t> mine;
          std::vector<Vec3d> asked;
          for (std::size_t i = 0; i < points.size(); ++i)
            if (int(i % 3) == world.rank()) {
              mine.push_back(i);
              asked.push_back(points[i]);
            }
          commit::Everywhere(p.mesh, world)
              .sample(asked, fields, {}, p.threads,
                      [&](std::size_t first, std::span<const commit::OwnerOfAll> owners,
                          std::span<const double> values) {
                        for (std::size_t k = 0; k < owners.size(); ++k) {
                          const Answer& expected = truth[mine[first + k]];
                          Answer a;
                          if (owners[k]) {
                            a = {owners[k].cell.global, owners[k].parametric, {}};
                            std::copy_n(values.begin() + std::ptrdiff_t(4 * k), 4, a.values);
                            EXPECT_EQ(owners[k].cell.rank, partition.process[std::size_t(a.cell)]);
                          }
                          EXPECT_TRUE(a == expected)
                              << earth.name << ", " << partition.name << " on " << processes
                              << ", point " << mine[first + k];
                        }
                      });
        });
  }
}
