#include "report/json.h"

#include <algorithm>
#include <cmath>

#include "report/format.h"

namespace insitu::bench {

namespace {

void append(std::string& out, const Json& json, std::size_t depth) {
  if (!json.is_structured()) {
    out += json.dump(-1, ' ', false, Json::error_handler_t::replace);
    return;
  }
  const bool by_lines = depth == 0 || std::any_of(json.begin(), json.end(), [](const Json& member) {
                          return member.is_structured() && !member.empty();
                        });
  const std::string line = "\n" + std::string(2 * depth, ' ');
  const char* separator = "";
  out += json.is_object() ? '{' : '[';
  for (const auto& [key, member] : json.items()) {
    out += separator + (by_lines ? line + "  " : "");
    if (json.is_object())
      out += Json(key).dump() + ": ";
    append(out, member, depth + 1);
    separator = by_lines ? "," : ", ";
  }
  out += by_lines ? line : "";
  out += json.is_object() ? '}' : ']';
}

} // namespace

Json number(double value, int digits) {
  // As text, so that a whole number has no point.
  return std::isfinite(value) ? Json::parse(format("%.*g", digits, value)) : Json();
}

std::string json_text(const Json& json) {
  std::string out;
  append(out, json, 0);
  return out + "\n";
}

} // namespace insitu::bench
