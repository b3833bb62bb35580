#include "output/annotate/overlay.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "output/annotate/overlay_style.h"
#include "output/annotate/time_label.h"

namespace insitu::output {

TextStyle style_on(const render::Color& background, int height) {
  // Rec. 709's luminance; 0.18 is the middle grey.
  const float luminance = 0.2126f * background.r + 0.7152f * background.g + 0.0722f * background.b;
  const bool light = luminance > 0.18f;
  const float ink = light ? 0.005f : 0.9f, rim = light ? 1.0f : 0.0f;
  TextStyle style;
  style.height = height;
  style.color = {ink, ink, ink, 1};
  style.halo_width = std::max(1.0f, 0.08f * float(height));
  style.halo_color = {rim, rim, rim, 0.5f};
  return style;
}

namespace {

int text_height(const core::Image& image) {
  return overlay_text_height(image.width, image.height);
}

/// Lays a colour over a rectangle, cut at the image's border.
void fill(core::Image& image, int x0, int y0, int x1, int y1, const render::Color& c) {
  for (int y = std::max(y0, 0); y < std::min(y1, image.height); ++y)
    for (int x = std::max(x0, 0); x < std::min(x1, image.width); ++x) {
      float* p = image.pixel(x, y);
      p[0] = c.r;
      p[1] = c.g;
      p[2] = c.b;
      p[3] = 1;
    }
}

/// 1.5e-07 -> 1.5e-7.
std::string short_exponent(std::string text) {
  const std::size_t e = text.find('e');
  if (e == std::string::npos)
    return text;
  const bool negative = text[e + 1] == '-';
  std::size_t first = e + 2;
  while (first + 1 < text.size() && text[first] == '0')
    ++first;
  return text.substr(0, e + 1) + (negative ? "-" : "") + text.substr(first);
}

/// Lays a colour over a line between two points, in pixels, of that width; its edge is smooth.
void draw_line(core::Image& image, const double (&from)[2], const double (&to)[2], double width,
               const std::array<float, 4>& color) {
  const double reach = 0.5 * width + 0.5;
  const double d[2] = {to[0] - from[0], to[1] - from[1]};
  const double length2 = d[0] * d[0] + d[1] * d[1];
  const auto low = [&](std::size_t a) {
    return std::max(0, int(std::floor(std::min(from[a], to[a]) - reach)));
  };
  const auto high = [&](std::size_t a, int side) {
    return std::min(side, int(std::ceil(std::max(from[a], to[a]) + reach)));
  };
  for (int y = low(1); y < high(1, image.height); ++y)
    for (int x = low(0); x < high(0, image.width); ++x) {
      const double at[2] = {x + 0.5 - from[0], y + 0.5 - from[1]};
      const double t =
          length2 > 0 ? std::clamp((at[0] * d[0] + at[1] * d[1]) / length2, 0.0, 1.0) : 0.0;
      const double distance = std::hypot(at[0] - t * d[0], at[1] - t * d[1]);
      const float alpha = color[3] * float(std::clamp(reach - distance, 0.0, 1.0));
      float* p = image.pixel(x, y);
      const float below = p[3] * (1 - alpha), total = alpha + below;
      if (!(alpha > 0))
        continue;
      for (std::size_t c = 0; c < 3; ++c)
        p[c] = (color[c] * alpha + p[c] * below) / total;
      p[3] = total;
    }
}

} // namespace

AxesPlace axes_place(const core::Image& image) {
  const int height = text_height(image);
  const double length = 2.2 * height;
  if (std::min(image.width, image.height) < 4 * length)
    return {};
  return {image.width - length - 2.0 * height, image.height - length - 2.0 * height, length};
}

void draw_axes(core::Image& image, const render::CameraAxes& camera, const Overlay& overlay) {
  const AxesPlace place = axes_place(image);
  if (!(place.length > 0))
    return;
  const int height = text_height(image);
  TextStyle style = style_on(overlay.background, height);
  const double width = std::max(1.5, 0.13 * height), rim = 2.0 * double(style.halo_width);
  // Linear; of about the same lightness.
  constexpr std::array<float, 4> colors[3] = {
      {0.75f, 0.03f, 0.03f, 1}, {0.03f, 0.4f, 0.03f, 1}, {0.06f, 0.2f, 0.9f, 1}};
  int order[3] = {0, 1, 2}; // the farthest first
  std::sort(order, order + 3, [&](int a, int b) { return camera.forward[a] > camera.forward[b]; });
  for (const int axis : order) {
    const auto color = colors[axis];
    const double along[2] = {camera.right[axis], camera.down[axis]};
    const double from[2] = {place.x, place.y};
    const auto point = [&](double forth, double aside, double(&to)[2]) {
      to[0] = place.x + place.length * (forth * along[0] - aside * along[1]);
      to[1] = place.y + place.length * (forth * along[1] + aside * along[0]);
    };
    double tip[2], left[2], right[2];
    point(1, 0, tip);
    point(0.78, 0.1, left);
    point(0.78, -0.1, right);
    for (const auto& [extra, ink] : {std::pair{rim, style.halo_color}, std::pair{0.0, color}}) {
      draw_line(image, from, tip, width + extra, ink);
      draw_line(image, left, tip, width + extra, ink);
      draw_line(image, right, tip, width + extra, ink);
    }
    // Beyond the tip; an arrow that is seen end on has its name above it.
    const double seen = std::hypot(along[0], along[1]);
    const double beyond = 0.75 * height;
    const double name[2] = {seen > 0.05 ? tip[0] + beyond * along[0] / seen : tip[0] - beyond,
                            seen > 0.05 ? tip[1] + beyond * along[1] / seen : tip[1] - beyond};
    const char text[2] = {"xyz"[axis], 0};
    style.color = color;
    draw_text(image, int(std::lround(name[0] - 0.5 * text_width(text, height))),
              int(std::lround(name[1] - 0.55 * height)), text, style);
  }
}

std::vector<double> tick_values(double low, double high, int most) {
  const double span = high - low;
  if (!std::isfinite(low) || !std::isfinite(high) ||
      !(span > 1e-12 * std::max(std::fabs(low), std::fabs(high))))
    return {low};
  most = std::max(most, 2);
  for (int exponent = int(std::floor(std::log10(span / most))) - 1;; ++exponent)
    for (const double factor : {1.0, 2.0, 5.0}) {
      const double spacing = factor * std::pow(10.0, exponent);
      const double first = std::ceil(low / spacing - 1e-9),
                   last = std::floor(high / spacing + 1e-9);
      const double count = last - first + 1;
      if (count > most)
        continue;
      if (count < 2)
        return {low, high}; // no two round values fit
      std::vector<double> ticks;
      for (double i = first; i <= last; ++i) {
        // Dividing by a power of ten gives the number nearest to the decimal, multiplying may not.
        const double tick = exponent < 0 ? i * factor / std::pow(10.0, -exponent) : i * spacing;
        ticks.push_back(std::clamp(tick, low, high));
      }
      return ticks;
    }
}

std::vector<std::string> tick_labels(const std::vector<double>& values) {
  double largest = 0;
  for (const double v : values)
    largest = std::max(largest, std::fabs(v));
  const bool scientific = largest != 0 && (largest >= 1e5 || largest < 1e-3);
  std::vector<std::string> labels;
  for (int digits = 0; digits <= 15; ++digits) {
    labels.clear();
    bool told_apart = true;
    for (const double v : values) {
      const std::string text = v == 0 ? "0" : printed(v, scientific ? 'e' : 'f', digits);
      double read = 0;
      std::from_chars(text.data(), text.data() + text.size(), read);
      // Within a millionth of the largest, the label is the value.
      told_apart &= std::fabs(read - v) <= 1e-6 * largest;
      labels.push_back(scientific ? short_exponent(text) : text);
    }
    if (told_apart &&
        (values.size() < 2 || std::adjacent_find(labels.begin(), labels.end()) == labels.end()))
      break;
    // A range whose ends are no round numbers is labelled to a few digits only.
    if (digits >= 4 && std::adjacent_find(labels.begin(), labels.end()) == labels.end())
      break;
  }
  return labels;
}

LogTicks log_tick_values(double low, double high, int most) {
  most = std::max(most, 2);
  LogTicks ticks;
  const auto within = [&](double v) { return v >= low * (1 - 1e-9) && v <= high * (1 + 1e-9); };
  const auto power = [](int exponent) {
    // Dividing by a power of ten gives the number nearest to the decimal, multiplying may not.
    return exponent < 0 ? 1 / std::pow(10.0, -exponent) : std::pow(10.0, exponent);
  };
  const int first = int(std::floor(std::log10(low))), last = int(std::ceil(std::log10(high)));
  std::vector<double> decades, fine, round;
  for (int e = first; e <= last; ++e)
    for (int factor = 1; factor <= 9; ++factor) {
      const double v = e < 0 ? factor / power(-e) : factor * power(e);
      if (!within(v))
        continue;
      (factor == 1 ? decades : fine).push_back(v);
      if (factor == 1 || factor == 2 || factor == 5)
        round.push_back(v);
    }
  if (decades.size() < 2) {
    const bool has_round = round.size() >= 2 && int(round.size()) <= most;
    ticks.major = has_round ? round : tick_values(low, high, most);
    return ticks;
  }
  const std::size_t apart = (decades.size() + std::size_t(most) - 1) / std::size_t(most);
  if (apart == 1)
    ticks.minor = fine;
  // Such that 1 is among them, if it is in the range at all.
  const int lowest = int(std::lround(std::log10(decades.front())));
  for (std::size_t i = 0; i < decades.size(); ++i)
    ((lowest + int(i)) % int(apart) == 0 ? ticks.major : ticks.minor).push_back(decades[i]);
  return ticks;
}

std::vector<std::string> log_tick_labels(const std::vector<double>& values) {
  const bool plain =
      std::all_of(values.begin(), values.end(), [](double v) { return v >= 0.01 && v < 1e5; });
  std::vector<std::string> labels;
  for (const double v : values) {
    char text[64];
    const auto format = plain || v == 1 ? std::chars_format::fixed : std::chars_format::scientific;
    labels.push_back(
        short_exponent({text, std::to_chars(text, text + sizeof text, v, format).ptr}));
  }
  return labels;
}

namespace {

/// The bar's place and looks.
struct Bar {
  int left, top, width, height, text_height, gap;
  render::Color ink;
};

/// From a side of the bar outwards to a tip; up: above the bar.
void fill_triangle(core::Image& image, const Bar& bar, bool up, const render::Color& color) {
  const int rows = bar.width;
  for (int r = 0; r <= rows; ++r) {
    const int y = up ? bar.top - 2 - r : bar.top + bar.height + 1 + r;
    const double half = 0.5 * bar.width * (1 - double(r) / rows);
    const int from = int(std::lround(bar.left + 0.5 * bar.width - half));
    const int to = int(std::lround(bar.left + 0.5 * bar.width + half));
    fill(image, from - 1, y, to + 1, y + 1, bar.ink);
    if (r < rows)
      fill(image, from, y, to, y + 1, color);
  }
}

/// The ticks of a function with their labels.
void draw_ticks(core::Image& image, const Bar& bar, const render::TransferFunction& function,
                const LogTicks& ticks, const std::vector<std::string>& labels,
                const TextStyle& style) {
  const double low = function.low(), high = function.high();
  const bool log = function.scale() == render::Scale::log;
  const auto place = [&](double value) {
    const double u = !(high > low) ? 0.5
                     : log         ? std::log(value / low) / std::log(high / low)
                                   : (value - low) / (high - low);
    return bar.top + (1.0 - u) * bar.height;
  };
  const auto draw = [&](double value, int length) {
    const int row =
        std::clamp(int(std::lround(place(value) - 0.5)), bar.top, bar.top + bar.height - 1);
    const int x = bar.left + bar.width;
    fill(image, x, row, x + length, row + 1, bar.ink);
  };
  for (const double value : ticks.minor)
    draw(value, std::max(bar.gap / 2, 2));
  for (std::size_t i = 0; i < ticks.major.size(); ++i) {
    draw(ticks.major[i], bar.gap);
    const double y = place(ticks.major[i]);
    draw_text(image, bar.left + bar.width + 2 * bar.gap,
              int(std::lround(y - text_middle(bar.text_height))), labels[i], style);
  }
}

} // namespace

void draw_scalar_bar(core::Image& image, const render::TransferFunction& function,
                     const std::string& title, const Overlay& overlay) {
  const int height = text_height(image);
  const TextStyle style = style_on(overlay.background, height);
  Bar bar;
  bar.text_height = height;
  bar.height = image.height / 2;
  bar.width = std::max(height * 4 / 5, 6);
  bar.gap = std::max(height / 3, 2);
  bar.ink = {style.color[0], style.color[1], style.color[2]};
  if (bar.height < 2 * height)
    return; // too small to be read
  const int most = std::clamp(bar.height / (3 * height), 2, 9);
  const bool log = function.scale() == render::Scale::log && function.low() < function.high();
  LogTicks ticks;
  if (log)
    ticks = log_tick_values(function.low(), function.high(), most);
  else
    ticks.major = tick_values(function.low(), function.high(), most);
  const std::vector<std::string> labels =
      log ? log_tick_labels(ticks.major) : tick_labels(ticks.major);
  int widest = overlay.names_nan ? text_width("NaN", height) : 0;
  for (const std::string& label : labels)
    widest = std::max(widest, text_width(label, height));
  const int margin = height, right = image.width - margin;
  bar.left = right - widest - 2 * bar.gap - bar.width;
  bar.top = (image.height - bar.height) / 2;
  fill(image, bar.left - 1, bar.top - 1, bar.left + bar.width + 1, bar.top + bar.height + 1,
       bar.ink);
  for (int y = 0; y < bar.height; ++y)
    fill(image, bar.left, bar.top + y, bar.left + bar.width, bar.top + y + 1,
         function.colors().at(1.0 - (y + 0.5) / bar.height));
  const auto& below = function.colors().below();
  const auto& above = function.colors().above();
  if (below)
    fill_triangle(image, bar, false, *below);
  if (above)
    fill_triangle(image, bar, true, *above);
  draw_ticks(image, bar, function, ticks, labels, style);
  if (overlay.names_nan) {
    const int top = bar.top + bar.height + (below ? bar.width : 0) + 2 * bar.gap + 2;
    const int side = bar.width;
    fill(image, bar.left - 1, top - 1, bar.left + side + 1, top + side + 1, bar.ink);
    fill(image, bar.left, top, bar.left + side, top + side, function.colors().nan_color());
    draw_text(image, bar.left + bar.width + 2 * bar.gap,
              int(std::lround(top + 0.5 * side - text_middle(height))), "NaN", style);
  }
  if (!title.empty()) {
    // Above the bar, ending at the right margin if it is wider than bar and labels.
    const int x = std::max(std::min(bar.left, right - text_width(title, height)), bar.gap);
    draw_text(image, x, bar.top - height - bar.gap - height / 2 - (above ? bar.width : 0), title,
              style);
  }
}

void draw_time_label(core::Image& image, const std::string& label, const Overlay& overlay) {
  const int height = text_height(image);
  draw_text(image, height, image.height - 2 * height, label, style_on(overlay.background, height));
}

} // namespace insitu::output
