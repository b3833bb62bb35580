#include "accuracy/sweep.h"

#include <algorithm>
#include <cmath>

#include "report/format.h"
#include "output/files/csv.h"

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

std::string method_of(const std::string& name) {
  return name.substr(0, name.find(','));
}

namespace {
/// Those of a group that have a place on its front.
std::vector<const Setting*> rivals(const Sweep& sweep, const std::string& group, const Cost& cost) {
  std::vector<const Setting*> out = sweep.of(group);
  std::erase_if(out, [&](const Setting* s) { return s->is_stand_in || !(cost(*s) > 0.0); });
  return out;
}
} // namespace

std::vector<const Setting*> front(const Sweep& sweep, const std::string& group, const Cost& cost) {
  std::vector<const Setting*> all = rivals(sweep, group, cost);
  std::stable_sort(all.begin(), all.end(), [&](const Setting* a, const Setting* b) {
    return std::pair(cost(*a), a->error) < std::pair(cost(*b), b->error);
  });
  std::vector<const Setting*> out;
  for (const Setting* s : all)
    if (out.empty() || s->error < out.back()->error)
      out.push_back(s);
  return out;
}

double over_front(const Sweep& sweep, const Setting& setting, const Cost& cost) {
  if (!(cost(setting) > 0.0))
    return 0.0;
  double least = cost(setting);
  for (const Setting* s : rivals(sweep, setting.group, cost))
    if (s->error <= 1.01 * setting.error)
      least = std::min(least, cost(*s));
  return cost(setting) / least;
}

double default_over_front(const Sweep& sweep, const std::string& group, const Cost& cost) {
  const Setting* chosen = sweep.default_of(group);
  return chosen ? over_front(sweep, *chosen, cost) : 0.0;
}

std::vector<Loser> losers(const Sweep& sweep) {
  constexpr double near = 1.1;
  struct Place {
    std::string name;
    double at_best = HUGE_VAL;
    bool wins = false;
  };
  std::vector<Place> settings, methods; // in the order of appearance
  const auto note = [](std::vector<Place>& in, const std::string& name, double over, bool wins) {
    auto at = std::find_if(in.begin(), in.end(), [&](const Place& p) { return p.name == name; });
    if (at == in.end())
      at = in.insert(in.end(), Place{name});
    at->at_best = std::min(at->at_best, over);
    at->wins = at->wins || wins;
  };
  for (const std::string& group : sweep.groups()) {
    const std::vector<const Setting*> all = rivals(sweep, group, seconds);
    for (const Setting* s : all) {
      const bool is_beaten = std::any_of(all.begin(), all.end(), [&](const Setting* other) {
        return other->error <= 1.01 * s->error && near * other->seconds() < s->seconds() &&
               other->most_seconds() < s->least_seconds();
      });
      const double over = over_front(sweep, *s, seconds);
      note(settings, s->name, over, !is_beaten);
      note(methods, method_of(s->name), over, !is_beaten);
    }
  }
  std::vector<Loser> out;
  for (const Place& m : methods)
    if (!m.wins)
      out.push_back({m.name, true, m.at_best});
  for (const Place& s : settings)
    if (!s.wins && std::none_of(out.begin(), out.end(), [&](const Loser& l) {
          return l.is_method && l.name == method_of(s.name);
        }))
      out.push_back({s.name, false, s.at_best});
  return out;
}

std::string say_losers(const Sweep& sweep) {
  std::string methods, settings;
  for (const Loser& l : losers(sweep)) {
    std::string& to = l.is_method ? methods : settings;
    to += (to.empty() ? "" : "; ") + l.name + format(" (%.2f)", l.at_best);
  }
  std::string out =
      methods.empty() ? "Every method wins somewhere, or loses by no more than a tenth or the "
                        "spread of repetitions."
                      : "Methods that win nowhere here, whatever their settings: " + methods + ".";
  if (!settings.empty())
    out += " Settings that win nowhere: " + settings + ".";
  if (!methods.empty() || !settings.empty())
    out += " (In brackets: their time, at best, over the least of what is as accurate.)";
  return out;
}

std::string csv(const Sweep& sweep) {
  std::vector<std::string> columns = {"group",         "setting",      sweep.error_label, "seconds",
                                      "seconds_least", "seconds_most", sweep.work_label,  "default",
                                      "on_front",      "peer"};
  columns.insert(columns.end(), sweep.more_labels.begin(), sweep.more_labels.end());
  output::CsvRows rows(columns.size());
  const auto value = [](double x) { return std::isfinite(x) ? format("%.6g", x) : std::string(); };
  for (const std::string& group : sweep.groups()) {
    const std::vector<const Setting*> best = front(sweep, group, seconds);
    for (const Setting* s : sweep.of(group, true)) {
      const bool on_front = std::find(best.begin(), best.end(), s) != best.end();
      rows.cell(s->group).cell(s->name).cell(value(s->error)).cell(value(s->seconds()));
      rows.cell(value(s->least_seconds())).cell(value(s->most_seconds()));
      rows.cell(s->work > 0.0 ? value(s->work) : "");
      rows.cell(int(s->is_default)).cell(int(on_front)).cell(int(s->is_peer));
      for (std::size_t i = 0; i < sweep.more_labels.size(); ++i)
        rows.cell(i < s->more.size() ? value(s->more[i]) : "");
      rows.end_row();
    }
  }
  return output::csv_header(columns) + std::string(rows.text());
}

} // namespace insitu::bench::accuracy
