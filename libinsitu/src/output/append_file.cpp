#include "output/append_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "output/file_system.h"

namespace insitu::output {

namespace {

std::size_t read_at(int descriptor, const std::string& path, char* data, std::size_t bytes,
                    off_t offset) {
  std::size_t done = 0;
  while (done < bytes) {
    const ssize_t count = ::pread(descriptor, data + done, bytes - done, offset + off_t(done));
    if (count == 0) {
      break;
    }
    if (count < 0 && errno != EINTR) {
      throw_file_error("read", path, errno);
    }
    done += count > 0 ? std::size_t(count) : 0;
  }
  return done;
}

/// Cuts the file after its last line end, so that it holds whole lines only.
void cut_partial_line(int descriptor, const std::string& path, const off_t size) {
  off_t end = size;
  char block[4096];
  while (end > 0) {
    const off_t begin = std::max<off_t>(0, end - off_t(sizeof block));
    const std::size_t count = read_at(descriptor, path, block, std::size_t(end - begin), begin);
    const void* last = ::memrchr(block, '\n', count);
    if (last != nullptr) {
      end = begin + (static_cast<const char*>(last) - block) + 1;
      break;
    }
    end = begin;
  }
  if (end < size && ::ftruncate(descriptor, end) != 0) {
    throw_file_error("cut the partial last line of", path, errno);
  }
}

} // namespace

AppendFile::AppendFile(std::string path) : path_(std::move(path)) {
  prepare_folder(folder_of(path_));
  descriptor_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (descriptor_ < 0) {
    throw_file_error("write", path_, errno);
  }
  try {
    if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      throw BeingWritten(path_);
    }
    cut_partial_line(descriptor_, path_, off_t(size()));
  } catch (...) {
    ::close(descriptor_);
    throw;
  }
}

AppendFile::~AppendFile() {
  ::close(descriptor_);
}

std::int64_t AppendFile::size() const {
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0) {
    throw_file_error("read", path_, errno);
  }
  return status.st_size;
}

std::string AppendFile::first_line() const {
  std::string line;
  char block[4096];
  for (;;) {
    const std::size_t count = read_at(descriptor_, path_, block, sizeof block, off_t(line.size()));
    const void* end = std::memchr(block, '\n', count);
    if (end != nullptr) {
      return line.append(block, static_cast<const char*>(end) - block + 1);
    }
    if (count == 0) {
      return line;
    }
    line.append(block, count);
  }
}

bool AppendFile::cut_from(
    std::int64_t from,
    const std::function<std::optional<std::int64_t>(std::string_view)>& number_of) {
  const auto header = off_t(first_line().size());
  const auto end_of_file = off_t(size());
  std::string carry; // the part of a line at the end of a block
  off_t line = header;
  char block[1 << 16];
  for (off_t at = header; at < end_of_file;) {
    const std::size_t count = read_at(descriptor_, path_, block, sizeof block, at);
    if (count == 0) {
      break;
    }
    at += off_t(count);
    carry.append(block, count);
    std::size_t begin = 0;
    for (std::size_t end; (end = carry.find('\n', begin)) != std::string::npos; begin = end + 1) {
      const auto number = number_of(std::string_view(carry).substr(begin, end - begin));
      if (number && *number >= from) {
        if (::ftruncate(descriptor_, line) != 0) {
          throw_file_error("cut the rows of an earlier run from", path_, errno);
        }
        return line > header;
      }
      line += off_t(end + 1 - begin);
    }
    carry.erase(0, begin);
  }
  return line > header;
}

void AppendFile::clear() {
  if (::ftruncate(descriptor_, 0) != 0) {
    throw_file_error("start anew", path_, errno);
  }
}

void AppendFile::append(std::string_view text) {
  std::size_t done = 0;
  const int error = write_all(descriptor_, text.data(), text.size(), &done);
  if (error != 0) {
    // Back to where the file ended before: rows that are still held must not appear twice.
    if (::ftruncate(descriptor_, off_t(size()) - off_t(done)) != 0) {
      throw_file_error("take back a partial append to", path_, errno);
    }
    throw_file_error("append to", path_, error);
  }
}

void AppendFile::replace(std::int64_t at, std::string_view text) {
  // Linux appends by pwrite too where a file was opened to append.
  const int flags = ::fcntl(descriptor_, F_GETFL);
  if (flags < 0 || ::fcntl(descriptor_, F_SETFL, flags & ~O_APPEND) != 0) {
    throw_file_error("write", path_, errno);
  }
  const ssize_t written = ::pwrite(descriptor_, text.data(), text.size(), off_t(at));
  const int error = written < 0 ? errno : 0;
  if (::fcntl(descriptor_, F_SETFL, flags) != 0) {
    throw_file_error("write", path_, errno);
  }
  if (written != ssize_t(text.size())) {
    throw_file_error("write", path_, error != 0 ? error : EIO);
  }
}

} // namespace insitu::output
