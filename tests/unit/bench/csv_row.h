#pragma once

#include <string>
#include <vector>

#include "output/files/csv.h"

namespace insitu::test {

/// The columns of a row of CSV on one line.
inline std::vector<std::string> split_csv(std::string_view line) {
  std::vector<output::CsvCell> cells;
  output::take_csv_record(line, cells);
  std::vector<std::string> out;
  for (const output::CsvCell& cell : cells)
    out.push_back(cell.text);
  return out;
}

} // namespace insitu::test
