// What kernels take from the hardware of a card, as it is computed on the host.
#include <bit>
#include <cfenv>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "device/arithmetic.cuh"
#include "numerics/exact/cases.h"

using namespace insitu;

namespace {

/// The difference by the processor's own rounding mode.
float rounded(float a, float b, int mode) {
  const volatile float x = a, y = b;
  std::fesetround(mode);
  const volatile float d = x - y;
  std::fesetround(FE_TONEAREST);
  return d;
}

} // namespace

TEST(DeviceArithmetic, DifferencesAreRoundedUpAndDown) {
  test::Random random(1);
  std::vector<float> values = {0.0f,       -0.0f,     1.0f,           0x1p-149f,
                               -0x1p-149f, 0x1p-126f, 0x1.fffffep127f};
  for (int i = 0; i < 300; ++i)
    values.push_back(float(random.uniform(-1, 1) * std::ldexp(1.0, random.below(100) - 50)));
  for (const float a : values)
    for (const float b : values) {
      EXPECT_EQ(device::difference_above(a, b), rounded(a, b, FE_UPWARD)) << a << " - " << b;
      EXPECT_EQ(device::difference_below(a, b), rounded(a, b, FE_DOWNWARD)) << a << " - " << b;
    }
}

TEST(DeviceArithmetic, BitsAndBytes) {
  EXPECT_EQ(device::count_bits(0xf0f0f0f1u), 17);
  EXPECT_EQ(device::lowest_bit(0x50u), 4);
  EXPECT_EQ(device::leading_zeros(std::uint32_t(1)), 31);
  EXPECT_EQ(device::leading_zeros(std::uint64_t(1) << 40), 23);
  EXPECT_EQ(device::bytes_at_most(0x00ff0510u, 0x00fe0511u), 0xff00ffffu);
  EXPECT_EQ(device::bytes_at_least(0x00ff0510u, 0x00fe0511u), 0xffffff00u);
}

TEST(DeviceArithmetic, WholeNumbersSaturate) {
  const float inf = std::numeric_limits<float>::infinity();
  EXPECT_EQ(device::whole_number(2.75f), 2u);
  EXPECT_EQ(device::whole_number(-3.0f), 0u);
  EXPECT_EQ(device::whole_number(std::nanf("")), 0u);
  EXPECT_EQ(device::whole_number(inf), 0xffffffffu);
}
