#include "paper/table.h"

#include <algorithm>
#include <cmath>

#include "format.h"
#include "report.h"

namespace insitu::bench::paper {

namespace {

std::string shown(const Cell& cell) {
  return cell.text().empty() ? "-" : cell.text();
}

/// A field of a CSV file.
std::string field(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos)
    return text;
  std::string out = "\"";
  for (const char c : text)
    out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
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
  std::string out = "section," + field(table.label.empty() ? "row" : table.label);
  for (const std::string& column : table.columns)
    out += "," + field(column);
  out += "\n";
  for (const Table::Row& row : table.rows) {
    out += field(row.section) + "," + field(row.name);
    for (std::size_t i = 0; i < table.columns.size(); ++i)
      out += "," + (i < row.cells.size() ? field(row.cells[i].exact()) : std::string());
    out += "\n";
  }
  return out;
}

std::string json(const Tables& tables) {
  const auto list = [](const std::vector<std::string>& items) {
    std::string out = "[";
    for (const std::string& item : items)
      out += (out.size() > 1 ? ", " : "") + item;
    return out + "]";
  };
  const auto all_quoted = [&](const std::vector<std::string>& words) {
    std::vector<std::string> out;
    for (const std::string& w : words)
      out.push_back(quoted(w));
    return list(out);
  };
  std::string out = "{\"title\": " + quoted(tables.title) +
                    ", \"notes\": " + all_quoted(tables.notes) + ", \"tables\": [";
  for (const Table& t : tables.tables) {
    out += std::string(&t == &tables.tables.front() ? "" : ",") + "\n {\"key\": " + quoted(t.key) +
           ", \"title\": " + quoted(t.title) + ", \"columns\": " + all_quoted(t.columns) +
           ", \"left_out\": " + all_quoted(t.left_out) + ", \"rows\": [";
    for (const Table::Row& row : t.rows) {
      std::vector<std::string> cells;
      for (const Cell& c : row.cells)
        cells.push_back(c.is_number()      ? c.exact()
                        : c.text().empty() ? std::string("null")
                                           : quoted(c.text()));
      out += std::string(&row == &t.rows.front() ? "" : ",") +
             "\n  {\"section\": " + quoted(row.section) + ", \"row\": " + quoted(row.name) +
             ", \"cells\": " + list(cells) + "}";
    }
    out += "]}";
  }
  return out + "\n]}\n";
}

} // namespace insitu::bench::paper
