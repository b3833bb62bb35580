/// Faces of two processes that should be one: those that lie near each other and do not match.
#include <array>
#include <functional>
#include <gtest/gtest.h>
#include <map>
#include <numeric>
#include <vector>

#include "commit/halo/seam_faces.h"
#include "fixtures/earth_meshes.h"
#include "process_of_whole.h"

using namespace insitu;
using math::Vec3d;

namespace {

/// Where a process has a vertex of the whole mesh.
using Displaced = std::function<Vec3d(const Vec3d& x, int rank)>;

struct Search {
  test::TestMesh whole;
  fixtures::Partition partition;
  Displaced displaced = [](const Vec3d& x, int) { return x; };
  double tolerance = 1e-6;
  insitu_frame frame = insitu_frame_default();
  bool ids = true;
  /// After a process's part is given.
  std::function<void(mesh::Mesh&, const fixtures::Part&, int rank)> then =
      [](mesh::Mesh&, const fixtures::Part&, int) {};
};

struct Found {
  std::vector<commit::SeamMismatches> of; ///< [process]
  std::vector<std::string> said;          ///< warnings of all processes
};

/// act(mesh, rank) with each process's mesh and its halo.
Found search(
    const Search& s, const std::function<void(const commit::CommittedMesh&, int)>& act =
                         [](const commit::CommittedMesh&, int) {}) {
  Found found;
  found.of.resize(std::size_t(s.partition.processes));
  std::mutex mutex;
  test::run_processes(s.partition.processes, [&](parallel::World& world) {
    core::Memory memory;
    const core::Threads threads(1);
    std::vector<std::string> said;
    const core::Log log{INSITU_LOG_WARNING,
                        [](insitu_log_level, const char* text, void* to) {
                          static_cast<std::vector<std::string>*>(to)->push_back(text);
                        },
                        &said};
    commit::CommittedMesh mesh("part", memory);
    mesh.mesh().set_is_part(world.size() > 1);
    mesh.reference_frame = s.frame;
    mesh.seam_tolerance = s.tolerance;
    fixtures::Part part(s.whole, s.partition, world.rank());
    part.give(mesh.mesh(), s.ids);
    s.then(mesh.mesh(), part, world.rank());
    std::vector<Vec3d> moved;
    for (const Vec3d& x : s.whole.vertices)
      moved.push_back(s.displaced(x, world.rank()));
    part.move(mesh.mesh(), moved);
    mesh.commit(threads, log, memory, false);
    mesh.update_halo(world, threads, log);
    EXPECT_TRUE(said.empty() || world.is_root());
    act(mesh, world.rank());
    const std::lock_guard lock(mutex);
    found.of[std::size_t(world.rank())] = commit::find_seam_mismatches(mesh);
    found.said.insert(found.said.end(), said.begin(), said.end());
  });
  return found;
}

/// What is to be found where no face at a seam matches: of each process the faces that it shares
/// with another one in the whole mesh, and the least pair of cells. Vertices are one where they are
/// whole turns apart.
struct Shared {
  std::vector<std::int64_t> count; ///< [process]
  std::map<int, std::pair<std::int64_t, std::int64_t>> first;
};
Shared shared_faces(const test::TestMesh& whole, const fixtures::Partition& partition,
                    double turn = 0.0) {
  std::map<std::vector<std::array<double, 3>>, std::vector<std::int64_t>> cells_of;
  for (std::size_t c = 0; c < whole.cells.size(); ++c) {
    const cells::FaceTable table = cells::face_table(whole.cells[c].shape);
    for (int f = 0; f < table.face_count; ++f) {
      std::vector<std::array<double, 3>> face;
      for (int v = 0; v < table.faces[f].vertex_count; ++v) {
        const Vec3d x = whole.vertices[std::size_t(
            whole.cells[c].vertices[std::size_t(table.faces[f].vertices[v])])];
        const double lon = turn > 0 ? x.x - turn * std::floor(x.x / turn + 1e-9) : x.x;
        face.push_back({turn > 0 ? std::round(lon / turn * 1e9) : lon, x.y, x.z});
      }
      std::ranges::sort(face);
      cells_of[face].push_back(std::int64_t(c));
    }
  }
  Shared shared;
  shared.count.resize(std::size_t(partition.processes));
  for (const auto& [face, cells] : cells_of) {
    if (cells.size() != 2)
      continue;
    for (const auto& [own, other] :
         {std::pair(cells[0], cells[1]), std::pair(cells[1], cells[0])}) {
      const int rank = partition.process[std::size_t(own)];
      if (rank == partition.process[std::size_t(other)])
        continue;
      ++shared.count[std::size_t(rank)];
      const auto [at, fresh] = shared.first.try_emplace(rank, own, other);
      if (!fresh && own < at->second.first)
        at->second = {own, other};
    }
  }
  return shared;
}

std::string told(const fixtures::Partition& partition, std::int64_t cell) {
  const int rank = partition.process[std::size_t(cell)];
  return "process " + std::to_string(rank) + ", piece 0, cell " +
         std::to_string(
             std::count(partition.process.begin(), partition.process.begin() + cell, rank));
}

void expect_all_found(const Search& s, const Found& found, const std::string& which,
                      double turn = 0.0) {
  const Shared shared = shared_faces(s.whole, s.partition, turn);
  std::int64_t count = 0;
  for (std::size_t r = 0; r < found.of.size(); ++r) {
    EXPECT_EQ(found.of[r].count, shared.count[r]) << which << ", process " << r;
    count += shared.count[r];
  }
  ASSERT_GT(count, 0) << which;
  ASSERT_EQ(found.said.size(), 1u) << which;
  const auto [own, other] = shared.first.begin()->second;
  for (const std::string& part :
       {"mesh 'part': " + std::to_string(count) + " faces on seams lie within ",
        "the first of " + told(s.partition, own) + " and " + told(s.partition, other) + ":"})
    EXPECT_NE(found.said[0].find(part), std::string::npos) << which << ": " << found.said[0];
}

void expect_none(const Found& found, const std::string& which) {
  for (const commit::SeamMismatches& of : found.of)
    EXPECT_EQ(of.count, 0) << which;
  EXPECT_TRUE(found.said.empty()) << which << ": " << found.said[0];
}

test::TestMesh cubes(int size = 6, double jitter = 0.0) {
  test::MeshOptions options;
  options.size = size;
  options.jitter = jitter;
  return test::make_mesh(options, 3);
}

} // namespace

