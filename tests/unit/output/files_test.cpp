#include <cerrno>
#include <csignal>
#include <functional>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/status.h"
#include "output/files/atomic_file.h"
#include "output/files/file_system.h"
#include "unit/output/folder.h"

namespace {

using insitu::core::Error;
using insitu::output::AtomicFile;
using test::content;
using test::Folder;
using test::put;

std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), INSITU_ERROR_FILE);
    return error.what();
  }
  return "";
}

/// Runs `child` in a process of its own, which says "ready" by closing its end of a pipe; then
/// kills it, and returns once it is gone.
void kill_when_ready(const std::function<void(const std::function<void()>&)>& child) {
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const pid_t pid = ::fork();
  ASSERT_GE(pid, 0);
  if (pid == 0) {
    ::close(ends[0]);
    child([&] {
      const char ready = 'r';
      (void)!::write(ends[1], &ready, 1);
    });
    ::pause();
    ::_exit(1);
  }
  ::close(ends[1]);
  char ready = 0;
  ASSERT_EQ(::read(ends[0], &ready, 1), 1);
  ::close(ends[0]);
  ::kill(pid, SIGKILL);
  int status = 0;
  ASSERT_EQ(::waitpid(pid, &status, 0), pid);
  ASSERT_TRUE(WIFSIGNALED(status));
}

TEST(AtomicFile, AppearsAtCommitOnly) {
  const Folder folder;
  const std::string target = folder / "a/b/frame.bin"; // folders are made
  const std::string big(1 << 20, 'x');
  {
    AtomicFile file(target);
    file.write("small");
    file.write(big);
    EXPECT_FALSE(std::filesystem::exists(target));
    EXPECT_TRUE(std::filesystem::exists(file.part()));
    file.commit();
    EXPECT_FALSE(std::filesystem::exists(file.part()));
    EXPECT_THROW(file.write("late"), Error);
  }
  EXPECT_EQ(content(target), "small" + big);
}

TEST(AtomicFile, WithoutCommitTheOldFileStays) {
  const Folder folder;
  put(folder / "index.pvd", "old");
  {
    AtomicFile file(folder / "index.pvd");
    file.write("new");
  }
  EXPECT_EQ(content(folder / "index.pvd"), "old");
  EXPECT_EQ(folder.count(), 1u);
}

TEST(AtomicFile, KilledWriterLeavesNoHalfFileAndIsCleanedUp) {
  const Folder folder;
  put(folder / "frame.png", "old");
  std::string stale;
  kill_when_ready([&](const std::function<void()>& ready) {
    AtomicFile file(folder / "frame.png");
    const std::string half(1 << 20, 'h'); // past the buffer: bytes are on the way to the disk
    file.write(half);
    ready();
    ::pause();
  });
  EXPECT_EQ(content(folder / "frame.png"), "old");
  ASSERT_EQ(folder.count(), 2u);
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    if (entry.path().string().ends_with(insitu::output::part_suffix)) {
      stale = entry.path().string();
      EXPECT_EQ(entry.file_size(), std::uintmax_t(1) << 20);
    }
  }
  ASSERT_FALSE(stale.empty());

  // A living writer's unfinished file stays, the dead one's goes, with the first file of this
  // process.
  AtomicFile living(folder / "other.png");
  EXPECT_FALSE(std::filesystem::exists(stale));
  EXPECT_EQ(insitu::output::remove_stale_parts(folder.path()), 0u);
  living.write("whole");
  living.commit();
  EXPECT_EQ(content(folder / "other.png"), "whole");
  EXPECT_EQ(folder.count(), 2u);
}

TEST(AtomicFile, AnotherProcessSeesThatTheWriterLives) {
  const Folder folder;
  AtomicFile file(folder / "frame.png");
  const pid_t pid = ::fork();
  ASSERT_GE(pid, 0);
  if (pid == 0) {
    ::_exit(int(insitu::output::remove_stale_parts(folder.path())));
  }
  int status = 0;
  ASSERT_EQ(::waitpid(pid, &status, 0), pid);
  EXPECT_EQ(WEXITSTATUS(status), 0);
  file.commit();
  EXPECT_TRUE(std::filesystem::exists(folder / "frame.png"));
}

TEST(AtomicFile, FullDiskNamesFileAndReason) {
  const Folder folder;
  put(folder / "frame.png", "old");
  // A limit on file size stands for the full disk: both end a write early and fail the next.
  struct rlimit before {};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  struct rlimit small = before;
  small.rlim_cur = 300000;
  void (*const handler)(int) = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string text = error_of([&] {
    AtomicFile file(folder / "frame.png");
    file.write(std::string(1 << 20, 'x'));
    file.commit();
  });
  const std::string at_commit = error_of([&] {
    AtomicFile file(folder / "frame.png");
    file.write(std::string(200000, 'x'));
    file.write(std::string(200000, 'x'));
    file.commit();
  });
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  for (const std::string& message : {text, at_commit}) {
    EXPECT_NE(message.find("frame.png'"), std::string::npos) << message;
    EXPECT_NE(message.find(insitu::output::system_reason(EFBIG)), std::string::npos) << message;
  }
  EXPECT_NE(text.find("300000 bytes"), std::string::npos) << text;
  EXPECT_EQ(content(folder / "frame.png"), "old");
  EXPECT_EQ(folder.count(), 1u);
}

TEST(AtomicFile, DeviceWithoutSpace) {
  // /dev/full refuses every byte with the full disk's own error.
  FILE* full = std::fopen("/dev/full", "w");
  if (full == nullptr) {
    GTEST_SKIP() << "no /dev/full here";
  }
  std::size_t done = 7;
  EXPECT_EQ(insitu::output::write_all(::fileno(full), "abc", 3, &done), ENOSPC);
  EXPECT_EQ(done, 0u);
  std::fclose(full);
}

TEST(AtomicFile, FolderInTheWay) {
  const Folder folder;
  std::filesystem::create_directory(folder / "frame.png");
  put(folder / "plain", "file");
  EXPECT_NE(error_of([&] {
              AtomicFile file(folder / "frame.png");
            }).find(insitu::output::system_reason(EISDIR)),
            std::string::npos);
  const std::string text = error_of([&] { AtomicFile file(folder / "plain/frame.png"); });
  EXPECT_NE(text.find("plain'"), std::string::npos) << text;
  EXPECT_NE(text.find(insitu::output::system_reason(ENOTDIR)), std::string::npos) << text;
}

TEST(AtomicFile, UnwritableFolder) {
  const Folder folder;
  std::filesystem::permissions(folder.path(), std::filesystem::perms::owner_read |
                                                  std::filesystem::perms::owner_exec);
  if (::access(folder.path().c_str(), W_OK) == 0) {
    GTEST_SKIP() << "this user may write everywhere";
  }
  const std::string text = error_of([&] { AtomicFile file(folder / "frame.png"); });
  EXPECT_NE(text.find(folder / "frame.png"), std::string::npos) << text;
  EXPECT_NE(text.find(insitu::output::system_reason(EACCES)), std::string::npos) << text;
}

TEST(AtomicFile, FolderThatVanished) {
  const Folder folder;
  std::string text;
  {
    AtomicFile file(folder / "gone/frame.png");
    std::filesystem::remove_all(folder / "gone");
    text = error_of([&] { file.commit(); });
  }
  EXPECT_NE(text.find("gone/frame.png"), std::string::npos) << text;
  EXPECT_NE(text.find(insitu::output::system_reason(ENOENT)), std::string::npos) << text;
}

} // namespace
