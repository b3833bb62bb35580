/// A ring of cells in longitude and latitude over processes: mpiexec -n 1, 3. Frames whose volumes,
/// averages and normals go over the seam, and particles that do, are those of one process that has
/// the whole mesh.
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <insitu/insitu.hpp>
#include <string>
#include <vector>

#include "api/mpi/files.h"
#include "api/mpi/main.h"

namespace {

constexpr int across = 18, along = 8; ///< cells of one layer, of which a column wraps around

/// Columns [first, last) of cells, of rows that stand 7.3 degrees east of those before.
struct Columns {
  std::vector<double> points, p, c, w;
  std::vector<std::int32_t> connectivity;
  std::vector<std::int64_t> cells;

  Columns(int first, int last) {
    for (int k = 0; k < 2; ++k)
      for (int j = 0; j <= along; ++j)
        for (int i = 0; i < across; ++i) {
          const double lon = std::fmod(20.0 * i + 7.3 * j, 360.0), lat = 20.0 * j - 80.0;
          points.insert(points.end(), {lon, lat, 30.0 * k});
          p.push_back(std::sin(0.1 * lat) + std::cos(lon * 0.0174532925199433));
          w.insert(w.end(), {1.5e6 * std::cos(0.02 * lat), 4e5 * std::sin(0.1 * lon), 0.0});
        }
    const auto id = [](int i, int j, int k) { return i % across + across * (j + (along + 1) * k); };
    for (int j = 0; j < along; ++j)
      for (int i = first; i < last; ++i) {
        cells.push_back(j * across + i);
        c.push_back(std::cos(2.0 * double(cells.back())));
        for (int k = 0; k < 2; ++k)
          for (const auto [di, dj] : {std::array{0, 0}, {1, 0}, {1, 1}, {0, 1}})
            connectivity.push_back(id(i + di, j + dj, k));
      }
  }
};

const char* const scene =
    "insitu: 1\n"
    "page: false\n"
    "every: 3\n"
    "tracers:\n"
    "  - {name: paths, velocity: w, seeds: {box: {min: [5, -70, 1], max: [345, 70, 29], counts: "
    "[5, 4, 2]}}, fields: [p, c], geodesics: [path_length], every: 1}\n"
    "  - {name: walks, velocity: w, seeds: [[350, 10, 5], [20, -30, 5]], effects: [{boundary: "
    "slide}, {settling: {speed: 20}}, {diffusion: {horizontal: 1e10}}], every: 1}\n"
    "  - {name: lines, velocity: w, kind: streamline, seeds: [[350, 10, 5], [20, -30, 5]], "
    "direction: both, until: {duration: 5}}\n"
    "frames:\n"
    "  - {name: smooth, size: [64, 40], images: [color, depth, cell], camera: {azimuth: -90, "
    "elevation: 70},\n"
    "     isosurfaces: [{field: c, values: [0.1], normals: smooth}],\n"
    "     volume: {field: p, shading: true, unit_distance: 60}}\n"
    "  - {name: rim, size: [64, 40], boundary: {opacity: 0.3}, camera: {azimuth: -90},\n"
    "     volume: {field: c, smooth: true, unit_distance: 60}}\n";

void run(const Columns& part, const MPI_Comm* comm, const std::string& output) {
  insitu::Options options;
  options.scene_text = scene;
  options.output = output;
  options.communicator = comm;
  options.log_level = insitu::LogLevel::error;
  insitu::Session session(options);
  insitu::Mesh mesh = session.mesh("sea");
  mesh.frame(insitu::Frame::geodetic());
  if (!part.cells.empty()) {
    insitu::Piece piece = mesh.piece(0);
    piece.points(part.points);
    piece.hexahedra(part.connectivity);
    piece.global_ids(insitu::Association::cell, part.cells);
    piece.vertex_field("p", part.p);
    piece.vertex_field("w", insitu::Array(part.w).components(3));
    piece.cell_field("c", part.c);
  }
  for (int cycle = 0; cycle < 3; ++cycle)
    session.execute(cycle, cycle);
}

} // namespace

TEST(EarthOverMpi, FramesAndTracksOverTheSeamAreThoseOfOneProcess) {
  const std::string together = "earth_together_" + std::to_string(size());
  const std::string alone = "earth_alone_" + std::to_string(size());
  if (rank() == 0) {
    std::filesystem::remove_all(together);
    std::filesystem::remove_all(alone);
    run(Columns(0, across), nullptr, alone);
  }
  MPI_Barrier(MPI_COMM_WORLD);
  const MPI_Comm world = MPI_COMM_WORLD;
  run(Columns(across * rank() / size(), across * (rank() + 1) / size()), &world, together);
  if (rank() > 0)
    return;
  expect_same_files(alone, together, 8);
}

int main(int argc, char** argv) {
  return run_on_all_processes(argc, argv);
}
