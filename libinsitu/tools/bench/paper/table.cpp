#include "paper/table.h"

#include <algorithm>
#include <cmath>

#include "report/format.h"
#include "report/json.h"
#include "output/files/csv.h"
#include "report/report.h"

namespace insitu::bench::paper {

namespace {

std::string shown(const Cell& cell) {
  return cell.text().empty() ? "-" : cell.text();
}

/// Words broken into lines of at most `width` characters, each after `indent`.
std::string wrapped(const std::string& words, const std::string& indent, std::size_t width) {
  std::string out, line = indent;
  for (std::size_t at = 0; at < words.size();) {
    const std::size_t end = std::min(words.find(' ', at), words.size());
    const std::string word = words.substr(at, end - at);
    if (line.size() > indent.size() && line.size() + 1 + word.size() > width) {
      out += line + "\n";
      line = indent;
    }
    line += (line.size() > indent.size() ? " " : "") + word;
    at = end + 1;
  }
  return out + line + "\n";
}

constexpr std::size_t line_width = 118;

} // namespace

Cell::Cell(double value, const char* pattern) : is_number_(std::isfinite(value)) {
  if (is_number_) {
    text_ = format(pattern, value);
    exact_ = format("%.9g", value);
  }
}

Cell::Cell(std::int64_t count) : text_(grouped(count)), exact_(std::to_string(count)) {
  is_number_ = true;
}

std::string heading(const Tables& tables) {
  std::string out = tables.title + "\n";
  for (const std::string& note : tables.notes)
    out += wrapped(note, "  ", line_width);
  return out + "\n";
}

std::string text(const Table& table) {
  std::string out = table.title + "\n" + wrapped(table.caption, "  ", line_width);
  std::size_t names = table.label.size();
  std::vector<std::size_t> widths;
  for (const std::string& column : table.columns)
    widths.push_back(std::max<std::size_t>(7, column.size()));
  for (const Table::Row& row : table.rows) {
    names = std::max(names, row.name.size() + (row.section.empty() ? 0 : 2));
    for (std::size_t i = 0; i < row.cells.size() && i < widths.size(); ++i)
      widths[i] = std::max(widths[i], shown(row.cells[i]).size());
  }
  const auto pad = [](const std::string& s, std::size_t width, bool left) {
    const std::string blank(width > s.size() ? width - s.size() : 0, ' ');
    return left ? s + blank : blank + s;
  };
  out += "  " + pad(table.label, names, true);
  for (std::size_t i = 0; i < widths.size(); ++i)
    out += "  " + pad(table.columns[i], widths[i], false);
  out += "\n";
  std::string section;
  for (const Table::Row& row : table.rows) {
    if (row.section != section)
      out += "  " + row.section + "\n";
    section = row.section;
    out += "  " + pad((section.empty() ? "" : "  ") + row.name, names, true);
    for (std::size_t i = 0; i < widths.size(); ++i)
      out += "  " + pad(i < row.cells.size() ? shown(row.cells[i]) : "", widths[i], false);
    out += "\n";
  }
  for (const std::string& left : table.left_out)
    out += wrapped("Left out: " + left, "  ", line_width);
  return out + "\n";
}

std::string csv(const Table& table) {
  std::vector<std::string> columns = {"section", table.label.empty() ? "row" : table.label};
  columns.insert(columns.end(), table.columns.begin(), table.columns.end());
  output::CsvRows rows(columns.size());
  for (const Table::Row& row : table.rows) {
    rows.cell(row.section).cell(row.name);
    for (std::size_t i = 0; i < table.columns.size(); ++i)
      rows.cell(i < row.cells.size() ? row.cells[i].exact() : std::string());
    rows.end_row();
  }
  return output::csv_header(columns) + std::string(rows.text());
}

std::string json(const Tables& tables) {
  Json out = {{"title", tables.title}, {"notes", tables.notes}, {"tables", Json::array()}};
  for (const Table& t : tables.tables) {
    Json rows = Json::array();
    for (const Table::Row& row : t.rows) {
      Json cells = Json::array();
      for (const Cell& c : row.cells)
        cells.push_back(c.is_number()      ? Json::parse(c.exact())
                        : c.text().empty() ? Json()
                                           : Json(c.text()));
      rows.push_back({{"section", row.section}, {"row", row.name}, {"cells", cells}});
    }
    out["tables"].push_back({{"key", t.key},
                             {"title", t.title},
                             {"columns", t.columns},
                             {"left_out", t.left_out},
                             {"rows", rows}});
  }
  return json_text(out);
}

} // namespace insitu::bench::paper
