#include "scene/parse/cursor.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace insitu::scene {
namespace {

std::string shown(double value) {
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  return {buffer, end};
}

std::string shown(const Interval& interval) {
  if (std::isinf(interval.low) && std::isinf(interval.high)) {
    return "a finite number";
  }
  if (std::isinf(interval.high)) {
    return (interval.open_low ? "a number above " : "a number of at least ") + shown(interval.low);
  }
  return (interval.open_low ? "a number above " : "a number from ") + shown(interval.low) +
         (interval.open_low ? " and up to " : " to ") + shown(interval.high);
}

/// The whole of `text` as a number of the type; independent of the locale, unlike the C library's
/// functions.
template <class T>
bool read_number(std::string_view text, T& value) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') {
    text.remove_prefix(1);
  }
  const char* end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, value);
  return result.ec == std::errc() && result.ptr == end;
}

std::string describe(const YamlNode& node) {
  switch (node.kind) {
  case YamlNode::Kind::nothing:
    return "nothing";
  case YamlNode::Kind::scalar:
    return (node.quoted ? "the text " : "") + quote(node.text);
  case YamlNode::Kind::list:
    return "a list of " + std::to_string(node.items.size());
  default:
    return "a map";
  }
}

std::string join(const std::vector<std::string>& words) {
  std::string all;
  for (const std::string& word : words) {
    all += (all.empty() ? "" : ", ") + word;
  }
  return all;
}

} // namespace

void Cursor::fail(const std::string& message) const {
  problems_->add(node_->line, path_.empty() ? message : path_ + ": " + message);
}

void Cursor::expected(const std::string& expected) const {
  fail(expected + " expected, " + describe(*node_) + " found");
}

std::optional<double> Cursor::number(const Interval& interval) const {
  double value = 0;
  if (!is_text() || node_->quoted || !read_number(node_->text, value) || !std::isfinite(value) ||
      value < interval.low || value > interval.high ||
      (interval.open_low && value == interval.low)) {
    expected(shown(interval));
    return std::nullopt;
  }
  return value;
}

std::optional<std::int64_t> Cursor::integer(std::int64_t low, std::int64_t high) const {
  std::int64_t value = 0;
  if (!is_text() || node_->quoted || !read_number(node_->text, value) || value < low ||
      value > high) {
    expected("an integer from " + std::to_string(low) + " to " + std::to_string(high));
    return std::nullopt;
  }
  return value;
}

std::optional<bool> Cursor::boolean() const {
  if (is_text() && !node_->quoted) {
    if (node_->text == "true" || node_->text == "True" || node_->text == "TRUE") {
      return true;
    }
    if (node_->text == "false" || node_->text == "False" || node_->text == "FALSE") {
      return false;
    }
  }
  expected("true or false");
  return std::nullopt;
}

std::optional<std::string> Cursor::text() const {
  if (!is_text() || node_->text.empty()) {
    expected("a text");
    return std::nullopt;
  }
  return node_->text;
}

std::optional<math::Vec3d> Cursor::vector() const {
  const auto values = numbers(3);
  if (!values) {
    return std::nullopt;
  }
  return math::Vec3d{(*values)[0], (*values)[1], (*values)[2]};
}

std::optional<std::vector<double>> Cursor::numbers(std::size_t count,
                                                   const Interval& interval) const {
  if (!is_list() || node_->items.empty() || (count > 0 && node_->items.size() != count)) {
    expected(count > 0 ? "a list of " + std::to_string(count) + " numbers" : "a list of numbers");
    return std::nullopt;
  }
  std::vector<double> values;
  for (std::size_t i = 0; i < node_->items.size(); ++i) {
    const auto value = Cursor(*node_->items[i], path_ + "[" + std::to_string(i) + "]", *problems_)
                           .number(interval);
    if (!value) {
      return std::nullopt;
    }
    values.push_back(*value);
  }
  return values;
}

