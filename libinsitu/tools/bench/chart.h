#pragma once

#include <string>
#include <utility>
#include <vector>

namespace insitu::bench {

/// A plot with logarithmic axes.
struct Chart {
  struct Line {
    std::string label;
    std::vector<std::pair<double, double>> points; ///< x and y, both positive
    bool dashed = false;
  };
  std::string title, x_label, y_label;
  std::vector<Line> lines;
};

/// The charts side by side as an SVG image.
std::string svg(const std::vector<Chart>& charts);

} // namespace insitu::bench
