#include "accuracy/sweep.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "format.h"

namespace insitu::bench::accuracy {

std::vector<std::string> Sweep::groups() const {
  std::vector<std::string> out;
  for (const Setting& s : settings)
    if (std::find(out.begin(), out.end(), s.group) == out.end())
      out.push_back(s.group);
  return out;
}

std::vector<const Setting*> Sweep::of(const std::string& group, bool peers) const {
  std::vector<const Setting*> out;
  for (const Setting& s : settings)
    if (s.group == group && (peers || !s.is_peer))
      out.push_back(&s);
  return out;
}

const Setting* Sweep::find(const std::string& group, const std::string& name) const {
  for (const Setting& s : settings)
    if (s.group == group && s.name == name)
      return &s;
  return nullptr;
}

const Setting* Sweep::default_of(const std::string& group) const {
  for (const Setting& s : settings)
    if (s.group == group && s.is_default)
      return &s;
  return nullptr;
}

double work(const Setting& s) {
  return s.work;
}
double seconds(const Setting& s) {
  return s.seconds();
}

std::vector<const Setting*> front(const Sweep& sweep, const std::string& group, const Cost& cost) {
  std::vector<const Setting*> all = sweep.of(group);
  std::erase_if(all, [&](const Setting* s) { return !(cost(*s) > 0.0); });
  std::stable_sort(all.begin(), all.end(), [&](const Setting* a, const Setting* b) {
    return std::pair(cost(*a), a->error) < std::pair(cost(*b), b->error);
  });
  std::vector<const Setting*> out;
  for (const Setting* s : all)
    if (out.empty() || s->error < out.back()->error)
      out.push_back(s);
  return out;
}

double default_over_front(const Sweep& sweep, const std::string& group, const Cost& cost) {
  const Setting* chosen = sweep.default_of(group);
  if (!chosen || !(cost(*chosen) > 0.0))
    return 0.0;
  double least = cost(*chosen);
  for (const Setting* s : sweep.of(group))
    if (cost(*s) > 0.0 && s->error <= 1.01 * chosen->error)
      least = std::min(least, cost(*s));
  return cost(*chosen) / least;
}

std::vector<std::string> never_on_a_front(const Sweep& sweep, const Cost& cost) {
  std::set<std::string> winners;
  std::vector<std::string> out;
  for (const std::string& group : sweep.groups())
    for (const Setting* s : front(sweep, group, cost))
      winners.insert(s->name);
  for (const Setting& s : sweep.settings)
    if (!s.is_peer && cost(s) > 0.0 && !winners.contains(s.name) &&
        std::find(out.begin(), out.end(), s.name) == out.end())
      out.push_back(s.name);
  return out;
}

namespace {
/// Commas and quotes of a text would end its column.
std::string column(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos)
    return text;
  std::string out = "\"";
  for (const char c : text)
    out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}
std::string value(double x) {
  return std::isfinite(x) ? format("%.6g", x) : "";
}
} // namespace

std::string csv(const Sweep& sweep) {
  std::string out = "group,setting," + column(sweep.error_label) +
                    ",seconds,seconds_least,"
                    "seconds_most," +
                    column(sweep.work_label) + ",default,on_front,peer";
  for (const std::string& label : sweep.more_labels)
    out += "," + column(label);
  out += "\n";
  for (const std::string& group : sweep.groups()) {
    const std::vector<const Setting*> best = front(sweep, group, seconds);
    for (const Setting* s : sweep.of(group, true)) {
      const bool on_front = std::find(best.begin(), best.end(), s) != best.end();
      out += column(s->group) + "," + column(s->name) + "," + value(s->error) + "," +
             value(s->seconds()) + "," + value(s->time.min() / s->items) + "," +
             value(s->time.max() / s->items) + "," + (s->work > 0.0 ? value(s->work) : "") + "," +
             (s->is_default ? "1" : "0") + "," + (on_front ? "1" : "0") + "," +
             (s->is_peer ? "1" : "0");
      for (const double m : s->more)
        out += "," + value(m);
      out += "\n";
    }
  }
  return out;
}

} // namespace insitu::bench::accuracy
