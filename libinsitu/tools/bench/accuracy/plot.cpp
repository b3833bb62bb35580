#include <tuple>

#include "accuracy/sweep.h"
#include "report/chart.h"
#include "report/format.h"

namespace insitu::bench::accuracy {

std::string plot(const Sweep& sweep) {
  Span errors, times; // of all groups but for those with axes of their own
  for (const Setting& s : sweep.settings) {
    errors.add(s.error);
    times.add(s.seconds());
  }
  std::vector<Chart> charts;
  for (const std::string& group : sweep.groups()) {
    Chart chart{group, sweep.time_label, sweep.error_label};
    if (const auto own = sweep.axes.find(group); own != sweep.axes.end()) {
      std::tie(chart.y_label, chart.x_label) = own->second;
    } else {
      chart.x = times;
      chart.y = errors;
    }
    chart.zero = "no error found";
    Chart::Line best{"", Chart::Style::dashed, {}};
    for (const Setting* s : front(sweep, group, seconds))
      best.points.push_back({s->seconds(), s->error, "", ""});
    chart.lines.push_back(best);
    for (const Setting* s : sweep.of(group, true)) {
      const Chart::Style style = s->is_peer ? Chart::Style::squares : Chart::Style::discs;
      const std::string tip = s->name + format(": error %.3g, %.3g s (%.3g to %.3g)", s->error,
                                               s->seconds(), s->least_seconds(), s->most_seconds());
      chart.lines.push_back({method_of(s->name),
                             style,
                             {{s->seconds(), s->error, tip, s->is_default ? "default" : ""}}});
    }
    charts.push_back(chart);
  }
  return svg(charts, 2);
}

} // namespace insitu::bench::accuracy
