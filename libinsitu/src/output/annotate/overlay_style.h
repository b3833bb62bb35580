#pragma once

#include <algorithm>

#include "output/annotate/overlay.h"
#include "output/files/text.h"

namespace insitu::output {

/// Of all that is written over an image of that size.
inline int overlay_text_height(int width, int height) {
  return std::clamp(std::min(width, height) / 36, 10, 40);
}

/// The shade, linear, that reads well on a background; and its opposite.
TextStyle style_on(const render::Color& background, int height);

} // namespace insitu::output
