#include "scene/probes/points_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/status.h"
#include "core/suggest.h"
#include "output/files/csv.h"
#include "scene/parse/problems.h"

namespace insitu::scene {
namespace {

constexpr std::size_t longest_line = 1 << 16; // bytes

/// Which column of the file is which number; -1: none.
struct Columns {
  std::array<int, 3> position{-1, -1, -1};
  int name = -1;
  std::size_t count = 0;
};

/// Of its first byte, from 1.
int column_of(const output::CsvCell& cell) {
  return static_cast<int>(cell.at + 1);
}

/// 0 to 2: a number of the position; 3: the name; -1: something else.
int meaning(const std::string& column, bool& geographic, bool& depth) {
  static constexpr struct {
    const char* name;
    int index;
    bool geographic, depth;
  } known[] = {{"x", 0, false, false},        {"y", 1, false, false},
               {"z", 2, false, false},        {"lon", 0, true, false},
               {"longitude", 0, true, false}, {"lat", 1, true, false},
               {"latitude", 1, true, false},  {"height", 2, true, false},
               {"depth", 2, true, true},      {"name", 3, false, false}};
  std::string lower = column;
  std::transform(lower.begin(), lower.end(), lower.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  for (const auto& one : known) {
    if (lower == one.name) {
      geographic = one.geographic;
      depth = one.depth;
      return one.index;
    }
  }
  return -1;
}

/// Reads the header; notes problems, and is then of no use.
Columns read_header(const std::vector<output::CsvCell>& fields, int line, PointTable& table,
                    Problems& problems) {
  static const std::array<const char*, 3> cartesian_names{"x", "y", "z"};
  static const std::array<const char*, 3> geographic_names{"lon", "lat", "height' or 'depth"};
  Columns columns;
  columns.count = fields.size();
  std::vector<std::string> unknown;
  std::array<bool, 2> found{}; // cartesian, geographic
  for (std::size_t i = 0; i < fields.size(); ++i) {
    bool geographic = false, depth = false;
    const int index = meaning(fields[i].text, geographic, depth);
    if (index < 0) {
      unknown.push_back(fields[i].text);
      continue;
    }
    int& column = index == 3 ? columns.name : columns.position[static_cast<std::size_t>(index)];
    if (index < 3)
      found[geographic ? 1 : 0] = true;
    if (column >= 0 && !(found[0] && found[1])) {
      problems.add(line, column_of(fields[i]),
                   "column " + quote(fields[i].text) + " repeats column " +
                       quote(fields[static_cast<std::size_t>(column)].text));
    }
    column = static_cast<int>(i);
    table.depth = table.depth || depth;
  }
  table.geographic = found[1];
  if (found[0] && found[1]) {
    problems.add(line, "the columns mix x, y, z with longitude and latitude");
    return columns;
  }
  if (!found[0] && !found[1]) {
    problems.add(line, "the first line must name the columns: x,y,z or lon,lat,height (or depth), "
                       "and optionally name");
    return columns;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if (columns.position[i] < 0) {
      const std::string wanted = found[1] ? geographic_names[i] : cartesian_names[i];
      std::string near;
      for (const std::string& one : unknown)
        if (wanted.size() > 1 && !core::suggest(one, {wanted.substr(0, wanted.find('\''))}).empty())
          near = "; is it " + quote(one) + "?";
      problems.add(line, "column '" + wanted + "' is missing" + near);
    }
  }
  return columns;
}

bool parse_number(std::string_view text, double& value) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-')
    text.remove_prefix(1);
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  return result.ec == std::errc() && result.ptr == text.data() + text.size() &&
         std::isfinite(value);
}

void read_row(const std::vector<output::CsvCell>& fields, const Columns& columns, int line,
              PointTable& table, Problems& problems) {
  if (fields.size() != columns.count) {
    problems.add(line, std::to_string(columns.count) + " columns expected, " +
                           std::to_string(fields.size()) + " found");
    return;
  }
  math::Vec3d point;
  for (int i = 0; i < 3; ++i) {
    const output::CsvCell& field =
        fields[static_cast<std::size_t>(columns.position[static_cast<std::size_t>(i)])];
    if (!parse_number(field.text, point[i])) {
      problems.add(line, column_of(field),
                   "a finite number expected, " +
                       (field.text.empty() ? "nothing" : quote(field.text)) + " found");
      return;
    }
    if (table.geographic && i == 1 && (point.y < -90 || point.y > 90)) {
      problems.add(line, column_of(field),
                   "a latitude from -90 to 90 degrees expected, " + quote(field.text) + " found");
      return;
    }
  }
  table.points.push_back(point);
  if (columns.name >= 0)
    table.names.push_back(fields[static_cast<std::size_t>(columns.name)].text);
}

} // namespace

PointTable parse_points_text(std::string_view text, const std::string& file) {
  Problems problems(file);
  PointTable table;
  table.file = file;
  if (text.substr(0, 3) == "\xEF\xBB\xBF")
    text.remove_prefix(3);
  Columns columns;
  std::vector<output::CsvCell> fields;
  bool has_header = false;
  int line = 0;
  while (!text.empty() && !problems.full()) {
    ++line;
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view row = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const std::size_t first = row.find_first_not_of(" \t\r");
    if (first == std::string_view::npos || row[first] == '#')
      continue;
    if (row.size() > longest_line) {
      problems.add(line, "the line has more than " + std::to_string(longest_line) + " bytes");
      break;
    }
    if (!output::take_csv_record(row, fields)) { // records of points are one line each
      problems.add(line, column_of(fields.back()),
                   "the quotation mark is not closed, or followed by more than a comma");
    } else if (has_header) {
      read_row(fields, columns, line, table, problems);
    } else {
      columns = read_header(fields, line, table, problems);
      problems.throw_if_any(); // the rows mean nothing then
    }
    has_header = true;
  }
  if (!has_header)
    problems.add(0, "the file is empty; its first line names the columns: x,y,z or lon,lat,height");
  else if (table.points.empty() && problems.count() == 0)
    problems.add(0, "the file has no points");
  problems.throw_if_any();
  return table;
}

PointTable read_points_file(const std::string& path) {
  return parse_points_text(read_points_text(path), path);
}

std::string read_points_text(const std::string& path) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  std::ifstream file(path, std::ios::binary);
  if (error || !file) {
    throw core::Error(INSITU_ERROR_FILE, "file of points '" + path + "' cannot be opened" +
                                             (error ? ": " + error.message() : std::string()));
  }
  std::string text(static_cast<std::size_t>(size), '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (static_cast<std::uintmax_t>(file.gcount()) != size)
    throw core::Error(INSITU_ERROR_FILE, "file of points '" + path + "' cannot be read");
  return text;
}

FrameOfReference frame_of(const PointTable& table, const FrameOfReference& stated,
                          const std::string& scene_file) {
  using Kind = FrameOfReference::Kind;
  const bool contradicts = table.geographic
                               ? stated.kind != Kind::mesh && stated.kind != Kind::geodetic
                               : stated.kind == Kind::geodetic;
  if (contradicts) {
    Problems problems(scene_file);
    problems.add(stated.line,
                 "the columns of '" + table.file + "' are " +
                     (table.geographic ? "longitude and latitude, but the frame is not geodetic"
                                       : "x, y, z, but the frame is geodetic"));
    problems.throw_if_any();
  }
  FrameOfReference frame = stated;
  if (table.geographic) {
    frame.kind = Kind::geodetic;
    frame.depth = table.depth;
  }
  return frame;
}

} // namespace insitu::scene
