#include <algorithm>
#include <cmath>

#include "accuracy/sweep.h"
#include "svg_axis.h"

namespace insitu::bench::accuracy {

namespace {

using namespace drawing;

constexpr double width = 420.0, height = 380.0; // of one chart
constexpr double left = 66.0, right = 14.0, top = 36.0, bottom = 56.0;
constexpr int columns = 2;

/// Settings of one family ("bvh, exact" and "bvh, fast") have one colour.
std::string family(const std::string& name) {
  return name.substr(0, name.find(','));
}

struct Range {
  double least = HUGE_VAL, most = 0.0;
  void add(double x) {
    if (x > 0.0 && std::isfinite(x)) {
      least = std::min(least, x);
      most = std::max(most, x);
    }
  }
};

std::string chart(const Sweep& sweep, const std::string& group, const Range& errors,
                  const Range& times, const std::vector<std::string>& families, double dx,
                  double dy) {
  Axis x{0, 1, dx + left, dx + width - right}, y{0, 1, dy + height - bottom, dy + top};
  x.fit(times.least, times.most);
  // No error at all has a line of its own, a decade below the least.
  y.fit(0.1 * errors.least, std::max(errors.most, errors.least));
  const auto at = [&](const Setting& s) {
    const double error = s.error > 0.0 ? s.error : std::pow(10.0, y.low);
    return std::pair(x.at(s.seconds()), y.at(error));
  };
  std::string out =
      text(dx + 0.5 * width, dy + 22.0, "middle", escaped(group), " font-size=\"14\"");
  out += grid(x, y, sweep.time_label, sweep.error_label, dy + height - 16.0, dx + 15.0);
  out += text(x.to - 4.0, y.from - 4.0, "end", "no error found", " fill=\"#888\" font-size=\"10\"");
  std::string path;
  for (const Setting* s : front(sweep, group, seconds)) {
    const auto [px, py] = at(*s);
    path += format("%c%.1f %.1f", path.empty() ? 'M' : 'L', px, py);
  }
  out += "<path d=\"" + path + "\" stroke=\"#444\" stroke-dasharray=\"5 4\" fill=\"none\"/>\n";
  for (const Setting* s : sweep.of(group, true)) {
    const auto [px, py] = at(*s);
    const auto f = std::find(families.begin(), families.end(), family(s->name)) - families.begin();
    const char* colour = s->is_peer ? "#000" : colours[std::size_t(f) % std::size(colours)];
    const std::string tip = "<title>" + escaped(s->name) +
                            format(": error %.3g, %.3g s (%.3g to %.3g)", s->error, s->seconds(),
                                   s->time.min() / s->items, s->time.max() / s->items) +
                            "</title>";
    if (s->is_peer)
      out += format("<rect x=\"%.1f\" y=\"%.1f\" width=\"8\" height=\"8\" fill=\"%s\">", px - 4.0,
                    py - 4.0, colour) +
             tip + "</rect>\n" +
             text(px + 7.0, py + 4.0, "start", escaped(s->name), " font-size=\"10\"");
    else
      out += format("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"4\" fill=\"%s\">", px, py, colour) + tip +
             "</circle>\n";
    if (s->is_default)
      out += format("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"9\" fill=\"none\" stroke=\"#d00\" "
                    "stroke-width=\"2\"/>\n",
                    px, py) +
             text(px, py - 12.0, "middle", "default", " fill=\"#d00\" font-size=\"11\"");
  }
  return out;
}

} // namespace

std::string plot(const Sweep& sweep) {
  Range errors, times;
  std::vector<std::string> families;
  for (const Setting& s : sweep.settings) {
    errors.add(s.error);
    times.add(s.seconds());
    if (!s.is_peer && std::find(families.begin(), families.end(), family(s.name)) == families.end())
      families.push_back(family(s.name));
  }
  if (!(times.most > 0.0))
    return "";
  if (!(errors.most > 0.0))
    errors.least = errors.most = 1.0;
  const std::vector<std::string> groups = sweep.groups();
  const int rows = (int(groups.size()) + columns - 1) / columns;
  const int across = std::min(columns, int(groups.size()));
  const double legend = 16.0 * std::ceil(double(families.size()) / (2.0 * across)) + 8.0;
  const double whole_width = width * across, whole_height = height * rows + legend;
  std::string out =
      format("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.0f\" height=\"%.0f\" "
             "viewBox=\"0 0 %.0f %.0f\" font-family=\"sans-serif\" font-size=\"12\">\n"
             "<rect width=\"100%%\" height=\"100%%\" fill=\"white\"/>\n",
             whole_width, whole_height, whole_width, whole_height);
  for (std::size_t g = 0; g < groups.size(); ++g)
    out += chart(sweep, groups[g], errors, times, families, width * double(g % columns),
                 height * double(g / columns));
  for (std::size_t f = 0; f < families.size(); ++f) {
    const double x = 0.5 * width * double(f % std::size_t(2 * across)) + 24.0;
    const double y = height * rows + 12.0 + 16.0 * double(f / std::size_t(2 * across));
    out += format("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"4\" fill=\"%s\"/>\n", x, y - 4.0,
                  colours[f % std::size(colours)]) +
           text(x + 10.0, y, "start", escaped(families[f]));
  }
  return out + "</svg>\n";
}

} // namespace insitu::bench::accuracy
