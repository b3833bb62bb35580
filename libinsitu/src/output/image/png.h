#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/image.h"

namespace insitu::output {

/// The sRGB code of a linear value: the piecewise function of IEC 61966-2-1 (1999), rounded to the
/// nearest code. Values below 0 and NaN give 0, values above 1 give 255.
std::uint8_t encode_srgb(float linear);
/// The linear value of an sRGB code.
float decode_srgb(std::uint8_t code);

/// Pixels as they stand in a PNG file: sRGB codes, row 0 at the top, 3 (RGB) or 4 (RGB and straight
/// alpha) bytes a pixel.
struct PngImage {
  int width = 0;
  int height = 0;
  int channels = 4;
  core::CountedVector<std::uint8_t> pixels; ///< what is made of them is counted as they are

  const std::uint8_t* pixel(int x, int y) const {
    return &pixels[(std::size_t(y) * std::size_t(width) + std::size_t(x)) * std::size_t(channels)];
  }
};

/// Linear colour to sRGB codes. Alpha, which is linear in a PNG file too, is kept in RGBA and left
/// out in RGB.
PngImage to_srgb(const core::Image& image, bool keep_alpha);

/// Writes a PNG file atomically. It says that it is sRGB and holds no time stamp: equal pixels give
/// equal bytes with the same versions of libpng and zlib. Throws core::Error: INSITU_ERROR_ARGUMENT
/// if sizes do not fit, INSITU_ERROR_FILE if it cannot be written.
void write_png(const std::string& path, const PngImage& image);
void write_png(const std::string& path, const core::Image& image, bool keep_alpha = false);

/// Numbers of 16 bits in a PNG file: 1 (grey) or 3 (RGB) a pixel; text: keywords (1 to 79 bytes)
/// and what stands under them.
struct PngValues {
  int width = 0;
  int height = 0;
  int channels = 1;
  core::CountedVector<std::uint16_t> values; ///< counted as PngImage's
  std::vector<std::pair<std::string, std::string>> text;
};

/// The same for numbers that are no colours, stored as they are.
void write_png(const std::string& path, const PngValues& image);

/// Reads a PNG file of any kind as 8-bit RGB or RGBA (grey, palette and 16-bit files are
/// converted). Throws core::Error (INSITU_ERROR_FILE) naming the file and what is wrong with it.
PngImage read_png(const std::string& path);

} // namespace insitu::output
