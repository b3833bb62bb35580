#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace insitu::output {

/// Appends the shortest decimal that reads back as the same number: "0.1", "1e-300", "-0", "inf".
/// NaN appends nothing: a missing value is an empty cell, which spreadsheets, pandas and ParaView
/// read as missing.
void append_number(std::string& text, double value);
void append_number(std::string& text, float value);
void append_number(std::string& text, std::int64_t value);

/// Appends a text cell, quoted as in RFC 4180 where it holds a comma, a quote or a blank at an end.
/// Line breaks become blanks, so a row is always one line.
void append_text(std::string& text, std::string_view value);

/// A cell of a text: without its quotes, and where it begins in its record.
struct CsvCell {
  std::string text;
  std::size_t at = 0;
};

/// Takes a record off the text, as RFC 4180 has it: up to a line break that is not within quotes.
/// Blanks around a cell are no part of it unless they are quoted. False where a quote is not closed
/// or is followed by more than a comma: in the last of the cells; the text is then of no use.
bool take_csv_record(std::string_view& text, std::vector<CsvCell>& cells);

/// Builds one table in memory, row by row: `csv.cell(1).cell(2.5).end_row()`.
class CsvRows {
public:
  explicit CsvRows(std::size_t columns) : columns_(columns) {}

  CsvRows& cell(double value);
  CsvRows& cell(float value);
  CsvRows& cell(std::int64_t value);
  CsvRows& cell(int value) { return cell(std::int64_t(value)); }
  CsvRows& cell(std::string_view value);
  CsvRows& cell(const char* value) { return cell(std::string_view(value)); }
  /// Throws core::Error (INSITU_ERROR_INTERNAL) if the row has not as many cells as the table
  /// columns.
  void end_row();

  /// The whole rows so far; a row that was not ended is not part of it.
  std::string_view text() const { return std::string_view(text_).substr(0, whole_); }
  void clear();
  /// Takes back all after so many bytes of text(), where a row ends.
  void shorten(std::size_t bytes);

private:
  void drop_row();
  /// Appends a cell; a row in which that fails is taken back.
  template <class Value>
  CsvRows& add(void (*append)(std::string&, Value), Value value);

  std::size_t columns_;
  std::size_t cells_ = 0;
  std::size_t whole_ = 0;
  std::string text_;
};

/// One line of column names, with its line end.
std::string csv_header(const std::vector<std::string>& columns);

/// Writes a whole table atomically (columns, then `rows`), replacing what was there.
void write_csv(const std::string& path, const std::vector<std::string>& columns,
               const CsvRows& rows);

class AppendFile;

/// A table that grows over a run and over restarts of it.
///
/// The header is written once, when the file is made. `flush` hands the system whole rows in one
/// append, so readers see whole rows; should a kill or a full disk cut that append short, the next
/// flush or the next opening removes the partial last line. An existing file must have the same
/// columns. One writer at a time: a second one on the same file, of this process or another, is
/// refused (FileLock). Failures are core::Error (INSITU_ERROR_FILE) that name
/// the file and the reason; the rows not written stay in `rows` and go out with the next flush.
class AppendTable {
public:
  /// from: rows of an earlier run whose first cell (a cycle) is at least this go, with all after
  /// them, since a run that restarted writes them again; nothing: all rows stay.
  AppendTable(std::string path, std::vector<std::string> columns,
              std::optional<std::int64_t> from = std::nullopt);
  ~AppendTable();
  AppendTable(const AppendTable&) = delete;
  AppendTable& operator=(const AppendTable&) = delete;

  CsvRows& rows() { return rows_; }
  /// Appends the whole rows of `rows` to the file. Called by the destructor too, where errors are
  /// lost.
  void flush();

  /// Bytes in the file.
  std::int64_t size() const;
  /// Takes back the whole rows after so many bytes, if rows begin there.
  void shorten(std::int64_t size);

  /// Bytes in the file once all rows that wait are written.
  std::int64_t end() const;
  /// Takes back the rows after what end() was once, in the file and of those that wait.
  void cut_back(std::int64_t end);

  const std::string& path() const;

private:
  CsvRows rows_;
  std::unique_ptr<AppendFile> file_;
};

} // namespace insitu::output
