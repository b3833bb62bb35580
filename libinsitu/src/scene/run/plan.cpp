#include "scene/run/plan.h"

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

void Plan::need(std::string item, std::int64_t bytes, std::string why, Held held) {
  add(std::move(item), bytes, false, std::move(why), held);
}

void Plan::need_at_most(std::string item, std::int64_t bytes, std::string why, Held held) {
  add(std::move(item), bytes, true, std::move(why), held);
}

void Plan::add(std::string item, std::int64_t bytes, bool at_most, std::string why, Held held) {
  const bool shared = held == Held::kept && bytes >= 0 &&
                      std::any_of(entries_.begin(), entries_.end(), [&](const Entry& e) {
                        return e.needed && e.mesh == mesh_ && e.item == item;
                      });
  entries_.push_back(
      {of_, mesh_, std::move(item), true, shared, bytes, at_most, held, std::move(why)});
}

void Plan::skip(std::string item, std::string why) {
  entries_.push_back(
      {of_, mesh_, std::move(item), false, false, -1, false, Held::kept, std::move(why)});
}

void Plan::tell(std::string item, const Decision& decision, std::int64_t bytes, Held held) {
  if (decision)
    need(std::move(item), bytes, decision.why, held);
  else
    skip(std::move(item), decision.why);
}

void Plan::tell_at_most(std::string item, const Decision& decision, std::int64_t bytes, Held held) {
  if (decision)
    need_at_most(std::move(item), bytes, decision.why, held);
  else
    skip(std::move(item), decision.why);
}

std::int64_t Plan::kept_bytes() const {
  std::int64_t sum = 0;
  for (const Entry& e : entries_)
    sum += e.needed && !e.shared && e.bytes > 0 && e.held == Held::kept ? e.bytes : 0;
  return sum;
}

std::int64_t Plan::bytes() const {
  std::int64_t most = 0, of_item = 0;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const Entry& e = entries_[i];
    if (i > 0 && e.of != entries_[i - 1].of)
      of_item = 0;
    of_item += e.needed && e.bytes > 0 && e.held == Held::while_executed ? e.bytes : 0;
    most = std::max(most, of_item);
  }
  return kept_bytes() + most;
}

std::string Plan::text() const {
  std::string text;
  const Entry* before = nullptr;
  for (const Entry& e : entries_) {
    if (!before || before->of != e.of || before->mesh != e.mesh)
      text += (e.of.empty() ? "" : e.of + " of ") + "mesh '" + e.mesh + "'\n";
    before = &e;
    std::string line = e.needed ? "  needed   " : "  skipped  ";
    line += e.item;
    pad(line, 52);
    if (e.shared)
      line += "shared";
    else if (e.bytes >= 0)
      line += (e.at_most ? "<= " : "") + readable(e.bytes);
    pad(line, 64);
    text += line + e.why + "\n";
  }
  return text + "beside what meshes hold, " + readable(kept_bytes()) +
         " are kept, and with what is held for a while it is at most " + readable(bytes()) + "\n";
}

} // namespace insitu::scene
