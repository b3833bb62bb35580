/// Sessions over processes: mpiexec -n 1, 3. One process errs, and all hear of it; nobody hangs.
/// INSITU_TEST_SINGLE: MPI is initialised for one thread; INSITU_TEST_BOUND: all processes are
/// bound to one core.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <insitu/insitu.hpp>
#include <sched.h>
#include <string>
#include <thread>
#include <unistd.h>
#include <vector>

#include "api/mpi/main.h"

namespace {

bool is_asked(const char* name) {
  return std::getenv(name) != nullptr;
}
bool is_last() {
  return rank() == size() - 1;
}
std::string last_process() {
  return "process " + std::to_string(size() - 1) + " of " + std::to_string(size());
}

const char* const scene = "insitu: 1\nprobes: [{name: gauges, points: [[0.5, 0.5, 0.5]]}]\n";

/// A session of all processes, and what it said.
struct Solver {
  std::unique_ptr<insitu::Session> session;
  insitu_status status = INSITU_OK;
  std::string error;
  std::vector<std::string> messages;
  std::vector<double> values = std::vector<double>(8, 2.5);

  using Change = std::function<void(insitu::Options&)>;
  explicit Solver(const Change& change = {}) {
    static const MPI_Comm world = MPI_COMM_WORLD;
    insitu::Options o;
    o.scene_text = scene;
    o.output = "process_" + std::to_string(rank());
    o.communicator = &world;
    o.log = [this](insitu::LogLevel, const char* m) { messages.emplace_back(m); };
    if (change)
      change(o);
    tell([&] { session = std::make_unique<insitu::Session>(o); });
  }
  void tell(const std::function<void()>& call) {
    status = INSITU_OK;
    error.clear();
    try {
      call();
    } catch (const insitu::Error& e) {
      status = e.status();
      error = e.what();
    }
  }
  insitu::Mesh give(const std::string& field = "f", int components = 1) {
    insitu::Mesh mesh = session->mesh("box");
    insitu_block block = insitu_block_default();
    block.kind = INSITU_BLOCK_UNIFORM;
    block.vertices[0] = block.vertices[1] = block.vertices[2] = 2;
    EXPECT_EQ(insitu_mesh_block(mesh.handle(), 0, &block), INSITU_OK);
    values.assign(std::size_t(8 * components), 2.5);
    const insitu_array array = insitu_array_of(values.data(), INSITU_FLOAT64, 8, components);
    EXPECT_EQ(insitu_mesh_field(mesh.handle(), 0, field.c_str(), INSITU_VERTEX, &array, 1),
              INSITU_OK);
    return mesh;
  }
  insitu_status execute(std::int64_t cycle, double time) {
    status = insitu_session_execute(session->handle(), cycle, time);
    error = insitu_last_message();
    return status;
  }
};

TEST(Sessions, OfAllProcessesExecuteTogether) {
  Solver solver;
  ASSERT_EQ(solver.error, "");
  solver.give();
  for (int cycle = 0; cycle < 3; ++cycle)
    EXPECT_EQ(solver.execute(cycle, 0.5 * cycle), INSITU_OK) << solver.error;
  EXPECT_EQ(solver.messages.size(), 0u);
}

/// A process may have nothing: at first, and by then something.
TEST(Sessions, AMeshThatAProcessLacksIsEmptyThere) {
  Solver solver;
  ASSERT_EQ(solver.error, "");
  if (!is_last() || size() == 1)
    solver.give();
  for (int cycle = 0; cycle < 2; ++cycle)
    EXPECT_EQ(solver.execute(cycle, cycle), INSITU_OK) << solver.error;
  solver.give();
  EXPECT_EQ(solver.execute(2, 2), INSITU_OK) << solver.error;
}

/// Whatever one process does wrong, all return the same status, and a message with who and what.
TEST(Sessions, AFailureOfOneIsAFailureOfAll) {
  const std::string prefix = size() > 1 ? last_process() + ": " : "";
  {
    const Solver bad([](insitu::Options& o) {
      if (is_last())
        o.scene_text = "insitu: 1\nprobs: []\n";
    });
    EXPECT_EQ(bad.status, INSITU_ERROR_SCENE);
    EXPECT_EQ(bad.error.find(prefix + "scene:2"), 0u) << bad.error;
    EXPECT_EQ(bad.messages.size(), rank() == 0 ? 1u : 0u);
  }
  {
    const Solver bad([](insitu::Options& o) { o.threads = is_last() ? -3 : 1; });
    EXPECT_EQ(bad.status, INSITU_ERROR_ARGUMENT);
    EXPECT_EQ(bad.error, prefix + "threads: -3, 0 (all) or more expected");
  }
  Solver solver;
  solver.give();
  EXPECT_EQ(solver.execute(0, is_last() ? std::nan("") : 0.0), INSITU_ERROR_ARGUMENT);
  EXPECT_EQ(solver.error, prefix + "time: not finite");
  // A commit fails: a field of two values for eight vertices.
  const insitu_array few = insitu_array_of(solver.values.data(), INSITU_FLOAT64, 2, 1);
  if (is_last())
    insitu_mesh_field(solver.session->mesh("box").handle(), 0, "f", INSITU_VERTEX, &few, 1);
  EXPECT_NE(solver.execute(0, 0.0), INSITU_OK);
  EXPECT_EQ(solver.error.find(prefix), 0u) << solver.error;
  EXPECT_NE(solver.error.find("'f'"), std::string::npos) << solver.error;
  // It is mended, and all go on.
  solver.give();
  EXPECT_EQ(solver.execute(0, 0.0), INSITU_OK) << solver.error;
}

/// The root cannot write; the folders of the others do not matter.
TEST(Sessions, AFailedActionIsToldToAll) {
  Solver solver([](insitu::Options& o) {
    if (rank() == 0) {
      std::filesystem::create_directories("here");
      std::filesystem::remove_all("here/file");
      std::fclose(std::fopen("here/file", "w"));
      o.output = "here/file/out";
    }
  });
  ASSERT_EQ(solver.error, "");
  solver.give();
  EXPECT_EQ(solver.execute(0, 0.0), INSITU_ERROR_ACTION);
  const std::string root = size() > 1 ? "process 0 of " + std::to_string(size()) + ": " : "";
  EXPECT_EQ(solver.error.find("probe 'gauges': " + root), 0u) << solver.error;
}

/// The root alone writes: one table, with a row for the point, of which all have a cell.
TEST(Sessions, OfOneFolderWriteOneTable) {
  if (rank() == 0)
    std::filesystem::remove_all("one_folder");
  MPI_Barrier(MPI_COMM_WORLD);
  {
    Solver solver([](insitu::Options& o) { o.output = "one_folder"; });
    ASSERT_EQ(solver.error, "");
    solver.give();
    EXPECT_EQ(solver.execute(0, 0.0), INSITU_OK) << solver.error;
  }
  std::ifstream in("one_folder/gauges.csv");
  const std::string table{std::istreambuf_iterator<char>(in), {}};
  EXPECT_EQ(table, size() > 1 ? "cycle,time,point,cell,process,r,s,t,f\n"
                                "0,0,0,0,0,0.5,0.5,0.5,2.5\n"
                              : "cycle,time,point,cell,r,s,t,f\n"
                                "0,0,0,0,0.5,0.5,0.5,2.5\n");
}

TEST(Sessions, WhatDiffersIsNamed) {
  if (size() == 1)
    GTEST_SKIP() << "one process differs from nobody";
  const auto expect = [](const Solver& s, const std::string& root, const std::string& last) {
    EXPECT_EQ(s.error,
              "processes differ: " + root + " on process 0, " + last + " on " + last_process());
  };
  {
    const Solver bad([](insitu::Options& o) {
      if (is_last())
        o.scene_text = "insitu: 1\n";
    });
    EXPECT_EQ(bad.status, INSITU_ERROR_ARGUMENT);
    EXPECT_EQ(bad.error.find("processes differ: scene of "), 0u) << bad.error;
  }
  Solver solver;
  solver.give();
  EXPECT_EQ(solver.execute(is_last() ? 8 : 7, 0.5), INSITU_ERROR_ARGUMENT);
  expect(solver, "cycle 7", "cycle 8");
  EXPECT_EQ(solver.execute(7, is_last() ? 0.25 : 0.1), INSITU_ERROR_ARGUMENT);
  expect(solver, "time 0.1", "time 0.25");
  solver.session.reset();
  Solver fields;
  fields.give("v", is_last() ? 3 : 1);
  EXPECT_EQ(fields.execute(0, 0), INSITU_ERROR_FIELD);
  EXPECT_NE(
      fields.error.find("processes differ: field 'v' of mesh 'box' has 1 component at vertices on "
                        "process 0, 3 components at vertices on process " +
                        std::to_string(size() - 1)),
      std::string::npos)
      << fields.error;
}

/// Two sessions at once, and one of a part of the processes.
TEST(Sessions, OfOtherGroupsWorkBesideIt) {
  MPI_Comm part = MPI_COMM_NULL;
  MPI_Comm_split(MPI_COMM_WORLD, rank() == 0, 0, &part);
  Solver all([](insitu::Options& o) { o.output = "all_" + std::to_string(rank()); });
  Solver some([&](insitu::Options& o) {
    o.output = "some_" + std::to_string(rank());
    o.communicator = &part;
  });
  all.give();
  some.give();
  EXPECT_EQ(all.execute(0, 0.0), INSITU_OK) << all.error;
  for (int cycle = 0; cycle < 3; ++cycle)
    EXPECT_EQ(some.execute(cycle, cycle), INSITU_OK) << some.error;
  EXPECT_EQ(all.execute(1, 1.0), INSITU_OK) << all.error;
  some.session.reset();
  all.session.reset();
  MPI_Comm_free(&part);
}

/// The least and the greatest number of threads of the processes' sessions, as the summary tells.
std::pair<int, int> threads_of(int asked) {
  const std::string summary = "threads_" + std::to_string(size()) + ".json";
  {
    Solver solver([=](insitu::Options& o) { o.threads = asked; });
    EXPECT_EQ(solver.error, "");
    solver.session->write_summary(summary);
  }
  MPI_Barrier(MPI_COMM_WORLD);
  std::ifstream in(summary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const auto after = [&](const char* key, std::size_t from) {
    const std::size_t at = text.find(key, from);
    EXPECT_NE(at, std::string::npos) << text;
    return std::pair(std::atoi(text.c_str() + at + std::strlen(key)), at);
  };
  const auto least = after("\"least\": ", text.find("\"threads\""));
  const int greatest = after("\"greatest\": ", least.second).first;
  MPI_Barrier(MPI_COMM_WORLD);
  return {least.first, greatest};
}

/// Each process has its share of the cores that any of them may use, within its own affinity.
TEST(Sessions, ThreadsAreAProcesssShareOfTheCores) {
  if (size() == 1)
    GTEST_SKIP() << "one process has all that its affinity allows";
  cpu_set_t mine, all;
  ASSERT_EQ(sched_getaffinity(getpid(), sizeof mine, &mine), 0);
  MPI_Allreduce(&mine, &all, sizeof all, MPI_BYTE, MPI_BOR, MPI_COMM_WORLD);
  const auto expect = [&](int asked, int share) {
    const int here = std::min(share, CPU_COUNT(&mine));
    int least = 0, greatest = 0;
    MPI_Allreduce(&here, &least, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
    MPI_Allreduce(&here, &greatest, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
    EXPECT_EQ(threads_of(asked), std::pair(least, greatest)) << asked;
  };
  expect(0, std::max(1, CPU_COUNT(&all) / size()));
  expect(2, 2);
  if (is_asked("INSITU_TEST_BOUND")) {
    EXPECT_EQ(CPU_COUNT(&all), 1);
  }
}

/// MPI was initialised for calls of its main thread.
TEST(Sessions, ACallOfAnotherThreadIsRefusedOnThatProcess) {
  Solver solver;
  solver.give();
  insitu_status status = INSITU_OK;
  std::string said;
  std::thread([&] {
    status = insitu_session_execute(solver.session->handle(), 0, 0.0);
    said = insitu_last_message();
  }).join();
  EXPECT_EQ(status, INSITU_ERROR_ORDER);
  EXPECT_NE(said.find("another thread"), std::string::npos) << said;
  EXPECT_EQ(solver.execute(0, 0.0), INSITU_OK) << solver.error;
}

/// Where MPI was initialised for one thread, the root warns once, and the library computes in
/// several.
TEST(Sessions, AHostOfOneThreadIsWarnedAndWorks) {
  int level = -1;
  MPI_Query_thread(&level);
  ASSERT_EQ(level, is_asked("INSITU_TEST_SINGLE") ? MPI_THREAD_SINGLE : MPI_THREAD_FUNNELED);
  Solver solver([](insitu::Options& o) { o.threads = 2; });
  ASSERT_EQ(solver.error, "");
  solver.give();
  for (int cycle = 0; cycle < 2; ++cycle)
    EXPECT_EQ(solver.execute(cycle, cycle), INSITU_OK) << solver.error;
  ASSERT_EQ(solver.messages.size(), level == MPI_THREAD_SINGLE && rank() == 0 ? 1u : 0u);
  for (const std::string& message : solver.messages)
    EXPECT_EQ(message.find("communicator: MPI is initialised for one thread (MPI_THREAD_SINGLE)"),
              0u)
        << message;
}

/// Before MPI and the library see it.
void bind_to_one_core() {
  for (int c = 0; c < CPU_SETSIZE; ++c) {
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(c, &one);
    if (sched_setaffinity(getpid(), sizeof one, &one) == 0)
      return;
  }
}

} // namespace

int main(int argc, char** argv) {
  if (is_asked("INSITU_TEST_BOUND"))
    bind_to_one_core();
  return run_on_all_processes(
      argc, argv, is_asked("INSITU_TEST_SINGLE") ? MPI_THREAD_SINGLE : MPI_THREAD_FUNNELED);
}
