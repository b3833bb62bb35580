#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace insitu::core {

/// Number of single-character insertions, removals, replacements and swaps of neighbours that turn
/// `a` into `b`, ignoring the case of ASCII letters: the Damerau-Levenshtein distance in its
/// "optimal string alignment" form (no part is edited twice). Bytes are compared, so a letter
/// outside ASCII counts as its UTF-8 bytes. O(|a| |b|) time.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The candidate that `word` most likely meant, or an empty string where none is close: the nearest
/// by edit_distance (the first of equals) within one edit for words of up to 3 letters, 2 for up to
/// 6, a third of the length beyond; or else the first candidate that begins with `word` (of at
/// least 3 letters).
std::string suggest(std::string_view word, const std::vector<std::string>& candidates);

/// "; did you mean 'opacity'?" for the end of a message, or an empty string where suggest() finds
/// nothing.
std::string did_you_mean(std::string_view word, const std::vector<std::string>& candidates);

} // namespace insitu::core
