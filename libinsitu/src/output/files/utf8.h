#pragma once

#include <string>
#include <string_view>

namespace insitu::output {

/// The code points of UTF-8, U+FFFD for each byte that begins no valid sequence (nor an overlong
/// one, nor a surrogate).
std::u32string decode_utf8(std::string_view text);

} // namespace insitu::output
