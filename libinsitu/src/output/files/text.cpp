#include "output/files/text.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "output/annotate/glyphs.h"
#include "output/files/utf8.h"

namespace insitu::output {

namespace {

constexpr float line_units = 22.0f;
constexpr float above_units = 16.9f; // from the top of the line box to the bottom of the letters
constexpr float stroke_units = 1.55f;
constexpr float gap_units = 2.7f;

/// The font at one size. Baseline, x-height and capital height are moved to pixel boundaries, and
/// so are the outer edges of each glyph: without that, stems smear over two pixels at small sizes.
class FittedFont {
public:
  explicit FittedFont(int height) : height_(height), scale_(float(height) / line_units) {
    stroke = std::max(1.0f, stroke_units * scale_);
    gap = std::max(1, rounded(gap_units * scale_));
    const float half = stroke / 2;
    const float bottom = float(rounded(above_units * scale_));
    const float depth = std::min(float(rounded(4 * scale_)), float(height) - bottom);
    baseline_ = bottom - half;
    knots_[0] = {-4, bottom + depth - half};
    knots_[1] = {0, baseline_};
    knots_[2] = {10, bottom - float(rounded((10 + stroke_units) * scale_)) + half};
    knots_[3] = {14, bottom - float(rounded((14 + stroke_units) * scale_)) + half};
    knots_[4] = {15, std::max(half, knots_[3].pixel - scale_)};
  }

  /// Pixels below the top of the line box.
  float y(float units) const {
    int i = 0;
    while (i < 3 && units > knots_[i + 1].units)
      ++i;
    const Knot& a = knots_[i];
    const Knot& b = knots_[i + 1];
    return a.pixel + (units - a.units) / (b.units - a.units) * (b.pixel - a.pixel);
  }

  /// Pixels from outer edge to outer edge.
  int width(const Glyph& g) const {
    return g.blank ? rounded(g.width * scale_)
                   : std::max(rounded((g.width + stroke_units) * scale_), int(std::ceil(stroke)));
  }

  /// Pixels right of the glyph's left outer edge.
  float x(const Glyph& g, float units) const {
    const float between = float(width(g)) - stroke;
    return stroke / 2 + (g.width > 0 ? units / g.width * between : 0);
  }

  float middle() const { return (y(0) + y(14)) / 2; }

  float stroke = 1;
  int gap = 1;

private:
  struct Knot {
    float units, pixel;
  };

  static int rounded(float v) { return int(std::floor(v + 0.5f)); }

  int height_;
  float scale_;
  float baseline_;
  Knot knots_[5];
};

/// Coverage of the pixels of a rectangle by strokes, each by its distance from the pixel's centre.
class Coverage {
public:
  Coverage(int width, int height)
      : width_(width), height_(height), values_(std::size_t(width) * std::size_t(height)) {}

  void add(GlyphPoint a, GlyphPoint b, float radius) {
    const float reach = radius + 0.5f;
    const int x0 = std::max(0, int(std::floor(std::min(a.x, b.x) - reach)));
    const int x1 = std::min(width_ - 1, int(std::ceil(std::max(a.x, b.x) + reach)));
    const int y0 = std::max(0, int(std::floor(std::min(a.y, b.y) - reach)));
    const int y1 = std::min(height_ - 1, int(std::ceil(std::max(a.y, b.y) + reach)));
    const float dx = b.x - a.x, dy = b.y - a.y;
    const float length2 = dx * dx + dy * dy;
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        const float px = float(x) + 0.5f - a.x, py = float(y) + 0.5f - a.y;
        const float t = length2 > 0 ? std::clamp((px * dx + py * dy) / length2, 0.0f, 1.0f) : 0.0f;
        const float ex = px - t * dx, ey = py - t * dy;
        const float covered = std::clamp(reach - std::sqrt(ex * ex + ey * ey), 0.0f, 1.0f);
        float& value = at(x, y);
        value = std::max(value, covered);
      }
    }
  }

  float& at(int x, int y) { return values_[std::size_t(y) * std::size_t(width_) + std::size_t(x)]; }
  int width() const { return width_; }
  int height() const { return height_; }

private:
  int width_;
  int height_;
  std::vector<float> values_;
};

void blend(float* pixel, const std::array<float, 4>& color, float coverage) {
  const float alpha = color[3] * coverage;
  const float below = pixel[3] * (1 - alpha);
  const float total = alpha + below;
  if (total <= 0)
    return;
  for (int i = 0; i < 3; ++i)
    pixel[i] = (color[std::size_t(i)] * alpha + pixel[i] * below) / total;
  pixel[3] = total;
}

/// Calls visit(glyph, pixels right of the text's start) for each glyph; returns the width of them
/// all.
template <class Visit>
int lay_out(const FittedFont& font, std::string_view text, const Visit& visit) {
  int pen = 0;
  for (const char32_t c : decode_utf8(text)) {
    const Glyph& g = glyph(c);
    visit(g, pen);
    pen += font.width(g) + font.gap;
  }
  return std::max(0, pen - font.gap);
}

/// Draws all of the text with strokes `extra` pixels wider on each side.
void draw_layer(core::Image& image, int x, int y, std::string_view text, const FittedFont& font,
                int height, float extra, const std::array<float, 4>& color) {
  const int margin = int(std::ceil(extra)) + 1;
  const int width = lay_out(font, text, [](const Glyph&, int) {});
  Coverage coverage(width + 2 * margin, height + 2 * margin);
  lay_out(font, text, [&](const Glyph& g, int pen) {
    for (const GlyphStroke& stroke : g.strokes) {
      const auto pixel = [&](const GlyphPoint& p) {
        return GlyphPoint{float(pen + margin) + font.x(g, p.x), float(margin) + font.y(p.y)};
      };
      if (stroke.size() == 1)
        coverage.add(pixel(stroke[0]), pixel(stroke[0]), 0.64f * font.stroke + extra);
      for (std::size_t i = 1; i < stroke.size(); ++i)
        coverage.add(pixel(stroke[i - 1]), pixel(stroke[i]), 0.5f * font.stroke + extra);
    }
  });
  for (int row = 0; row < coverage.height(); ++row) {
    const int to_y = y + row - margin;
    if (to_y < 0 || to_y >= image.height)
      continue;
    for (int column = 0; column < coverage.width(); ++column) {
      const int to_x = x + column - margin;
      const float covered = coverage.at(column, row);
      if (to_x >= 0 && to_x < image.width && covered > 0)
        blend(image.pixel(to_x, to_y), color, covered);
    }
  }
}

} // namespace

void draw_text(core::Image& image, int x, int y, std::string_view text, const TextStyle& style) {
  if (text.empty() || style.height < 1)
    return;
  const FittedFont font(style.height);
  if (style.halo_width > 0)
    draw_layer(image, x, y, text, font, style.height, style.halo_width, style.halo_color);
  draw_layer(image, x, y, text, font, style.height, 0, style.color);
}

std::string first_without_glyph(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    std::size_t end = at + 1; // the bytes of one character
    while (end < text.size() && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80)
      ++end;
    const std::string_view one = text.substr(at, end - at);
    for (const char32_t c : decode_utf8(one))
      if (!has_glyph(c))
        return std::string(one);
    at = end;
  }
  return {};
}

int text_width(std::string_view text, int height) {
  return height < 1 ? 0 : lay_out(FittedFont(height), text, [](const Glyph&, int) {});
}

float text_middle(int height) {
  return FittedFont(height).middle();
}

} // namespace insitu::output
