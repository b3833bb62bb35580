#pragma once

#include <vector>

namespace insitu::output {

/// A point of a stroke's centre line. Units: capitals stand from the baseline, 0, to 14; small
/// letters reach 10; descenders -4; brackets -3 to 15. x runs from 0 to the glyph's width.
struct GlyphPoint {
  float x, y;
};

/// A polyline, or a dot if it has one point.
using GlyphStroke = std::vector<GlyphPoint>;

struct Glyph {
  float width = 0;
  bool blank = false;
  std::vector<GlyphStroke> strokes;
};

/// The glyph of a code point, or that of "unknown". Made once, on first use.
const Glyph& glyph(char32_t code_point);
/// Whether there is a glyph of it.
bool has_glyph(char32_t code_point);

} // namespace insitu::output