/// Vertices of one process that are a unit in the last place off: its faces are counted, those of
/// others too, and both cells are named.
TEST(SeamFaces, ThatDoNotMatchToTheBitAreCounted) {
  for (const int processes : {2, 3}) {
    Search s{cubes(), {}};
    s.partition = fixtures::slabs(s.whole, processes);
    expect_none(search(s), "matching");
    s.displaced = [](Vec3d x, int rank) {
      if (rank == 1)
        x.y = std::nextafter(x.y, 9.0);
      return x;
    };
    for (const bool ids : {true, false}) {
      s.ids = ids;
      expect_all_found(s, search(s), "a unit in the last place, on " + std::to_string(processes));
    }
    s.tolerance = 0.0;
    expect_none(search(s), "no search");
  }
}

/// Gaps and overlaps across the seam and along it: told by the tolerance that is above them, and by
/// none below.
TEST(SeamFaces, OfAGapAreToldByTheToleranceAlone) {
  for (const int processes : {2, 3})
    for (const double jitter : {0.0, 0.2})
      for (const Vec3d& direction :
           {Vec3d{1, 0, 0}, Vec3d{-1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0.6, -0.5, 0.6}})
        for (const double gap : {1e-4, 5e-7}) {
          Search s{cubes(6, jitter), {}};
          s.partition = fixtures::slabs(s.whole, processes);
          s.displaced = [&](const Vec3d& x, int rank) { return x + gap * rank * direction; };
          const std::string which =
              "gap " + std::to_string(gap) + " along " + std::to_string(direction.x) + ", " +
              std::to_string(direction.y) + " on " + std::to_string(processes);
          s.tolerance = 10 * gap;
          expect_all_found(s, search(s), which);
          s.tolerance = 0.1 * gap;
          expect_none(search(s), which);
          s.tolerance = commit::SeamMismatches::most_tolerance;
          expect_all_found(s, search(s), which + ", the largest tolerance");
        }
}

