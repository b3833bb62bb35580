#include "report/chart.h"

#include "report/svg_axis.h"

namespace insitu::bench {

namespace {

using namespace drawing;
using Style = Chart::Style;

constexpr double width = 440.0, height = 400.0; // of one chart
constexpr double left = 66.0, right = 16.0, top = 38.0, bottom = 56.0;

/// How lines look, by their labels: ours in colours, those of others, as squares, in greys.
class Looks {
public:
  explicit Looks(const std::vector<Chart>& charts) {
    for (const bool squares : {false, true})
      for (const Chart& chart : charts)
        for (const Chart::Line& line : chart.lines)
          if ((line.style == Style::squares) == squares && !line.label.empty() && !find(line))
            looks_.push_back({line.label, line.style, colour(line.style)});
  }

  std::string path(const Chart::Line& line, const std::string& d) const {
    if (line.style == Style::joined)
      return "<path d=\"" + d +
             format("\" stroke=\"%s\" stroke-width=\"2\" fill=\"none\"/>\n", find(line)->colour);
    return line.style == Style::dashed
               ? "<path d=\"" + d + "\" stroke=\"#666\" stroke-dasharray=\"5 4\" fill=\"none\"/>\n"
               : "";
  }
  std::string mark(const Chart::Line& line, double x, double y, const std::string& tip = "") const {
    const std::string title = tip.empty() ? "" : "<title>" + escaped(tip) + "</title>";
    if (line.style == Style::dashed)
      return "";
    if (line.style == Style::squares)
      return format("<rect x=\"%.1f\" y=\"%.1f\" width=\"8\" height=\"8\" fill=\"%s\">", x - 4.0,
                    y - 4.0, find(line)->colour) +
             title + "</rect>\n";
    return format("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%d\" fill=\"%s\">", x, y,
                  line.style == Style::joined ? 3 : 4, find(line)->colour) +
           title + "</circle>\n";
  }

  /// From left to right, then down, in `across` from `y`, which moves to its end.
  std::string legend(double across, double& y) const {
    constexpr double letter = 6.6;
    std::string out;
    double x = 24.0;
    y += 12.0;
    for (const Look& look : looks_) {
      const Chart::Line line{look.label, look.style, {}};
      const double needed = 50.0 + letter * double(look.label.size());
      if (x > 24.0 && x + needed > across) {
        x = 24.0;
        y += 16.0;
      }
      out += path(line, format("M%.1f %.1fh20", x - 10.0, y - 4.0)) + mark(line, x, y - 4.0) +
             text(x + 16.0, y, "start", escaped(look.label));
      x += needed;
    }
    y += 12.0;
    return out;
  }

private:
  struct Look {
    std::string label;
    Style style;
    const char* colour;
  };

  const Look* find(const Chart::Line& line) const {
    for (const Look& look : looks_)
      if (look.label == line.label && look.style == line.style)
        return &look;
    return nullptr;
  }
  const char* colour(Style style) const {
    constexpr const char* greys[] = {"#000", "#888", "#bbb"};
    const bool grey = style == Style::squares;
    const auto before = std::count_if(looks_.begin(), looks_.end(), [&](const Look& look) {
      return look.style != Style::dashed && (look.style == Style::squares) == grey;
    });
    return grey ? greys[std::size_t(before) % std::size(greys)]
                : colours[std::size_t(before) % std::size(colours)];
  }

  std::vector<Look> looks_;
};

std::string draw(const Chart& chart, const Looks& looks, double dx, double dy) {
  Span across = chart.x, up = chart.y;
  for (const Chart::Line& line : chart.lines)
    for (const Chart::Point& p : line.points) {
      across.add(p.x);
      up.add(p.y);
    }
  if (!(across.most > 0.0))
    return "";
  if (!(up.most > 0.0))
    up.least = up.most = 1.0;
  Axis x{0, 1, dx + left, dx + width - right}, y{0, 1, dy + height - bottom, dy + top};
  x.fit(across.least, across.most);
  y.fit(up.has_zero ? 0.1 * up.least : up.least, up.most);

  std::string out =
      text(0.5 * (x.from + x.to), dy + 22.0, "middle", escaped(chart.title), " font-size=\"14\"");
  out += grid(x, y, chart.x_label, chart.y_label, dy + height - 16.0, dx + 15.0);
  if (up.has_zero)
    out += text(x.to - 4.0, y.from - 6.0, "end", escaped(chart.zero),
                " fill=\"#888\" font-size=\"10\"");
  for (const Chart::Line& line : chart.lines) {
    std::string path, marks;
    for (const Chart::Point& p : line.points) {
      if (!(p.x > 0.0))
        continue;
      const double px = x.at(p.x), py = p.y > 0.0 ? y.at(p.y) : y.from;
      path += format("%c%.1f %.1f", path.empty() ? 'M' : 'L', px, py);
      marks += looks.mark(line, px, py, p.tip);
      if (p.word.empty())
        continue;
      marks += format("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"9\" fill=\"none\" stroke=\"#d00\" "
                      "stroke-width=\"2\"/>\n",
                      px, py);
      // Left of a front nothing else is drawn, but for the axes.
      const bool room = px - x.from > 60.0;
      const double down = !room ? -12.0 : y.from - py < 6.0 ? -6.0 : 4.0;
      marks += text(room ? px - 13.0 : px, py + down, room ? "end" : "middle", escaped(p.word),
                    " fill=\"#d00\" font-size=\"11\"");
    }
    out += looks.path(line, path) + marks;
  }
  return out;
}

} // namespace

std::string svg(const std::vector<Chart>& charts, int columns) {
  const Looks looks(charts);
  const std::size_t count = charts.size(), across = std::min(std::size_t(columns), count);
  std::string out;
  for (std::size_t i = 0; i < count; ++i)
    out += draw(charts[i], looks, width * double(i % across), height * double(i / across));
  if (out.empty())
    return "";
  double down = height * std::ceil(double(count) / double(across));
  out += looks.legend(width * double(across), down);
  return image(width * double(across), down, out);
}

} // namespace insitu::bench
