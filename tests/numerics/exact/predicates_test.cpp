/// Every stage of every predicate against integers of unlimited length.

#include <boost/multiprecision/cpp_int.hpp>
#include <functional>
#include <gtest/gtest.h>

#include "cases.h"
#include "math/exact_integer.h"
#include "math/predicates_exact.h"

namespace insitu::test {
namespace {

using boost::multiprecision::cpp_int;
using math::ExactInteger;
using IntVec = std::array<cpp_int, 3>;

/// value * 2^1074, an integer for every finite double.
cpp_int scaled(double value) {
  int exponent = 0;
  const auto mantissa = static_cast<std::int64_t>(std::ldexp(std::frexp(value, &exponent), 53));
  cpp_int r = mantissa;
  const int shift = exponent - 53 + 1074;
  return shift >= 0 ? cpp_int(r * (cpp_int(1) << shift)) : cpp_int(r / (cpp_int(1) << -shift));
}
IntVec difference(const Vec3d& a, const Vec3d& b) {
  return {scaled(a.x) - scaled(b.x), scaled(a.y) - scaled(b.y), scaled(a.z) - scaled(b.z)};
}
cpp_int determinant(const IntVec& a, const IntVec& b, const IntVec& c) {
  return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
         a[2] * (b[0] * c[1] - b[1] * c[0]);
}
cpp_int volume(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  return determinant(difference(a, d), difference(b, d), difference(c, d));
}

struct StageCounts {
  int filter = 0, double_double = 0, exact = 0, zero = 0;
};

/// A decided stage must be right, and the last must always be.
void check(int filter, int double_double, int exact, int combined, int truth, StageCounts& counts,
           const std::function<std::string()>& text) {
  ASSERT_EQ(exact, truth) << "exact stage, " << text();
  ASSERT_EQ(combined, truth) << "all stages, " << text();
  if (filter != math::undecided) {
    ASSERT_EQ(filter, truth) << "filter, " << text();
    ++counts.filter;
  } else if (double_double != math::undecided) {
    ++counts.double_double;
  } else {
    ++counts.exact;
  }
  if (double_double != math::undecided) {
    ASSERT_EQ(double_double, truth) << "double-double, " << text();
  }
  counts.zero += truth == 0;
}

std::string describe_points(const std::vector<Vec3d>& points) {
  std::string text;
  char line[120];
  for (const Vec3d& p : points) {
    std::snprintf(line, sizeof line, "{%a, %a, %a}\n", p.x, p.y, p.z);
    text += line;
  }
  return text;
}

/// Five points in special position, up to rounding: q is a combination of the others, or on the
/// patch of them, before it is nudged; `scale` puts them anywhere in the range of doubles.
struct Configuration {
  std::array<Vec3d, 4> p;
  Vec3d q;
};
Configuration near_degenerate(Random& random, double offset, const Vec3d& scale, bool integer) {
  Configuration c;
  const auto place = [&](const Vec3d& p) {
    return Vec3d{scale.x * (p.x + offset), scale.y * (p.y + offset), scale.z * (p.z + offset)};
  };
  for (Vec3d& p : c.p) {
    p = integer ? Vec3d{double(random.below(8)), double(random.below(8)), double(random.below(8))}
                : random.uniform({0, 0, 0}, {1, 1, 1});
    p = place(p);
  }
  const double u = random.below(9) / 8.0, v = random.below(9) / 8.0;
  switch (random.below(4)) {
  case 0:
    c.q = (1 - u) * c.p[0] + u * (0.5 * c.p[1] + 0.5 * c.p[2]);
    break; // in a face's plane
  case 1:
    c.q = (1 - u) * c.p[0] + u * c.p[2];
    break;
  default:
    c.q = ((1 - u) * (1 - v)) * c.p[0] + (u * (1 - v)) * c.p[1] + (u * v) * c.p[2] +
          ((1 - u) * v) * c.p[3];
  }
  if (random.below(2) == 0)
    c.q = nudge(c.q, random, 2);
  if (random.below(4) == 0)
    c.q = place(random.uniform({0, 0, 0}, {1, 1, 1}));
  return c;
}

void check_configuration(const Configuration& c, StageCounts& flat, StageCounts& solid,
                         StageCounts& patch) {
  const Vec3d &a = c.p[0], &b = c.p[1], &d = c.p[2], &e = c.p[3], &q = c.q;
  const auto text = [&] { return describe_points({a, b, d, e, q}); };
  math::Predicates all;
  const IntVec aq = difference(a, q), bq = difference(b, q);
  check(math::orient2d_filter(a.x, a.y, b.x, b.y, q.x, q.y),
        math::orient2d_double_double(a.x, a.y, b.x, b.y, q.x, q.y),
        math::orient2d_exact(a.x, a.y, b.x, b.y, q.x, q.y),
        all.orient2d(a.x, a.y, b.x, b.y, q.x, q.y), cpp_int(aq[0] * bq[1] - aq[1] * bq[0]).sign(),
        flat, text);
  check(math::orient3d_filter(a, b, d, q), math::orient3d_double_double(a, b, d, q),
        math::orient3d_exact(a, b, d, q), all.orient3d(a, b, d, q), volume(a, b, d, q).sign(),
        solid, text);
  const cpp_int w0 = -volume(b, d, e, q), w1 = volume(a, d, e, q);
  const cpp_int w2 = -volume(a, b, e, q), w3 = volume(a, b, d, q);
  check(math::bilinear_side_filter(a, b, d, e, q), math::bilinear_side_double_double(a, b, d, e, q),
        math::bilinear_side_exact(a, b, d, e, q), all.bilinear_side(a, b, d, e, q),
        cpp_int(w0 * w2 - w1 * w3).sign(), patch, text);
}

void run(std::uint64_t seed, int count, double offset, double scale, bool integer,
         bool double_double_expected) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  StageCounts flat, solid, patch;
  for (int i = 0; i < count; ++i) {
    check_configuration(near_degenerate(random, offset, {scale, scale, scale}, integer), flat,
                        solid, patch);
    if (testing::Test::HasFatalFailure())
      return;
  }
  for (const StageCounts& counts : {flat, solid, patch}) {
    EXPECT_GT(counts.exact, 0);
    EXPECT_GT(counts.zero, 0);
    if (double_double_expected) {
      EXPECT_GT(counts.filter, count / 10);
      EXPECT_GT(counts.double_double, 0);
    }
  }
}

TEST(Predicates, NearDegenerate) {
  run(201, 20000, 0.0, 1.0, false, true);
}
TEST(Predicates, NearDegenerateOffset) {
  run(202, 20000, 1e7, 1.0, false, false);
}
TEST(Predicates, SmallIntegers) {
  run(203, 20000, 0.0, 1.0, true, false);
}
TEST(Predicates, Overflowing) {
  run(204, 3000, -0.5, 0x1p+1023, false, false);
}
TEST(Predicates, Large) {
  run(205, 3000, 0.0, 0x1p+400, false, false);
}
TEST(Predicates, LargestThatTheFilterTakes) {
  run(206, 3000, -0.5, 0x1p+149, false, true);
}
TEST(Predicates, Small) {
  run(207, 3000, 0.0, 0x1p-250, false, false);
}
TEST(Predicates, Subnormal) {
  run(208, 3000, 0.0, 0x1p-1060, false, false);
}

/// Where products of two, three or six differences underflow or overflow, in part or in all.
TEST(Predicates, AllScales) {
  constexpr std::uint64_t seed = 212;
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  StageCounts flat, solid, patch;
  for (int k = -1070; k <= 1020; k += 5) {
    for (int i = 0; i < 20; ++i) {
      const auto scale = [&](int low, int high) {
        return std::ldexp(1.0, std::min(1020, low + random.below(high - low + 1)));
      };
      const double even = scale(k, k + 4);
      const Vec3d uneven = {scale(-1070, 1020), scale(-1070, 1020), scale(-1070, 1020)};
      // x y is next to underflow and z brings it back.
      const Vec3d rescued = {scale(-545, -525), scale(-545, -525), scale(100, 1020)};
      for (const Vec3d& s : {Vec3d{even, even, even}, uneven, rescued}) {
        check_configuration(near_degenerate(random, 0.0, s, false), flat, solid, patch);
        if (HasFatalFailure())
          return;
      }
    }
  }
  EXPECT_GT(patch.filter, 0);
}

/// Coordinates of all magnitudes in one predicate.
TEST(Predicates, AllExponents) {
  constexpr std::uint64_t seed = 209;
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  StageCounts flat, solid, patch;
  for (int i = 0; i < 2000; ++i) {
    Configuration c;
    const auto any = [&random] {
      const double fraction = random.uniform(-1, 1);
      return random.below(4) == 0 ? 0.0 : std::ldexp(fraction, random.below(2097) - 1073);
    };
    for (Vec3d& p : c.p)
      p = {any(), any(), any()};
    c.q = {any(), any(), any()};
    if (random.below(4) == 0)
      c.p[3] = c.p[random.below(3)];
    check_configuration(c, flat, solid, patch);
    if (HasFatalFailure())
      return;
  }
  EXPECT_GT(patch.exact, 0);
}

/// A corner moved by far less than double-double resolves: undecided there, never wrong.
TEST(Predicates, PerturbationOfOneCorner) {
  for (int k : {20, 60, 90, 120, 300, 1000, 1074}) {
    for (int direction : {-1, 0, 1}) {
      // The patch z = x y, but for p00; q is on it for direction 0.
      const double step = direction * std::ldexp(1.0, -k);
      const Vec3d p00{0, 0, step}, p10{1, 0, 0}, p11{1, 1, 1}, p01{0, 1, 0}, q{0.5, 0.5, 0.25};
      math::Predicates all;
      // Raising p00 leaves q below the patch; the diagonal p00-p11 is above it.
      EXPECT_EQ(all.bilinear_side(p00, p10, p11, p01, q), -direction) << "k " << k;
      const math::Stage stage = direction == 0 || k >= 120 ? math::Stage::exact
                                : k >= 60                  ? math::Stage::double_double
                                                           : math::Stage::filter;
      EXPECT_EQ(all.deepest, stage) << "k " << k;
    }
  }
}

TEST(ExactInteger, AgreesWithUnlimitedIntegers) {
  constexpr std::uint64_t seed = 210;
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  for (int i = 0; i < 2000; ++i) {
    const int span = 1 + random.below(2097);
    std::array<double, 4> x;
    for (double& value : x) {
      value = std::ldexp(random.uniform(-1, 1), random.below(span) - 1073);
      if (random.below(8) == 0)
        value = std::ldexp(1.0, random.below(span) - 1074);
    }
    std::array<ExactInteger, 4> e;
    std::array<cpp_int, 4> r;
    for (int k = 0; k < 4; ++k)
      e[k] = ExactInteger(x[k], -1074), r[k] = scaled(x[k]);
    EXPECT_EQ((e[0] * e[1] - e[2] * e[3]).sign(), cpp_int(r[0] * r[1] - r[2] * r[3]).sign());
    // Identities that vanish only if every limb is right.
    const ExactInteger s = e[0] + e[1], t = e[2] - e[3];
    EXPECT_EQ((s * t - (e[0] * e[2] + e[1] * e[2] - e[0] * e[3] - e[1] * e[3])).sign(), 0);
    const ExactInteger one(std::ldexp(1.0, -1074), -1074);
    EXPECT_EQ((s * t - (s * t + one)).sign(), -1);
    EXPECT_EQ(((s * t) * (s * t) - one - (s * s) * (t * t)).sign(), -1);
  }
}

TEST(Expansion, TransformsAreErrorFree) {
  constexpr std::uint64_t seed = 211;
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  for (int i = 0; i < 20000; ++i) {
    const double a = std::ldexp(random.uniform(-1, 1), random.below(200) - 100);
    const double b = std::ldexp(random.uniform(-1, 1), random.below(200) - 100);
    const auto sum = math::two_sum(a, b), difference = math::two_difference(a, b);
    ASSERT_EQ(scaled(sum.hi) + scaled(sum.lo), scaled(a) + scaled(b));
    ASSERT_EQ(scaled(difference.hi) + scaled(difference.lo), scaled(a) - scaled(b));
    const auto product = math::two_product(a, b);
    ASSERT_EQ((scaled(product.hi) + scaled(product.lo)) << 1074, scaled(a) * scaled(b));
  }
}

} // namespace
} // namespace insitu::test