/// A tolerance changes no answer: points in a gap have no owner, points where cells overlap the
/// lowest one.
TEST(SeamFaces, AreReportedAndNotJoined) {
  Search s{cubes(), {}};
  s.partition = fixtures::slabs(s.whole, 2);
  const Shared shared = shared_faces(s.whole, s.partition);
  const auto [own, other] = shared.first.begin()->second;
  const auto middle = [&](std::int64_t cell) {
    Vec3d sum;
    for (int v = 0; v < 8; ++v)
      sum +=
          s.whole.vertices[std::size_t(s.whole.cells[std::size_t(cell)].vertices[std::size_t(v)])];
    return sum / 8.0;
  };
  for (const double gap : {1e-4, -1e-4})
    for (const double tolerance : {0.0, 1e-6, 1e-3}) {
      s.displaced = [&](Vec3d x, int rank) {
        x.x += gap * rank;
        return x;
      };
      s.tolerance = tolerance;
      const Vec3d p = 0.5 * (middle(own) + middle(other)) + Vec3d{0.5 * gap, 0, 0};
      std::mutex mutex;
      std::vector<std::int64_t> owners;
      search(s, [&](const commit::CommittedMesh& mesh, int) {
        const query::Location at = mesh.sampler().locate(p);
        const std::lock_guard lock(mutex);
        if (at && at.cell < mesh.mesh().own_view().own_cell_count())
          owners.push_back(mesh.name(at.cell).global);
      });
      EXPECT_EQ(owners, gap > 0 ? std::vector<std::int64_t>{}
                                : std::vector<std::int64_t>{std::min(own, other)})
          << gap << ", tolerance " << tolerance;
    }
}

/// Cells that match are told by no tolerance, however many others are near.
TEST(SeamFaces, ThatMatchAreNoneByAnyTolerance) {
  for (const std::uint64_t seed : {0, 3, 5})
    for (const double tolerance : {1e-6, 1e-3, commit::SeamMismatches::most_tolerance}) {
      Search s{test::mesh_of(seed), {}};
      s.tolerance = tolerance;
      for (const fixtures::Partition& partition : fixtures::partitions(s.whole, 3)) {
        s.partition = partition;
        expect_none(search(s), partition.name);
      }
    }
}

/// Distances are in metres, whatever the numbers count: of cells that are thin, or much thicker
/// than a degree's thousandth; over the date line, and where cells wrap.
TEST(SeamFaces, InLongitudeAndLatitude) {
  for (const geo::ChartUnits& units :
       {geo::ChartUnits{}, geo::ChartUnits{.radians = true, .kilometres = true, .down = true}}) {
    fixtures::Lattice ring, wrapping, small;
    ring.south = -60, ring.north = 60;
    wrapping = ring;
    wrapping.wraps = true, wrapping.jump = -360;
    wrapping.west = 0, wrapping.east = 360;
    small.west = 10, small.east = 10.24, small.south = 40, small.north = 40.12;
    const std::string names[] = {"ring", "wrapping ring", "small"};
    fixtures::Lattice lattices[] = {ring, wrapping, small};
    for (int i = 0; i < 3; ++i)
      for (const int processes : {2, 3}) {
        fixtures::Lattice& l = lattices[i];
        l.units = units;
        Search s{fixtures::lattice(l), {}};
        s.frame = fixtures::frame_of(units);
        s.partition = {"columns", processes, {}};
        for (std::size_t c = 0; c < s.whole.cells.size(); ++c)
          s.partition.process.push_back(int(c) % l.across * processes / l.across);
        const std::string which = names[i] + " on " + std::to_string(processes);
        expect_none(search(s), which + ", matching");
        const double width = (l.east - l.west) / l.across * units.turn() / 360;
        s.displaced = [&](Vec3d x, int rank) {
          x.x += 1e-4 * width * rank;
          return x;
        };
        expect_none(search(s), which + ", by default");
        s.tolerance = 1e-3;
        expect_all_found(s, search(s), which, i == 2 ? 0.0 : units.turn());
      }
  }
}

/// Poles are one place whatever the longitude there; globes match by any tolerance.
TEST(SeamFaces, OfGlobesMatch) {
  for (const double tilt : {0.0, 0.3})
    for (const double tolerance : {1e-6, 1e-3}) {
      fixtures::Globe globe;
      globe.subdivisions = 2;
      globe.tilt = tilt;
      Search s{fixtures::globe(globe), {}};
      s.frame = fixtures::frame_of({});
      s.tolerance = tolerance;
      for (const fixtures::Partition& partition : fixtures::partitions(s.whole, 3)) {
        s.partition = partition;
        expect_none(search(s), partition.name);
      }
    }
}

