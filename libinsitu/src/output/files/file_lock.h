#pragma once

#include <string>
#include <string_view>

#include "core/status.h"

namespace insitu::output {

/// The name ending of every lock file: `paths.csv.insitu-lock`.
inline constexpr std::string_view lock_suffix = ".insitu-lock";

/// Thrown where another session, of this process or another, holds the file.
class BeingWritten : public core::Error {
public:
  explicit BeingWritten(const std::string& message) : core::Error(INSITU_ERROR_FILE, message) {}
};

/// One writer at a time of a file, or of what else `target` names: a lock file beside it,
/// `<target>.insitu-lock`, which tells the process, its start and its host, while this object
/// lives. It is made whole under another name and linked, which is atomic on network file systems
/// too, without their locks.
///
/// What a process of this host left that runs no more, or is another one of the same number by now,
/// is taken over: by one of those that find it, since whoever removes it holds the system's lock on
/// that very file. What another host left cannot be judged from here; the message tells what to
/// remove. A process that exits removes its own; a forked child leaves its parent's alone.
class FileLock {
public:
  /// Makes the folder if absent, which goes again with the last lock if no file came in. Throws
  /// BeingWritten, which names `shown` and the holder. Where the system refuses to make the lock
  /// file (a folder that is read-only, a full disk), held() is false: writing the file will meet
  /// the same refusal, and names what was asked for.
  FileLock(const std::string& target, const std::string& shown);
  explicit FileLock(const std::string& target) : FileLock(target, target) {}
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

  bool held() const { return !path_.empty(); }

private:
  std::string path_; ///< absolute; empty: not held
};

} // namespace insitu::output
