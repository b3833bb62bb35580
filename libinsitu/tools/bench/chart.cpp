#include "chart.h"

#include <algorithm>
#include <cmath>

#include "format.h"

namespace insitu::bench {

namespace {

constexpr double width = 460.0, height = 400.0; // of one chart
constexpr double left = 64.0, right = 16.0, top = 40.0, bottom = 52.0;
constexpr const char* colours[] = {"#0072b2", "#d55e00", "#009e73",
                                   "#cc79a7", "#56b4e9", "#e69f00"};

std::string text(double x, double y, const char* anchor, const std::string& words,
                 const char* more = "") {
  return format("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\"%s>%s</text>\n", x, y, anchor, more,
                words.c_str());
}

/// An axis from one power of ten to another, mapped to [from, to].
struct Axis {
  int low = 0, high = 1;
  double from, to;

  void fit(double least, double most) {
    low = int(std::floor(std::log10(least) + 1e-9));
    high = std::max(low + 1, int(std::ceil(std::log10(most) - 1e-9)));
  }
  double at(double value) const {
    return from + (to - from) * (std::log10(value) - low) / (high - low);
  }
};

std::string power(int exponent) {
  return exponent >= 0 && exponent <= 2
             ? format("%.0f", std::pow(10.0, exponent))
             : format("10<tspan dy=\"-5\" font-size=\"9\">%d</tspan>", exponent);
}

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

  std::string out = text(0.5 * (x.from + x.to), 22.0, "middle", chart.title, " font-size=\"14\"");
  for (int e = x.low; e <= x.high; ++e) {
    const double at = x.at(std::pow(10.0, e));
    out += format("<path d=\"M%.1f %.1fV%.1f\" stroke=\"#ddd\"/>\n", at, y.from, y.to);
    out += text(at, y.from + 17.0, "middle", power(e));
  }
  for (int e = y.low; e <= y.high; ++e)
    for (int digit = 1; digit <= (e < y.high ? 9 : 1); ++digit) {
      const double at = y.at(digit * std::pow(10.0, e));
      out += format("<path d=\"M%.1f %.1fH%.1f\" stroke=\"%s\"/>\n", x.from, at, x.to,
                    digit == 1 ? "#ccc" : "#f0f0f0");
      if (digit == 1)
        out += text(x.from - 6.0, at + 4.0, "end", power(e));
    }
  out += format("<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" fill=\"none\" "
                "stroke=\"#444\"/>\n",
                x.from, y.to, x.to - x.from, y.from - y.to);
  out += text(0.5 * (x.from + x.to), height - 14.0, "middle", chart.x_label);
  const double label_x = offset + 16.0, label_y = 0.5 * (y.from + y.to);
  out += text(label_x, label_y, "middle", chart.y_label,
              format(" transform=\"rotate(-90 %.1f %.1f)\"", label_x, label_y).c_str());

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
    out += text(x.from + 42.0, legend, "start", line.label);
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
