#include "compare/table_compare.h"

#include <algorithm>
#include <limits>
#include <map>

#include "core/status.h"
#include "output/files/csv.h"

namespace insitu::compare {

namespace {

[[noreturn]] void unusable(const std::string& what) {
  throw core::Error(INSITU_ERROR_FILE, what);
}

constexpr std::size_t none = std::size_t(-1);

std::size_t find(const std::vector<std::string>& names, const std::string& name) {
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? none : std::size_t(found - names.begin());
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return find(names, name) != none;
}

/// Pairs of rows to compare, and what has no partner.
struct Pairing {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  std::vector<std::size_t> only_a, only_b;
};

class Comparison {
public:
  Comparison(const Table& a, const Table& b, const TableOptions& options)
      : a_(a), b_(b), options_(options) {}

  Verdict run() {
    if (!options_.lenient)
      check_names();
    for (const std::string& key : options_.keys) {
      if (options_.lenient && (!contains(a_.columns, key) || !contains(b_.columns, key)))
        continue;
      key_columns_a_.push_back(key_column(a_, key, "first"));
      key_columns_b_.push_back(key_column(b_, key, "second"));
    }
    const Pairing pairing = key_columns_a_.empty() ? by_order() : by_key();
    report_missing_columns();
    report_missing(pairing.only_a, a_, key_columns_a_, "second");
    report_missing(pairing.only_b, b_, key_columns_b_, "first");
    for (std::size_t i = 0; i < a_.columns.size(); ++i) {
      const std::size_t j = find(b_.columns, a_.columns[i]);
      if (j != none && !contains(options_.ignored, a_.columns[i]))
        compare_column(i, j, pairing.pairs);
    }
    if (verdict_.same) {
      verdict_.lines.push_back("same: " + count_text(a_.rows.size(), "row") + ", " +
                               count_text(a_.columns.size(), "column"));
    }
    return std::move(verdict_);
  }

private:
  /// An option for a column that neither table has is a mistake in the call, not a difference.
  void check_names() const {
    std::vector<std::string> named = options_.ignored;
    for (const NamedTolerance& column : options_.columns)
      named.push_back(column.name);
    for (const std::string& name : named)
      if (!contains(a_.columns, name) && !contains(b_.columns, name))
        unusable("no column '" + name + "' in either table");
  }

  static std::size_t key_column(const Table& table, const std::string& key, const char* which) {
    const std::size_t column = find(table.columns, key);
    if (column == none)
      unusable("no key column '" + key + "' in the " + which + " table");
    return column;
  }

  static std::string key_text(const Table& table, const std::vector<std::size_t>& columns,
                              std::size_t row) {
    std::string text;
    for (const std::size_t column : columns)
      text += (text.empty() ? "" : ", ") + table.columns[column] + " " + table.rows[row][column];
    return text;
  }

  Pairing by_order() const {
    Pairing out;
    const std::size_t both = std::min(a_.rows.size(), b_.rows.size());
    for (std::size_t i = 0; i < both; ++i)
      out.pairs.emplace_back(i, i);
    for (std::size_t i = both; i < a_.rows.size(); ++i)
      out.only_a.push_back(i);
    for (std::size_t i = both; i < b_.rows.size(); ++i)
      out.only_b.push_back(i);
    return out;
  }

  Pairing by_key() const {
    std::map<std::string, std::size_t> rows;
    for (std::size_t i = 0; i < b_.rows.size(); ++i) {
      const std::string key = key_text(b_, key_columns_b_, i);
      if (!rows.emplace(key, i).second)
        unusable("the second table has more than one row with " + key);
    }
    Pairing out;
    std::map<std::string, std::size_t> seen;
    for (std::size_t i = 0; i < a_.rows.size(); ++i) {
      const std::string key = key_text(a_, key_columns_a_, i);
      if (!seen.emplace(key, i).second)
        unusable("the first table has more than one row with " + key);
      const auto found = rows.find(key);
      if (found == rows.end()) {
        out.only_a.push_back(i);
      } else {
        out.pairs.emplace_back(i, found->second);
        rows.erase(found);
      }
    }
    for (const auto& [key, row] : rows)
      out.only_b.push_back(row);
    std::sort(out.only_b.begin(), out.only_b.end());
    return out;
  }

  void report_missing_columns() {
    for (const std::string& name : a_.columns)
      if (!contains(b_.columns, name) && !contains(options_.ignored, name))
        verdict_.differ("column '" + name + "' is missing in the second table");
    for (const std::string& name : b_.columns)
      if (!contains(a_.columns, name) && !contains(options_.ignored, name))
        verdict_.differ("column '" + name + "' is missing in the first table");
  }

