#include "output/annotate/time_label.h"

#include <charconv>

#include "core/status.h"

namespace insitu::output {

namespace {

constexpr int most_digits = 17;     ///< tell all doubles apart
constexpr int most_characters = 20; ///< of a cycle

[[noreturn]] void refuse(const std::string& message) {
  throw core::Error(INSITU_ERROR_ARGUMENT, message);
}

[[noreturn]] void refuse_field(std::string_view field) {
  refuse("'{" + std::string(field) +
         "}' is neither {time} nor {cycle}, alone or as in {time:.3f}, {time:.2e}, {time:.4g}, "
         "{cycle:6} or {cycle:06}; a brace itself is {{ or }}");
}

/// Takes a number from 0 to `most` off the text, which has no more than two digits.
bool take_number(std::string_view& text, int most, int& number) {
  if (text.empty() || text[0] < '0' || text[0] > '9')
    return false;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || number > most)
    return false;
  text.remove_prefix(std::size_t(end - text.data()));
  return true;
}

} // namespace

std::string printed(double value, char notation, int digits) {
  const std::chars_format format = notation == 'f'   ? std::chars_format::fixed
                                   : notation == 'e' ? std::chars_format::scientific
                                                     : std::chars_format::general;
  char text[400];
  std::string out(text, std::to_chars(text, text + sizeof text, value, format, digits).ptr);
  if (out.front() == '-' && out.find_first_not_of("-0.e+") == std::string::npos)
    out.erase(0, 1);
  return out;
}

TimeLabel::TimeLabel(std::string_view format) {
  bool has_field = false;
  for (std::size_t at = 0; at < format.size();) {
    const char c = format[at];
    const bool twice = at + 1 < format.size() && format[at + 1] == c;
    if ((c == '{' || c == '}') && twice) {
      add_text(format.substr(at, 1));
      at += 2;
    } else if (c == '}') {
      refuse("'}' without '{'; a brace itself is {{ or }}");
    } else if (c == '{') {
      const std::size_t end = format.find('}', at);
      if (end == std::string_view::npos)
        refuse("'{' without '}'; a brace itself is {{ or }}");
      parts_.push_back(field_of(format.substr(at + 1, end - at - 1)));
      has_field = true;
      at = end + 1;
    } else {
      add_text(format.substr(at, 1));
      ++at;
    }
  }
  if (!has_field)
    refuse("a text with {time} or {cycle} expected");
}

void TimeLabel::add_text(std::string_view text) {
  if (parts_.empty() || parts_.back().kind != Part::Kind::text)
    parts_.emplace_back();
  parts_.back().text += text;
}

TimeLabel::Part TimeLabel::field_of(std::string_view field) {
  Part part;
  std::string_view rest = field;
  const std::size_t colon = field.find(':');
  const std::string_view name = field.substr(0, colon);
  if (name != "time" && name != "cycle")
    refuse_field(field);
  part.kind = name == "time" ? Part::Kind::time : Part::Kind::cycle;
  if (part.kind == Part::Kind::cycle)
    part.digits = 0;
  if (colon == std::string_view::npos)
    return part;
  rest.remove_prefix(colon + 1);
  if (part.kind == Part::Kind::time) {
    if (rest.empty() || rest[0] != '.')
      refuse_field(field);
    rest.remove_prefix(1);
    if (!take_number(rest, most_digits, part.digits) || rest.size() != 1 ||
        std::string_view("feg").find(rest[0]) == std::string_view::npos)
      refuse_field(field);
    part.notation = rest[0];
    return part;
  }
  part.zeros = !rest.empty() && rest[0] == '0';
  if (!take_number(rest, most_characters, part.digits) || !rest.empty() || part.digits == 0)
    refuse_field(field);
  return part;
}

std::string TimeLabel::operator()(double time, std::int64_t cycle) const {
  std::string label;
  for (const Part& part : parts_) {
    if (part.kind == Part::Kind::text) {
      label += part.text;
    } else if (part.kind == Part::Kind::time) {
      label += printed(time, part.notation, part.digits);
    } else {
      std::string number = std::to_string(cycle);
      if (number.size() < std::size_t(part.digits)) {
        const std::size_t missing = std::size_t(part.digits) - number.size();
        number.insert(part.zeros && cycle < 0 ? 1 : 0, missing, part.zeros ? '0' : ' ');
      }
      label += number;
    }
  }
  return label;
}

} // namespace insitu::output
