#include "output/files/csv.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/status.h"
#include "output/files/atomic_file.h"

namespace insitu::output {

namespace {

template <class T>
void append_shortest(std::string& text, T value) {
  if (std::isnan(value))
    return;
  char digits[32];
  const std::to_chars_result end = std::to_chars(digits, digits + sizeof digits, value);
  text.append(digits, end.ptr);
}

} // namespace

void append_number(std::string& text, double value) {
  append_shortest(text, value);
}
void append_number(std::string& text, float value) {
  append_shortest(text, value);
}

void append_number(std::string& text, std::int64_t value) {
  char digits[24];
  const std::to_chars_result end = std::to_chars(digits, digits + sizeof digits, value);
  text.append(digits, end.ptr);
}

void append_text(std::string& text, std::string_view value) {
  const bool quoted = value.find_first_of(",\"\r\n") != std::string_view::npos ||
                      value.starts_with(' ') || value.ends_with(' ');
  if (!quoted) {
    text.append(value);
    return;
  }
  text.push_back('"');
  for (const char c : value) {
    if (c == '"')
      text.push_back('"');
    text.push_back(c == '\n' || c == '\r' ? ' ' : c);
  }
  text.push_back('"');
}

bool take_csv_record(std::string_view& text, std::vector<CsvCell>& cells) {
  constexpr std::string_view blanks = " \t\r";
  cells.clear();
  std::size_t at = 0;
  for (bool more = true; more; ++at) {
    at = std::min(text.find_first_not_of(blanks, at), text.size());
    CsvCell& cell = cells.emplace_back(CsvCell{{}, at});
    if (at < text.size() && text[at] == '"') {
      for (++at; at < text.size() && (text[at] != '"' || text.substr(at, 2) == "\"\""); ++at) {
        cell.text += text[at];
        at += text[at] == '"' ? 1 : 0;
      }
      if (at == text.size())
        return false;
      at = std::min(text.find_first_not_of(blanks, at + 1), text.size());
      if (at < text.size() && text[at] != ',' && text[at] != '\n')
        return false;
    } else {
      const std::size_t begin = at;
      at = std::min(text.find_first_of(",\n", at), text.size());
      cell.text = text.substr(begin, at - begin);
      cell.text.erase(cell.text.find_last_not_of(blanks) + 1);
    }
    more = at < text.size() && text[at] == ',';
  }
  text.remove_prefix(std::min(at, text.size()));
  return true;
}

template <class Value>
CsvRows& CsvRows::add(void (*append)(std::string&, Value), Value value) {
  try {
    if (cells_ > 0)
      text_.push_back(',');
    append(text_, value);
    if (cells_ + 1 == columns_)
      text_.reserve(text_.size() + 1); // for the row's end
  } catch (...) {
    drop_row();
    throw;
  }
  ++cells_;
  return *this;
}

CsvRows& CsvRows::cell(double value) {
  return add<double>(append_number, value);
}

CsvRows& CsvRows::cell(float value) {
  return add<float>(append_number, value);
}

CsvRows& CsvRows::cell(std::int64_t value) {
  return add<std::int64_t>(append_number, value);
}

CsvRows& CsvRows::cell(std::string_view value) {
  return add<std::string_view>(append_text, value);
}

void CsvRows::drop_row() {
  text_.resize(whole_);
  cells_ = 0;
}

void CsvRows::end_row() {
  if (cells_ != columns_) {
    const std::size_t given = cells_;
    drop_row();
    throw core::Error(INSITU_ERROR_INTERNAL, "row of " + std::to_string(given) +
                                                 " cells in a table of " +
                                                 std::to_string(columns_) + " columns");
  }
  text_.push_back('\n');
  whole_ = text_.size();
  cells_ = 0;
}

void CsvRows::shorten(std::size_t bytes) {
  whole_ = std::min(whole_, bytes);
  drop_row();
}

void CsvRows::clear() {
  text_.erase(0, whole_);
  whole_ = 0;
}

std::string csv_header(const std::vector<std::string>& columns) {
  std::string header;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (i > 0)
      header.push_back(',');
    append_text(header, columns[i]);
  }
  header.push_back('\n');
  return header;
}

void write_csv(const std::string& path, const std::vector<std::string>& columns,
               const CsvRows& rows) {
  AtomicFile file(path);
  file.write(csv_header(columns));
  file.write(rows.text());
  file.commit();
}

} // namespace insitu::output
