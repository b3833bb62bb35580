/// A mesh cut into slabs over processes, of which some have none: mpiexec -n 1, 2, 3, 4, 8. What
/// the session of all processes writes is what one process writes that has the whole mesh.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <insitu/insitu.hpp>
#include <string>
#include <thread>
#include <vector>

#include "api/mpi/files.h"
#include "api/mpi/main.h"
#include "api/mpi/slab.h"

namespace {

/// Of this process, before each of the library's exchanges; a few milliseconds, or none.
struct Delay {
  bool on = false;
  unsigned calls = 0;

  void pass() {
    if (on) // now shorter, now longer than what the others take
      std::this_thread::sleep_for(std::chrono::milliseconds(++calls * 7 % 4));
  }
};
Delay delay;

} // namespace

// The calls of MPI by which a World exchanges come here first.
extern "C" {
int MPI_Allreduce(const void* in, void* out, int n, MPI_Datatype type, MPI_Op op, MPI_Comm comm) {
  delay.pass();
  return PMPI_Allreduce(in, out, n, type, op, comm);
}
int MPI_Alltoall(const void* in, int n_in, MPI_Datatype type_in, void* out, int n_out,
                 MPI_Datatype type_out, MPI_Comm comm) {
  delay.pass();
  return PMPI_Alltoall(in, n_in, type_in, out, n_out, type_out, comm);
}
int MPI_Bcast(void* data, int n, MPI_Datatype type, int root, MPI_Comm comm) {
  delay.pass();
  return PMPI_Bcast(data, n, type, root, comm);
}
int MPI_Waitall(int n, MPI_Request* requests, MPI_Status* statuses) {
  delay.pass();
  return PMPI_Waitall(n, requests, statuses);
}
}

namespace {

const char* const scene =
    "insitu: 1\n"
    "page: false\n"
    "probes:\n"
    "  - {name: grid, points: {box: {min: [0, 0, 0], max: [6, 6, 6], counts: [13, 13, 13]}},\n"
    "     output: [csv, vtp, json, netcdf]}\n"
    "  - {name: mean, points: [[1, 1, 1]], when: mean(p) > 0.5}\n"
    "  - {name: body, points: {box: {min: [1, 1, 0.5], max: [5, 5, 5.5], counts: [2, 2, 11]}}, "
    "attached: body}\n"
    "frames:\n"
    "  - {name: smoke, size: [70, 66], images: [color, depth, cell], volume: {field: p},\n"
    "     isosurfaces: [{field: p, values: [0.5], opacity: 0.5, normals: smooth}],\n"
    "     boundary: {opacity: 0.1, color: {field: c}}}\n";

/// Cycles [from, to), if not from the first one on from a checkpoint, which each run ends with.
struct Cycles {
  int from = 0, to = 4;
  std::string state = {};
};

/// Runs some cycles; comm: null: of this process alone.
void run(Slab& slab, const MPI_Comm* comm, const std::string& output, const Cycles& cycles = {},
         const char* with = scene) {
  insitu::Options options;
  options.scene_text = with;
  options.output = output;
  options.communicator = comm;
  options.log_level = insitu::LogLevel::error;
  insitu::Session session(options);
  if (cycles.from > 0)
    session.restart(cycles.state);
  for (int cycle = cycles.from; cycle < cycles.to; ++cycle) {
    slab.step(cycle);
    insitu::Mesh mesh = session.mesh("m");
    if (cycle == cycles.from)
      slab.give(mesh);
    else if (!slab.empty()) // the arrays stay where they are
      mesh.changed(insitu::geometry | insitu::fields);
    session.execute(cycle, 0.5 * cycle);
  }
  if (!cycles.state.empty())
    session.checkpoint(cycles.state);
}

/// Compares the files of all processes together, of which one may be slow.
void expect_files_of_one_process(bool with_delay) {
  int rank = 0, size = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  const std::string together = "together_" + std::to_string(size), alone = "alone";
  if (rank == 0) {
    std::filesystem::remove_all(together);
    std::filesystem::remove_all(alone);
    Slab whole(0, side);
    run(whole, nullptr, alone);
  }
  MPI_Barrier(MPI_COMM_WORLD);
  const MPI_Comm world = MPI_COMM_WORLD;
  Slab slab(side * rank / size, side * (rank + 1) / size);
  delay = {.on = with_delay && rank == size / 2};
  run(slab, &world, together);
  EXPECT_TRUE(!delay.on || delay.calls > 0); // the library's calls do come here
  delay = {};
  if (rank > 0)
    return;
  expect_same_files(alone, together, 12);
}

TEST(Parts, FilesAreThoseOfOneProcess) {
  expect_files_of_one_process(false);
}

/// One process comes late to each exchange, so that messages of the others' later ones are there
/// before its own.
TEST(Parts, WithASlowProcess) {
  expect_files_of_one_process(true);
}

const char* const restarted =
    "insitu: 1\n"
    "page: false\n"
    "probes:\n"
    "  - {name: body, points: {box: {min: [1, 1, 0.5], max: [5, 5, 5.5], counts: [2, 2, 11]}}, "
    "attached: body}\n"
    "tracers:\n"
    "  - {name: paths, velocity: u, seeds: {box: {min: [1, 1, 0.5], max: [5, 5, 5.5], counts: [3, "
    "3, 5]}}, fields: [p, c], output: [csv, vtp, netcdf]}\n";

/// Stopped on all processes, and taken up on all but the last.
TEST(Parts, GoesOnFromACheckpointOnFewerProcesses) {
  int rank = 0, size = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  const std::string stopped = "stopped_" + std::to_string(size), alone = "never_stopped";
  const std::string state = "stopped_" + std::to_string(size) + ".insitu";
  if (rank == 0) {
    std::filesystem::remove_all(stopped);
    std::filesystem::remove_all(alone);
    Slab whole(0, side);
    run(whole, nullptr, alone, {0, 6}, restarted);
  }
  MPI_Barrier(MPI_COMM_WORLD);
  const MPI_Comm world = MPI_COMM_WORLD;
  {
    Slab slab(side * rank / size, side * (rank + 1) / size);
    run(slab, &world, stopped, {0, 3, state}, restarted);
  }
  const int fewer = std::max(1, size - 1);
  MPI_Comm some = MPI_COMM_NULL;
  MPI_Comm_split(MPI_COMM_WORLD, rank < fewer ? 0 : MPI_UNDEFINED, rank, &some);
  if (rank < fewer) {
    Slab slab(side * rank / fewer, side * (rank + 1) / fewer);
    run(slab, &some, stopped, {3, 6, state}, restarted);
    MPI_Comm_free(&some);
  }
  if (rank > 0)
    return;
  expect_same_files(alone, stopped, 5);
}

} // namespace

int main(int argc, char** argv) {
  return run_on_all_processes(argc, argv);
}
