#pragma once

#include <cmath>

namespace insitu::render {

/// Linear RGB, or sRGB where a name says so; each from 0 to 1.
struct Color {
  float r = 0, g = 0, b = 0;
  friend bool operator==(const Color&, const Color&) = default;
};

inline Color operator+(const Color& a, const Color& b) {
  return {a.r + b.r, a.g + b.g, a.b + b.b};
}
inline Color operator*(float s, const Color& a) {
  return {s * a.r, s * a.g, s * a.b};
}

/// Red, green, blue and alpha: a register of any machine that is likely to march rays.
using Rgba = float __attribute__((vector_size(16)));

inline Rgba rgba_of(const Color& c, float alpha) {
  return Rgba{c.r, c.g, c.b, alpha};
}
inline Color color_of(const Rgba& c) {
  return {c[0], c[1], c[2]};
}

/// IEC 61966-2-1 (1999): the value shown for a stored one.
inline double linear_of_srgb(double s) {
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}
/// Its inverse.
inline double srgb_of_linear(double v) {
  return v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055;
}
inline Color linear_of_srgb(double r, double g, double b) {
  return {float(linear_of_srgb(r)), float(linear_of_srgb(g)), float(linear_of_srgb(b))};
}

} // namespace insitu::render
