#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace insitu::compare {

/// What a comparison found: same or not, and lines for a person to read.
struct Verdict {
  bool same = true;
  std::vector<std::string> lines;

  void differ(std::string line) {
    same = false;
    lines.push_back(std::move(line));
  }
};

/// Two numbers are the same if |a - b| <= absolute + relative max(|a|, |b|), or if both are not a
/// number, or infinite with one sign.
struct Tolerance {
  double relative = 0;
  double absolute = 0;
};
bool same_number(double a, double b, const Tolerance& tolerance);

/// How far two numbers are apart, as multiples of what the tolerance admits; infinite where it
/// admits nothing or one of them is not finite.
double excess(double a, double b, const Tolerance& tolerance);

/// A tolerance for the columns or keys of one name.
struct NamedTolerance {
  std::string name;
  Tolerance tolerance;
};

/// The whole text as a number: also "nan", "inf", and, as not a number, the empty text.
bool parse_number(const std::string& text, double& value);
/// Shortest text of a number; "nan" where the tables leave a cell empty.
std::string number_text(double value);
/// "0.25 -> 0.26 (by 0.01, relative 0.038)".
std::string change_text(double a, double b);
/// "1 row", "3 rows".
std::string count_text(std::size_t count, const char* noun);

} // namespace insitu::compare
