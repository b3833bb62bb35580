#pragma once

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <sys/wait.h>

/// Runs of insitu-bench, and what they wrote.
namespace insitu::test {

struct Outcome {
  int exit_code = -1;
  std::string out;
};

inline Outcome run(const std::string& arguments, const std::string& redirect = "2>&1") {
  Outcome r;
  std::string command = INSITU_BENCH;
  command.append(" ").append(arguments).append(" ").append(redirect);
  FILE* pipe = popen(command.c_str(), "r");
  if (!pipe)
    return r;
  char text[4096];
  for (std::size_t n; (n = fread(text, 1, sizeof text, pipe)) > 0;)
    r.out.append(text, n);
  const int status = pclose(pipe);
  r.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return r;
}

/// The number after the first "key": at or behind `from`; NaN if there is none.
inline double number(const std::string& json, const std::string& key, std::size_t from = 0) {
  const std::size_t at = json.find("\"" + key + "\": ", from);
  if (at == std::string::npos)
    return std::nan("");
  const std::string value = json.substr(at + key.size() + 4, 40);
  char* end = nullptr;
  const double x = std::strtod(value.c_str(), &end);
  return end == value.c_str() ? std::nan("") : x;
}

} // namespace insitu::test
