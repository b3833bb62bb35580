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

struct Range {
  double least = HUGE_VAL, most = 0.0;
  bool has_zero = false;
  void add(double x) {
    if (x > 0.0 && std::isfinite(x)) {
      least = std::min(least, x);
      most = std::max(most, x);
    } else if (x == 0.0) {
      has_zero = true;
    }
  }
};

/// What a chart spans: all groups, or one with axes of its own.
struct Ranges {
  Range errors, times;
  explicit Ranges(const std::vector<const Setting*>& settings) {
    for (const Setting* s : settings) {
      errors.add(s->error);
      times.add(s->seconds());
    }
    if (!(errors.most > 0.0))
      errors.least = errors.most = 1.0;
  }
};

/// Methods as they are drawn: ours as discs in colours, peers as squares in greys.
class Marks {
public:
  explicit Marks(const Sweep& sweep) {
    for (const bool peers : {false, true})
      for (const Setting& s : sweep.settings)
        if (s.is_peer == peers && index(s) < 0)
          methods_.push_back({method_of(s.name), peers});
  }

  std::string mark(const Setting& s, double x, double y, const std::string& tip) const {
    return mark(index(s), x, y, tip);
  }

  /// From left to right, then down, in `across`; taken: the height.
  std::string legend(double across, double y, double& taken) const {
    constexpr double line = 16.0, letter = 6.6;
    std::string out;
    double x = 24.0, down = 12.0;
    for (std::size_t m = 0; m < methods_.size(); ++m) {
      const double needed = 34.0 + letter * double(methods_[m].name.size());
      if (x > 24.0 && x + needed > across) {
        x = 24.0;
        down += line;
      }
      out += mark(int(m), x, y + down - 4.0, "") +
             text(x + 10.0, y + down, "start", escaped(methods_[m].name));
      x += needed;
    }
    taken = down + 12.0;
    return out;
  }

private:
  struct Method {
    std::string name;
    bool is_peer;
  };

  int index(const Setting& s) const {
    for (std::size_t m = 0; m < methods_.size(); ++m)
      if (methods_[m].is_peer == s.is_peer && methods_[m].name == method_of(s.name))
        return int(m);
    return -1;
  }
  std::string mark(int method, double x, double y, const std::string& tip) const {
    constexpr const char* greys[] = {"#000", "#888", "#bbb"};
    if (!methods_[std::size_t(method)].is_peer)
      return format("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"4\" fill=\"%s\">", x, y,
                    colours[std::size_t(method) % std::size(colours)]) +
             tip + "</circle>\n";
    const auto first =
        std::find_if(methods_.begin(), methods_.end(), [](const Method& m) { return m.is_peer; });
    const auto grey = std::size_t(method - (first - methods_.begin())) % std::size(greys);
    return format("<rect x=\"%.1f\" y=\"%.1f\" width=\"8\" height=\"8\" fill=\"%s\">", x - 4.0,
                  y - 4.0, greys[grey]) +
           tip + "</rect>\n";
  }

  std::vector<Method> methods_;
};

std::string chart(const Sweep& sweep, const std::string& group, const Ranges& ranges,
                  const Marks& marks, double dx, double dy) {
  const auto& [errors, times] = ranges;
  Axis x{0, 1, dx + left, dx + width - right}, y{0, 1, dy + height - bottom, dy + top};
  x.fit(times.least, times.most);
  // No error at all has a line of its own, a decade below the least.
  y.fit(errors.has_zero ? 0.1 * errors.least : errors.least, std::max(errors.most, errors.least));
  const auto at = [&](const Setting& s) {
    const double error = s.error > 0.0 ? s.error : std::pow(10.0, y.low);
    return std::pair(x.at(s.seconds()), y.at(error));
  };
  const auto own = sweep.axes.find(group);
  const auto& [error_label, time_label] =
      own == sweep.axes.end() ? std::pair(sweep.error_label, sweep.time_label) : own->second;
  std::string out =
      text(dx + 0.5 * width, dy + 22.0, "middle", escaped(group), " font-size=\"14\"");
  out += grid(x, y, time_label, error_label, dy + height - 16.0, dx + 15.0);
  if (errors.has_zero)
    out +=
        text(x.to - 4.0, y.from - 6.0, "end", "no error found", " fill=\"#888\" font-size=\"10\"");
  std::string path;
  for (const Setting* s : front(sweep, group, seconds)) {
    const auto [px, py] = at(*s);
    path += format("%c%.1f %.1f", path.empty() ? 'M' : 'L', px, py);
  }
  out += "<path d=\"" + path + "\" stroke=\"#444\" stroke-dasharray=\"5 4\" fill=\"none\"/>\n";
  for (const Setting* s : sweep.of(group, true)) {
    const auto [px, py] = at(*s);
    const std::string tip = "<title>" + escaped(s->name) +
                            format(": error %.3g, %.3g s (%.3g to %.3g)", s->error, s->seconds(),
                                   s->least_seconds(), s->most_seconds()) +
                            "</title>";
    out += marks.mark(*s, px, py, tip);
    if (s->is_default) {
      out += format("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"9\" fill=\"none\" stroke=\"#d00\" "
                    "stroke-width=\"2\"/>\n",
                    px, py);
      // Left of a front nothing else is drawn, but for the axes.
      const bool room = px - x.from > 60.0;
      const double down = !room ? -12.0 : y.from - py < 6.0 ? -6.0 : 4.0;
      out += text(room ? px - 13.0 : px, py + down, room ? "end" : "middle", "default",
                  " fill=\"#d00\" font-size=\"11\"");
    }
  }
  return out;
}

} // namespace

std::string plot(const Sweep& sweep) {
  std::vector<const Setting*> all;
  for (const Setting& s : sweep.settings)
    all.push_back(&s);
  const Ranges whole(all);
  if (!(whole.times.most > 0.0))
    return "";
  const Marks marks(sweep);
  const std::vector<std::string> groups = sweep.groups();
  const int rows = (int(groups.size()) + columns - 1) / columns;
  const double whole_width = width * std::min(columns, int(groups.size()));
  double legend_height = 0.0;
  const std::string legend = marks.legend(whole_width, height * rows, legend_height);
  const double whole_height = height * rows + legend_height;
  std::string out =
      format("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.0f\" height=\"%.0f\" "
             "viewBox=\"0 0 %.0f %.0f\" font-family=\"sans-serif\" font-size=\"12\">\n"
             "<rect width=\"100%%\" height=\"100%%\" fill=\"white\"/>\n",
             whole_width, whole_height, whole_width, whole_height);
  for (std::size_t g = 0; g < groups.size(); ++g)
    out += chart(sweep, groups[g],
                 sweep.axes.contains(groups[g]) ? Ranges(sweep.of(groups[g], true)) : whole, marks,
                 width * double(g % columns), height * double(g / columns));
  return out + legend + "</svg>\n";
}

} // namespace insitu::bench::accuracy
