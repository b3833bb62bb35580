#include "output/files/json_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/unsigned_zero.h"
#include "output/files/utf8.h"

namespace insitu::output {

namespace {

void append_unit(std::string& text, unsigned unit) {
  constexpr char digits[] = "0123456789abcdef";
  text += "\\u";
  for (int shift = 12; shift >= 0; shift -= 4)
    text += digits[unit >> shift & 0xf];
}

void append_code_point(std::string& text, char32_t c) {
  if (c == '"' || c == '\\') {
    text += '\\';
    text += char(c);
  } else if (c == '\n') {
    text += "\\n";
  } else if (c >= 0x20 && c < 0x7f && c != '<' && c != '>' && c != '&') {
    text += char(c);
  } else if (c < 0x10000) {
    append_unit(text, unsigned(c));
  } else {
    append_unit(text, unsigned(0xd800 + ((c - 0x10000) >> 10)));
    append_unit(text, unsigned(0xdc00 + ((c - 0x10000) & 0x3ff)));
  }
}

} // namespace

JsonText JsonText::spaced() {
  JsonText text;
  text.blank_ = " ";
  return text;
}

void JsonText::separate() {
  if (!first_)
    text_ += ',';
  text_ += first_ || !line_.empty() ? line_ : blank_;
  line_.clear();
  first_ = false;
}

JsonText& JsonText::line() {
  std::string& closing = closing_.back();
  if (closing.size() == 1) { // as far in as brackets with lines of their own stand around it
    const auto depth = std::count_if(closing_.begin(), closing_.end(),
                                     [](const std::string& c) { return c.size() > 1; });
    closing = "\n" + std::string(2 * std::size_t(depth), ' ') + closing;
  }
  line_ = closing.substr(0, closing.size() - 1) + "  ";
  return *this;
}

JsonText& JsonText::open(char bracket) {
  separate();
  text_ += bracket;
  closing_.emplace_back(1, bracket == '{' ? '}' : ']');
  first_ = true;
  return *this;
}

JsonText& JsonText::close() {
  text_ += closing_.back();
  closing_.pop_back();
  first_ = false;
  return *this;
}

JsonText& JsonText::key(std::string_view name) {
  value(name);
  text_ += ':' + blank_;
  first_ = true;
  return *this;
}

JsonText& JsonText::value(double number) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, core::unsigned_zero(number));
  return raw(std::isfinite(number) ? std::string_view(digits, std::size_t(end.ptr - digits))
                                   : "null");
}

JsonText& JsonText::short_value(double number) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, core::unsigned_zero(number),
                                 std::chars_format::general, 7);
  return raw(std::isfinite(number) ? std::string_view(digits, std::size_t(end.ptr - digits))
                                   : "null");
}

JsonText& JsonText::value(std::int64_t number) {
  return raw(std::to_string(number));
}

JsonText& JsonText::value(bool b) {
  return raw(b ? "true" : "false");
}

JsonText& JsonText::value(std::string_view text) {
  separate();
  text_ += '"';
  for (const char32_t c : decode_utf8(text))
    append_code_point(text_, c);
  text_ += '"';
  return *this;
}

JsonText& JsonText::raw(std::string_view json) {
  separate();
  text_ += json;
  return *this;
}

} // namespace insitu::output
