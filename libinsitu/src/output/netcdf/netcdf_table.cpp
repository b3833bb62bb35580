#include "output/netcdf/netcdf_table.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <filesystem>

#include "core/status.h"
#include "output/files/append_file.h"
#include "output/files/atomic_file.h"

namespace insitu::output {

namespace {

/// The classic format (NetCDF User's Guide, appendix B): "CDF" and a byte for the version, then the
/// count of records, big-endian.
constexpr std::int64_t count_at = 4, count_end = 12;

void append_big_endian(std::string& to, std::uint64_t bits, int bytes) {
  for (int b = bytes - 1; b >= 0; --b)
    to.push_back(static_cast<char>(bits >> (8 * b)));
}

std::int64_t big_endian(const char* bytes) {
  std::uint64_t bits = 0;
  for (int b = 0; b < 8; ++b)
    bits = bits << 8 | static_cast<unsigned char>(bytes[b]);
  return static_cast<std::int64_t>(bits);
}

std::int64_t read_number(const LockedFile& file, std::int64_t at) {
  char bytes[8];
  if (file.read(at, bytes, sizeof bytes) != sizeof bytes) {
    throw core::Error(INSITU_ERROR_FILE, "cannot read '" + file.path() + "': it ends at byte " +
                                             std::to_string(file.size()));
  }
  return big_endian(bytes);
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names)
    text += (text.empty() ? "" : ",") + name;
  return text;
}

} // namespace

std::optional<NetcdfSummary> summary_before(const std::string& path,
                                            std::optional<std::int64_t> from) {
  std::error_code error;
  if (!std::filesystem::exists(path, error) || std::filesystem::file_size(path, error) == 0)
    return std::nullopt;
  NetcdfSummary summary = summarize_netcdf(path);
  return summary.keeps_before(from) ? std::optional(std::move(summary)) : std::nullopt;
}

NetcdfRecords& NetcdfRecords::put(double value) {
  append_big_endian(bytes_, std::bit_cast<std::uint64_t>(value), 8);
  return *this;
}
NetcdfRecords& NetcdfRecords::put(std::int64_t value) {
  append_big_endian(bytes_, static_cast<std::uint64_t>(value), 8);
  return *this;
}
NetcdfRecords& NetcdfRecords::put(std::int32_t value) {
  append_big_endian(bytes_, static_cast<std::uint32_t>(value), 4);
  return *this;
}
NetcdfRecords& NetcdfRecords::put(std::int8_t value) {
  append_big_endian(bytes_, static_cast<std::uint64_t>(static_cast<std::uint8_t>(value)) << 24, 4);
  return *this;
}
NetcdfRecords& NetcdfRecords::put(std::span<const double> values) {
  for (const double value : values)
    put(value);
  return *this;
}

NetcdfTable::NetcdfTable(std::string path, NetcdfLayout layout, std::optional<std::int64_t> from)
    : layout_(std::move(layout)), record_bytes_(layout_.record_bytes()) {
  const std::string head = netcdf_head(path, layout_);
  head_bytes_ = std::int64_t(head.size());
  std::error_code error;
  if (!std::filesystem::exists(path, error)) { // whole from its first moment on
    AtomicFile out(path);
    out.write(head);
    out.commit_if_absent();
  }
  file_ = std::make_unique<LockedFile>(std::move(path));
  std::string found(head.size(), '\0');
  const std::size_t count = file_->read(0, found.data(), found.size());
  const bool same = count == found.size() &&
                    std::equal(head.begin(), head.begin() + count_at, found.begin()) &&
                    std::equal(head.begin() + count_end, head.end(), found.begin() + count_end);
  if (same) {
    // As many as are counted and there: what a kill cut short is written again.
    const std::int64_t whole = (file_->size() - head_bytes_) / record_bytes_;
    records_ = std::clamp<std::int64_t>(big_endian(found.data() + count_at), 0, whole);
    if (from)
      records_ = first_with(*from);
    file_->cut(head_bytes_ + records_ * record_bytes_, "cut the records of an earlier run from");
    set_records(records_);
    return;
  }
  // A run that starts anew, with other fields perhaps, owes nothing to a file without records.
  if (count > 0) {
    const NetcdfSummary old = summarize_netcdf(file_->path());
    if (old.keeps_before(from))
      refuse(old);
  }
  file_->renew(head);
}

