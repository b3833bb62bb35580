#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace insitu::output {

/// Builds JSON that may also stand in a script or in a page, whatever texts it holds: it is ASCII,
/// without "<", and one line but for those that line() begins.
///
///   JsonText j;
///   j.open('{').key("cycle").value(12).key("values").open('[').value(0.5).close().close();
class JsonText {
public:
  JsonText() = default;
  /// With a blank behind commas and colons, for people who read the file.
  static JsonText spaced();

  /// '{' or '['; close() writes its other half.
  JsonText& open(char bracket);
  JsonText& close();
  JsonText& key(std::string_view name);
  /// The next item begins a line, indented, and the bracket that it is in closes on a line.
  JsonText& line();
  /// The shortest decimal that reads back as the same number; NaN and infinities, which JSON lacks,
  /// are null.
  JsonText& value(double number);
  /// Seven digits: for plots.
  JsonText& short_value(double number);
  JsonText& value(std::int64_t number);
  JsonText& value(int number) { return value(std::int64_t(number)); }
  JsonText& value(bool b);
  /// UTF-8; what is not is U+FFFD.
  JsonText& value(std::string_view text);
  JsonText& value(const char* text) { return value(std::string_view(text)); }
  /// JSON made elsewhere.
  JsonText& raw(std::string_view json);

  const std::string& text() const { return text_; }
  bool empty() const { return text_.empty(); }

private:
  void separate();

  std::string text_;
  std::vector<std::string> closing_; ///< of brackets still open
  std::string blank_;                ///< behind commas and colons
  std::string line_;                 ///< the line break before the next item, if any
  bool first_ = true;                ///< within the innermost bracket, or after a key
};

} // namespace insitu::output
