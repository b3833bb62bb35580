#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "output/netcdf/netcdf_layout.h"

namespace insitu::output {

class LockedFile;

/// Of the file if it has records that a run that restarts there will keep (nothing: all of them).
std::optional<NetcdfSummary> summary_before(const std::string& path,
                                            std::optional<std::int64_t> from);

/// Records of a netCDF file as it holds them: the values in the order of the layout's variables,
/// big-endian.
class NetcdfRecords {
public:
  NetcdfRecords& put(double value);
  NetcdfRecords& put(std::int64_t value);
  NetcdfRecords& put(std::int32_t value);
  /// Of a variable without further dimensions: three bytes of padding follow.
  NetcdfRecords& put(std::int8_t value);
  NetcdfRecords& put(std::span<const double> values);

  const std::string& bytes() const { return bytes_; }
  void clear() { bytes_.clear(); }
  /// Takes back all after so many bytes.
  void shorten(std::size_t bytes) { bytes_.resize(std::min(bytes_.size(), bytes)); }

private:
  std::string bytes_;
};

/// A netCDF file that grows by whole records, over a run and over restarts of it: the classic
/// format, CDF-5 (64-bit), whose records are contiguous.
///
/// netCDF-C makes everything up to the first record; the records are appended here, in one call of
/// the system, and the file's count of records, which is at a fixed place, is raised after that. So
/// a reader that opens the file at any moment sees whole records, what a killed run leaves opens,
/// and an append that fails is taken back: netCDF-C, which writes a record variable by variable,
/// and HDF5, whose files do not open after a kill, promise none of this. One writer at a time.
/// Failures are core::Error (INSITU_ERROR_FILE); records not written stay and go out with the next
/// flush.
class NetcdfTable {
public:
  /// The layout's first variable is per record, an int64 that does not decrease, or does not
  /// increase (the cycle). from: records of an earlier run in which it is at least this, or at
  /// most, where it goes down, go; nothing: all stay. An existing file must have the same layout.
  NetcdfTable(std::string path, NetcdfLayout layout,
              std::optional<std::int64_t> from = std::nullopt);
  ~NetcdfTable();
  NetcdfTable(const NetcdfTable&) = delete;
  NetcdfTable& operator=(const NetcdfTable&) = delete;

  NetcdfRecords& rows() { return rows_; }
  void flush();

  /// Goes on with another layout of the same variables per record (a longer dimension): the file is
  /// made anew, at once.
  void change(NetcdfLayout layout);

  const std::string& path() const;
  /// In the file.
  std::int64_t records() const { return records_; }
  /// Takes back the records after so many.
  void shorten(std::int64_t records);

  /// Records in the file once all that wait are written.
  std::int64_t end() const;
  /// Takes back the records after what end() was once, in the file and of those that wait.
  void cut_back(std::int64_t end);

private:
  void set_records(std::int64_t records);
  std::int64_t first_with(std::int64_t from) const;
  [[noreturn]] void refuse(const NetcdfSummary& old) const;

  NetcdfLayout layout_;
  NetcdfRecords rows_;
  std::unique_ptr<LockedFile> file_;
  std::int64_t head_bytes_ = 0, record_bytes_ = 0, records_ = 0;
};

} // namespace insitu::output
