#include "core/status.h"
#include "output/files/text.h"
#include "scene/parse/parse_parts.h"

namespace insitu::scene {
namespace {

bool is_boolean(const Cursor& cursor) {
  static const std::set<std::string> words{"true", "True", "TRUE", "false", "False", "FALSE"};
  return cursor.is_text() && !cursor.node().quoted && words.contains(cursor.node().text);
}

/// Reads a text that can be drawn into images.
std::optional<std::string> drawn_text(const Cursor& cursor) {
  const auto text = cursor.text();
  if (!text) {
    return std::nullopt;
  }
  const std::string unknown = output::first_without_glyph(*text);
  if (!unknown.empty()) {
    cursor.fail("the character " + quote(unknown) +
                " cannot be drawn; ASCII, signs of units and superscripts can");
    return std::nullopt;
  }
  return text;
}

std::optional<ScalarBar> parse_scalar_bar(const Cursor& cursor) {
  if (is_boolean(cursor)) {
    return *cursor.boolean() ? std::optional(ScalarBar{}) : std::nullopt;
  }
  if (!cursor.is_map()) {
    cursor.expected("true or false, or a map of 'title' and 'unit',");
    return std::nullopt;
  }
  ScalarBar bar;
  const MapReader map(cursor, {"title", "unit"});
  if (const auto title = map.find("title")) {
    assign(bar.title, drawn_text(*title));
  }
  if (const auto unit = map.find("unit")) {
    assign(bar.unit, drawn_text(*unit));
  }
  return bar;
}

std::optional<output::TimeLabel> parse_time_label(const Cursor& cursor) {
  if (is_boolean(cursor)) {
    return *cursor.boolean() ? std::optional(output::TimeLabel()) : std::nullopt;
  }
  if (!cursor.is_text() || cursor.node().text.find_first_of("{}") == std::string::npos) {
    cursor.expected("true or false, or a text within quotes with {time} or {cycle},");
    return std::nullopt;
  }
  const auto format = drawn_text(cursor);
  try {
    return format ? std::optional(output::TimeLabel(*format)) : std::nullopt;
  } catch (const core::Error& e) {
    cursor.fail(e.what());
    return std::nullopt;
  }
}

} // namespace

void parse_labels(const MapReader& map, Frame& frame) {
  if (const auto bar = map.find("scalar_bar")) {
    frame.scalar_bar = parse_scalar_bar(*bar);
  }
  if (const auto label = map.find("time_label")) {
    frame.time_label = parse_time_label(*label);
  }
  if (const auto axes = map.find("axes")) {
    assign(frame.axes, axes->boolean());
  }
}

} // namespace insitu::scene
