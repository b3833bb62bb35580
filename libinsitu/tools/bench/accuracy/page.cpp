#include <algorithm>

#include "accuracy/sweeps.h"
#include "report/format.h"
#include "report/svg_axis.h"

namespace insitu::bench::accuracy {

namespace {

using drawing::escaped;

constexpr const char* head = R"(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>What accuracy costs</title>
<style>
body{font:15px/1.5 sans-serif;max-width:900px;margin:2em auto;padding:0 1em;color:#222}
h2{margin-top:2.2em;border-top:1px solid #ddd;padding-top:1em}
.advice{background:#eef5fb;border-left:4px solid #0072b2;padding:.6em 1em}
.small,details{color:#555;font-size:13px}
table{border-collapse:collapse;font-size:13px}td,th{padding:2px 8px;border-bottom:1px solid #eee;text-align:right}
td:first-child,th:first-child,td:nth-child(2),th:nth-child(2){text-align:left}
svg{max-width:100%;height:auto}tr.default td{font-weight:bold}tr.front td{background:#f3f9f3}
pre{overflow-x:auto;font-size:12px}
</style></head><body>
)";

std::string value(double x) {
  return std::isfinite(x) ? format("%.3g", x) : std::string("&ndash;");
}

/// How far defaults are off their fronts, in seconds and in counted work where there is any.
std::string place_of_default(const Sweep& s) {
  double by_time = 0.0, by_work = 0.0;
  for (const std::string& group : s.groups()) {
    by_time = std::max(by_time, default_over_front(s, group, seconds));
    by_work = std::max(by_work, default_over_front(s, group, work));
  }
  std::string out;
  if (by_time > 0.0)
    out = format(
        "The default takes at most %.2f times the least time of a setting that is as accurate",
        by_time);
  if (by_work > 0.0)
    out += format("%s at most %.2f times the least counted work",
                  out.empty() ? "The default takes" : ", and", by_work);
  return out.empty() ? out : out + ".";
}

std::string table(const Sweep& s) {
  std::string out = "<table><tr><th>" + escaped("group") + "</th><th>setting</th><th>" +
                    escaped(s.error_label) + "</th><th>" + escaped(s.time_label) +
                    "</th><th>least to most</th><th>" + escaped(s.work_label) + "</th>";
  for (const std::string& label : s.more_labels)
    out += "<th>" + escaped(label) + "</th>";
  out += "</tr>\n";
  for (const std::string& group : s.groups()) {
    const auto best = front(s, group, seconds);
    for (const Setting* one : s.of(group, true)) {
      const bool on_front = std::find(best.begin(), best.end(), one) != best.end();
      out += std::string("<tr class=\"") + (one->is_default ? "default " : "") +
             (on_front ? "front" : "") + "\"><td>" + escaped(one->group) + "</td><td>" +
             escaped(one->name) + "</td><td>" + value(one->error) + "</td><td>" +
             value(one->seconds()) + "</td><td>" + value(one->least_seconds()) + " to " +
             value(one->most_seconds()) + "</td><td>" +
             (one->work > 0.0 ? value(one->work) : "&ndash;") + "</td>";
      for (const double m : one->more)
        out += "<td>" + value(m) + "</td>";
      out += "</tr>\n";
    }
  }
  return out + "</table>\n";
}

} // namespace

std::string page(const std::vector<Sweep>& sweeps, const Output& effects,
                 const std::string& machine) {
  std::string out = head;
  out +=
      "<h1>What accuracy costs</h1>\n<p>Every choice of the library that trades accuracy for time, "
      "swept against a "
      "reference that is exact or far better converged. Plots show error against time, both "
      "logarithmic: "
      "left and down is better. Dashed: the front, where nothing is both faster and more accurate; "
      "circled in red: the default. Hover over a point for its numbers. Seconds are medians of "
      "processor time "
      "on one core, and only their ratios carry over to other machines.</p>\n<p class=\"small\">" +
      escaped(machine) + "</p>\n<ul>\n";
  for (const Sweep& s : sweeps)
    out += "<li><a href=\"#" + s.key + "\">" + escaped(s.title) + "</a>: " + escaped(s.advice) +
           "</li>\n";
  if (!effects.text.empty())
    out += "<li><a href=\"#effects\">Effects</a>: " + escaped(effects.advice) + "</li>\n";
  out += "</ul>\n";
  for (const Sweep& s : sweeps) {
    out += "<h2 id=\"" + s.key + "\">" + escaped(s.title) + "</h2>\n<p>" + escaped(s.swept) +
           " <span class=\"small\">Reference: " + escaped(s.reference) +
           "</span></p>\n<p class=\"advice\">" + escaped(s.advice) + "</p>\n<p>" +
           escaped(place_of_default(s)) + "</p>\n" + plot(s);
    out += "<p>" + escaped(say_losers(s)) + "</p>\n";
    for (const std::string& note : s.notes)
      out += "<p class=\"small\">" + escaped(note) + "</p>\n";
    out +=
        "<details><summary>All figures (" + s.key + ".csv)</summary>\n" + table(s) + "</details>\n";
  }
  if (!effects.text.empty())
    out += "<h2 id=\"effects\">Effects</h2>\n<p>What each effect adds to the bare frame, or to "
           "particles, that do without it; lines: the spread of repetitions.</p>\n"
           "<p class=\"advice\">" +
           escaped(effects.advice) + "</p>\n" + effects.svg +
           "<details><summary>All figures (effects.csv)</summary>\n<pre>" + escaped(effects.text) +
           "</pre>\n</details>\n";
  return out + "</body></html>\n";
}

} // namespace insitu::bench::accuracy
