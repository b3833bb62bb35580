#pragma once

#include <array>
#include <string>
#include <string_view>

#include "core/image.h"

namespace insitu::output {

/// How text looks. Colours are linear RGB with straight alpha, as the image's.
struct TextStyle {
  /// Height of a line in pixels, from above the tallest bracket to below the deepest descender;
  /// capital letters and digits are 0.7 of it. Made for 10 to 40; from 6 up it can be read.
  int height = 16;
  std::array<float, 4> color{1, 1, 1, 1};
  /// A rim of this many pixels around the strokes keeps text readable on any background.
  float halo_width = 0;
  std::array<float, 4> halo_color{0, 0, 0, 0.6f};
};

/// Draws one line of text over the image, its line box's upper left corner at pixel (x, y); what
/// falls outside the image is left out, the rim may leave the line box. Text is UTF-8: printable
/// ASCII and what units need (degree, micro, superscripts 1 2 3 and minus, plus-minus, times,
/// middle dot, minus sign, en dash); anything else is drawn as a small box. Digits are all equally
/// wide.
void draw_text(core::Image& image, int x, int y, std::string_view text, const TextStyle& style);

/// Returns the first character of a text that draw_text draws as a box, or an empty text.
std::string first_without_glyph(std::string_view text);

/// The width in pixels of what draw_text draws.
int text_width(std::string_view text, int height);

/// From the top of the line box to the middle of its digits, to put a label beside a tick.
float text_middle(int height);

} // namespace insitu::output
