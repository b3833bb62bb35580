#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "insitu/insitu.h"

namespace insitu::output {

/// A dataset of numbers.
struct HdfDataset {
  insitu_type type = INSITU_FLOAT64;
  std::vector<std::int64_t> extents; ///< the slowest first

  /// Of all extents; 0 or above.
  std::int64_t numbers() const;
};

/// Reads HDF5 files. Every failure is a core::Error (INSITU_ERROR_FILE) that names the file, the
/// path within it, and the reason; HDF5 prints nothing.
class HdfReader {
public:
  explicit HdfReader(const std::string& path);
  ~HdfReader();
  HdfReader(const HdfReader&) = delete;
  HdfReader& operator=(const HdfReader&) = delete;

  /// Whether there is a group or dataset of this path. Throws where the file does not tell.
  bool has(const std::string& where) const;
  /// Throws for what is no dataset of such numbers, or of more than the file can hold.
  HdfDataset dataset(const std::string& where) const;
  /// Reads the numbers [first, first + count) of a dataset, in the order of memory, in its type.
  void read(const std::string& where, const HdfDataset& dataset, std::int64_t first,
            std::int64_t count, std::byte* to) const;
  /// An attribute of 64-bit numbers.
  std::vector<std::int64_t> attribute(const std::string& where, const char* name) const;

  /// Throws with the file's name and the path before the message.
  [[noreturn]] void refuse(const std::string& where, const std::string& message) const;

private:
  struct File;
  std::unique_ptr<File> file_;
};

} // namespace insitu::output
