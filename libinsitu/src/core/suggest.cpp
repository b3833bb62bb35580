#include "core/suggest.h"

#include <algorithm>
#include <cstddef>

namespace insitu::core {
namespace {

// Longer words are never a slip of the fingers, and the distance is quadratic in the length.
constexpr std::size_t longest_word = 128;

char lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

bool begins_with(std::string_view text, std::string_view beginning) {
  return text.size() >= beginning.size() &&
         std::equal(beginning.begin(), beginning.end(), text.begin(),
                    [](char a, char b) { return lower(a) == lower(b); });
}

std::size_t allowed_edits(std::size_t length) {
  if (length <= 3)
    return 1;
  return length <= 6 ? 2 : length / 3;
}

} // namespace

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before_last(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j)
    row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::swap(before_last, last);
    std::swap(last, row);
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = last[j - 1] + (lower(a[i - 1]) == lower(b[j - 1]) ? 0 : 1);
      row[j] = std::min({replaced, last[j] + 1, row[j - 1] + 1});
      if (i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) &&
          lower(a[i - 2]) == lower(b[j - 1]))
        row[j] = std::min(row[j], before_last[j - 2] + 1);
    }
  }
  return row[b.size()];
}

std::string suggest(std::string_view word, const std::vector<std::string>& candidates) {
  if (word.empty() || word.size() > longest_word)
    return {};
  const std::string* best = nullptr;
  std::size_t best_distance = allowed_edits(word.size()) + 1;
  for (const std::string& candidate : candidates) {
    // The lengths alone bound the distance from below.
    if (candidate.size() >= word.size() + best_distance ||
        word.size() >= candidate.size() + best_distance)
      continue;
    const std::size_t distance = edit_distance(word, candidate);
    // An edit of every letter is another word.
    if (distance < best_distance && distance < std::max(word.size(), candidate.size())) {
      best = &candidate;
      best_distance = distance;
    }
  }
  if (best == nullptr && word.size() >= 3) {
    for (const std::string& candidate : candidates)
      if (begins_with(candidate, word))
        return candidate;
  }
  return best != nullptr ? *best : std::string();
}

std::string did_you_mean(std::string_view word, const std::vector<std::string>& candidates) {
  const std::string nearest = suggest(word, candidates);
  return nearest.empty() ? std::string() : "; did you mean '" + nearest + "'?";
}

} // namespace insitu::core
