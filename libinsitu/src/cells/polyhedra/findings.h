#pragma once

#include <string>
#include <utility>
#include <vector>

#include "insitu/insitu.h"

namespace insitu::cells {

/// What is wrong with cells given by faces: counts, and the first few in words.
struct FaceFindings {
  static constexpr std::size_t most_lines = 4;
  std::int64_t index_errors = 0, shape_errors = 0, coordinate_errors = 0;
  std::vector<std::string> lines;

  std::int64_t count() const { return index_errors + shape_errors + coordinate_errors; }
  void add(std::int64_t& errors, std::string line) {
    ++errors;
    if (lines.size() < most_lines)
      lines.push_back(std::move(line));
  }
  void add(const FaceFindings& behind) {
    index_errors += behind.index_errors;
    shape_errors += behind.shape_errors;
    coordinate_errors += behind.coordinate_errors;
    for (const std::string& line : behind.lines)
      if (lines.size() < most_lines)
        lines.push_back(line);
  }
  /// One a line; empty if there are none.
  std::string text() const {
    std::string all;
    for (const std::string& line : lines)
      all += (all.empty() ? "" : "\n") + line;
    if (count() > std::int64_t(lines.size()))
      all += "\n(" + std::to_string(count()) + " errors in all)";
    return all;
  }
};

} // namespace insitu::cells
