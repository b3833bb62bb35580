#include <algorithm>
#include <charconv>

#include "core/status.h"
#include "output/files/append_file.h"
#include "output/files/csv.h"

namespace insitu::output {

namespace {

std::optional<std::int64_t> first_cell(std::string_view row) {
  std::int64_t number = 0;
  const auto parsed = std::from_chars(row.data(), row.data() + row.size(), number);
  return parsed.ec == std::errc() ? std::optional(number) : std::nullopt;
}

} // namespace

AppendTable::AppendTable(std::string path, std::vector<std::string> columns,
                         std::optional<std::int64_t> from)
    : rows_(columns.size()), file_(std::make_unique<AppendFile>(std::move(path))) {
  const std::string header = csv_header(columns);
  // A run that starts anew, with other columns perhaps, owes nothing to a table without rows.
  if (from && !file_->cut_from(*from, first_cell))
    file_->clear();
  std::string found = file_->first_line();
  if (found.empty()) {
    file_->append(header);
  } else if (found != header) {
    found.pop_back();
    throw core::Error(INSITU_ERROR_FILE, "cannot append to '" + file_->path() +
                                             "': its columns are '" + found + "', not '" +
                                             header.substr(0, header.size() - 1) +
                                             "'; move the old file away");
  }
}

AppendTable::~AppendTable() {
  try {
    flush();
  } catch (const core::Error&) {
    // A destructor has nobody to tell; whoever needs to know calls flush first.
  }
}

std::int64_t AppendTable::size() const {
  return file_->size();
}

void AppendTable::shorten(std::int64_t size) {
  char before = 0;
  if (size > 0 && size < file_->size() && file_->read(size - 1, &before, 1) == 1 && before == '\n')
    file_->cut(size, "take rows back from");
}

std::int64_t AppendTable::end() const {
  return size() + std::int64_t(rows_.text().size());
}

void AppendTable::cut_back(std::int64_t end) {
  const std::int64_t in_file = size();
  rows_.shorten(std::size_t(std::max<std::int64_t>(end - in_file, 0)));
  if (end < in_file)
    file_->cut(end, "take the rows of a step that comes again from");
}

const std::string& AppendTable::path() const {
  return file_->path();
}

void AppendTable::flush() {
  if (!rows_.text().empty()) {
    file_->append(rows_.text());
    rows_.clear();
  }
}

} // namespace insitu::output