std::optional<std::vector<Cursor>> Cursor::items() const {
  if (!is_list()) {
    expected("a list");
    return std::nullopt;
  }
  std::vector<Cursor> all;
  all.reserve(node_->items.size());
  for (std::size_t i = 0; i < node_->items.size(); ++i) {
    all.emplace_back(*node_->items[i], path_ + "[" + std::to_string(i) + "]", *problems_);
  }
  return all;
}

void Cursor::fail_choice(const std::string& word, const std::vector<std::string>& names) const {
  fail(quote(word) + " is not one of " + join(names) + core::did_you_mean(word, names));
}

namespace {

/// What the key is called now, if it was retired from this map; else null.
const RetiredKey* find_retired(const Cursor& map, const std::string& key) {
  const std::span<const RetiredKey> all = map.problems().retired();
  if (all.empty())
    return nullptr;
  std::string place; // the path without indices
  bool within = false;
  for (const char c : map.path()) {
    within = within || c == '[';
    if (!within)
      place += c;
    within = within && c != ']';
  }
  const auto found = std::find_if(all.begin(), all.end(), [&](const RetiredKey& r) {
    return place == r.place && key == r.old;
  });
  return found == all.end() ? nullptr : &*found;
}

} // namespace

MapReader::MapReader(const Cursor& cursor, std::vector<std::string> keys)
    : cursor_(cursor), keys_(std::move(keys)), entries_(keys_.size(), nullptr),
      is_map_(cursor.is_map()) {
  if (!is_map_) {
    cursor.expected("a map of " + join(keys_));
    return;
  }
  const std::string place = cursor.path().empty() ? "the scene" : cursor.path();
  Problems& problems = cursor.problems();
  for (const YamlNode::Entry& entry : cursor.node().entries) {
    const auto position = [&](const std::string& key) {
      const auto found = std::find(keys_.begin(), keys_.end(), key);
      return found == keys_.end() ? -1 : static_cast<int>(found - keys_.begin());
    };
    int at = position(entry.key);
    if (const RetiredKey* const retired = at < 0 ? find_retired(cursor, entry.key) : nullptr) {
      at = position(retired->now);
      problems.warn(entry.line, "key " + quote(entry.key) + " in " + place + " is called " +
                                    quote(retired->now) + " now; version " + retired->gone +
                                    " will not know the old name");
    }
    if (at < 0) {
      // Suggestions cost time: none for problems that will only be counted.
      std::string near = problems.full() ? "" : core::did_you_mean(entry.key, keys_);
      if (entry.key == "<<") {
        near = "; merge keys are not part of YAML 1.2";
      }
      problems.add(entry.line, "key " + quote(entry.key) + " is unknown in " + place + near +
                                   " (keys: " + join(keys_) + ")");
    } else if (entries_[static_cast<std::size_t>(at)] != nullptr) {
      problems.add(entry.line,
                   "key " + quote(entry.key) + " is given twice in " + place + " (first in line " +
                       std::to_string(entries_[static_cast<std::size_t>(at)]->line) + ")");
    } else {
      entries_[static_cast<std::size_t>(at)] = &entry;
    }
  }
}

int MapReader::index(const std::string& key) const {
  const auto found = std::find(keys_.begin(), keys_.end(), key);
  const auto at = found - keys_.begin();
  return found != keys_.end() && entries_[static_cast<std::size_t>(at)] != nullptr
             ? static_cast<int>(at)
             : -1;
}

std::optional<Cursor> MapReader::find(const std::string& key) const {
  const int at = index(key);
  if (at < 0) {
    return std::nullopt;
  }
  const std::string path = cursor_.path().empty() ? key : cursor_.path() + "." + key;
  return Cursor(*entries_[static_cast<std::size_t>(at)]->value, path, cursor_.problems());
}

std::optional<Cursor> MapReader::require(const std::string& key) const {
  auto found = find(key);
  if (!found && is_map_) {
    cursor_.problems().add(cursor_.line(),
                           "key '" + key + "' is missing in " +
                               (cursor_.path().empty() ? "the scene" : cursor_.path()));
  }
  return found;
}

} // namespace insitu::scene
