#pragma once

#include <string>
#include <vector>

#include "compare/verdict.h"

namespace insitu::compare {

/// A CSV table. The first row is the header unless all of its cells are numbers; then columns are
/// named "1", "2", ...
struct Table {
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
  std::vector<std::size_t> lines; ///< of each row, in the file
};

/// Reads CSV text (RFC 4180: quoted cells may hold commas, doubled quotes and line breaks). Throws
/// core::Error (INSITU_ERROR_FILE) naming file and line where a row has another number of cells.
Table parse_csv(const std::string& text, const std::string& name);

struct TableOptions {
  Tolerance tolerance;
  std::vector<NamedTolerance> columns;
  std::vector<std::string> ignored;
  /// Columns whose texts together name a row. None: rows are compared in their order.
  std::vector<std::string> keys;
  /// Names that a table does not have are passed over rather than an error.
  bool lenient = false;
};

/// Columns are matched by name and compared as numbers where both cells are numbers or empty, else
/// as text. For each column that moved, a line tells in how many rows and where most.
Verdict compare_tables(const Table& a, const Table& b, const TableOptions& options);

} // namespace insitu::compare
