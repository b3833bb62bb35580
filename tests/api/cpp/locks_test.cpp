/// Two sessions that would write the same files: in one process, in two, and after a kill.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <insitu/insitu.hpp>
#include <spawn.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include "two.h"
#include "unit/output/folder.h"

extern char** environ;

namespace {

/// Every kind of file.
const std::string everything = R"(
insitu: 1
checkpoint: {every: 1}
probes:
  - {name: gauges, points: [[0.5, 0.5, 0.5]], fields: [p], output: [csv, vtp, json, netcdf]}
tracers:
  - {name: paths, velocity: u, seeds: [[0.2, 0.5, 0.5]], output: [csv, vtp, netcdf]}
  - {name: lines, kind: streamline, velocity: u, seeds: [[0.2, 0.5, 0.5]], output: [csv, vtp]}
frames:
  - {name: front, size: [16, 16], volume: {field: p}, format: [png, exr]}
)";

std::string with_probe(const std::string& name) {
  return "insitu: 1\nprobes: [{name: " + name +
         ", points: [[0.5, 0.5, 0.5]], fields: [p], output: [json]}]\n";
}

insitu::Options options(const std::string& scene, const std::string& output) {
  insitu::Options o;
  o.scene_text = scene;
  o.output = output;
  o.threads = 1;
  o.log = [](insitu::LogLevel, const char*) {};
  return o;
}

struct Solver : Two {
  std::vector<double> u = std::vector<double>(36, 0.01);
  void give(insitu::Session& session) {
    insitu::Mesh mesh = session.mesh("m");
    mesh.points(xyz);
    mesh.hexahedra(ids);
    mesh.vertex_field("p", pressure);
    mesh.vertex_field("u", insitu::Array(u).components(3));
  }
};

/// Why a session of this scene cannot be opened; "opened".
std::string refusal(const std::string& scene, const std::string& output) {
  try {
    insitu::Session session(options(scene, output));
    return "opened";
  } catch (const insitu::Error& e) {
    EXPECT_EQ(e.status(), INSITU_ERROR_FILE);
    return e.what();
  }
}

std::vector<std::string> locks_in(const std::string& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().extension() == ".insitu-lock")
      names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(SessionLocks, EachActionIsLockedWhileItsSessionIsOpen) {
  const test::Folder folder;
  const std::string out = folder / "out";
  Solver solver;
  insitu::Session first(options(everything, out));
  solver.give(first);
  EXPECT_EQ(locks_in(out),
            (std::vector<std::string>{"checkpoint.action.insitu-lock", "front.action.insitu-lock",
                                      "gauges.action.insitu-lock", "lines.action.insitu-lock",
                                      "paths.action.insitu-lock"}));
  EXPECT_TRUE(first.execute(0, 0.0)) << insitu_last_message();
  for (const std::string name : {"gauges", "paths", "lines", "front"}) {
    const std::string why = refusal(with_probe(name), out);
    EXPECT_TRUE(holds(why, "out/" + name + "*'") && holds(why, "this process") &&
                holds(why, "output folder of its own"))
        << why;
  }
  // Nothing of a failed opening stays, what the first one holds is its own, and other names are
  // free.
  const std::vector<std::string> before = locks_in(out);
  EXPECT_TRUE(holds(refusal("insitu: 1\nprobes:\n  - {name: a, points: [[0, 0, 0]]}\n"
                            "  - {name: gauges, points: [[0, 0, 0]]}\n",
                            out),
                    "gauges"));
  EXPECT_TRUE(holds(refusal("insitu: 1\ncheckpoint: {every: 5}\n", out), "checkpoint"));
  EXPECT_EQ(locks_in(out), before);
  EXPECT_EQ(refusal(with_probe("other"), out), "opened");
  EXPECT_EQ(refusal(everything, folder / "elsewhere"), "opened");
  EXPECT_EQ(locks_in(out), before);
  EXPECT_TRUE(first.execute(1, 0.1)) << insitu_last_message();
  first.close();
  EXPECT_TRUE(locks_in(out).empty());
  // What is left behind is as it ever was: the next run goes on there.
  insitu::Session next(options(everything, out));
  solver.give(next);
  EXPECT_TRUE(next.execute(2, 0.2)) << insitu_last_message();
}

TEST(SessionLocks, ARestartInTheSameFolderAfterTheClose) {
  const test::Folder folder;
  Solver solver;
  {
    insitu::Session first(options(everything, folder.path()));
    solver.give(first);
    EXPECT_TRUE(first.execute(0, 0.0)) << insitu_last_message();
    first.checkpoint(folder / "mine.insitu");
    EXPECT_EQ(locks_in(folder.path()).size(), 5u + 1 + /* tables, page, frames' table */ 6);
  }
  EXPECT_TRUE(locks_in(folder.path()).empty());
  insitu::Session second(options(everything, folder.path()));
  solver.give(second);
  second.restart(folder / "mine.insitu");
  EXPECT_TRUE(second.execute(1, 0.1)) << insitu_last_message();
  EXPECT_EQ(second.report().failures, 0);
}

