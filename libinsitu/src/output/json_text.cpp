#include "output/json_text.h"

#include <charconv>
#include <cmath>

namespace insitu::output {

namespace {

constexpr char32_t replacement = 0xfffd;

void append_unit(std::string& text, unsigned unit) {
  constexpr char digits[] = "0123456789abcdef";
  text += "\\u";
  for (int shift = 12; shift >= 0; shift -= 4) {
    text += digits[unit >> shift & 0xf];
  }
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

/// Length of the valid sequence that text begins with, 0 if there is none; c: its code point.
std::size_t sequence(std::string_view text, char32_t& c) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned first = byte(0);
  const std::size_t length = first < 0x80           ? 1
                             : (first >> 5) == 0x06 ? 2
                             : (first >> 4) == 0x0e ? 3
                             : (first >> 3) == 0x1e ? 4
                                                    : 0;
  if (length == 0 || length > text.size()) {
    return 0;
  }
  c = length == 1 ? first : first & (0xffu >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0) != 0x80) {
      return 0;
    }
    c = c << 6 | (byte(i) & 0x3fu);
  }
  constexpr char32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool valid = c >= least[length] && c <= 0x10ffff && (c < 0xd800 || c > 0xdfff);
  return valid ? length : 0;
}

} // namespace

std::u32string decode_utf8(std::string_view text) {
  std::u32string out;
  while (!text.empty()) {
    char32_t c = 0;
    const std::size_t length = sequence(text, c);
    out += length > 0 ? c : replacement;
    text.remove_prefix(length > 0 ? length : 1);
  }
  return out;
}

void JsonText::separate() {
  if (!first_) {
    text_ += ',';
  }
  first_ = false;
}

JsonText& JsonText::open(char bracket) {
  separate();
  text_ += bracket;
  closing_ += bracket == '{' ? '}' : ']';
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
  text_ += ':';
  first_ = true;
  return *this;
}

JsonText& JsonText::value(double number) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, number);
  return raw(std::isfinite(number) ? std::string_view(digits, std::size_t(end.ptr - digits))
                                   : "null");
}

JsonText& JsonText::short_value(double number) {
  char digits[32];
  const auto end =
      std::to_chars(digits, digits + sizeof digits, number, std::chars_format::general, 7);
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
  for (const char32_t c : decode_utf8(text)) {
    append_code_point(text_, c);
  }
  text_ += '"';
  return *this;
}

JsonText& JsonText::raw(std::string_view json) {
  separate();
  text_ += json;
  return *this;
}

} // namespace insitu::output
