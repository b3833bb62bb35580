#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "scene/parse/retired_keys.h"

namespace insitu::scene {

/// `text` within single quotes for a message: control bytes become '?', and what goes beyond 60
/// bytes becomes "...".
std::string quote(std::string_view text);

/// The problems of one file, gathered so that they are all reported at once.
class Problems {
public:
  /// Problems beyond this many are only counted.
  static constexpr std::size_t most = 20;

  /// retired: keys that still work, with a warning.
  explicit Problems(std::string file, std::span<const RetiredKey> retired = retired_keys())
      : file_(std::move(file)), retired_(retired) {}

  /// Notes "file:line: message"; with a `column`, "file:line:column: message". A line of 0 is left
  /// out.
  void add(int line, const std::string& message) { add(line, 0, message); }
  void add(int line, int column, const std::string& message);

  /// Notes "file:line: message" of what works all the same; at most so many are kept.
  void warn(int line, const std::string& message);
  const std::vector<std::string>& warnings() const { return warnings_; }

  std::span<const RetiredKey> retired() const { return retired_; }
  const std::string& file() const { return file_; }
  std::size_t count() const { return count_; }
  bool full() const { return count_ >= most; }

  /// All problems in the order of their lines, one below the other.
  std::string message() const;
  /// Throws core::Error(INSITU_ERROR_SCENE, message()) where there is a problem.
  void throw_if_any() const;

private:
  struct Problem {
    int line;
    std::string text;
  };
  std::string file_;
  std::vector<Problem> problems_;
  std::size_t count_ = 0;
  std::span<const RetiredKey> retired_;
  std::vector<std::string> warnings_;
};

} // namespace insitu::scene
