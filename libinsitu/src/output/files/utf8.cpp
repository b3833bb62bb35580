#include "output/files/utf8.h"

namespace insitu::output {

namespace {

constexpr char32_t replacement = 0xfffd;

/// Length of the valid sequence that text begins with, 0 if there is none; c: its code point.
std::size_t sequence(std::string_view text, char32_t& c) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned first = byte(0);
  const std::size_t length = first < 0x80           ? 1
                             : (first >> 5) == 0x06 ? 2
                             : (first >> 4) == 0x0e ? 3
                             : (first >> 3) == 0x1e ? 4
                                                    : 0;
  if (length == 0 || length > text.size())
    return 0;
  c = length == 1 ? first : first & (0xffu >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0) != 0x80)
      return 0;
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

} // namespace insitu::output
