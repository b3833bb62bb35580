#include <bit>
#include <cmath>
#include <limits>

#include "output/image/png.h"

namespace insitu::output {

namespace {

double linear_of(double code) {
  const double s = code / 255.0;
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

/// Encoding by comparison. `least[k]` is the smallest float whose code is at least k, so rounding
/// is to the nearest without evaluating a power per channel; `start` holds, for each interval of
/// floats that agree in their upper bits, the code of its lower end.
struct SrgbTable {
  // No code but 0 lies below 2^-13: the smallest bound is 0.5 / 255 / 12.92 = 1.5e-4.
  static constexpr int shift = 15;
  static constexpr std::uint32_t first = std::bit_cast<std::uint32_t>(0x1p-13f) >> shift;
  static constexpr std::uint32_t last = std::bit_cast<std::uint32_t>(1.0f) >> shift;

  std::array<float, 257> least;
  std::array<std::uint8_t, last - first> start;

  SrgbTable() {
    least[0] = 0;
    for (int k = 1; k < 256; ++k) {
      const double bound = linear_of(k - 0.5);
      float above = float(bound);
      if (double(above) < bound)
        above = std::nextafter(above, 2.0f);
      least[std::size_t(k)] = above;
    }
    least[256] = std::numeric_limits<float>::infinity();
    int code = 0;
    for (std::uint32_t i = first; i < last; ++i) {
      const float lower = std::bit_cast<float>(i << shift);
      while (lower >= least[std::size_t(code) + 1])
        ++code;
      start[i - first] = std::uint8_t(code);
    }
  }
};

const SrgbTable& table() {
  static const SrgbTable made;
  return made;
}

std::uint8_t encode(const SrgbTable& t, float linear) {
  if (!(linear >= 0x1p-13f)) // NaN too
    return 0;
  if (linear >= 1.0f)
    return 255;
  unsigned code =
      t.start[(std::bit_cast<std::uint32_t>(linear) >> SrgbTable::shift) - SrgbTable::first];
  while (linear >= t.least[code + 1])
    ++code;
  return std::uint8_t(code);
}

std::uint8_t encode_alpha(float alpha) {
  if (!(alpha > 0.0f))
    return 0;
  return alpha >= 1.0f ? std::uint8_t(255) : std::uint8_t(std::lround(double(alpha) * 255.0));
}

} // namespace

std::uint8_t encode_srgb(float linear) {
  return encode(table(), linear);
}

float decode_srgb(std::uint8_t code) {
  return float(linear_of(code));
}

PngImage to_srgb(const core::Image& image, bool keep_alpha) {
  PngImage out{image.width, image.height, keep_alpha ? 4 : 3,
               core::CountedVector<std::uint8_t>(image.rgba.get_allocator())};
  const std::size_t count = image.rgba.size() / 4;
  out.pixels.resize(count * std::size_t(out.channels));
  const SrgbTable& t = table();
  std::uint8_t* to = out.pixels.data();
  for (std::size_t i = 0; i < count; ++i) {
    const float* from = &image.rgba[4 * i];
    *to++ = encode(t, from[0]);
    *to++ = encode(t, from[1]);
    *to++ = encode(t, from[2]);
    if (keep_alpha)
      *to++ = encode_alpha(from[3]);
  }
  return out;
}

} // namespace insitu::output
