#include "chart.h"

#include <algorithm>
#include <cmath>

#include "svg_axis.h"

namespace insitu::bench {

namespace {

using namespace drawing;

constexpr double width = 460.0, height = 400.0; // of one chart
constexpr double left = 64.0, right = 16.0, top = 40.0, bottom = 52.0;
std::string draw(const Chart& chart, double offset) {
  Axis x{0, 1, offset + left, offset + width - right}, y{0, 1, height - bottom, top};
  double least[2] = {HUGE_VAL, HUGE_VAL}, most[2] = {0.0, 0.0};
  for (const Chart::Line& line : chart.lines)
    for (const auto& [px, py] : line.points) {
      least[0] = std::min(least[0], px);
      most[0] = std::max(most[0], px);
      least[1] = std::min(least[1], py);
      most[1] = std::max(most[1], py);
    }
  if (!(most[0] > 0.0 && most[1] > 0.0))
    return "";
  x.fit(least[0], most[0]);
  y.fit(least[1], most[1]);

  std::string out =
      text(0.5 * (x.from + x.to), 22.0, "middle", escaped(chart.title), " font-size=\"14\"");
  out += grid(x, y, chart.x_label, chart.y_label, height - 14.0, offset + 16.0);

  double legend = y.to + 18.0;
  for (std::size_t i = 0; i < chart.lines.size(); ++i) {
    const Chart::Line& line = chart.lines[i];
    const std::string stroke = format("stroke=\"%s\" stroke-width=\"2\" fill=\"none\"%s",
                                      line.dashed ? "#888" : colours[i % std::size(colours)],
                                      line.dashed ? " stroke-dasharray=\"5 4\"" : "");
    std::string path, dots;
    for (const auto& [px, py] : line.points) {
      path += format("%c%.1f %.1f", path.empty() ? 'M' : 'L', x.at(px), y.at(py));
      if (!line.dashed)
        dots += format("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"3\" fill=\"%s\"/>\n", x.at(px),
                       y.at(py), colours[i % std::size(colours)]);
    }
    out += "<path d=\"" + path + "\" " + stroke + "/>\n" + dots;
    out += format("<path d=\"M%.1f %.1fh24\" %s/>\n", x.from + 12.0, legend - 4.0, stroke.c_str());
    out += text(x.from + 42.0, legend, "start", escaped(line.label));
    legend += 16.0;
  }
  return out;
}

} // namespace

std::string svg(const std::vector<Chart>& charts) {
  const double whole = width * double(charts.size());
  std::string out =
      format("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.0f\" height=\"%.0f\" "
             "viewBox=\"0 0 %.0f %.0f\" font-family=\"sans-serif\" font-size=\"12\">\n"
             "<rect width=\"100%%\" height=\"100%%\" fill=\"white\"/>\n",
             whole, height, whole, height);
  for (std::size_t i = 0; i < charts.size(); ++i)
    out += draw(charts[i], width * double(i));
  return out + "</svg>\n";
}

} // namespace insitu::bench
