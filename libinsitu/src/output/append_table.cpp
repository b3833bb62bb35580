#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/status.h"
#include "output/csv.h"
#include "output/file_system.h"

namespace insitu::output {

namespace {

off_t size_of(int descriptor, const std::string& path) {
  struct stat status {};
  if (::fstat(descriptor, &status) != 0) {
    throw_file_error("read", path, errno);
  }
  return status.st_size;
}

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
void cut_partial_line(int descriptor, const std::string& path) {
  off_t end = size_of(descriptor, path);
  const off_t size = end;
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

std::string first_line(int descriptor, const std::string& path) {
  std::string line;
  char block[4096];
  for (;;) {
    const std::size_t count = read_at(descriptor, path, block, sizeof block, off_t(line.size()));
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

/// Cuts the file before its first row, after the header, whose first cell is a number of at least
/// `from`. Returns whether any row is left.
bool cut_rows_from(int descriptor, const std::string& path, std::int64_t from) {
  const auto header = off_t(first_line(descriptor, path).size());
  const off_t size = size_of(descriptor, path);
  std::string carry; // the part of a row at the end of a block
  off_t row = header;
  char block[1 << 16];
  for (off_t at = header; at < size;) {
    const std::size_t count = read_at(descriptor, path, block, sizeof block, at);
    if (count == 0) {
      break;
    }
    at += off_t(count);
    carry.append(block, count);
    std::size_t begin = 0;
    for (std::size_t end; (end = carry.find('\n', begin)) != std::string::npos; begin = end + 1) {
      std::int64_t first = 0;
      const auto parsed = std::from_chars(carry.data() + begin, carry.data() + end, first);
      if (parsed.ec == std::errc() && first >= from) {
        if (::ftruncate(descriptor, row) != 0) {
          throw_file_error("cut the rows of an earlier run from", path, errno);
        }
        return row > header;
      }
      row += off_t(end + 1 - begin);
    }
    carry.erase(0, begin);
  }
  return row > header;
}

} // namespace

AppendTable::AppendTable(std::string path, std::vector<std::string> columns,
                         std::optional<std::int64_t> from)
    : path_(std::move(path)), rows_(columns.size()) {
  prepare_folder(folder_of(path_));
  descriptor_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (descriptor_ < 0) {
    throw_file_error("write", path_, errno);
  }
  try {
    if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      throw core::Error(INSITU_ERROR_FILE,
                        "cannot write '" + path_ + "': another table or another run is writing it");
    }
    cut_partial_line(descriptor_, path_);
    const std::string header = csv_header(columns);
    // A run that starts anew, with other columns perhaps, owes nothing to a table without rows.
    if (from && !cut_rows_from(descriptor_, path_, *from) && ::ftruncate(descriptor_, 0) != 0) {
      throw_file_error("start anew", path_, errno);
    }
    std::string found = first_line(descriptor_, path_);
    if (found.empty()) {
      append(header);
    } else if (found != header) {
      found.pop_back();
      throw core::Error(INSITU_ERROR_FILE,
                        "cannot append to '" + path_ + "': its columns are '" + found + "', not '" +
                            header.substr(0, header.size() - 1) + "'; move the old file away");
    }
  } catch (...) {
    ::close(descriptor_);
    throw;
  }
}

AppendTable::~AppendTable() {
  try {
    flush();
  } catch (const core::Error&) {
    // A destructor has nobody to tell; whoever needs to know calls flush first.
  }
  ::close(descriptor_);
}

void AppendTable::append(std::string_view text) {
  std::size_t done = 0;
  const int error = write_all(descriptor_, text.data(), text.size(), &done);
  if (error != 0) {
    // Back to where the file ended before: rows that are still held must not appear twice.
    const off_t before = size_of(descriptor_, path_) - off_t(done);
    if (::ftruncate(descriptor_, before) != 0) {
      throw_file_error("take back a partial append to", path_, errno);
    }
    throw_file_error("append to", path_, error);
  }
}

void AppendTable::flush() {
  if (!rows_.text().empty()) {
    append(rows_.text());
    rows_.clear();
  }
}

} // namespace insitu::output
