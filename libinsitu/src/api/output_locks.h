#pragma once

#include <map>
#include <memory>
#include <string>

#include "output/files/file_lock.h"
#include "scene/parse/description.h"

namespace insitu::api {

/// Locks of what a session writes, from its opening to its close: of each action all files, by
/// folder and name; of checkpoints and records; and of single files that its caller names. Tables,
/// the page and the frames' table, which sessions of other actions share, have locks of their own
/// too (output::LockedFile).
class OutputLocks {
public:
  /// All of the scene's actions, its checkpoints and its records, or none. Throws
  /// output::BeingWritten.
  void take(const scene::SceneDescription& scene, const std::string& folder);
  /// Those of them for which the system could not make a lock file before. Throws
  /// output::BeingWritten.
  void take_missing();
  /// One file. Throws output::BeingWritten.
  void take(const std::string& path);
  void release();

private:
  using Locks = std::map<std::string, std::unique_ptr<output::FileLock>>; ///< by target

  Locks actions_, files_;
};

} // namespace insitu::api
