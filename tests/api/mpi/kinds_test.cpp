/// Scenes of meshes of other kinds: adaptive ones by both reconstructions, whose patches become
/// others, and polyhedra: mpiexec -n 1, 3, 4. What the session of all processes writes is what one
/// process writes that has the whole mesh.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <insitu/insitu.hpp>
#include <map>
#include <string>
#include <vector>

#include "api/mpi/files.h"
#include "api/mpi/main.h"
#include "api/mpi/slab.h"

namespace {

constexpr int cycles = 4;

/// Runs advance(mesh, cycle, rank, size) on one process and on all.
template <class Advance>
void expect_files_of_one_process(const std::string& name, const std::string& scene,
                                 std::size_t least, const Advance& advance) {
  const MPI_Comm world = MPI_COMM_WORLD;
  const auto run = [&](const MPI_Comm* comm, const std::string& output, int at, int of) {
    const std::string text = "insitu: 1\npage: false\n" + scene;
    insitu::Options options;
    options.scene_text = text;
    options.output = output;
    options.communicator = comm;
    options.log_level = insitu::LogLevel::error;
    insitu::Session session(options);
    auto solver = advance(at, of);
    for (int cycle = 0; cycle < cycles; ++cycle) {
      insitu::Mesh mesh = session.mesh("m");
      solver.give(mesh, cycle);
      session.execute(cycle, 0.5 * cycle);
    }
  };
  const std::string alone = name + "_alone", together = name + "_together";
  if (rank() == 0) {
    std::filesystem::remove_all(together);
    std::filesystem::remove_all(alone);
    run(nullptr, alone, 0, 1);
  }
  MPI_Barrier(MPI_COMM_WORLD);
  run(&world, together, rank(), size());
  if (rank() == 0)
    expect_same_files(alone, together, least);
}

/// Patches of two levels in a cube from 0 to 6, dealt out by turns to all processes but the last.
/// The fine ones move in cycle 2.
struct Patches {
  struct Patch {
    int level;
    std::array<std::int64_t, 3> lower, cells;
    std::vector<std::int64_t> ids = {};
    std::vector<double> s = {}, v = {};
  };
  insitu::Reconstruction how;
  int at, of;
  std::vector<Patch> mine = {};

  void deal(int cycle) {
    mine.clear();
    std::vector<Patch> all;
    for (std::int64_t k = 0; k < side; ++k)
      all.push_back({0, {0, 0, k}, {side, side, 1}});
    const std::int64_t x = cycle < 2 ? 2 : 4;
    for (std::int64_t j = 0; j < 2; ++j)
      all.push_back({1, {x, 2 + 4 * j, 4}, {6, 4, 4}});
    std::int64_t first = 0;
    for (std::size_t p = 0; p < all.size(); ++p) {
      Patch& patch = all[p];
      const std::int64_t count = patch.cells[0] * patch.cells[1] * patch.cells[2];
      for (std::int64_t c = 0; c < count; ++c)
        patch.ids.push_back(first + c);
      first += count;
      if (int(p) % std::max(1, of - 1) == at)
        mine.push_back(patch);
    }
  }
  void give(insitu::Mesh& mesh, int cycle) {
    if (cycle % 2 == 0)
      deal(cycle);
    if (mine.empty())
      return;
    if (cycle % 2 == 0) {
      insitu::AmrLevels levels;
      levels.ratios = {2};
      levels.reconstruction = how;
      mesh.adaptive(levels);
    }
    for (std::size_t p = 0; p < mine.size(); ++p) {
      Patch& patch = mine[p];
      insitu::Piece piece = mesh.piece(int(p));
      patch.s.clear();
      patch.v.clear();
      for (std::int64_t c = 0; c < std::int64_t(patch.ids.size()); ++c) {
        const double h = patch.level == 0 ? 1.0 : 0.5;
        const double i = double(patch.lower[0] + c % patch.cells[0]) * h,
                     j = double(patch.lower[1] + c / patch.cells[0] % patch.cells[1]) * h,
                     k = double(patch.lower[2] + c / patch.cells[0] / patch.cells[1]) * h;
        patch.s.push_back(std::sin(i + 0.3 * cycle) + 0.1 * k);
        patch.v.insert(patch.v.end(), {3.0 - j, i - 3.0, 0.3 * std::cos(k + cycle)});
      }
      if (cycle % 2 == 0) {
        piece.patch(patch.level, patch.lower, patch.cells);
        piece.global_ids(insitu::Association::cell, patch.ids);
      }
      piece.cell_field("s", patch.s);
      piece.cell_field("v", insitu::Array(patch.v).components(3));
    }
  }
};

/// The cells of a slab by their faces.
struct Polyhedra {
  Slab slab;
  std::vector<std::int32_t> vertices = {}, offsets = {0}, faces = {}, starts = {0};

