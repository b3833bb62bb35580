#pragma once

#include <string>
#include <sys/types.h>
#include <vector>
#include <yaml-cpp/yaml.h>

#include "unit/output/folder.h"

/// Chromium without a window, driven through its debugging pipe: what a reader would see and do.
namespace test {

/// The first of the usual names that is on the path; empty if there is none.
std::string find_chromium();

class Browser {
public:
  /// Throws std::runtime_error if it does not start.
  explicit Browser(const std::string& program);
  ~Browser();
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  /// Opens a file and waits until it has loaded.
  void open(const std::string& path);
  void size(int width, int height);
  void dark(bool on);
  /// The value of an expression, of a promise when it is kept. Throws what it throws.
  YAML::Node evaluate(const std::string& expression);
  std::string text(const std::string& expression) { return evaluate(expression).as<std::string>(); }
  /// Whether the expression became true within some seconds.
  bool wait(const std::string& expression, double seconds = 10);
  /// A click of the mouse at a place of an element: 0 is its left edge, 1 its right one.
  void click(const std::string& selector, double across = 0.5);
  /// A key, as KeyboardEvent.key names it, such as "ArrowLeft".
  void press(const std::string& key);
  void screenshot(const std::string& path);

  std::vector<std::string> problems; ///< exceptions of the page and errors of loading
  std::vector<std::string> requests; ///< addresses

private:
  YAML::Node call(const std::string& method, const std::string& parameters = "{}");
  YAML::Node receive();
  void note(const YAML::Node& event);

  Folder profile_;
  pid_t child_ = -1;
  int to_ = -1, from_ = -1;
  int last_id_ = 0;
  std::string session_, buffer_;
};

} // namespace test
