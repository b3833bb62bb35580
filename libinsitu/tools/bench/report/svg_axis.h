#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include "report/format.h"

/// What charts and bars draw with.
namespace insitu::bench::drawing {

constexpr const char* colours[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                   "#56b4e9", "#e69f00", "#6a3d9a", "#8c510a"};

/// Text as SVG and HTML have it.
inline std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text)
    out += c == '<' ? std::string("&lt;") : c == '&' ? std::string("&amp;") : std::string(1, c);
  return out;
}

/// words: with markup, if any.
inline std::string text(double x, double y, const char* anchor, const std::string& words,
                        const char* more = "") {
  return format("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\"%s>", x, y, anchor, more) + words +
         "</text>\n";
}

/// An image of that size on white.
inline std::string image(double width, double height, const std::string& content) {
  return format("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.0f\" height=\"%.0f\" "
                "viewBox=\"0 0 %.0f %.0f\" font-family=\"sans-serif\" font-size=\"12\">\n"
                "<rect width=\"100%%\" height=\"100%%\" fill=\"white\"/>\n",
                width, height, width, height) +
         content + "</svg>\n";
}

/// A logarithmic axis from one power of ten to another, drawn from `from` to `to`.
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

inline std::string power(int exponent) {
  return exponent >= 0 && exponent <= 2
             ? format("%.0f", std::pow(10.0, exponent))
             : format("10<tspan dy=\"-5\" font-size=\"9\">%d</tspan>", exponent);
}

/// Lines and numbers of both axes, the frame about them, and labels at `bottom` and `left`.
inline std::string grid(const Axis& x, const Axis& y, const std::string& x_label,
                        const std::string& y_label, double bottom, double left) {
  std::string out;
  const int every_x = std::max(1, (x.high - x.low) / 8),
            every_y = std::max(1, (y.high - y.low) / 10);
  for (int e = x.low; e <= x.high; ++e) {
    const double at = x.at(std::pow(10.0, e));
    out += format("<path d=\"M%.1f %.1fV%.1f\" stroke=\"#ddd\"/>\n", at, y.from, y.to);
    if ((e - x.low) % every_x == 0)
      out += text(at, y.from + 17.0, "middle", power(e));
  }
  for (int e = y.low; e <= y.high; ++e)
    for (int digit = 1; digit <= (e < y.high && every_y == 1 ? 9 : 1); ++digit) {
      const double at = y.at(digit * std::pow(10.0, e));
      out += format("<path d=\"M%.1f %.1fH%.1f\" stroke=\"%s\"/>\n", x.from, at, x.to,
                    digit == 1 ? "#ccc" : "#f0f0f0");
      if (digit == 1 && (e - y.low) % every_y == 0)
        out += text(x.from - 6.0, at + 4.0, "end", power(e));
    }
  out += format("<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" fill=\"none\" "
                "stroke=\"#444\"/>\n",
                x.from, y.to, x.to - x.from, y.from - y.to);
  out += text(0.5 * (x.from + x.to), bottom, "middle", escaped(x_label));
  const double middle = 0.5 * (y.from + y.to);
  return out + text(left, middle, "middle", escaped(y_label),
                    format(" transform=\"rotate(-90 %.1f %.1f)\"", left, middle).c_str());
}

} // namespace insitu::bench::drawing
