#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "core/status.h"
#include "render/transfer_function.h"

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

} // namespace
} // namespace insitu::render