/// Processes that move the vertices between them apart, once a step, are told so by the first, the
/// second, the fourth step; others never.
TEST(SeamFaces, ThatMoveApart) {
  const test::TestMesh whole = cubes(3);
  const fixtures::Partition partition = fixtures::slabs(whole, 2);
  for (const double apart : {0.0, 1e-9}) {
    std::vector<std::size_t> said; // after each step, at the root
    test::run_processes(2, [&](parallel::World& world) {
      core::Memory memory;
      const core::Threads threads(1);
      std::size_t count = 0;
      const core::Log log{INSITU_LOG_WARNING,
                          [](insitu_log_level, const char* text, void* to) {
                            *static_cast<std::size_t*>(to) +=
                                std::string(text).find("faces on seams") != std::string::npos;
                          },
                          &count};
      commit::CommittedMesh mesh("part", memory);
      mesh.mesh().set_is_part(true);
      fixtures::Part part(whole, partition, world.rank());
      part.give(mesh.mesh(), true);
      for (int step = 0; step < 6; ++step) {
        std::vector<Vec3d> moved;
        for (const Vec3d& x : whole.vertices)
          moved.push_back(x + (0.1 + apart * world.rank()) * double(step) * Vec3d{0, 0, 1});
        part.move(mesh.mesh(), moved);
        mesh.commit(threads, log, memory, false);
        mesh.update_halo(world, threads, log);
        if (world.is_root())
          said.push_back(count);
      }
    });
    EXPECT_EQ(said, apart == 0.0 ? (std::vector<std::size_t>{0, 0, 0, 0, 0, 0})
                                 : (std::vector<std::size_t>{0, 1, 2, 2, 3, 3}));
  }
}

namespace {

/// What is said of the cells of the mesh, but for faces.
void expect_said(const Found& found, const std::vector<std::string>& parts) {
  ASSERT_EQ(found.said.size(), 1u);
  for (const std::string& part : parts)
    EXPECT_NE(found.said[0].find(part), std::string::npos) << part << " in: " << found.said[0];
}

} // namespace

/// Each process gives its own numbers as global ids.
TEST(SeamNames, NumbersOfAProcessAlone) {
  const test::TestMesh whole = cubes(3);
  Search s{whole, fixtures::slabs(whole, 3)};
  std::vector<std::int64_t> own(whole.cells.size());
  std::iota(own.begin(), own.end(), std::int64_t(0));
  s.then = [&](mesh::Mesh& mesh, const fixtures::Part& part, int) {
    const insitu_array ids =
        insitu_array_of(own.data(), INSITU_INT64, std::int64_t(part.pieces()[0].cells.size()), 1);
    mesh.set_global_ids(0, INSITU_CELL, &ids);
  };
  // All cells of slabs of 9 cells have the ids of those beside them, the middle one's twice.
  expect_said(search(s), {"mesh 'part': 36 cells have the global id of another process's cell",
                          "the first of process 0, piece 0, cell 0 and process 1, piece 0, cell 0:",
                          "a process's own numbers are no global ids"});
}

TEST(SeamNames, IdsOfSomeProcessesOnly) {
  const test::TestMesh whole = cubes(3);
  Search s{whole, fixtures::slabs(whole, 3)};
  s.then = [&](mesh::Mesh& mesh, const fixtures::Part&, int rank) {
    if (rank == 1)
      mesh.set_global_ids(0, INSITU_CELL, nullptr);
  };
  expect_said(search(s), {"process 0 gives global ids of cells and process 1 gives none"});
}

/// Copies of others' cells that are not given as ghosts.
TEST(SeamNames, CellsThatTwoProcessesGive) {
  const test::TestMesh whole = cubes(3);
  Search s{whole, fixtures::with_ghosts(fixtures::slabs(whole, 3))};
  EXPECT_TRUE(search(s).said.empty());
  const std::vector<std::uint8_t> none(whole.cells.size());
  s.ids = false;
  s.then = [&](mesh::Mesh& mesh, const fixtures::Part& part, int) {
    const insitu_array bits =
        insitu_array_of(none.data(), INSITU_UINT8, std::int64_t(part.pieces()[0].cells.size()), 1);
    mesh.set_ghosts(0, &bits, INSITU_GHOSTS_VTK);
  };
  // The outer slabs have two of three slabs, the middle one all.
  expect_said(search(s), {"cells are cells of another process, too, to the bit",
                          "they count twice; all but one of these are to be ghosts"});
}
