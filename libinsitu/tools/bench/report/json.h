#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace insitu::bench {

/// Keys stay in the order in which they were given.
using Json = nlohmann::ordered_json;

/// A figure of so many digits; null unless finite.
Json number(double value, int digits = 9);

/// What holds lists or objects has its members on a line each, as has the whole; the rest is on one
/// line.
std::string json_text(const Json& json);

} // namespace insitu::bench
