#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "core/random.h"
#include "core/status.h"
#include "render/color/transfer_function.h"

namespace insitu::render {
namespace {

ColorMap ramp() {
  return ColorMap("ramp", ColorSpace::linear, {{0, 0, 0, 0}, {1, 1, 1, 1}}, {0.25f, 0.5f, 0.75f});
}

TransferFunction constant_opaque() {
  return {ramp(), 0, 1, {{0, 1.0}}};
}

TEST(TransferFunction, OpacityBetweenAndBeyondItsPoints) {
  const TransferFunction f(ramp(), 0, 10, {{2, 0.1}, {4, 0.5}, {4, 0.9}, {6, 0.3}});
  EXPECT_DOUBLE_EQ(f.opacity(-1), 0.1);
  EXPECT_DOUBLE_EQ(f.opacity(2), 0.1);
  EXPECT_DOUBLE_EQ(f.opacity(3), 0.3);
  EXPECT_NEAR(f.opacity(std::nextafter(4.0, 0.0)), 0.5, 1e-12);
  EXPECT_DOUBLE_EQ(f.opacity(4), 0.9);
  EXPECT_DOUBLE_EQ(f.opacity(5), 0.6);
  EXPECT_DOUBLE_EQ(f.opacity(1e300), 0.3);
  EXPECT_DOUBLE_EQ(f.opacity(std::nan("")), 0.0);
  const TransferFunction standard(ramp(), 2, 6);
  EXPECT_DOUBLE_EQ(standard.opacity(2), 0.0);
  EXPECT_DOUBLE_EQ(standard.opacity(5), 0.75);
}

TEST(TransferFunction, ColorOverTheRange) {
  const TransferFunction f(ramp(), 2, 6);
  EXPECT_FLOAT_EQ(f.color(1).g, 0.0f);
  EXPECT_NEAR(f.color(3).g, 0.25f, 1e-6);
  EXPECT_FLOAT_EQ(f.color(7).g, 1.0f);
  EXPECT_FLOAT_EQ(f.color(std::nan("")).b, 0.75f);
  const TransferFunction point(ramp(), 3, 3);
  EXPECT_FLOAT_EQ(point.color(2.9).g, 0.0f);
  EXPECT_FLOAT_EQ(point.color(3).g, 1.0f);
}

TEST(TransferFunction, RefusesWhatDoesNotFit) {
  const auto refused = [](double low, double high, std::vector<OpacityPoint> points) {
    try {
      TransferFunction(ramp(), low, high, std::move(points));
    } catch (const core::Error& e) {
      return std::string(e.what());
    }
    return std::string("no error");
  };
  EXPECT_NE(refused(1, 0, {}).find("ascending"), std::string::npos);
  EXPECT_NE(refused(0, HUGE_VAL, {}).find("finite"), std::string::npos);
  EXPECT_EQ(refused(0, 1, {{0, 0}, {1, 1.5}}),
            "transfer function: opacity point 1 is 1.500000; 0 to 1 expected");
  EXPECT_NE(refused(0, 1, {{1, 0}, {0, 1}}).find("opacity point 1"), std::string::npos);
  EXPECT_EQ(refused(0, 1, {{0, 0}, {1, 1}}), "no error");
}

TEST(Classifier, CorrectsOpacityToTheStep) {
  const TransferFunction f(ramp(), 0, 1, {{0, 0.0}, {1, 0.8}});
  const Classifier c(f, 0.05, 0.2);
  for (const double v : {0.0, 0.125, 0.5, 0.7, 1.0}) {
    EXPECT_NEAR(c(v).alpha, 1 - std::pow(1 - 0.8 * v, 0.25), 1e-6) << v;
    if (v > 0) {
      EXPECT_NEAR(c(v).color.g, v, 1e-6);
    }
  }
  // Two half steps are one.
  const float half = Classifier::partial(c(0.7).alpha, 0.5);
  EXPECT_NEAR(1 - (1 - half) * (1 - half), c(0.7).alpha, 1e-6);
  EXPECT_FLOAT_EQ(Classifier::partial(1.0f, 0.1), 1.0f);
  EXPECT_FLOAT_EQ(Classifier(constant_opaque(), 0.05, 0.2)(0.3).alpha, 1.0f);
  EXPECT_THROW(Classifier(f, 0, 1), core::Error);
}

TEST(Classifier, ValuesThatAreNoNumbersAndBeyondTheEnds) {
  TransferFunction f(ramp(), 0, 1, {{0, 0.25}, {1, 0.5}});
  const Classifier plain(f, 1, 1);
  EXPECT_FLOAT_EQ(plain(std::nan("")).alpha, 0.0f);
  EXPECT_FLOAT_EQ(plain(HUGE_VAL).alpha, 0.5f);
  EXPECT_FLOAT_EQ(plain(-HUGE_VAL).alpha, 0.25f);
  EXPECT_FLOAT_EQ(plain(HUGE_VAL).color.g, 1.0f);
  f.set_nan_opacity(0.75);
  const Classifier shown(f, 1, 1);
  EXPECT_FLOAT_EQ(shown(std::nan("")).alpha, 0.75f);
  EXPECT_FLOAT_EQ(shown(std::nan("")).color.b, 0.75f);
  // A step of opacity at the lower end, and a range of one point.
  const Classifier step(TransferFunction(ramp(), 2, 2, {{2, 0.0}, {2, 1.0}}), 1, 1);
  EXPECT_FLOAT_EQ(step(1.999).alpha, 0.0f);
  EXPECT_FLOAT_EQ(step(2.001).alpha, 1.0f);
}

TEST(Classifier, FindsEachOfManyStretches) {
  const struct {
    double low, extent;
  } ranges[] = {{-3, 7}, {1e9, 1e-3}, {-1e308, 1.6e308}, {1e-290, 1e-290}, {0, 5e-324}};
  for (const auto& range : ranges)
    for (const int count : {2, 9, 10, 200}) {
      const auto value = [&](double u) { return range.low + range.extent * u; };
      std::vector<OpacityPoint> points;
      double u = 0;
      for (int i = 0; i < count; ++i) {
        points.push_back({value(u), core::random_unit(4, std::uint64_t(i), 0)});
        // Far apart and near, and steps where a value stands twice.
        u += (1 - u) *
             (i % 5 == 4   ? 0.0
              : i % 7 == 6 ? 0.3
                           : 2.0 / count) *
             core::random_unit(4, std::uint64_t(i), 1);
      }
      const TransferFunction f(ramp(), value(0), value(1), points);
      const Classifier c(f, 1, 1);
      const auto check = [&](double v) {
        const ColorSample s = c(v);
        ASSERT_NEAR(s.alpha, f.opacity(v), 1e-5) << v << " of " << count;
        if (s.alpha > 0) {
          ASSERT_NEAR(s.color.g, f.color(v).g, 1e-6) << v;
        }
      };
      for (const OpacityPoint& p : points)
        for (const double v :
             {p.value, std::nextafter(p.value, -HUGE_VAL), std::nextafter(p.value, HUGE_VAL)})
          check(v);
      for (int i = 0; i < 2000; ++i)
        check(value(1.2 * core::random_unit(5, std::uint64_t(i), 0) - 0.1));
    }
  // Decades: nearly all points are in the first part of the range.
  ColorMap decades = ramp();
  decades.set_scale(Scale::log);
  std::vector<OpacityPoint> points;
  for (int i = 0; i <= 100; ++i)
    points.push_back({std::pow(10.0, 0.1 * i - 5), core::random_unit(6, std::uint64_t(i), 0)});
  const TransferFunction f(decades, 1e-5, 1e5, points);
  const Classifier c(f, 1, 1);
  for (int i = 0; i < 2000; ++i) {
    const double v = std::pow(10.0, 11 * core::random_unit(7, std::uint64_t(i), 0) - 5.5);
    ASSERT_NEAR(c(v).alpha, f.opacity(v), 2e-2) << v; // linear between the logarithms of a table
  }
}

TEST(Classifier, KeepsStepsToTheBit) {
  // Where entries of the tables are, as near as rounding comes.
  const double low = 0.1, high = 0.7;
  for (int i = 1; i < Classifier::table_size; i += 13) {
    const double at = low + i * (high - low) / Classifier::table_size;
    for (const double p : {std::nextafter(at, 0.0), at, std::nextafter(at, 1.0)}) {
      const Classifier c(TransferFunction(ramp(), low, high, {{p, 0.2}, {p, 0.9}}), 1, 1);
      EXPECT_FLOAT_EQ(c(std::nextafter(p, 0.0)).alpha, 0.2f) << i;
      EXPECT_FLOAT_EQ(c(p).alpha, 0.9f) << i;
      EXPECT_FLOAT_EQ(c(std::nextafter(p, 1.0)).alpha, 0.9f) << i;
    }
  }
}

} // namespace
} // namespace insitu::render
