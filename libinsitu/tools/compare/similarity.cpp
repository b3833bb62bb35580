#include "compare/similarity.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace insitu::compare {

namespace {

constexpr double degree = std::numbers::pi / 180;

/// CIE 15, with the exact fractions of the linear part near black.
double lab_curve(double t) {
  constexpr double d = 6.0 / 29.0;
  return t > d * d * d ? std::cbrt(t) : t / (3 * d * d) + 4.0 / 29.0;
}

double hue_degrees(double a, double b) {
  if (a == 0 && b == 0)
    return 0;
  const double h = std::atan2(b, a) / degree;
  return h < 0 ? h + 360 : h;
}

double pow7(double x) {
  const double x3 = x * x * x;
  return x3 * x3 * x;
}

constexpr int reach = 5;

/// Weighted means over the window, along x and then along y.
std::vector<double> blur(const std::vector<double>& in, int width, int height) {
  double weight[2 * reach + 1];
  for (int k = -reach; k <= reach; ++k)
    weight[k + reach] = std::exp(-k * k / (2 * 1.5 * 1.5));
  const auto pass = [&](const std::vector<double>& from, bool along_x) {
    std::vector<double> to(from.size());
    const int length = along_x ? width : height;
    const std::ptrdiff_t step = along_x ? 1 : width;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const int at = along_x ? x : y;
        const double* centre = &from[std::size_t(y) * std::size_t(width) + std::size_t(x)];
        double sum = 0, total = 0;
        for (int k = std::max(-reach, -at); k <= std::min(reach, length - 1 - at); ++k) {
          sum += weight[k + reach] * centre[k * step];
          total += weight[k + reach];
        }
        to[std::size_t(y) * std::size_t(width) + std::size_t(x)] = sum / total;
      }
    }
    return to;
  };
  return pass(pass(in, true), false);
}

std::vector<double> product(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> out(a.size());
  std::transform(a.begin(), a.end(), b.begin(), out.begin(),
                 [](double x, double y) { return x * y; });
  return out;
}

} // namespace

Lab lab_of_linear(double red, double green, double blue) {
  // White is (1, 1, 1): the rows are divided by their sums.
  const double x = (0.4124 * red + 0.3576 * green + 0.1805 * blue) / 0.9505;
  const double y = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
  const double z = (0.0193 * red + 0.1192 * green + 0.9505 * blue) / 1.0890;
  const double fx = lab_curve(x), fy = lab_curve(y), fz = lab_curve(z);
  return {116 * fy - 16, 500 * (fx - fy), 200 * (fy - fz)};
}

double delta_e_2000(const Lab& x, const Lab& y) {
  // Numbers in brackets are the equations of Sharma et al.
  const double c_mean = 0.5 * (std::hypot(x.a, x.b) + std::hypot(y.a, y.b));        // (2, 3)
  const double g = 0.5 * (1 - std::sqrt(pow7(c_mean) / (pow7(c_mean) + pow7(25)))); // (4)
  const double a1 = (1 + g) * x.a, a2 = (1 + g) * y.a;                              // (5)
  const double c1 = std::hypot(a1, x.b), c2 = std::hypot(a2, y.b);                  // (6)
  const double h1 = hue_degrees(a1, x.b), h2 = hue_degrees(a2, y.b);                // (7)

  double dh = 0;      // (10)
  double h = h1 + h2; // (14)
  if (c1 * c2 != 0) {
    dh = h2 - h1;
    const bool around = std::abs(dh) > 180;
    dh += around ? (dh > 0 ? -360 : 360) : 0;
    h = around ? (h < 360 ? h + 360 : h - 360) / 2 : h / 2;
  }
  const double dl = y.l - x.l, dc = c2 - c1;                             // (8, 9)
  const double dhh = 2 * std::sqrt(c1 * c2) * std::sin(dh / 2 * degree); // (11)
  const double l = 0.5 * (x.l + y.l), c = 0.5 * (c1 + c2);               // (12, 13)
  const double t = 1 - 0.17 * std::cos((h - 30) * degree) + 0.24 * std::cos(2 * h * degree) +
                   0.32 * std::cos((3 * h + 6) * degree) -
                   0.20 * std::cos((4 * h - 63) * degree); // (15)
  const double turn = (h - 275) / 25;
  const double rotation = 30 * std::exp(-turn * turn);             // (16)
  const double rc = 2 * std::sqrt(pow7(c) / (pow7(c) + pow7(25))); // (17)
  const double l50 = (l - 50) * (l - 50);
  const double sl = 1 + 0.015 * l50 / std::sqrt(20 + l50); // (18)
  const double sc = 1 + 0.045 * c;                         // (19)
  const double sh = 1 + 0.015 * c * t;                     // (20)
  const double rt = -std::sin(2 * rotation * degree) * rc; // (21)
  const double el = dl / sl, ec = dc / sc, eh = dhh / sh;
  return std::sqrt(std::max(0.0, el * el + ec * ec + eh * eh + rt * ec * eh)); // (22)
}

Similarity structural_similarity(const Plane& a, const Plane& b, double range) {
  const int width = a.width, height = a.height;
  const double c1 = (0.01 * range) * (0.01 * range), c2 = (0.03 * range) * (0.03 * range);
  const std::vector<double> ma = blur(a.values, width, height), mb = blur(b.values, width, height);
  const std::vector<double> aa = blur(product(a.values, a.values), width, height);
  const std::vector<double> bb = blur(product(b.values, b.values), width, height);
  const std::vector<double> ab = blur(product(a.values, b.values), width, height);
  Similarity out;
  double sum = 0;
  for (std::size_t i = 0; i < ma.size(); ++i) {
    const double means = ma[i] * mb[i], squares = ma[i] * ma[i] + mb[i] * mb[i];
    const double similarity = (2 * means + c1) * (2 * (ab[i] - means) + c2) /
                              ((squares + c1) * (aa[i] + bb[i] - squares + c2));
    sum += similarity;
    if (similarity < out.lowest) {
      out.lowest = similarity;
      out.x = int(i % std::size_t(width));
      out.y = int(i / std::size_t(width));
    }
  }
  out.mean = sum / double(ma.size());
  return out;
}

} // namespace insitu::compare
