// Lock files: one writer at a time, of this process and others, and what dead ones leave.
#include <atomic>
#include <csignal>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include "folder.h"
#include "output/files/file_lock.h"

using insitu::output::BeingWritten;
using insitu::output::FileLock;
using test::Folder;

namespace {

std::string refusal(const std::string& target) {
  try {
    const FileLock lock(target);
    return lock.held() ? "taken" : "not held";
  } catch (const BeingWritten& e) {
    return e.what();
  }
}

std::string lock_file(const std::string& target) {
  return target + ".insitu-lock";
}

/// Runs in a child process; returns what it exits with.
template <class Body>
pid_t child_of(Body&& body) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::alarm(60); // should the parent fail
    ::_exit(body());
  }
  return child;
}
int status_of(pid_t child) {
  int status = 0;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

/// A lock file as a process of this host writes it, with one line changed.
std::string lock_text(const Folder& folder, const std::string& key, const std::string& value) {
  const FileLock own(folder / "sample");
  std::istringstream lines(test::content(lock_file(folder / "sample")));
  std::string line, text;
  while (std::getline(lines, line))
    text += (line.starts_with(key + " ") ? key + " " + value : line) + "\n";
  return text;
}

TEST(FileLocks, ASecondOneInTheProcessIsRefusedUntilTheFirstEnds) {
  const Folder folder;
  const std::string target = folder / "sub/table.csv";
  {
    const FileLock lock(target);
    EXPECT_TRUE(lock.held());
    const std::string why = refusal(target);
    EXPECT_NE(why.find("'" + target + "'"), std::string::npos) << why;
    EXPECT_NE(why.find("this process (" + std::to_string(::getpid())), std::string::npos) << why;
    EXPECT_NE(why.find(lock_file(target)), std::string::npos) << why;
    EXPECT_EQ(refusal(folder / "sub/other.csv"), "taken");
    EXPECT_NE(refusal(folder / "sub/../sub/table.csv"), "taken");
  }
  EXPECT_EQ(refusal(target), "taken");
  EXPECT_FALSE(std::filesystem::exists(lock_file(target)));
  EXPECT_FALSE(std::filesystem::exists(folder / "sub")) << "made for the locks alone";
  std::filesystem::create_directory(folder / "theirs");
  EXPECT_EQ(refusal(folder / "theirs/a"), "taken");
  EXPECT_TRUE(std::filesystem::is_empty(folder / "theirs")) << "unfinished lock files";
}

TEST(FileLocks, AnotherProcessIsRefusedAndToldWhoHoldsIt) {
  const Folder folder;
  const std::string target = folder / "a";
  const pid_t parent = ::getpid();
  const FileLock lock(target);
  EXPECT_EQ(status_of(child_of([&] {
              const std::string why = refusal(target);
              return why.find("process " + std::to_string(parent) + " on this host") !=
                                 std::string::npos &&
                             why.find(lock_file(target)) != std::string::npos
                         ? 0
                         : 1;
            })),
            0);
  // A child that inherits it and exits, by exit() or by a destructor, leaves it alone.
  EXPECT_EQ(status_of(child_of([&] {
              lock.~FileLock();
              std::exit(3);
              return 4;
            })),
            3);
  EXPECT_TRUE(std::filesystem::exists(lock_file(target)));
}

TEST(FileLocks, WhatAProcessLeavesThatExitsOrIsKilled) {
  const Folder folder;
  const std::string target = folder / "a";
  // At exit() they are removed, though nobody closed them.
  EXPECT_EQ(status_of(child_of([&] {
              static FileLock* volatile kept = new FileLock(target); // and never given back
              (void)kept;
              std::exit(std::filesystem::exists(lock_file(target)) ? 0 : 1);
              return 2;
            })),
            0);
  EXPECT_FALSE(std::filesystem::exists(lock_file(target)));
  // After a kill the lock is stale: already while the dead process waits for its parent.
  int ready[2];
  ASSERT_EQ(::pipe(ready), 0);
  const pid_t child = child_of([&] {
    const FileLock lock(target);
    (void)!::write(ready[1], "x", 1);
    ::pause();
    return 0;
  });
  char byte = 0;
  ASSERT_EQ(::read(ready[0], &byte, 1), 1);
  const std::string why = refusal(target);
  EXPECT_NE(why.find("process " + std::to_string(child)), std::string::npos) << why;
  ASSERT_EQ(::kill(child, SIGKILL), 0);
  siginfo_t info;
  ASSERT_EQ(::waitid(P_PID, id_t(child), &info, WEXITED | WNOWAIT), 0);
  EXPECT_TRUE(std::filesystem::exists(lock_file(target)));
  EXPECT_EQ(refusal(target), "taken");
  EXPECT_EQ(status_of(child), -SIGKILL);
  EXPECT_FALSE(std::filesystem::exists(lock_file(target)));
  ::close(ready[0]);
  ::close(ready[1]);
}

TEST(FileLocks, StaleOnesAreToldFromOthers) {
  const Folder folder;
  const std::string target = folder / "a";
  const pid_t gone = child_of([] { return 0; });
  EXPECT_EQ(status_of(gone), 0);
  test::put(lock_file(target), lock_text(folder, "process", std::to_string(gone)));
  EXPECT_EQ(refusal(target), "taken");
  // The number is another process's by now.
  test::put(lock_file(target), lock_text(folder, "started", "1"));
  EXPECT_EQ(refusal(target), "taken");
  // Who is on another host, or in another container, cannot be judged.
  for (const std::string key : {"host", "namespace"}) {
    test::put(lock_file(target), lock_text(folder, key, "elsewhere"));
    const std::string why = refusal(target);
    EXPECT_NE(why.find(key == "host" ? "on host 'elsewhere'" : "in another container"),
              std::string::npos)
        << why;
    EXPECT_NE(why.find("remove '" + folder.path() + "/*.insitu-lock'"), std::string::npos) << why;
    EXPECT_TRUE(std::filesystem::exists(lock_file(target)));
  }
  for (const std::string text : {"", "something else\n", "libinsitu writes here\nprocess 12\n"}) {
    test::put(lock_file(target), text);
    const std::string why = refusal(target);
    EXPECT_NE(why.find("does not say who holds it"), std::string::npos) << why;
    EXPECT_NE(why.find("remove"), std::string::npos) << why;
  }
}

TEST(FileLocks, OfManyThatFindAStaleOneOneTakesIt) {
  const Folder folder;
  for (int round = 0; round < 20; ++round) {
    const std::string target = folder / ("a" + std::to_string(round));
    test::put(lock_file(target), lock_text(folder, "started", "1"));
    int start[2], end[2];
    ASSERT_EQ(::pipe(start), 0);
    ASSERT_EQ(::pipe(end), 0);
    std::vector<pid_t> children;
    for (int i = 0; i < 8; ++i)
      children.push_back(child_of([&] {
        char byte;
        ::close(start[1]);
        ::close(end[1]);
        (void)!::read(start[0], &byte, 1); // all at once, when the parent closes it
        try {
          const FileLock lock(target);
          (void)!::read(end[0], &byte, 1); // held until all have tried
          return lock.held() ? 1 : 2;
        } catch (const BeingWritten&) {
          return 0;
        }
      }));
    ::close(start[1]);
    int taken = 0;
    // Seven end at once; the one that holds it waits.
    for (int left = 8; left > 1; --left) {
      int status = 0;
      ASSERT_GT(::wait(&status), 0);
      ASSERT_TRUE(WIFEXITED(status));
      EXPECT_EQ(WEXITSTATUS(status), 0) << round;
    }
    ::close(end[1]);
    int status = 0;
    ASSERT_GT(::wait(&status), 0);
    taken += WIFEXITED(status) && WEXITSTATUS(status) == 1;
    EXPECT_EQ(taken, 1);
    EXPECT_FALSE(std::filesystem::exists(lock_file(target)));
    ::close(start[0]);
    ::close(end[0]);
  }
}

TEST(FileLocks, OfManyThreadsOneTakesIt) {
  const Folder folder;
  const std::string target = folder / "a";
  for (int round = 0; round < 20; ++round) {
    std::atomic<int> taken{0}, tried{0};
    std::vector<std::thread> threads;
    for (int i = 0; i < 8; ++i)
      threads.emplace_back([&] {
        try {
          const FileLock lock(target);
          taken += lock.held();
          ++tried;
          while (tried < 8)
            std::this_thread::yield();
        } catch (const BeingWritten&) {
          ++tried;
        }
      });
    for (std::thread& t : threads)
      t.join();
    EXPECT_EQ(taken, 1);
  }
}

TEST(FileLocks, AFoldersOtherNameAndItsCopy) {
  const Folder folder;
  std::filesystem::create_directory(folder / "out");
  std::filesystem::create_directory_symlink(folder / "out", folder / "link");
  const FileLock lock(folder / "out/a");
  EXPECT_NE(refusal(folder / "link/a").find("this process"), std::string::npos);
  std::filesystem::copy(folder / "out", folder / "copy");
  EXPECT_EQ(refusal(folder / "copy/a"), "taken") << "what is in a copy locks nothing";
  EXPECT_TRUE(std::filesystem::exists(lock_file(folder / "out/a")));
}

TEST(FileLocks, WhereNoFileCanBeMadeNoneIsHeld) {
  const Folder folder;
  test::put(folder / "file", "");
  EXPECT_EQ(refusal(folder / "file/a"), "not held"); // no folder can be made there
  if (::geteuid() == 0)
    GTEST_SKIP() << "root may write everywhere";
  std::filesystem::permissions(folder.path(), std::filesystem::perms::owner_read |
                                                  std::filesystem::perms::owner_exec);
  EXPECT_EQ(refusal(folder / "a"), "not held");
}

} // namespace
