#include "output/files/atomic_file.h"

#include <atomic>
#include <cerrno>
#include <fcntl.h>
#include <filesystem>
#include <mutex>
#include <set>
#include <sys/file.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

#include "core/status.h"
#include "output/files/file_system.h"

namespace insitu::output {

namespace {

constexpr std::size_t buffer_bytes = std::size_t(1) << 18;

/// Locks without waiting. Where the file system has no locks this fails, and then nothing is ever
/// removed as stale there either.
bool try_lock(int descriptor) {
  return ::flock(descriptor, LOCK_EX | LOCK_NB) == 0;
}

bool is_linked(int descriptor) {
  struct stat status {};
  return ::fstat(descriptor, &status) == 0 && status.st_nlink > 0;
}

/// Makes and locks a fresh unfinished file. Between its making and its locking another process that
/// cleans the folder may take it for a dead writer's; then the file has lost its name, and the next
/// name is tried.
int open_part(const std::string& target, std::string& part) {
  static std::atomic<unsigned> counter{0};
  for (;;) {
    part = target + "." + std::to_string(::getpid()) + "-" + std::to_string(counter++) +
           std::string(part_suffix);
    const int descriptor = ::open(part.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor < 0) {
      if (errno == EEXIST || errno == EINTR)
        continue;
      return -1;
    }
    (void)::flock(descriptor, LOCK_EX);
    if (is_linked(descriptor))
      return descriptor;
    ::close(descriptor);
  }
}

} // namespace

std::string system_reason(int error) {
  return std::system_category().message(error);
}

void throw_file_error(const char* doing, const std::string& path, int error) {
  throw core::Error(INSITU_ERROR_FILE,
                    std::string("cannot ") + doing + " '" + path + "': " + system_reason(error));
}

std::string folder_of(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  return folder.empty() ? std::string(".") : folder;
}

int write_all(int descriptor, const char* data, std::size_t bytes, std::size_t* done) {
  *done = 0;
  while (*done < bytes) {
    const ssize_t count = ::write(descriptor, data + *done, bytes - *done);
    if (count > 0)
      *done += std::size_t(count);
    else if (count == 0)
      return EIO;
    else if (errno != EINTR)
      return errno;
  }
  return 0;
}

void make_folder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    throw_file_error("make folder", folder, error.value());
  if (!std::filesystem::is_directory(folder, error))
    throw_file_error("make folder", folder, ENOTDIR);
}

std::size_t remove_stale_parts(const std::string& folder) {
  std::size_t removed = 0;
  std::error_code error;
  std::filesystem::directory_iterator entry(folder, error);
  for (; !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
    const std::string path = entry->path().string();
    if (!path.ends_with(part_suffix))
      continue;
    const int descriptor = ::open(path.c_str(), O_RDWR | O_NOFOLLOW | O_CLOEXEC);
    if (descriptor < 0)
      continue;
    if (try_lock(descriptor) && ::unlink(path.c_str()) == 0)
      ++removed;
    ::close(descriptor);
  }
  return removed;
}

void prepare_folder(const std::string& folder) {
  static std::mutex mutex;
  static std::set<std::string> prepared;
  const std::lock_guard<std::mutex> lock(mutex);
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error))
    make_folder(folder);
  if (prepared.insert(std::filesystem::absolute(folder, error).string()).second)
    remove_stale_parts(folder);
}

AtomicFile::AtomicFile(std::string target) : target_(std::move(target)) {
  prepare_folder(folder_of(target_));
  std::error_code error;
  if (std::filesystem::is_directory(target_, error))
    throw_file_error("write", target_, EISDIR);
  buffer_.reserve(buffer_bytes);
  descriptor_ = open_part(target_, part_);
  if (descriptor_ < 0)
    throw_file_error("write", target_, errno);
}

AtomicFile::~AtomicFile() {
  discard();
}

void AtomicFile::discard() noexcept {
  if (descriptor_ >= 0) {
    ::unlink(part_.c_str());
    ::close(descriptor_);
    descriptor_ = -1;
  }
}

void AtomicFile::fail(const char* doing, int error) {
  discard();
  throw core::Error(INSITU_ERROR_FILE, std::string("cannot ") + doing + " '" + target_ + "' (" +
                                           std::to_string(written_) +
                                           " bytes written): " + system_reason(error));
}

void AtomicFile::write(const void* data, std::size_t bytes) {
  if (descriptor_ < 0) {
    throw core::Error(INSITU_ERROR_INTERNAL,
                      "write to '" + target_ + "' after it was committed or had failed");
  }
  const char* from = static_cast<const char*>(data);
  if (buffer_.size() + bytes > buffer_bytes)
    flush();
  if (bytes >= buffer_bytes) {
    std::size_t done = 0;
    const int error = write_all(descriptor_, from, bytes, &done);
    written_ += done;
    if (error != 0)
      fail("write", error);
    return;
  }
  buffer_.insert(buffer_.end(), from, from + bytes);
}

void AtomicFile::write_begin(const void* data, std::size_t bytes) {
  flush();
  if (::lseek(descriptor_, 0, SEEK_SET) < 0)
    fail("write", errno);
  std::size_t done = 0;
  if (const int error = write_all(descriptor_, static_cast<const char*>(data), bytes, &done);
      error != 0)
    fail("write", error);
  if (::lseek(descriptor_, 0, SEEK_END) < 0)
    fail("write", errno);
}

void AtomicFile::flush() {
  std::size_t done = 0;
  const int error = write_all(descriptor_, buffer_.data(), buffer_.size(), &done);
  written_ += done;
  if (error != 0)
    fail("write", error);
  buffer_.clear();
}

void AtomicFile::flush_to_device() {
  if (descriptor_ < 0) {
    throw core::Error(INSITU_ERROR_INTERNAL,
                      "commit of '" + target_ + "' after it was committed or had failed");
  }
  flush();
  // Some file systems have no way to flush (EINVAL); the rename is still all or nothing for every
  // process of this machine.
  if (::fsync(descriptor_) != 0 && errno != EINVAL && errno != ENOTSUP)
    fail("flush", errno);
}

void AtomicFile::close_committed() {
  const int descriptor = descriptor_;
  descriptor_ = -1;
  // Network file systems report a lost write here at the latest.
  if (::close(descriptor) != 0 && errno != EINTR)
    throw_file_error("close", target_, errno);
}

void AtomicFile::commit() {
  flush_to_device();
  // Renamed while the lock is held, so a cleaner never sees an unlocked unfinished file.
  if (::rename(part_.c_str(), target_.c_str()) != 0)
    fail("rename to", errno);
  close_committed();
}

void AtomicFile::commit_if_absent() {
  flush_to_device();
  if (::link(part_.c_str(), target_.c_str()) == 0 || errno == EEXIST)
    ::unlink(part_.c_str());
  else if (::rename(part_.c_str(), target_.c_str()) != 0) // a file system without links
    fail("rename to", errno);
  close_committed();
}

} // namespace insitu::output
