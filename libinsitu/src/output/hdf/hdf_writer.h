#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "insitu/insitu.h"

namespace insitu::output {

/// An HDF5 file that appears whole or not at all (AtomicFile). Paths within the file begin with
/// "/", and their groups are made where they are absent. Every failure is a core::Error
/// (INSITU_ERROR_FILE) that names the file, the path within it, and the reason that HDF5 gives, of
/// which nothing goes to stderr; in a build without HDF5 the constructor throws
/// INSITU_ERROR_UNSUPPORTED. Several threads may write files of their own.
class HdfWriter {
public:
  /// Throws core::Error (INSITU_ERROR_UNSUPPORTED) in a build without HDF5; `what` is what needs
  /// it.
  static void require_hdf5(const std::string& what);

  explicit HdfWriter(const std::string& path);
  ~HdfWriter();
  HdfWriter(const HdfWriter&) = delete;
  HdfWriter& operator=(const HdfWriter&) = delete;

  /// Makes a dataset of numbers, which is contiguous in the file. extents: the slowest first, in
  /// each of which there may be none.
  void make_dataset(const std::string& where, insitu_type type,
                    std::span<const std::int64_t> extents);
  /// Writes numbers of the dataset's type, from the `first` of it on, in the order of memory.
  void write(const std::string& where, std::int64_t first, std::span<const std::byte> numbers);

  void make_group(const std::string& where);
  /// Attributes of a dataset or group: 64-bit numbers, and texts of fixed length.
  void set_attribute(const std::string& where, const char* name,
                     std::span<const std::int64_t> numbers);
  void set_attribute(const std::string& where, const char* name, std::span<const double> numbers);
  void set_attribute(const std::string& where, const char* name, std::string_view text);
  /// Gives a dataset a second path, without a copy.
  void link(const std::string& where, const std::string& dataset);

  void commit();

private:
  struct File;
  std::unique_ptr<File> file_;
};

} // namespace insitu::output