NetcdfTable::~NetcdfTable() {
  try {
    flush();
  } catch (const core::Error&) {
    // A destructor has nobody to tell; whoever needs to know calls flush first.
  }
}

const std::string& NetcdfTable::path() const {
  return file_->path();
}

void NetcdfTable::refuse(const NetcdfSummary& old) const {
  std::vector<std::string> wanted;
  for (const NetcdfVariable& v : layout_.variables)
    wanted.push_back(v.name);
  const bool names_differ = old.variables != wanted;
  throw core::Error(INSITU_ERROR_FILE,
                    "cannot append to '" + file_->path() + "': its " +
                        (names_differ ? "variables are '" + joined(old.variables) + "', not '" +
                                            joined(wanted) + "'"
                                      : std::string("dimensions, attributes or fixed values are "
                                                    "not those of this run")) +
                        "; move the old file away");
}

void NetcdfTable::set_records(std::int64_t records) {
  std::string count;
  append_big_endian(count, static_cast<std::uint64_t>(records), 8);
  file_->replace(count_at, count);
  records_ = records;
}

/// Where to cut: the first variable of the records goes up, or down if its last one is the lower.
std::int64_t NetcdfTable::first_with(std::int64_t from) const {
  const auto number = [&](std::int64_t record) {
    return read_number(*file_, head_bytes_ + record * record_bytes_);
  };
  const bool descends = records_ > 1 && number(records_ - 1) < number(0);
  std::int64_t low = 0, high = records_;
  while (low < high) {
    const std::int64_t middle = low + (high - low) / 2;
    const std::int64_t found = number(middle);
    if (descends ? found > from : found < from)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

void NetcdfTable::flush() {
  const std::string& bytes = rows_.bytes();
  if (bytes.empty())
    return;
  const auto count = std::int64_t(bytes.size()) / record_bytes_;
  if (count * record_bytes_ != std::int64_t(bytes.size())) {
    const std::size_t given = bytes.size();
    rows_.clear();
    throw core::Error(INSITU_ERROR_INTERNAL, "'" + path() + "': " + std::to_string(given) +
                                                 " bytes are no whole number of records of " +
                                                 std::to_string(record_bytes_));
  }
  file_->append(bytes);
  try {
    set_records(records_ + count);
  } catch (...) { // not counted: they would appear twice
    file_->cut(head_bytes_ + records_ * record_bytes_, "take back a partial append to");
    throw;
  }
  rows_.clear();
}

void NetcdfTable::shorten(std::int64_t records) {
  if (records < records_) {
    set_records(records); // first, so that no reader looks for what is gone
    file_->cut(head_bytes_ + records_ * record_bytes_, "take records back from");
  }
}

std::int64_t NetcdfTable::end() const {
  return records_ + std::int64_t(rows_.bytes().size()) / record_bytes_;
}

void NetcdfTable::cut_back(std::int64_t end) {
  rows_.shorten(std::size_t(std::max<std::int64_t>(end - records_, 0) * record_bytes_));
  shorten(end);
}

void NetcdfTable::change(NetcdfLayout layout) {
  std::string head = netcdf_head(path(), layout);
  if (layout.record_bytes() != record_bytes_)
    throw core::Error(INSITU_ERROR_INTERNAL, "'" + path() + "': records of another size");
  std::string count;
  append_big_endian(count, static_cast<std::uint64_t>(records_), 8);
  head.replace(std::size_t(count_at), count.size(), count);
  file_->renew(head, head_bytes_);
  head_bytes_ = std::int64_t(head.size());
  layout_ = std::move(layout);
}

} // namespace insitu::output
