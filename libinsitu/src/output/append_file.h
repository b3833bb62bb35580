#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "core/status.h"

namespace insitu::output {

/// Thrown where another session, of this process or another, holds the file.
class BeingWritten : public core::Error {
public:
  explicit BeingWritten(const std::string& path)
      : core::Error(INSITU_ERROR_FILE,
                    "cannot write '" + path + "': another table or another run is writing it") {}
};

/// A text file that grows by whole lines, over a run and over restarts of it.
///
/// Opening makes the folder and the file if absent and cuts a partial last line, which a killed run
/// may have left. One writer at a time: a second one is refused (BeingWritten) where the file
/// system has locks. All failures are core::Error (INSITU_ERROR_FILE) that name the file and the
/// reason.
class AppendFile {
public:
  explicit AppendFile(std::string path);
  ~AppendFile();
  AppendFile(const AppendFile&) = delete;
  AppendFile& operator=(const AppendFile&) = delete;

  const std::string& path() const { return path_; }
  /// With its line end; without one where the file has no whole line.
  std::string first_line() const;
  std::int64_t size() const;

  /// Cuts the file before its first line, after the header, whose number is at least `from`.
  /// number_of: of a line without its end; nothing: a line that has none. Returns whether any line
  /// is left after the header.
  bool cut_from(std::int64_t from,
                const std::function<std::optional<std::int64_t>(std::string_view)>& number_of);
  void clear();

  /// In one call of the system. What got through of an append that failed is taken back.
  void append(std::string_view text);
  /// Writes over bytes that are there.
  void replace(std::int64_t at, std::string_view text);

private:
  std::string path_;
  int descriptor_ = -1;
};

} // namespace insitu::output
