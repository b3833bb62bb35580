#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "core/random.h"
#include "render/color/preintegration.h"

/// Integrals over values against quadrature.
namespace insitu::test {
namespace {

using render::OpacityPoint;
using render::TransferFunction;

/// A stretch between two samples against quadrature of twenty thousand points.
TEST(Preintegration, StretchesAgainstQuadrature) {
  const std::vector<std::vector<OpacityPoint>> functions = {
      {{0, 0}, {1, 0.8}},
      {{0, 0.3}},
      {{0.2, 0.1}, {0.4, 0.5}, {0.4, 0.9}, {0.6, 0.3}},
      {{0, 0}, {0.5, 0}, {0.5, 0.7}, {0.502, 0.7}, {0.502, 0}, {1, 0}}, // a thin peak
      {{0, 0}, {1, 1}}};
  for (std::size_t f = 0; f < functions.size(); ++f) {
    const TransferFunction function(render::ColorMap::built_in("turbo"), 0.1, 0.9, functions[f]);
    const double step = 0.3, unit = 0.7;
    const render::Preintegration integral(function, step, unit);
    for (std::uint64_t i = 0; i < 40; ++i) {
      const double from = -0.1 + 1.2 * core::random_unit(9, i, f);
      double to = -0.1 + 1.2 * core::random_unit(10, i, f);
      if (i % 4 == 0)
        to = from + 1e-4 * (to - from);
      double depth = 0, color[3] = {0, 0, 0};
      constexpr int count = 20000;
      for (int k = 0; k < count; ++k) {
        const double v = from + (to - from) * (k + 0.5) / count;
        const double t = std::min(40 * unit / step, -std::log1p(-function.opacity(v)));
        const render::Color c = function.color(v);
        depth += t / count;
        color[0] += t * c.r / count;
        color[1] += t * c.g / count;
        color[2] += t * c.b / count;
      }
      const render::ColorSample s = integral(from, to);
      // Steps within a point of the stretch are the quadrature's own error.
      const double expected = -std::expm1(-depth * step / unit);
      EXPECT_NEAR(s.alpha, expected, f == 4 ? 4e-4 : 1e-4) << f << " " << from << " " << to;
      if (depth > 1e-4) {
        EXPECT_NEAR(s.color.r, color[0] / depth, 2e-3) << f << " " << from << " " << to;
        EXPECT_NEAR(s.color.b, color[2] / depth, 2e-3) << f << " " << from << " " << to;
      }
      const render::ColorSample back = integral(to, from);
      EXPECT_FLOAT_EQ(s.alpha, back.alpha);
    }
    EXPECT_EQ(integral(0.3, 0.3).alpha, render::Classifier(function, step, unit)(0.3).alpha);
  }
}

} // namespace
} // namespace insitu::test
