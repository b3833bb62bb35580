#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "output/files/file_lock.h"

namespace insitu::output {

/// A file that grows, with one writer at a time: a second one is refused (BeingWritten, see
/// FileLock). All failures are core::Error (INSITU_ERROR_FILE) that name the file and the reason.
class LockedFile {
public:
  /// Makes the folder and the file if absent.
  explicit LockedFile(std::string path);
  ~LockedFile();
  LockedFile(const LockedFile&) = delete;
  LockedFile& operator=(const LockedFile&) = delete;

  const std::string& path() const { return path_; }
  std::int64_t size() const;
  /// Reads at most `bytes` from there; returns how many there were.
  std::size_t read(std::int64_t at, char* data, std::size_t bytes) const;

  /// In one call of the system. What got through of an append that failed is taken back.
  void append(std::string_view text);
  /// Writes over bytes that are there.
  void replace(std::int64_t at, std::string_view text);
  /// Shortens it; doing: for the message, such as "cut the partial last line of".
  void cut(std::int64_t size, const char* doing);
  /// Puts a whole new file in its place, at once, and goes on with that: see AtomicFile. copy_from:
  /// what follows `head` is copied from this file, from there to its end; nothing: no more.
  void renew(std::string_view head, std::optional<std::int64_t> copy_from = std::nullopt);

private:
  void open();

  std::string path_;
  FileLock lock_;
  int descriptor_ = -1;
};

/// A text file that grows by whole lines, over a run and over restarts of it. Opening cuts a
/// partial last line, which a killed run may have left.
class AppendFile : public LockedFile {
public:
  explicit AppendFile(std::string path);

  /// With its line end; without one where the file has no whole line.
  std::string first_line() const;

  /// Cuts the file before its first line, after the header, whose number is at least `from`, or at
  /// most, where the lines' numbers go down: which is known once two of them differ. number_of: of
  /// a line without its end; nothing: a line that has none. Returns whether any line is left after
  /// the header.
  bool cut_from(std::int64_t from,
                const std::function<std::optional<std::int64_t>(std::string_view)>& number_of);
  void clear() { cut(0, "start anew"); }
};

} // namespace insitu::output
