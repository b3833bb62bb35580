#include <clocale>
#include <cmath>
#include <gtest/gtest.h>

#include "output/overlay.h"

namespace insitu::output {
namespace {

using Values = std::vector<double>;
using Labels = std::vector<std::string>;

TEST(Overlay, TicksAreRoundAndWithinTheRange) {
  EXPECT_EQ(tick_values(0, 6, 4), (Values{0, 2, 4, 6}));
  EXPECT_EQ(tick_values(0, 1, 6), (Values{0, 0.2, 0.4, 0.6, 0.8, 1}));
  EXPECT_EQ(tick_values(0.13, 0.97, 5), (Values{0.2, 0.4, 0.6, 0.8}));
  EXPECT_EQ(tick_values(-1, 1, 5), (Values{-1, -0.5, 0, 0.5, 1}));
  EXPECT_EQ(tick_values(3, 3, 5), (Values{3}));
  for (const double low : {-7.3, 0.0, 1e-7, 1013.2})
    for (const double span : {1e-6, 0.37, 12.0, 9e9})
      for (const int most : {2, 5, 9}) {
        const Values ticks = tick_values(low, low + span, most);
        EXPECT_GE(ticks.size(), 2u);
        EXPECT_LE(ticks.size(), std::size_t(most));
        EXPECT_TRUE(std::is_sorted(ticks.begin(), ticks.end()));
        EXPECT_GE(ticks.front(), low);
        EXPECT_LE(ticks.back(), low + span);
      }
}

TEST(Overlay, LabelsTellTicksApart) {
  EXPECT_EQ(tick_labels({0, 2, 4}), (Labels{"0", "2", "4"}));
  EXPECT_EQ(tick_labels({0, 0.25, 0.5}), (Labels{"0", "0.25", "0.50"}));
  EXPECT_EQ(tick_labels({0, 1e-7, 2e-7}), (Labels{"0", "1e-7", "2e-7"}));
  EXPECT_EQ(tick_labels({0, 1.5e12, 3e12}), (Labels{"0", "1.5e12", "3.0e12"}));
  EXPECT_EQ(tick_labels({1013.2, 1013.25}), (Labels{"1013.20", "1013.25"}));
  const char* old = std::setlocale(LC_NUMERIC, nullptr);
  const std::string kept = old ? old : "C";
  if (std::setlocale(LC_NUMERIC, "de_DE.UTF-8")) { // where it is installed
    EXPECT_EQ(tick_labels({0, 0.5}), (Labels{"0", "0.5"}));
  }
  std::setlocale(LC_NUMERIC, kept.c_str());
}

TEST(Overlay, BarShowsTheMapFromBottomToTop) {
  core::Image image(300, 240);
  const render::TransferFunction ramp(
      render::ColorMap("ramp", render::ColorSpace::linear, {{0, 1, 0, 0}, {1, 0, 0, 1}}), 0, 6);
  draw_scalar_bar(image, ramp, "density");
  // Some column is the bar: pure mixtures of red and blue, redder downwards.
  int columns = 0;
  for (int x = 0; x < image.width; ++x) {
    float last = -1;
    int rows = 0;
    for (int y = 0; y < image.height; ++y) {
      const float* p = image.pixel(x, y);
      if (std::fabs(p[0] + p[2] - 1) < 1e-4 && p[1] == 0 && p[0] > last) {
        last = p[0];
        ++rows;
      }
    }
    columns += rows >= 118;
  }
  EXPECT_GE(columns, 6);
  // Title above and labels to the right leave ink.
  double ink = 0;
  for (int y = 0; y < 60; ++y)
    for (int x = 150; x < 300; ++x)
      ink += image.pixel(x, y)[3];
  EXPECT_GT(ink, 20);
}

TEST(Overlay, TimeLabelIsDrawnAndSmallImagesSurvive) {
  core::Image image(200, 100);
  draw_time_label(image, 0.25, 120);
  double ink = 0;
  for (int y = 50; y < 100; ++y)
    for (int x = 0; x < 150; ++x)
      ink += image.pixel(x, y)[3];
  EXPECT_GT(ink, 50);
  for (const int side : {1, 5, 20, 40}) {
    core::Image tiny(side, side);
    draw_time_label(tiny, 1e300);
    draw_scalar_bar(tiny, {render::ColorMap::built_in("grey"), 0, 0}, "a long title of a field");
  }
}

} // namespace
} // namespace insitu::output