  explicit Polyhedra(Slab of) : slab(std::move(of)) {
    std::map<std::array<std::int32_t, 4>, std::int32_t> known;
    for (std::size_t c = 0; c < slab.cells.size(); ++c) {
      for (const auto& f : {std::array{0, 3, 2, 1},
                            {4, 5, 6, 7},
                            {0, 1, 5, 4},
                            {1, 2, 6, 5},
                            {2, 3, 7, 6},
                            {3, 0, 4, 7}}) {
        std::array<std::int32_t, 4> face{};
        for (std::size_t v = 0; v < 4; ++v)
          face[v] = slab.connectivity[8 * c + std::size_t(f[v])];
        auto sorted = face;
        std::ranges::sort(sorted);
        const auto [at, is_new] = known.emplace(sorted, std::int32_t(known.size()));
        faces.push_back(at->second);
        if (!is_new)
          continue;
        vertices.insert(vertices.end(), face.begin(), face.end());
        offsets.push_back(std::int32_t(vertices.size()));
      }
      starts.push_back(std::int32_t(faces.size()));
    }
  }
  void give(insitu::Mesh& mesh, int cycle) {
    slab.step(cycle);
    if (slab.empty())
      return;
    if (cycle > 0)
      return mesh.changed(insitu::geometry | insitu::fields);
    insitu::Piece piece = mesh.piece(0);
    piece.points(slab.points);
    piece.faces_of_cells(vertices, offsets, faces, starts);
    piece.global_ids(insitu::Association::cell, slab.cells);
    piece.global_ids(insitu::Association::vertex, slab.vertices);
    piece.vertex_field("s", slab.p);
    piece.vertex_field("v", insitu::Array(slab.u).components(3));
  }
};

const std::string scene = "probes:\n"
                          "  - {name: seams, points: {box: {min: [0.1, 0, 0], max: [5.9, 6, 6], "
                          "counts: [7, 7, 13]}}, outside: nearest}\n"
                          "  - {name: mean, points: [[1, 1, 1]], when: mean(s) < 10}\n"
                          "tracers:\n"
                          "  - {name: paths, velocity: v, fields: [s], seeds: {box: {min: [1, 1, "
                          "1], max: [5, 5, 5], counts: [3, 3, 3]}}}\n"
                          "  - {name: walks, velocity: v, seeds: [[1, 1, 1], [4, 2, 3], [5, 5, "
                          "5]], effects: [{boundary: slide}, {settling: "
                          "{speed: 1}}, {diffusion: {coefficient: 0.1}}]}\n"
                          "  - {name: lines, velocity: v, kind: streamline, seeds: [[1, 1, 1], [4, "
                          "2, 3]], until: {duration: 2}, every: 2}\n"
                          "frames:\n"
                          "  - {name: inside, size: [40, 66], images: [color, cell], every: 2, "
                          "volume: {field: s, opacity: [[-1, 0.05], [1, 0.4]]},\n"
                          "     boundary: {opacity: 0.3, color: {field: s}}}\n";

TEST(KindsOverMpi, AdaptiveByNearest) {
  expect_files_of_one_process("nearest", scene, 11, [](int at, int of) {
    return Patches{insitu::Reconstruction::nearest, at, of};
  });
}

TEST(KindsOverMpi, AdaptiveByTheDual) {
  expect_files_of_one_process("dual", scene, 11, [](int at, int of) {
    return Patches{insitu::Reconstruction::dual, at, of};
  });
}

TEST(KindsOverMpi, Polyhedra) {
  expect_files_of_one_process("polyhedra", scene, 11, [](int at, int of) {
    return Polyhedra(Slab(side * at / of, side * (at + 1) / of));
  });
}

} // namespace

int main(int argc, char** argv) {
  return run_on_all_processes(argc, argv);
}
