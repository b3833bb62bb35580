#include <cmath>
#include <cstring>
#include <gtest/gtest.h>

#include "core/status.h"
#include "render/color/preintegration.h"
#include "render/path/medium.h"
#include "render/structures/structures.h"
#include "unit/render/render_mesh.h"

/// Colours over a logarithmic range, and beyond a range.
namespace insitu::test {
namespace {

using render::Classifier;
using render::Color;
using render::ColorMap;
using render::ColorSpace;
using render::ColorTable;
using render::OpacityPoint;
using render::Scale;
using render::TransferFunction;

/// From black to white as linear light: the green channel is the place in the range.
ColorMap ramp(Scale scale) {
  ColorMap map("ramp", ColorSpace::linear, {{0, 0, 0, 0}, {1, 1, 1, 1}}, {0.25f, 0.5f, 0.75f});
  map.set_scale(scale);
  return map;
}

ColorMap with_ends(Scale scale) {
  ColorMap map = ramp(scale);
  map.set_below({1, 0, 0});
  map.set_above({0, 0, 1});
  return map;
}

void expect_color(const Color& c, float r, float g, float b, double value) {
  EXPECT_FLOAT_EQ(c.r, r) << value;
  EXPECT_FLOAT_EQ(c.g, g) << value;
  EXPECT_FLOAT_EQ(c.b, b) << value;
}

TEST(ColorScale, LogarithmicPlacesAreThoseOfTheLogarithm) {
  const TransferFunction f(ramp(Scale::log), 1e-3, 1e2);
  const ColorTable table(f);
  for (int i = 0; i <= 1000; ++i) {
    const double u = i / 1000.0, value = std::pow(10.0, -3 + 5 * u);
    EXPECT_NEAR(f.color(value).g, u, 1e-6) << value;
    // 4096 entries; in those that a power of two divides the slope changes by a half.
    EXPECT_NEAR(table(value).g, u, 1.0 / 4096 / 4) << value;
  }
  for (const double value : {0.0, -0.0, -1e-300, -5.0, -HUGE_VAL, 1e-310, 9.99e-4}) {
    EXPECT_EQ(f.color(value).g, 0.0f) << value;
    EXPECT_EQ(table(value).g, 0.0f) << value;
  }
  for (const double value : {1e2, 101.0, 1e308, double(HUGE_VAL)}) {
    EXPECT_EQ(f.color(value).g, 1.0f) << value;
    EXPECT_EQ(table(value).g, 1.0f) << value;
  }
}

TEST(ColorScale, HugeRanges) {
  for (const auto& [low, high] : {std::pair{1e-300, 1e300},
                                  {3e-308, 1e-306},
                                  {1e300, 1.7e308},
                                  {1.0, std::nextafter(1.0, 2.0)}}) {
    const TransferFunction f(ramp(Scale::log), low, high);
    const ColorTable table(f);
    float last = 0;
    for (int i = 0; i <= 500; ++i) {
      const double value = std::min(high, std::max(low, f.value_between(low, high, i / 500.0)));
      const float g = table(value).g;
      EXPECT_GE(g, last - 1e-6f) << low << " " << value;
      EXPECT_NEAR(g, f.color(value).g, 0.01) << low << " " << value;
      last = g;
    }
    EXPECT_EQ(table(low).g, 0.0f);
    EXPECT_EQ(table(high).g, 1.0f);
  }
}

TEST(ColorScale, ColoursBeyondTheRangeBeginJustBeyondIt) {
  for (const Scale scale : {Scale::linear, Scale::log}) {
    const TransferFunction f(with_ends(scale), 0.3, 0.7, {{0, 0.5}});
    const ColorTable table(f);
    const Classifier classifier(f, 1, 1);
    for (const double value : {std::nextafter(0.3, 0.0), 0.0, -1.0, -HUGE_VAL}) {
      expect_color(f.color(value), 1, 0, 0, value);
      expect_color(table(value), 1, 0, 0, value);
      expect_color(classifier(value).color, 1, 0, 0, value);
    }
    for (const double value : {std::nextafter(0.7, 1.0), 1.0, double(HUGE_VAL)}) {
      expect_color(f.color(value), 0, 0, 1, value);
      expect_color(table(value), 0, 0, 1, value);
      expect_color(classifier(value).color, 0, 0, 1, value);
    }
    expect_color(table(0.3), 0, 0, 0, 0.3); // the ends belong to the range
    expect_color(table(0.7), 1, 1, 1, 0.7);
    expect_color(f.color(std::nan("")), 0.25f, 0.5f, 0.75f, 0);
    // A range of one value.
    const ColorTable point(TransferFunction(with_ends(scale), 2, 2));
    expect_color(point(std::nextafter(2.0, 0.0)), 1, 0, 0, 2);
    expect_color(point(2), 1, 1, 1, 2);
    expect_color(point(2.1), 0, 0, 1, 2.1);
  }
}

TEST(ColorScale, OpacityGoesByTheLogarithmBetweenPointsAboveZero) {
  const TransferFunction f(ramp(Scale::log), 1e-4, 1,
                           {{-1, 0.2}, {1e-4, 0}, {1e-2, 0.8}, {1e-2, 0.1}, {1, 0.6}});
  EXPECT_NEAR(f.opacity(1e-3), 0.4, 1e-12);
  EXPECT_NEAR(f.opacity(0.1), 0.35, 1e-12);
  EXPECT_NEAR(f.opacity(-0.5), 0.1, 1e-4); // linear where a point is not above 0
  EXPECT_NEAR(f.opacity(std::nextafter(1e-2, 0)), 0.8, 1e-12);
  EXPECT_NEAR(f.opacity_below(1e-2), 0.8, 1e-12);
  EXPECT_DOUBLE_EQ(f.opacity(1e-2), 0.1);
  const Classifier classifier(f, 0.05, 0.2);
  for (std::uint64_t i = 0; i < 20000; ++i) {
    const double value = std::pow(10.0, -5 + 6 * core::random_unit(3, i, 0));
    const double expected = -std::expm1(0.25 * std::log1p(-f.opacity(value)));
    EXPECT_NEAR(classifier(value).alpha, expected, 1e-4) << value;
    EXPECT_GE(f.max_opacity(0.5 * value, 2 * value) + 1e-15, f.opacity(value)) << value;
  }
}

TEST(ColorScale, RefusesRangesThatHaveNoLogarithm) {
  for (const double low : {0.0, -1.0})
    try {
      TransferFunction(ramp(Scale::log), low, 1);
      ADD_FAILURE() << low;
    } catch (const core::Error& e) {
      EXPECT_NE(std::string(e.what()).find("a logarithmic range must begin above 0"),
                std::string::npos);
    }
}

/// Against the mean over the values between, which a quadrature even in the value finds.
TEST(ColorScale, PreintegrationOverDecadesAndBeyondTheRange) {
  const double step = 0.3, unit = 0.7;
  for (const Scale scale : {Scale::linear, Scale::log}) {
    const TransferFunction f(with_ends(scale), 1e-3, 0.5,
                             {{0, 0.1}, {1e-3, 0.1}, {0.1, 0.6}, {0.3, 0.2}, {1, 0.9}});
    const render::Preintegration integral(f, step, unit);
    for (std::uint64_t i = 0; i < 60; ++i) {
      double ends[2];
      for (std::uint64_t e = 0; e < 2; ++e)
        ends[e] = i % 3 == 0 ? -0.2 + 1.4 * core::random_unit(5, i, e)
                             : std::pow(10.0, -4 + 4 * core::random_unit(5, i, e));
      double depth = 0, color[3] = {0, 0, 0};
      constexpr int count = 100000;
      for (int k = 0; k < count; ++k) {
        const double v = ends[0] + (ends[1] - ends[0]) * (k + 0.5) / count;
        const double t = -std::log1p(-f.opacity(v));
        const Color c = f.color(v);
        depth += t / count;
        color[0] += t * c.r / count;
        color[1] += t * c.g / count;
        color[2] += t * c.b / count;
      }
      const render::ColorSample s = integral(ends[0], ends[1]);
      EXPECT_NEAR(s.alpha, -std::expm1(-depth * step / unit), 1e-4) << ends[0] << " " << ends[1];
      EXPECT_NEAR(s.color.r, color[0] / depth, 2e-3) << ends[0] << " " << ends[1];
      EXPECT_NEAR(s.color.g, color[1] / depth, 2e-3) << ends[0] << " " << ends[1];
      EXPECT_NEAR(s.color.b, color[2] / depth, 2e-3) << ends[0] << " " << ends[1];
    }
  }
}

bool same(const core::Image& a, const core::Image& b) {
  return std::memcmp(a.rgba.data(), b.rgba.data(), a.rgba.size() * sizeof(float)) == 0;
}

double decades(const Vec3d& p) {
  return std::pow(10.0, -5 + 6 * p.z) - 2e-5; // negative at the bottom
}

/// Skipping what is empty, pre-integration and a tolerance agree on a logarithmic function too.
TEST(ColorScale, VolumesByEveryMode) {
  RenderMesh mesh(12, Shape::hexahedron, 0.2);
  const auto field = mesh.field("f", INSITU_VERTEX, decades);
  render::FrameSettings s = box_frame(24);
  s.volume = render::VolumeSettings{
      field, TransferFunction(with_ends(Scale::log), 1e-3, 1, {{1e-2, 0}, {1e-1, 0.3}, {1, 0.5}})};
  s.volume->unit_distance = 0.3;
  s.volume->step = 0.0005;
  const core::Image truth = mesh.draw(s);
  s.volume->skip_empty = false;
  EXPECT_TRUE(same(truth, mesh.draw(s)));
  s.volume->skip_empty = true;
  const auto difference = [&] {
    const core::Image image = mesh.draw(s);
    double most = 0;
    for (std::size_t i = 0; i < image.rgba.size(); ++i)
      most = std::max(most, std::fabs(double(image.rgba[i]) - double(truth.rgba[i])));
    return most;
  };
  s.volume->preintegrated = true;
  EXPECT_LT(difference(), 2e-3);
  s.volume->preintegrated = false;
  s.volume->step.reset();
  s.volume->tolerance = 0.01;
  EXPECT_LT(difference(), 0.01);
}

/// Majorants of a linear function do not stand in for those of a logarithmic one.
TEST(ColorScale, MajorantsFollowTheScale) {
  RenderMesh mesh(8);
  const auto field = mesh.field("f", INSITU_VERTEX, decades);
  render::Structures structures(mesh.committed.memory);
  structures.begin(mesh.sampler(), 1, 1, mesh.committed.threads);
  const std::vector<OpacityPoint> points{{1e-3, 0}, {1, 0.8}};
  const auto grid = render::Macrocells::grid_of(mesh.sampler(), 4);
  double sums[2] = {0, 0};
  for (const Scale scale : {Scale::linear, Scale::log}) {
    const auto& m =
        structures.majorants(field, TransferFunction(ramp(scale), 1e-3, 1, points), &grid);
    for (std::int64_t i = 0; i < m.grid().count(); ++i)
      sums[scale == Scale::log] += double(m.opacity(i));
  }
  EXPECT_GT(sums[1], 1.2 * sums[0]);
}

/// Albedos are those of the function, by values' logarithms and beyond the range.
TEST(ColorScale, AlbedosOfAMedium) {
  RenderMesh mesh(4);
  const auto field = mesh.field("f", INSITU_VERTEX, decades);
  render::Structures structures(mesh.committed.memory);
  structures.begin(mesh.sampler(), 1, 1, mesh.committed.threads);
  const TransferFunction f(with_ends(Scale::log), 1e-3, 1, {{1e-3, 0.1}, {1, 0.8}});
  render::VolumeSettings volume{field, f};
  volume.unit_distance = 0.1;
  const render::Medium medium(mesh.sampler(), volume, 1, structures.majorants(field, f),
                              mesh.committed.threads, mesh.committed.memory);
  for (const double value : {-1.0, 0.0, 5e-4, 1e-3, 3e-3, 0.2, 1.0, 7.0}) {
    const Color a = medium.albedo(value), b = f.color(value);
    EXPECT_NEAR(a.r, b.r, 1e-4) << value;
    EXPECT_NEAR(a.g, b.g, 1e-4) << value;
    EXPECT_NEAR(a.b, b.b, 1e-4) << value;
    EXPECT_NEAR(medium.extinction(value), -std::log1p(-f.opacity(value)) / 0.1, 1e-12) << value;
  }
  EXPECT_FLOAT_EQ(medium.albedo(std::nan("")).b, 0.75f);
}

} // namespace
} // namespace insitu::test
