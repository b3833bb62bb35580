#pragma once

#include <string>
#include <vector>

namespace insitu::test {

/// The columns of a row of CSV on one line; quotes around a column go, doubled ones within are not
/// looked for.
inline std::vector<std::string> split_csv(const std::string& line) {
  std::vector<std::string> out(1);
  bool quoted = false;
  for (const char c : line)
    if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      out.emplace_back();
    else
      out.back() += c;
  return out;
}

} // namespace insitu::test