  std::string row_text(const Table& table, const std::vector<std::size_t>& keys,
                       std::size_t row) const {
    const std::string line = "line " + std::to_string(table.lines[row]);
    return keys.empty() ? "row " + std::to_string(row + 1) + " (" + line + ")"
                        : key_text(table, keys, row) + " (" + line + ")";
  }

  void report_missing(const std::vector<std::size_t>& rows, const Table& table,
                      const std::vector<std::size_t>& keys, const char* where) {
    constexpr std::size_t shown = 5;
    for (std::size_t i = 0; i < std::min(rows.size(), shown); ++i)
      verdict_.differ(row_text(table, keys, rows[i]) + " is missing in the " + where + " table");
    if (rows.size() > shown) {
      verdict_.differ("and " + count_text(rows.size() - shown, "more row") + " missing in the " +
                      where + " table");
    }
  }

  void compare_column(std::size_t i, std::size_t j,
                      const std::vector<std::pair<std::size_t, std::size_t>>& pairs) {
    const std::string& name = a_.columns[i];
    Tolerance tolerance = options_.tolerance;
    for (const NamedTolerance& column : options_.columns)
      tolerance = column.name == name ? column.tolerance : tolerance;
    std::size_t moved = 0, worst_row = 0;
    double worst = -1;
    std::string change;
    for (const auto& [row_a, row_b] : pairs) {
      const std::string& text_a = a_.rows[row_a][i];
      const std::string& text_b = b_.rows[row_b][j];
      if (text_a == text_b)
        continue;
      double x = 0, y = 0;
      const bool numbers = parse_number(text_a, x) && parse_number(text_b, y);
      if (numbers && same_number(x, y, tolerance))
        continue;
      ++moved;
      // Where nothing is admitted, the largest change is the worst.
      const bool exact = tolerance.relative == 0 && tolerance.absolute == 0;
      const double far = numbers ? excess(x, y, exact ? Tolerance{0, 1} : tolerance)
                                 : std::numeric_limits<double>::infinity();
      if (far > worst) {
        worst = far;
        worst_row = row_a;
        change = numbers ? change_text(x, y) : "'" + text_a + "' -> '" + text_b + "'";
      }
    }
    if (moved > 0) {
      verdict_.differ("column '" + name + "' moved in " + std::to_string(moved) + " of " +
                      count_text(pairs.size(), "row") + ", most in " +
                      row_text(a_, key_columns_a_, worst_row) + ": " + change);
    }
  }

  const Table& a_;
  const Table& b_;
  const TableOptions& options_;
  std::vector<std::size_t> key_columns_a_, key_columns_b_;
  Verdict verdict_;
};

} // namespace

Table parse_csv(const std::string& text, const std::string& name) {
  Table table;
  std::string_view rest = text;
  rest.remove_prefix(rest.starts_with("\xef\xbb\xbf") ? 3 : 0); // a byte order mark
  std::size_t line = 1;
  bool first = true;
  std::vector<output::CsvCell> record;
  while (!rest.empty()) {
    const std::size_t begin = line;
    const std::string_view before = rest;
    if (!output::take_csv_record(rest, record)) {
      unusable("'" + name + "' line " + std::to_string(begin) +
               ": a quoted cell does not end, or more than a comma follows it");
    }
    line += std::size_t(std::count(before.begin(), before.end() - rest.size(), '\n'));
    std::vector<std::string> cells;
    for (output::CsvCell& cell : record)
      cells.push_back(std::move(cell.text));
    const bool blank = cells.size() == 1 && cells[0].empty();
    if (blank && (first || table.columns.size() > 1))
      continue;
    if (first) {
      first = false;
      double value = 0;
      const bool header = !std::all_of(cells.begin(), cells.end(), [&](const std::string& cell) {
        return !cell.empty() && parse_number(cell, value);
      });
      if (header) {
        table.columns = std::move(cells);
        continue;
      }
      for (std::size_t i = 0; i < cells.size(); ++i)
        table.columns.push_back(std::to_string(i + 1));
    }
    if (cells.size() != table.columns.size()) {
      unusable("'" + name + "' line " + std::to_string(begin) + ": " +
               count_text(table.columns.size(), "cell") + " expected, " +
               std::to_string(cells.size()) + " found");
    }
    table.rows.push_back(std::move(cells));
    table.lines.push_back(begin);
  }
  if (table.columns.empty())
    unusable("'" + name + "' holds no table");
  return table;
}

Verdict compare_tables(const Table& a, const Table& b, const TableOptions& options) {
  return Comparison(a, b, options).run();
}

} // namespace insitu::compare
