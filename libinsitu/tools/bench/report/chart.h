#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace insitu::bench {

/// What a logarithmic axis is to show.
struct Span {
  double least = HUGE_VAL, most = 0.0;
  bool has_zero = false; ///< which stands a decade below the least

  void add(double x) {
    if (x > 0.0 && std::isfinite(x)) {
      least = std::min(least, x);
      most = std::max(most, x);
    } else if (x == 0.0) {
      has_zero = true;
    }
  }
};

/// A plot with logarithmic axes.
struct Chart {
  struct Point {
    double x, y;      ///< those without a positive x are not drawn
    std::string tip;  ///< shown under the mouse
    std::string word; ///< beside a ring around it; empty: no ring
  };
  enum class Style { joined, dashed, discs, squares };
  struct Line {
    std::string label; ///< in the legend, alike in all charts of an image; dashed ones may lack it
    Style style = Style::joined;
    std::vector<Point> points;
  };
  std::string title, x_label, y_label;
  std::vector<Line> lines = {};
  Span x = {}, y = {};   ///< what the axes show beside the points
  std::string zero = {}; ///< what y = 0 means, if that is drawn
};

/// The charts in columns, and their legend below, as an SVG image; nothing if no x is positive.
std::string svg(const std::vector<Chart>& charts, int columns = 3);

} // namespace insitu::bench
