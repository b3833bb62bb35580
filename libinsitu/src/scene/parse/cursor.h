#pragma once

#include <cstdint>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/suggest.h"
#include "math/vec.h"
#include "scene/parse/document.h"

namespace insitu::scene {

/// A word of the scene file and what it stands for.
template <class T>
struct Choice {
  const char* name;
  T value;
};

/// Numbers from `low` to `high`, both allowed unless `open_low`.
struct Interval {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool open_low = false;
};
constexpr Interval positive{0, std::numeric_limits<double>::infinity(), true};

/// A node of the document together with its path ("frames[0].volume") and the problems it adds to.
/// The reading functions return nothing where the node is not what they read, and have then noted
/// the problem.
class Cursor {
public:
  Cursor(const YamlNode& node, std::string path, Problems& problems)
      : node_(&node), path_(std::move(path)), problems_(&problems) {}

  const YamlNode& node() const { return *node_; }
  const std::string& path() const { return path_; }
  Problems& problems() const { return *problems_; }
  int line() const { return node_->line; }

  bool is_list() const { return node_->kind == YamlNode::Kind::list; }
  bool is_map() const { return node_->kind == YamlNode::Kind::map; }
  bool is_text() const { return node_->kind == YamlNode::Kind::scalar; }

  /// Notes "file:line: path: message".
  void fail(const std::string& message) const;
  /// Notes that `expected` was expected, and what was found.
  void expected(const std::string& expected) const;

  std::optional<double> number(const Interval& interval = {}) const;
  std::optional<std::int64_t> integer(std::int64_t low, std::int64_t high) const;
  std::optional<bool> boolean() const;
  /// A text that is not empty.
  std::optional<std::string> text() const;
  /// A list of three finite numbers.
  std::optional<math::Vec3d> vector() const;
  /// A list of `count` numbers, or with 0 of any but none.
  std::optional<std::vector<double>> numbers(std::size_t count,
                                             const Interval& interval = {}) const;

  /// The items of a list, or nothing for what is none.
  std::optional<std::vector<Cursor>> items() const;

  /// One of the words.
  template <class T>
  std::optional<T> choice(std::initializer_list<Choice<T>> choices) const {
    const auto word = text();
    if (!word) {
      return std::nullopt;
    }
    std::vector<std::string> names;
    for (const Choice<T>& one : choices) {
      if (*word == one.name) {
        return one.value;
      }
      names.emplace_back(one.name);
    }
    fail_choice(*word, names);
    return std::nullopt;
  }

private:
  void fail_choice(const std::string& word, const std::vector<std::string>& names) const;

  const YamlNode* node_;
  std::string path_;
  Problems* problems_;
};

/// The entries of a map whose keys are known. Keys that are not, and repeated ones, are noted at
/// construction.
class MapReader {
public:
  MapReader(const Cursor& cursor, std::vector<std::string> keys);

  /// False where the node is no map; then no key is found and none is missed.
  explicit operator bool() const { return is_map_; }
  const Cursor& cursor() const { return cursor_; }

  bool has(const std::string& key) const { return index(key) >= 0; }
  std::optional<Cursor> find(const std::string& key) const;
  /// As find(), and notes that the key is missing.
  std::optional<Cursor> require(const std::string& key) const;

private:
  int index(const std::string& key) const;

  Cursor cursor_;
  std::vector<std::string> keys_;
  std::vector<const YamlNode::Entry*> entries_; // one for each key; null: absent
  bool is_map_;
};

/// Gives `out` the value where there is one.
template <class To, class From>
void assign(To& out, std::optional<From>&& value) {
  if (value) {
    out = std::move(*value);
  }
}

} // namespace insitu::scene
