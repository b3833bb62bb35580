#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace insitu::output {

/// A line of text in which the time and the cycle of a step stand where a format has fields within
/// braces:
///
///     {time}  {time:.3f}  {time:.2e}  {time:.4g}    digits, and f: fixed, e: scientific, g: short
///     {cycle}  {cycle:6}  {cycle:06}                at least so many characters, filled up by
///                                                   blanks or zeros
///     {{  }}                                        a brace itself
///
/// {time} alone is {time:.6g}. Decimals have points, whatever the locale.
class TimeLabel {
public:
  static constexpr const char* usual = "cycle {cycle}  time {time}";

  /// Throws core::Error (INSITU_ERROR_ARGUMENT) for a text that is no format, or has no field.
  explicit TimeLabel(std::string_view format = usual);

  std::string operator()(double time, std::int64_t cycle) const;

private:
  struct Part {
    enum class Kind { text, time, cycle };
    Kind kind = Kind::text;
    std::string text;
    char notation = 'g'; ///< of a time
    int digits = 6;      ///< of a time; of a cycle the least number of characters
    bool zeros = false;  ///< fill a cycle up
  };

  static Part field_of(std::string_view field);
  void add_text(std::string_view text);

  std::vector<Part> parts_;
};

/// By to_chars: the solver may have set a locale whose decimals have commas. What is rounded to
/// zero has no sign.
std::string printed(double value, char notation, int digits);

} // namespace insitu::output
