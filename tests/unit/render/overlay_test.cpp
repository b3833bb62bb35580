#include <algorithm>
#include <clocale>
#include <cmath>
#include <gtest/gtest.h>

#include "output/annotate/overlay.h"
#include "output/annotate/time_label.h"

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

TEST(Overlay, LogarithmicTicksAreAtPowersOfTen) {
  const LogTicks few = log_tick_values(1e-3, 1, 9);
  EXPECT_EQ(few.major, (Values{1e-3, 1e-2, 1e-1, 1}));
  EXPECT_EQ(few.minor.size(), 24u); // 2 to 9 of each of three
  EXPECT_EQ(few.minor[0], 2e-3);
  const LogTicks many = log_tick_values(1e-8, 2e7, 5);
  EXPECT_EQ(many.major, (Values{1e-8, 1e-4, 1, 1e4}));
  EXPECT_EQ(many.minor.size(), 12u);
  EXPECT_EQ(log_tick_values(3, 70, 9).major, (Values{5, 10, 20, 50}));
  EXPECT_EQ(log_tick_values(1.2, 1.9, 5).major, tick_values(1.2, 1.9, 5));
  EXPECT_EQ(log_tick_values(5e-324, 1.7e308, 5).major.size(), 5u);
  for (const double low : {1e-300, 2.3e-7, 1.0, 4.4e12})
    for (const double ratio : {1.1, 3.0, 25.0, 1e4, 3e15})
      for (const int most : {2, 5, 9}) {
        const LogTicks t = log_tick_values(low, ratio * low, most);
        EXPECT_GE(t.major.size(), 1u) << low << " " << ratio;
        EXPECT_LE(t.major.size(), std::size_t(most)) << low << " " << ratio;
        EXPECT_TRUE(std::is_sorted(t.major.begin(), t.major.end()));
      }
  EXPECT_EQ(log_tick_labels({1e-3, 1e-2, 1}), (Labels{"1e-3", "1e-2", "1"}));
  EXPECT_EQ(log_tick_labels({0.1, 1, 10}), (Labels{"0.1", "1", "10"}));
  EXPECT_EQ(log_tick_labels({2e5, 1e6}), (Labels{"2e5", "1e6"}));
}

/// Pixels of a colour, by row.
std::vector<int> rows_of(const core::Image& image, const render::Color& c) {
  std::vector<int> rows(std::size_t(image.height), 0);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const float* p = image.pixel(x, y);
      rows[std::size_t(y)] += p[0] == c.r && p[1] == c.g && p[2] == c.b && p[3] == 1;
    }
  return rows;
}

TEST(Overlay, BarShowsWhatIsBeyondTheRangeAndNaN) {
  render::ColorMap map("ramp", render::ColorSpace::linear, {{0, 0, 0, 0}, {1, 1, 1, 1}});
  map.set_scale(render::Scale::log);
  const render::Color red{1, 0, 0}, blue{0, 0, 1}, green{0, 1, 0};
  map.set_nan_color(green);
  const auto drawn = [&](const render::ColorMap& colors, bool names_nan) {
    core::Image image(300, 240);
    Overlay overlay;
    overlay.names_nan = names_nan;
    draw_scalar_bar(image, {colors, 1e-3, 10}, "density", overlay);
    return image;
  };
  const auto sum = [](const std::vector<int>& rows) {
    int all = 0;
    for (const int n : rows)
      all += n;
    return all;
  };
  const core::Image plain = drawn(map, false);
  EXPECT_EQ(sum(rows_of(plain, red)) + sum(rows_of(plain, blue)) + sum(rows_of(plain, green)), 0);
  map.set_below(blue);
  map.set_above(red);
  const core::Image full = drawn(map, true);
  const std::vector<int> above = rows_of(full, red), below = rows_of(full, blue);
  // The bar is from row 60 to row 180; triangles become narrower outwards.
  EXPECT_GT(above[57], above[54]);
  EXPECT_GT(above[54], 0);
  EXPECT_EQ(above[60], 0);
  EXPECT_GT(below[182], below[185]);
  EXPECT_EQ(below[179], 0);
  EXPECT_GT(sum(rows_of(full, green)), 30);
  EXPECT_EQ(sum(rows_of(drawn(map, false), green)), 0);
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
  draw_time_label(image, TimeLabel()(0.25, 120));
  double ink = 0;
  for (int y = 50; y < 100; ++y)
    for (int x = 0; x < 150; ++x)
      ink += image.pixel(x, y)[3];
  EXPECT_GT(ink, 50);
  for (const int side : {1, 5, 20, 40}) {
    core::Image tiny(side, side);
    draw_time_label(tiny, TimeLabel()(1e300, 0));
    draw_scalar_bar(tiny, {render::ColorMap::built_in("grey"), 0, 0}, "a long title of a field");
  }
}

