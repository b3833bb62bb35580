#pragma once

#include <cstdio>
#include <string>

namespace insitu::bench {

/// std::snprintf into a string, cut at 511 characters.
template <class... A>
std::string format(const char* pattern, A... a) {
  char text[512];
  std::snprintf(text, sizeof text, pattern, a...);
  return text;
}

} // namespace insitu::bench
