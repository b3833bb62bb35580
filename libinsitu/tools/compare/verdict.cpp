#include "compare/verdict.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>

namespace insitu::compare {

bool same_number(double a, double b, const Tolerance& tolerance) {
  if (std::isnan(a) || std::isnan(b))
    return std::isnan(a) && std::isnan(b);
  if (std::isinf(a) || std::isinf(b))
    return a == b;
  return std::abs(a - b) <=
         tolerance.absolute + tolerance.relative * std::max(std::abs(a), std::abs(b));
}

double excess(double a, double b, const Tolerance& tolerance) {
  const double admitted =
      tolerance.absolute + tolerance.relative * std::max(std::abs(a), std::abs(b));
  const double ratio = std::abs(a - b) / admitted;
  return std::isfinite(ratio) ? ratio : std::numeric_limits<double>::infinity();
}

bool parse_number(const std::string& text, double& value) {
  const std::size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string::npos) {
    value = std::numeric_limits<double>::quiet_NaN();
    return true;
  }
  const std::size_t end = text.find_last_not_of(" \t") + 1;
  const char* first = text.data() + begin;
  const char* const last = text.data() + end;
  if (*first == '+' && last - first > 1 && first[1] != '-')
    ++first;
  const std::from_chars_result read = std::from_chars(first, last, value);
  if (read.ptr != last)
    return false;
  if (read.ec == std::errc::result_out_of_range)
    value = std::strtod(text.c_str(), nullptr); // to zero or to infinity
  return read.ec != std::errc::invalid_argument;
}

std::string number_text(double value) {
  if (std::isnan(value))
    return "nan";
  char text[32];
  return std::string(text, std::to_chars(text, text + sizeof text, value).ptr);
}

std::string change_text(double a, double b) {
  std::string text = number_text(a) + " -> " + number_text(b);
  if (std::isfinite(a) && std::isfinite(b)) {
    const double difference = std::abs(a - b);
    char by[80];
    std::snprintf(by, sizeof by, " (by %.3g, relative %.3g)", difference,
                  difference / std::max(std::abs(a), std::abs(b)));
    text += by;
  }
  return text;
}

std::string count_text(std::size_t count, const char* noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

} // namespace insitu::compare