/// Which axis a pixel belongs to, by the channel that stands out: 0 to 2, or -1.
int axis_at(const core::Image& image, double x, double y) {
  const float* p = image.pixel(int(x), int(y));
  for (int a = 0; a < 3; ++a)
    if (p[3] > 0 && p[a] > 0.2f + std::max(p[(a + 1) % 3], p[(a + 2) % 3]))
      return a;
  return -1;
}

TEST(Overlay, AxesPointWhereTheCameraSeesThem) {
  const math::Vec3d units[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  int checked = 0;
  for (const double height : {0.0, 2.0}) // orthographic too
    for (const double azimuth : {0.0, 90.0, 35.0, 200.0})
      for (const double elevation : {0.0, 20.0, -60.0, 90.0}) {
        render::Camera camera = render::Camera::around({0, 0, 0}, {1, 1, 1}, azimuth, elevation);
        camera.orthographic_height = height;
        core::Image image(400, 300);
        std::fill(image.rgba.begin(), image.rgba.end(), 1.0f);
        draw_axes(image, render::CameraAxes(camera));
        const AxesPlace place = axes_place(image);
        ASSERT_GT(place.length, 20);
        // Against the camera's own rays: where a short step along each axis goes.
        const render::RayGenerator rays(camera, 400, 300);
        const auto middle = *rays.project(camera.look_at);
        for (int a = 0; a < 3; ++a) {
          const auto step = *rays.project(camera.look_at + 1e-6 * units[a]);
          double d[2] = {step[0] - middle[0], step[1] - middle[1]};
          const double across = std::hypot(d[0], d[1]);
          const auto x_step =
              rays.project(camera.look_at + 1e-6 * render::CameraAxes(camera).right);
          const double scale = place.length / ((*x_step)[0] - middle[0]);
          if (across * scale < 0.3 * place.length)
            continue;           // towards the viewer, or nearly so
          bool covered = false; // by another axis that is seen in the same direction
          for (int b = 0; b < 3; ++b) {
            const auto other = *rays.project(camera.look_at + 1e-6 * units[b]);
            const double e[2] = {other[0] - middle[0], other[1] - middle[1]};
            covered |= b != a && d[0] * e[0] + d[1] * e[1] > 0.95 * across * std::hypot(e[0], e[1]);
          }
          if (covered)
            continue;
          ++checked;
          // Near the tip, where no other axis is.
          EXPECT_EQ(axis_at(image, place.x + 0.9 * scale * d[0], place.y + 0.9 * scale * d[1]), a)
              << azimuth << " " << elevation;
          EXPECT_NE(axis_at(image, place.x - 0.9 * scale * d[0], place.y - 0.9 * scale * d[1]), a)
              << azimuth << " " << elevation;
        }
      }
  EXPECT_GT(checked, 60);
}

TEST(Overlay, TheNearestAxisIsDrawnLast) {
  // Seen along -x: x comes towards the viewer, over the others' beginnings.
  core::Image image(400, 300);
  const AxesPlace place = axes_place(image);
  draw_axes(image, render::CameraAxes(render::Camera::around({0, 0, 0}, {1, 1, 1}, 0, 0)));
  EXPECT_EQ(axis_at(image, place.x, place.y), 0);
  core::Image behind(400, 300);
  draw_axes(behind, render::CameraAxes(render::Camera::around({0, 0, 0}, {1, 1, 1}, 180, 0)));
  EXPECT_NE(axis_at(behind, place.x, place.y), 0);
  EXPECT_GT(image.pixel(int(place.x), int(place.y))[3], 0.9f); // on a transparent background too
  core::Image small(40, 300);
  draw_axes(small, render::CameraAxes(render::Camera()));
  EXPECT_EQ(*std::max_element(small.rgba.begin(), small.rgba.end()), 0.0f);
}

} // namespace
} // namespace insitu::output
