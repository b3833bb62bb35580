#pragma once

#include <stdexcept>
#include <string>

namespace insitu_replay {

/// A file that cannot be read; what() begins with its name.
struct FileError : std::runtime_error {
  FileError(const std::string& path, const std::string& what)
      : std::runtime_error(path + ": " + what) {}
};

} // namespace insitu_replay
