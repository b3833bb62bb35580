#include "output/files/append_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>
#include <vector>

#include "output/files/atomic_file.h"
#include "output/files/file_system.h"

namespace insitu::output {

namespace {

std::size_t read_at(int descriptor, const std::string& path, char* data, std::size_t bytes,
                    off_t offset) {
  std::size_t done = 0;
  while (done < bytes) {
    const ssize_t count = ::pread(descriptor, data + done, bytes - done, offset + off_t(done));
    if (count == 0)
      break;
    if (count < 0 && errno != EINTR)
      throw_file_error("read", path, errno);
    done += count > 0 ? std::size_t(count) : 0;
  }
  return done;
}

} // namespace

LockedFile::LockedFile(std::string path) : path_(std::move(path)), lock_(path_) {
  prepare_folder(folder_of(path_));
  open();
}

void LockedFile::open() {
  const int descriptor = ::open(path_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (descriptor < 0)
    throw_file_error("write", path_, errno);
  descriptor_ = descriptor;
}

LockedFile::~LockedFile() {
  if (descriptor_ >= 0)
    ::close(descriptor_);
}

std::int64_t LockedFile::size() const {
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0)
    throw_file_error("read", path_, errno);
  return status.st_size;
}

std::size_t LockedFile::read(std::int64_t at, char* data, std::size_t bytes) const {
  return read_at(descriptor_, path_, data, bytes, off_t(at));
}

void LockedFile::cut(std::int64_t size, const char* doing) {
  if (::ftruncate(descriptor_, off_t(size)) != 0)
    throw_file_error(doing, path_, errno);
}

void LockedFile::renew(std::string_view head, std::optional<std::int64_t> copy_from) {
  AtomicFile out(path_);
  out.write(head);
  std::vector<char> block(copy_from ? std::size_t(1) << 20 : 0);
  for (std::int64_t at = copy_from.value_or(0); copy_from;) {
    const std::size_t count = read(at, block.data(), block.size());
    if (count == 0)
      break;
    out.write(block.data(), count);
    at += std::int64_t(count);
  }
  out.commit();
  const int before = descriptor_;
  open();
  ::close(before);
}

AppendFile::AppendFile(std::string path) : LockedFile(std::move(path)) {
  // It holds whole lines only.
  const std::int64_t all = size();
  std::int64_t end = all;
  char block[4096];
  while (end > 0) {
    const std::int64_t begin = std::max<std::int64_t>(0, end - std::int64_t(sizeof block));
    const std::size_t count = read(begin, block, std::size_t(end - begin));
    const void* last = ::memrchr(block, '\n', count);
    if (last != nullptr) {
      end = begin + (static_cast<const char*>(last) - block) + 1;
      break;
    }
    end = begin;
  }
  if (end < all)
    cut(end, "cut the partial last line of");
}

std::string AppendFile::first_line() const {
  std::string line;
  char block[4096];
  for (;;) {
    const std::size_t count = read(std::int64_t(line.size()), block, sizeof block);
    const void* end = std::memchr(block, '\n', count);
    if (end != nullptr)
      return line.append(block, static_cast<const char*>(end) - block + 1);
    if (count == 0)
      return line;
    line.append(block, count);
  }
}

bool AppendFile::cut_from(
    std::int64_t from,
    const std::function<std::optional<std::int64_t>(std::string_view)>& number_of) {
  const auto header = std::int64_t(first_line().size());
  const std::int64_t end_of_file = size();
  std::string carry; // the part of a line at the end of a block
  std::int64_t line = header;
  // Where to cut if numbers go up, and down.
  std::optional<std::int64_t> up, down, first;
  bool descends = false, known = false;
  char block[1 << 16];
  for (std::int64_t at = header; at < end_of_file;) {
    const std::size_t count = read(at, block, sizeof block);
    if (count == 0)
      break;
    at += std::int64_t(count);
    carry.append(block, count);
    std::size_t begin = 0;
    for (std::size_t end; (end = carry.find('\n', begin)) != std::string::npos; begin = end + 1) {
      const auto number = number_of(std::string_view(carry).substr(begin, end - begin));
      if (number) {
        first = first ? first : number;
        descends = !known && *number != *first ? *number < *first : descends;
        known = known || *number != *first;
        up = !up && *number >= from ? line : up;
        down = !down && *number <= from ? line : down;
      }
      line += std::int64_t(end + 1 - begin);
    }
    if (known && (descends ? down : up))
      break;
    carry.erase(0, begin);
  }
  if (const auto where = descends ? down : up) {
    cut(*where, "cut the rows of an earlier run from");
    return *where > header;
  }
  return line > header;
}

void LockedFile::append(std::string_view text) {
  std::size_t done = 0;
  const int error = write_all(descriptor_, text.data(), text.size(), &done);
  if (error != 0) {
    // Back to where the file ended before: rows that are still held must not appear twice.
    if (::ftruncate(descriptor_, off_t(size()) - off_t(done)) != 0)
      throw_file_error("take back a partial append to", path_, errno);
    throw_file_error("append to", path_, error);
  }
}

void LockedFile::replace(std::int64_t at, std::string_view text) {
  // Linux appends by pwrite too where a file was opened to append.
  const int flags = ::fcntl(descriptor_, F_GETFL);
  if (flags < 0 || ::fcntl(descriptor_, F_SETFL, flags & ~O_APPEND) != 0)
    throw_file_error("write", path_, errno);
  const ssize_t written = ::pwrite(descriptor_, text.data(), text.size(), off_t(at));
  const int error = written < 0 ? errno : 0;
  if (::fcntl(descriptor_, F_SETFL, flags) != 0)
    throw_file_error("write", path_, errno);
  if (written != ssize_t(text.size()))
    throw_file_error("write", path_, error != 0 ? error : EIO);
}

} // namespace insitu::output
