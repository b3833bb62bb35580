/// Memory that one process lacks in each phase of each collective call: mpiexec -n 3. All return
/// the same status and message, which names the process; nobody hangs (the test's limit of time is
/// the check), and the next call works.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "api/mpi/main.h"
#include "api/mpi/slab.h"
#include "fixtures/lacking_memory.h"

namespace {

thread_local bool counts = false;
thread_local std::size_t least = insitu::test::least_bytes; ///< of a piece that counts
thread_local std::int64_t taken = 0;    ///< pieces, while they count
thread_local std::int64_t lacking = -1; ///< the number of the piece that is not had; -1: none
thread_local bool has_failed = false;

} // namespace

bool insitu::test::lacks(std::size_t bytes) {
  if (!counts || bytes < least || taken++ != lacking)
    return false;
  return has_failed = true;
}

namespace {

const char* const scene =
    "insitu: 1\n"
    "page: false\n"
    "probes:\n"
    "  - {name: grid, points: {box: {min: [0, 0, 0], max: [6, 6, 6], counts: [7, 7, 7]}}, when: "
    "mean(p) > -9}\n"
    "  - {name: body, points: {box: {min: [1, 1, 0.5], max: [5, 5, 5.5], counts: [4, 4, 11]}}, "
    "attached: body}\n"
    "tracers:\n"
    "  - {name: paths, velocity: u, seeds: {box: {min: [1, 1, 0.5], max: [5, 5, 5.5], counts: [4, "
    "4, 5]}}, fields: [p, c], output: [csv, vtp]}\n"
    "frames:\n"
    "  - {name: smoke, size: [66, 34], images: [color, depth, cell], volume: {field: p},\n"
    "     isosurfaces: [{field: p, values: [0.5], opacity: 0.5, normals: smooth}]}\n";

/// A solver of a slab a process, and the calls of all.
struct Solver {
  explicit Solver(const std::string& folder)
      : slab(side * rank() / size(), side * (rank() + 1) / size()) {
    static const MPI_Comm world = MPI_COMM_WORLD;
    options.scene_text = scene;
    options.output = folder;
    options.communicator = &world;
    options.threads = 1;
    options.log = [](insitu::LogLevel, const char*) {};
  }
  void open() { session.emplace(options); }
  void give() {
    insitu::Mesh mesh = session->mesh("m");
    slab.give(mesh);
  }
  void execute(int cycle) {
    slab.step(cycle);
    if (cycle > 0 && given)
      session->mesh("m").changed(insitu::geometry | insitu::fields);
    else
      give();
    given = true;
    if (!session->execute(cycle, 0.5 * cycle))
      throw insitu::Error(INSITU_ERROR_ACTION, insitu_last_message());
  }
  void ask() {
    constexpr int count = 100;
    double points[3 * count];
    for (int i = 0; i < count; ++i) {
      points[3 * i] = 3.0;
      points[3 * i + 1] = 2.5;
      points[3 * i + 2] = 0.06 * i;
    }
    insitu::LocateOptions everywhere;
    everywhere.everywhere = true;
    const insitu::Mesh mesh = session->mesh("m");
    mesh.locate(insitu::Points(points, count), everywhere);
    mesh.sample("p", insitu::Points(points, count), everywhere);
    mesh.sample_fields({"p", "c"}, insitu::Points(points, count), everywhere);
  }

