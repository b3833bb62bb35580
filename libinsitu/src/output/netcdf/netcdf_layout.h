#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace insitu::output {

enum class NetcdfType { int8, int32, int64, float64, text };

struct NetcdfAttribute {
  std::string name;
  std::variant<std::string, double, std::int64_t, std::int32_t, std::vector<std::int8_t>> value;
};

struct NetcdfVariable {
  std::string name;
  NetcdfType type = NetcdfType::float64;
  bool per_record = true;
  std::vector<std::string> dimensions; ///< after the record dimension, if it has that
  std::vector<NetcdfAttribute> attributes;
  // The values of one that is not per record, all of them, by its type.
  std::vector<double> doubles;
  std::vector<std::int64_t> integers;
  std::string text;
};

/// What a netCDF file holds before its first record.
struct NetcdfLayout {
  std::string record_dimension;
  std::vector<std::pair<std::string, std::int64_t>> dimensions; ///< the fixed ones
  std::vector<NetcdfVariable> variables;
  std::vector<NetcdfAttribute> attributes;

  /// Bytes of one record: its variables one after the other, each padded to a multiple of four.
  std::int64_t record_bytes() const;
  /// A variable's name that netCDF takes, after `name`, and that no variable has yet: characters
  /// other than ASCII letters, digits and `_.@+-` become '_'.
  std::string free_name(const std::string& name) const;
};

/// The bytes of a file in the classic format CDF-5 with these variables and no record, made by
/// netCDF-C in an unfinished file beside `path`. The first record begins where they end. Throws
/// core::Error (INSITU_ERROR_FILE) that names the path.
std::string netcdf_head(const std::string& path, const NetcdfLayout& layout);

/// What is known of a file before it is taken up again; throws core::Error (INSITU_ERROR_FILE) if
/// it is no netCDF file.
struct NetcdfSummary {
  std::vector<std::pair<std::string, std::int64_t>> dimensions;
  std::vector<std::string> variables;
  std::int64_t first = 0, last = 0; ///< the first variable in those records, where there are some
  std::int64_t records = 0;
  /// Whether a run that goes on at `from` keeps a record: one below it, or above, where they go
  /// down; nothing: any.
  bool keeps_before(std::optional<std::int64_t> from) const;
  std::int64_t dimension(const std::string& name) const; ///< 0 if there is none
};
NetcdfSummary summarize_netcdf(const std::string& path);

} // namespace insitu::output
