#include "scene/parse/problems.h"

#include <algorithm>

#include "core/status.h"

namespace insitu::scene {

std::string quote(std::string_view text) {
  constexpr std::size_t longest = 60;
  std::size_t end = std::min(text.size(), longest);
  while (end > 0 && end < text.size() && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) {
    --end; // not within a UTF-8 letter
  }
  std::string quoted = "'";
  for (const char c : text.substr(0, end)) {
    const auto byte = static_cast<unsigned char>(c);
    quoted += byte < 0x20 || byte == 0x7F ? '?' : c;
  }
  quoted += end < text.size() ? "...'" : "'";
  return quoted;
}

void Problems::add(int line, int column, const std::string& message) {
  if (count_++ < most) {
    std::string place = file_;
    for (const int number : {line, column}) {
      if (line > 0 && number > 0) {
        place += ':';
        place += std::to_string(number);
      }
    }
    problems_.push_back({line, place + ": " + message});
  }
}

void Problems::warn(int line, const std::string& message) {
  if (warnings_.size() < most)
    warnings_.push_back(file_ + ":" + std::to_string(line) + ": " + message);
}

std::string Problems::message() const {
  std::vector<Problem> sorted = problems_;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Problem& a, const Problem& b) { return a.line < b.line; });
  std::string all;
  for (const Problem& problem : sorted) {
    all += (all.empty() ? "" : "\n") + problem.text;
  }
  if (count_ > most) {
    all += "\n" + file_ + ": and " + std::to_string(count_ - most) + " more";
  }
  return all;
}

void Problems::throw_if_any() const {
  if (count_ > 0) {
    throw core::Error(INSITU_ERROR_SCENE, message());
  }
}

} // namespace insitu::scene
