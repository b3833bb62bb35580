#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace insitu::output {

/// The name ending of every unfinished file: `blast_000120.png.4711-0.insitu-part`.
inline constexpr std::string_view part_suffix = ".insitu-part";

/// Makes a folder and its parents if absent. Throws core::Error (INSITU_ERROR_FILE) that names the
/// folder and the system's reason.
void make_folder(const std::string& folder);

/// Removes unfinished files in `folder` whose writers have died, and returns how many. A writer
/// holds a lock on its unfinished file, and the system drops that lock when the writer dies, so
/// files of living writers, on other nodes and in other containers too, stay. Where the file system
/// has no locks nothing is removed.
std::size_t remove_stale_parts(const std::string& folder);

/// A file that appears whole or not at all: bytes go to an unfinished file in the same folder,
/// which `commit` flushes to the device and renames over the target. Without `commit` (an error, an
/// early return) the destructor removes the unfinished file and the target keeps what it held
/// before.
///
/// The first file written to a folder makes the folder if absent, and clears it of what killed runs
/// left. Every failure (full disk, no permission, a folder in the way) is a core::Error
/// (INSITU_ERROR_FILE) that names the target and the system's reason.
class AtomicFile {
public:
  explicit AtomicFile(std::string target);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(const void* data, std::size_t bytes);
  void write(std::string_view text) { write(text.data(), text.size()); }
  void commit();
  /// The same where there is no target yet; where there is one, that stays, and the bytes go.
  void commit_if_absent();

  const std::string& target() const { return target_; }
  /// Where the bytes go until `commit`.
  const std::string& part() const { return part_; }

private:
  void flush();
  void flush_to_device();
  void close_committed();
  void discard() noexcept;
  [[noreturn]] void fail(const char* doing, int error);

  std::string target_;
  std::string part_;
  int descriptor_ = -1;
  std::size_t written_ = 0;
  std::vector<char> buffer_;
};

} // namespace insitu::output
