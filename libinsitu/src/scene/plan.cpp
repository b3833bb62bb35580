#include "scene/plan.h"

#include <algorithm>
#include <cstdio>

namespace insitu::scene {

namespace {

/// "1.5 MB": three digits, decimal prefixes.
std::string readable(std::int64_t bytes) {
  constexpr const char* units[] = {"B", "kB", "MB", "GB", "TB"};
  double value = double(bytes);
  std::size_t unit = 0;
  for (; value >= 999.5 && unit + 1 < std::size(units); ++unit)
    value /= 1000;
  char text[32];
  std::snprintf(text, sizeof text, unit == 0 || value >= 99.95 ? "%.0f %s" : "%.1f %s", value,
                units[unit]);
  return text;
}

void pad(std::string& line, std::size_t width) {
  line.append(line.size() < width ? width - line.size() : 1, ' ');
}

} // namespace

void Plan::begin(std::string of, std::string mesh) {
  of_ = std::move(of);
  mesh_ = std::move(mesh);
}

void Plan::need(std::string item, std::int64_t bytes, std::string why) {
  const bool shared = std::any_of(entries_.begin(), entries_.end(), [&](const Entry& e) {
    return e.needed && e.mesh == mesh_ && e.item == item && bytes >= 0;
  });
  entries_.push_back({of_, mesh_, std::move(item), true, shared, bytes, std::move(why)});
}

void Plan::skip(std::string item, std::string why) {
  entries_.push_back({of_, mesh_, std::move(item), false, false, -1, std::move(why)});
}

std::int64_t Plan::bytes() const {
  std::int64_t sum = 0;
  for (const Entry& e : entries_)
    sum += e.needed && !e.shared && e.bytes > 0 ? e.bytes : 0;
  return sum;
}

std::string Plan::text() const {
  std::string text;
  const std::string* of = nullptr;
  for (const Entry& e : entries_) {
    if (!of || *of != e.of)
      text += e.of + " of mesh '" + e.mesh + "'\n";
    of = &e.of;
    std::string line = e.needed ? "  needed   " : "  skipped  ";
    line += e.item;
    pad(line, 52);
    line += e.shared ? "shared" : e.bytes >= 0 ? readable(e.bytes) : "";
    pad(line, 62);
    text += line + e.why + "\n";
  }
  return text + "beside the trees, at most " + readable(bytes()) + "\n";
}

} // namespace insitu::scene
