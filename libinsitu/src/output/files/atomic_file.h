#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace insitu::output {

/// Every unfinished file has this ending of its name: `blast_000120.png.4711-0.insitu-part`.
inline constexpr std::string_view part_suffix = ".insitu-part";

/// Makes a folder and its parents where they are absent. Throws core::Error (INSITU_ERROR_FILE),
/// which names the folder and the reason that the system gives.
void make_folder(const std::string& folder);

/// Removes unfinished files in `folder` whose writers have died, and returns how many. A writer
/// holds a lock on its unfinished file, and the system drops that lock when the writer dies, so
/// files of living writers stay, those on other nodes and in other containers too. Where the file
/// system has no locks, nothing is removed.
std::size_t remove_stale_parts(const std::string& folder);

/// A file that appears whole or not at all. Its bytes go to an unfinished file in the same folder,
/// which `commit` flushes to the device and renames over the target. Without `commit` (after an
/// error or an early return) the destructor removes the unfinished file, and the target keeps what
/// it held before.
///
/// The first file that a process writes to a folder makes the folder if it is absent, and removes
/// what killed runs left there. Every failure (a full disk, no permission, a folder in the way) is
/// a core::Error (INSITU_ERROR_FILE) that names the target and the reason that the system gives.
class AtomicFile {
public:
  explicit AtomicFile(std::string target);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(const void* data, std::size_t bytes);
  void write(std::string_view text) { write(text.data(), text.size()); }
  /// Writes over the first bytes, of which so many at least were written.
  void write_begin(const void* data, std::size_t bytes);
  void commit();
  /// Commits if there is no target yet. Otherwise the target stays, and the bytes are dropped.
  void commit_if_absent();

  const std::string& target() const { return target_; }
  /// Returns the path of the unfinished file, to which the bytes go until `commit`.
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
