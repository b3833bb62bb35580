// What path tracing is made of: random numbers, phase functions, lights.
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <set>

#include "core/status.h"
#include "render/path/path_lights.h"
#include "render/path/path_random.h"
#include "render/path/phase_function.h"

namespace insitu::test {
namespace {

using math::Vec3d;
using render::Light;
using render::PathRandom;

TEST(PathRandom, IsAFunctionOfItsKeysAlone) {
  std::set<std::uint64_t> seen;
  for (std::uint64_t seed = 0; seed < 3; ++seed)
    for (std::uint64_t cycle = 0; cycle < 3; ++cycle)
      for (std::uint64_t pixel = 0; pixel < 30; ++pixel)
        for (std::uint64_t sample = 0; sample < 30; ++sample) {
          PathRandom a(seed, cycle, pixel, sample), b(seed, cycle, pixel, sample);
          for (int k = 0; k < 10; ++k) {
            const std::uint64_t bits = a.bits();
            EXPECT_EQ(bits, b.bits());
            seen.insert(bits);
          }
        }
  EXPECT_EQ(seen.size(), 3u * 3 * 30 * 30 * 10);
}

/// Uniform, and not correlated along a path, from sample to sample or from pixel to pixel.
TEST(PathRandom, IsUniformAndUncorrelated) {
  constexpr int pixels = 64, samples = 64, draws = 32;
  std::array<double, 16> bins{};
  double along = 0, across_samples = 0, across_pixels = 0;
  const double n = double(pixels) * samples * draws;
  std::vector<double> of_pixel(std::size_t(samples * draws)), of_sample(draws);
  for (int pixel = 0; pixel < pixels; ++pixel)
    for (int sample = 0; sample < samples; ++sample) {
      PathRandom random(7, 1, std::uint64_t(pixel), std::uint64_t(sample));
      double last = 0;
      for (int k = 0; k < draws; ++k) {
        const double u = random.unit() - 0.5;
        ++bins[std::size_t((u + 0.5) * 16)];
        double& before = of_pixel[std::size_t(sample * draws + k)];
        along += u * last;
        across_samples += u * of_sample[std::size_t(k)];
        across_pixels += u * before;
        last = of_sample[std::size_t(k)] = before = u;
      }
    }
  double chi = 0;
  for (const double count : bins)
    chi += (count - n / 16) * (count - n / 16) / (n / 16);
  EXPECT_LT(chi, 15 + 4.5 * std::sqrt(30.0) + 10); // chi square of 15 degrees
  // Products of two such numbers have the variance 1/144.
  for (const double sum : {along, across_samples, across_pixels})
    EXPECT_LT(std::fabs(sum), 4.5 * std::sqrt(n / 144));
}

TEST(PhaseFunction, IntegratesToOneWithItsMeanCosine) {
  for (const double g : {-0.95, -0.4, -1e-9, 0.0, 1e-5, 0.3, 0.8, 0.99}) {
    // Simpson's rule in w with cosine(w), dense at the peak: both integrals are of d(CDF).
    constexpr int n = 200000;
    double sum = 0, mean = 0;
    for (int i = 0; i < n; ++i) {
      // Cosines spaced by the cube towards both ends.
      const auto at = [&](double u) { return u * (3 - u * u) / 2; };
      const double a = at(2.0 * i / n - 1), b = at(2.0 * (i + 1) / n - 1), m = 0.5 * (a + b);
      const auto p = [&](double c) { return 2 * render::pi * render::henyey_greenstein(c, g); };
      sum += (b - a) / 6 * (p(a) + 4 * p(m) + p(b));
      mean += (b - a) / 6 * (a * p(a) + 4 * m * p(m) + b * p(b));
    }
    EXPECT_NEAR(sum, 1, 1e-9) << g;
    EXPECT_NEAR(mean, g, 1e-9) << g;
  }
}

TEST(PhaseFunction, SamplesFollowIt) {
  for (const double g : {-0.9, -0.4, 0.0, 1e-7, 0.3, 0.8, 0.99}) {
    constexpr int n = 1000000;
    PathRandom random(3, 0, 0, 0);
    double sum = 0, squares = 0;
    std::array<double, 20> bins{};
    for (int i = 0; i < n; ++i) {
      const double c = render::sample_henyey_greenstein(g, random.unit());
      sum += c;
      squares += c * c;
      ++bins[std::min<std::size_t>(19, std::size_t((c + 1) * 10))];
    }
    const double mean = sum / n, error = std::sqrt((squares / n - mean * mean) / n);
    EXPECT_LT(std::fabs(mean - g), 4.5 * error) << g;
    // The share of each bin, by the closed cumulative distribution.
    const auto below = [&](double c) {
      if (std::fabs(g) < 1e-3)
        return 0.5 * (1 + c) + 0.75 * g * (c * c - 1);
      return (1 - g * g) / (2 * g) * (1 / std::sqrt(1 + g * g - 2 * g * c) - 1 / (1 + g));
    };
    for (int b = 0; b < 20; ++b) {
      const double p = below(-0.9 + 0.1 * b) - below(-1 + 0.1 * b);
      EXPECT_LT(std::fabs(bins[std::size_t(b)] - n * p), 4.5 * std::sqrt(n * p * (1 - p)) + 1)
          << g << " bin " << b;
    }
  }
}

TEST(PhaseFunction, EndsOfTheRangeOfCosines) {
  for (const double g : {-0.999, -0.5, 0.0, 0.5, 0.999}) {
    EXPECT_NEAR(render::sample_henyey_greenstein(g, 0.0), -1, 1e-9) << g;
    EXPECT_NEAR(render::sample_henyey_greenstein(g, 1 - 0x1p-53), 1, 1e-9) << g;
  }
}

TEST(PhaseFunction, DirectionsKeepTheirAngle) {
  PathRandom random(5, 0, 0, 0);
  for (int i = 0; i < 10000; ++i) {
    Vec3d n{2 * random.unit() - 1, 2 * random.unit() - 1, 2 * random.unit() - 1};
    if (i % 10 == 0) // along an axis, both ways
      n = {i % 30 == 0 ? 1.0 : 0.0, i % 30 == 10 ? -1.0 : 0.0, 0.0};
    if (i % 10 == 5 || dot(n, n) == 0)
      n = {0, 0, i % 20 == 5 ? 1.0 : -1.0};
    n = n / std::sqrt(dot(n, n));
    const double cosine = 2 * random.unit() - 1;
    const Vec3d d = render::direction_around(n, cosine, random.unit());
    EXPECT_NEAR(dot(d, d), 1, 1e-14);
    EXPECT_NEAR(dot(d, n), cosine, 1e-13);
  }
}

TEST(PathLights, KindsAndUnits) {
  render::Camera camera;
  camera.position = {0, 0, 5};
  camera.look_at = {0, 0, 0};
  const render::PathLights standard({}, camera);
  EXPECT_TRUE(standard.has_dome());
  EXPECT_FALSE(standard.has_small());
  EXPECT_EQ(standard.dome().g, 1.0f);

  using Kind = Light::Kind;
  const auto pi = float(render::pi);
  const render::PathLights sun({{Kind::directional, {0, 3, 4}, {1, 2, 0}}}, camera);
  EXPECT_FALSE(sun.has_dome());
  const render::LightSample from_sun = sun.sample({7, 8, 9}, 0.5);
  EXPECT_NEAR(from_sun.direction.z, 0.8, 1e-15);
  EXPECT_EQ(from_sun.distance, HUGE_VAL);
  EXPECT_FLOAT_EQ(from_sun.irradiance.g, 2 * pi);

  const render::PathLights lamp({{Kind::point, {0, 2, 0}, {1, 1, 1}}}, camera);
  const render::LightSample from_lamp = lamp.sample({0, 0, 0}, 0.5);
  EXPECT_EQ(from_lamp.distance, 2);
  EXPECT_FLOAT_EQ(from_lamp.irradiance.r, pi / 4);

  const render::PathLights head({{Kind::head, {}, {1, 1, 1}}}, camera);
  EXPECT_EQ(head.sample({0, 0, 1}, 0).distance, 4);
  EXPECT_FLOAT_EQ(head.sample({0, 0, 1}, 0).irradiance.r, pi);
  camera.orthographic_height = 1;
  const render::PathLights far_head({{Kind::head, {}, {1, 1, 1}}}, camera);
  EXPECT_EQ(far_head.sample({0, 3, 1}, 0).distance, HUGE_VAL);
  EXPECT_EQ(far_head.sample({0, 3, 1}, 0).direction.z, 1);

  // Of several small lights one is picked, and counts for all; domes add up.
  const render::PathLights both({{Kind::directional, {1, 0, 0}, {1, 1, 1}},
                                 {Kind::directional, {0, 1, 0}, {1, 1, 1}},
                                 {Kind::dome, {}, {0.5f, 0, 0}},
                                 {Kind::dome, {}, {0.25f, 0, 0}}},
                                camera);
  EXPECT_EQ(both.sample({}, 0.49).direction.x, 1);
  EXPECT_EQ(both.sample({}, 0.51).direction.y, 1);
  EXPECT_FLOAT_EQ(both.sample({}, 0.51).irradiance.b, 2 * pi);
  EXPECT_FLOAT_EQ(both.dome().r, 0.75f);
  for (const Vec3d& none : {Vec3d{0, 0, 0}, Vec3d{HUGE_VAL, 0, 0}, Vec3d{std::nan(""), 0, 0}})
    EXPECT_THROW(render::PathLights({{Kind::directional, none, {1, 1, 1}}}, camera), core::Error);
  EXPECT_NEAR(render::PathLights({{Kind::directional, {1e-200, 0, 0}, {1, 1, 1}}}, camera)
                  .sample({}, 0)
                  .direction.x,
              1, 1e-15);
}

} // namespace
} // namespace insitu::test
