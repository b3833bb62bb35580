#include <gtest/gtest.h>
#include <random>

#include "math/exact_integer.h"
#include "math/exact_sum.h"

using insitu::math::ExactInteger;
using insitu::math::ExactSum;

namespace {

/// Doubles of all exponents, or of a few so that many sums cancel.
std::vector<double> numbers(std::uint64_t seed, std::size_t count, int exponents) {
  std::mt19937_64 engine(seed);
  std::vector<double> all;
  while (all.size() < count) {
    const std::uint64_t sign_and_fraction = engine() & 0x800fffffffffffff;
    const std::uint64_t exponent = exponents ? 1023 + engine() % std::uint64_t(exponents)
                                             : engine() % 2046; // 0: subnormal numbers
    all.push_back(std::bit_cast<double>(sign_and_fraction | exponent << 52));
    if (engine() % 3 == 0)
      all.push_back(-all[engine() % all.size()]);
  }
  return all;
}

ExactInteger integer(double value) {
  return {value, -1074};
}

double mean(const std::vector<double>& values, std::int64_t count) {
  ExactSum sum;
  for (const double v : values)
    sum.add(v);
  return sum.mean(count);
}

} // namespace

/// Held against integers of any length: the sum lies within half a gap between doubles.
TEST(ExactSum, IsTheNearestDouble) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const std::vector<double> values = numbers(seed, 1 + seed % 50, int(seed % 4) * 30);
    ExactInteger twice;
    for (const double v : values)
      twice = twice + integer(v) + integer(v);
    const double found = mean(values, 1);
    ASSERT_TRUE(std::isfinite(found)) << seed;
    const double above = std::nextafter(found, HUGE_VAL), below = std::nextafter(found, -HUGE_VAL);
    if (std::isfinite(above) && std::isfinite(below)) {
      EXPECT_LE((twice - integer(found) - integer(above)).sign(), 0) << seed;
      EXPECT_GE((twice - integer(found) - integer(below)).sign(), 0) << seed;
    }
  }
}

TEST(ExactSum, DoesNotDependOnOrderNorOnParts) {
  std::mt19937_64 engine(5);
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    std::vector<double> values = numbers(seed, 500, int(seed % 3) * 40);
    const double found = mean(values, 500);
    std::shuffle(values.begin(), values.end(), engine);
    EXPECT_EQ(mean(values, 500), found);
    std::vector<ExactSum> parts(1 + seed % 8);
    for (const double v : values)
      parts[engine() % parts.size()].add(v);
    ExactSum together, by_words;
    for (ExactSum& part : parts) {
      together.add(part);
      for (std::size_t i = 0; i < ExactSum::word_count; ++i)
        by_words.words()[i] += part.words()[i];
    }
    EXPECT_EQ(together.mean(500), found);
    EXPECT_EQ(by_words.mean(500), found);
  }
}

TEST(ExactSum, RoundsTiesToEven) {
  constexpr double ulp = 0x1p-52;
  EXPECT_EQ(mean({1.0, ulp / 2}, 1), 1.0);
  EXPECT_EQ(mean({1.0 + ulp, ulp / 2}, 1), 1.0 + 2 * ulp);
  EXPECT_EQ(mean({1.0, ulp / 2, 0x1p-1074}, 1), 1.0 + ulp);
  EXPECT_EQ(mean({-1.0, -ulp / 2, -0x1p-1074}, 1), -1.0 - ulp);
  EXPECT_EQ(mean({1.0, ulp / 2, -0x1p-1074}, 1), 1.0);
  EXPECT_EQ(mean({1e300, 1.0, -1e300}, 1), 1.0);
  EXPECT_EQ(mean({0x1p-1074, 0x1p-1074}, 1), 0x1p-1073);
}

TEST(ExactSum, OfNothingAndOfInfinities) {
  EXPECT_EQ(mean({}, 1), 0.0);
  EXPECT_EQ(mean({-0.0}, 1), 0.0);
  EXPECT_EQ(mean({HUGE_VAL, -1e308}, 2), HUGE_VAL);
  EXPECT_EQ(mean({-HUGE_VAL, 1e308}, 2), -HUGE_VAL);
  EXPECT_TRUE(std::isnan(mean({-HUGE_VAL, HUGE_VAL}, 2)));
  const double most = std::numeric_limits<double>::max();
  EXPECT_EQ(mean({most, most, most}, 3), most); // the sum is no double
  EXPECT_EQ(mean({-most, -most}, 2), -most);
}