TEST(SessionLocks, FilesThatTheCallerNames) {
  const test::Folder folder;
  Solver solver;
  insitu::Session first(options(with_probe("a"), folder.path())),
      second(options(with_probe("b"), folder.path()));
  for (insitu::Session* s : {&first, &second}) {
    solver.give(*s);
    EXPECT_TRUE(s->execute(0, 0.0)) << insitu_last_message();
  }
  for (int again = 0; again < 2; ++again) {
    first.write_summary(folder / "summary.json");
    first.checkpoint(folder / "state.insitu");
  }
  const auto refused = [&](auto&& write, const std::string& name) {
    try {
      write();
      ADD_FAILURE() << name;
    } catch (const insitu::Error& e) {
      EXPECT_EQ(e.status(), INSITU_ERROR_FILE);
      EXPECT_TRUE(holds(e.what(), name) && holds(e.what(), "this process")) << e.what();
    }
  };
  refused([&] { second.write_summary(folder / "summary.json"); }, "summary.json");
  refused([&] { second.checkpoint(folder / "state.insitu"); }, "state.insitu");
  EXPECT_TRUE(second.execute(1, 0.1)) << "a refused file is no action's: " << insitu_last_message();
  first.close();
  second.write_summary(folder / "summary.json");
  second.checkpoint(folder / "state.insitu");
}

TEST(SessionLocks, TheDefaultSceneIsLockedWithItsFirstFrame) {
  const test::Folder folder;
  Solver solver;
  insitu::Options o = options("", folder.path());
  o.default_scene = true;
  insitu::Session first(o), second(o);
  solver.give(first);
  solver.give(second);
  EXPECT_TRUE(first.execute(0, 0.0)) << insitu_last_message();
  EXPECT_FALSE(second.execute(0, 0.0));
  EXPECT_TRUE(holds(insitu_last_message(), "holds it")) << insitu_last_message();
  first.close();
  EXPECT_TRUE(second.execute(10, 0.1)) << insitu_last_message();
  EXPECT_EQ(second.report().frames, 1);
}

/// Not a test: what the process does that TwoProcesses starts. It opens a session, says so by a
/// file, and waits to be killed.
TEST(SessionLocks, DISABLED_Holder) {
  const char* const folder = std::getenv("INSITU_LOCKS_TEST_FOLDER");
  ASSERT_TRUE(folder);
  ::alarm(30); // should the other one fail
  insitu::Session session(options(everything, folder));
  std::ofstream(std::string(folder) + "/ready");
  for (;;)
    ::pause();
}

pid_t start_holder(const std::string& folder) {
  const std::string variable = "INSITU_LOCKS_TEST_FOLDER=" + folder;
  std::vector<std::string> words{"locks_test", "--gtest_also_run_disabled_tests",
                                 "--gtest_filter=SessionLocks.DISABLED_Holder"};
  std::vector<char*> arguments, environment{const_cast<char*>(variable.c_str())};
  for (std::string& w : words)
    arguments.push_back(w.data());
  for (char** e = environ; *e; ++e)
    environment.push_back(*e);
  arguments.push_back(nullptr);
  environment.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  pid_t child = -1;
  const int error = ::posix_spawn(&child, "/proc/self/exe", &actions, nullptr, arguments.data(),
                                  environment.data());
  posix_spawn_file_actions_destroy(&actions);
  return error == 0 ? child : -1;
}

TEST(SessionLocks, TwoProcessesAndOneThatIsKilled) {
  const test::Folder folder;
  const pid_t child = start_holder(folder.path());
  ASSERT_GT(child, 0);
  int status = 0;
  while (!std::filesystem::exists(folder / "ready")) {
    ASSERT_EQ(::waitpid(child, &status, WNOHANG), 0) << "it ended";
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  const std::string why = refusal(with_probe("gauges"), folder.path());
  EXPECT_TRUE(holds(why, "process " + std::to_string(child)) && holds(why, "gauges*'")) << why;
  ASSERT_EQ(::kill(child, SIGKILL), 0);
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(locks_in(folder.path()).size(), 5u);
  {
    Solver solver;
    insitu::Session next(options(everything, folder.path()));
    solver.give(next);
    EXPECT_TRUE(next.execute(0, 0.0)) << insitu_last_message();
  }
  EXPECT_TRUE(locks_in(folder.path()).empty());
}

TEST(SessionLocks, WhereNothingCanBeWrittenActionsFailAsEver) {
  const test::Folder folder;
  test::put(folder / "file", "");
  Solver solver;
  insitu::Session session(options(with_probe("a"), folder / "file/out"));
  solver.give(session);
  EXPECT_FALSE(session.execute(0, 0.0));
  EXPECT_TRUE(holds(insitu_last_message(), "probe 'a'")) << insitu_last_message();
  // Once there is room the lock is taken too.
  std::filesystem::remove(folder / "file");
  EXPECT_TRUE(session.execute(1, 0.1)) << insitu_last_message();
  EXPECT_NE(refusal(with_probe("a"), folder / "file/out"), "opened");
}

/// Without MPI it is said to be unused; with it MPI has to be initialised.
TEST(SessionLocks, ACommunicatorOfAProgramWithoutMpi) {
  std::vector<std::string> messages;
  insitu::Options o;
  o.log = [&](insitu::LogLevel, const char* m) { messages.emplace_back(m); };
  { insitu::Session none(o); }
  EXPECT_TRUE(messages.empty());
  const int something = 0;
  const auto open = [&](const void* communicator, int fortran_communicator) {
    o.communicator = communicator;
    o.fortran_communicator = fortran_communicator;
    messages.clear();
#ifdef INSITU_TEST_MPI
    EXPECT_THROW(insitu::Session one(o), insitu::Error);
    const char* const expected = "is not initialised";
#else
    { insitu::Session one(o); }
    const char* const expected = "this build has no MPI";
#endif
    ASSERT_EQ(messages.size(), 1u);
    EXPECT_TRUE(holds(messages[0], expected)) << messages[0];
  };
  open(&something, INSITU_NO_COMMUNICATOR);
  open(nullptr, 1140850688);
  open(nullptr, 0); // Open MPI's MPI_COMM_WORLD
}

} // namespace
