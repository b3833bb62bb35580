#include "measure.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <numeric>
#include <stdexcept>
#include <sys/resource.h>
#include <unistd.h>
#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace insitu::bench {

Series::Clock::Clock() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) { return double(t.tv_sec) + 1e-6 * double(t.tv_usec); };
  cpu = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  wall = std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void Series::add(const Clock& before) {
  const Clock now;
  wall_.push_back(now.wall - before.wall);
  cpu_.push_back(now.cpu - before.cpu);
}

Series Series::plus(const Series& other) const {
  Series out;
  for (std::size_t i = 0; i < std::min(wall_.size(), other.wall_.size()); ++i) {
    out.wall_.push_back(wall_[i] + other.wall_[i]);
    out.cpu_.push_back(cpu_[i] + other.cpu_[i]);
  }
  return out;
}

double Series::at(std::vector<double> values, double quantile) {
  if (values.empty())
    return 0.0;
  std::sort(values.begin(), values.end());
  const double place = quantile * double(values.size() - 1);
  const auto below = std::size_t(place);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return std::lerp(values[below], values[above], place - double(below));
}

double Series::cpu_sum() const {
  return std::accumulate(cpu_.begin(), cpu_.end(), 0.0);
}

double power_of(const std::vector<double>& x, const std::vector<double>& y) {
  double sum_x = 0, sum_y = 0, sum_xx = 0, sum_xy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double u = std::log(x[i]), v = std::log(y[i]);
    sum_x += u;
    sum_y += v;
    sum_xx += u * u;
    sum_xy += u * v;
  }
  const auto n = double(x.size());
  return (n * sum_xy - sum_x * sum_y) / (n * sum_xx - sum_x * sum_x);
}

std::int64_t heap_bytes() {
#if defined(__GLIBC__) && (__GLIBC__ > 2 || __GLIBC_MINOR__ >= 33)
  const auto info = mallinfo2();
  return std::int64_t(info.uordblks) + std::int64_t(info.hblkhd);
#else
  return 0;
#endif
}

namespace {
std::int64_t status_bytes(const std::string& key) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with(key))
      return 1024 * std::atoll(line.c_str() + key.size());
  return 0;
}
} // namespace

std::int64_t start_resident_peak() {
#if defined(__GLIBC__)
  malloc_trim(0);
#endif
  std::ofstream("/proc/self/clear_refs") << "5";
  return status_bytes("VmRSS:");
}

std::int64_t resident_peak() {
  return status_bytes("VmHWM:");
}

void write_file(const std::string& option, const std::string& file, const std::string& text) {
  std::ofstream out(file, std::ios::trunc);
  out << text;
  out.close();
  if (!out)
    throw std::runtime_error(option + " " + file + ": writing failed");
}

void progress(const std::string& text) {
  static const bool terminal = isatty(STDERR_FILENO) == 1;
  if (terminal)
    std::fprintf(stderr, "\r\033[K%s", text.c_str());
}

} // namespace insitu::bench