  insitu::Options options;
  Slab slab;
  std::optional<insitu::Session> session;
  bool given = false;
};

/// A call of all processes, and what goes before it.
struct Phase {
  const char* name;
  std::function<void(Solver&)> before, call;
};

const char* const state = "faults.insitu";

const std::vector<Phase>& phases() {
  const auto open = [](Solver& s) { s.open(); };
  const auto opened = [](Solver& s) {
    s.open();
    s.session->keep_answers(); // probes tell all processes what they find
  };
  const auto executed = [opened](Solver& s) {
    opened(s);
    s.execute(0);
  };
  const auto restarted = [opened](Solver& s) {
    opened(s);
    s.session->restart(state);
  };
  static const std::vector<Phase> all = {
      {"open", [](Solver&) {}, open},
      {"first execute", opened, [](Solver& s) { s.execute(0); }},
      {"execute", executed, [](Solver& s) { s.execute(1); }},
      {"query everywhere", executed, [](Solver& s) { s.ask(); }},
      {"checkpoint", executed, [](Solver& s) { s.session->checkpoint(state); }},
      {"restart", open, [](Solver& s) { s.session->restart(state); }},
      {"execute after a restart", restarted, [](Solver& s) { s.execute(1); }}};
  return all;
}

/// What a call of all said, which is the same on all.
std::string said_by(Solver& solver, const std::function<void(Solver&)>& call) {
  char said[2048] = {}, root[2048] = {};
  counts = true;
  try {
    call(solver);
  } catch (const insitu::Error& e) {
    counts = false;
    std::snprintf(said, sizeof said, "%d %s", int(e.status()), e.what());
  }
  counts = false;
  std::copy(std::begin(said), std::end(said), std::begin(root));
  MPI_Bcast(root, sizeof root, MPI_CHAR, 0, MPI_COMM_WORLD);
  EXPECT_STREQ(said, root) << "process " << rank();
  return said;
}

bool any(bool one) {
  int all = one;
  MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  return all != 0;
}

/// The call of a phase without the piece of this number on one process. Returns whether it failed.
bool fails_without(const Phase& phase, int failing, std::int64_t piece) {
  Solver solver("faults");
  phase.before(solver);
  taken = 0;
  lacking = rank() == failing ? piece : -1;
  has_failed = false;
  const std::string said = said_by(solver, phase.call);
  lacking = -1;
  const bool failed = any(has_failed);
  if (said.empty())
    return false; // it did without, as a sort may, or has that many not
  const std::string who = "process " + std::to_string(failing) + " of " + std::to_string(size());
  EXPECT_TRUE(failed) << phase.name << ": " << said;
  EXPECT_NE(said.find(who + ": out of memory"), std::string::npos) << phase.name << ": " << said;
  EXPECT_EQ(said_by(solver, phase.call), "") << phase.name << ", once more after: " << said;
  return true;
}

/// So many pieces of each phase, from its first to its last, on each process in turn;
/// INSITU_LACK_TRIES: another number of them.
TEST(Faults, MemoryThatLacksInAnyPhaseOfAnyCall) {
  const char* const given = std::getenv("INSITU_LACK_TRIES");
  const int tries = given ? std::atoi(given) : 9;
  for (const Phase& phase : phases()) {
    Solver solver("faults");
    phase.before(solver);
    taken = 0;
    ASSERT_EQ(said_by(solver, phase.call), "") << phase.name;
    const std::int64_t pieces = taken;
    solver.session.reset();
    int failures = 0;
    for (int i = 0; i < tries && !any(HasFailure()); ++i)
      failures += fails_without(phase, i % size(), pieces * (2 * i + 1) / (2 * tries));
    EXPECT_GT(failures, 0) << phase.name;
  }
}

/// Each piece of opening, however small, one process after the other: from before there is a
/// communicator of the session's until the scene is read.
TEST(Faults, EachPieceOfMemoryThatLacksInOpening) {
  const Phase opening{"open", [](Solver&) {},
                      [](Solver& s) {
                        s.options.scene_text = "insitu: 1";
                        s.open();
                      }};
  least = 1;
  std::int64_t most = 0;
  for (int i = 0; i < 2; ++i) { // the first one takes what stays
    Solver solver("faults");
    taken = 0;
    ASSERT_EQ(said_by(solver, opening.call), "");
    most = taken;
  }
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_INT64_T, MPI_MAX, MPI_COMM_WORLD);
  int failures = 0;
  for (std::int64_t piece = 0; piece < most && !any(HasFailure()); ++piece)
    failures += fails_without(opening, int(piece % size()), piece);
  EXPECT_GT(failures, most / 2);
  least = insitu::test::least_bytes;
}

} // namespace

int main(int argc, char** argv) {
  return run_on_all_processes(argc, argv);
}
