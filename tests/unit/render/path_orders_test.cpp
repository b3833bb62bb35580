// Light scattered more than once, in media that absorb, against truths that trace no paths: two
// orders by quadrature, and all of them in a half-space, which has a closed form.
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "render/path/phase_function.h"
#include "unit/render/path_mesh.h"
#include "unit/render/placed_mesh.h"

namespace insitu::test {
namespace {

using render::Color;
using render::FrameSettings;
using render::Light;
using render::PathCounts;

/// Nodes and weights of Gauss and Legendre's rule on [from, to].
struct Rule {
  std::vector<double> x, w;
  Rule(double from, double to, int n = 48) {
    for (int i = 0; i < n; ++i) {
      double t = std::cos(M_PI * (i + 0.75) / (n + 0.5)), slope = 1;
      for (int step = 0; step < 50; ++step) { // Newton
        double p = 1, before = 0;
        for (int k = 1; k <= n; ++k) {
          const double next = ((2 * k - 1) * t * p - (k - 1) * before) / k;
          before = p;
          p = next;
        }
        slope = n * (t * p - before) / (t * t - 1);
        t -= p / slope;
      }
      x.push_back(0.5 * (from + to) + 0.5 * (to - from) * t);
      w.push_back((to - from) / ((1 - t * t) * slope * slope));
    }
  }
  template <class F>
  double operator()(F&& f) const {
    double sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i)
      sum += w[i] * f(x[i]);
    return sum;
  }
};

/// A slab from x = 0 to 1, 400 times as wide: paths that reach its sides are dimmer than e^-200.
struct Slab {
  static constexpr double wide = 400;
  explicit Slab(Shape shape) : mesh(placed(4, shape, {1, wide, wide}, {})) {
    one = mesh.field(std::vector<double>(mesh.cells.vertices.size(), 1.0));
  }
  /// Along +x, normal to it. The extinction is per unit_distance.
  FrameSettings frame(const Color& albedo, double extinction, double unit_distance) const {
    FrameSettings s = one_ray();
    s.camera.position = {-1, 0.45 * wide, 0.55 * wide};
    s.camera.look_at = {0, 0.45 * wide, 0.55 * wide};
    s.volume = render::VolumeSettings{
        one, medium_of(albedo, opacity_of(extinction), opacity_of(extinction))};
    s.volume->unit_distance = unit_distance;
    return s;
  }
  core::Image draw(const FrameSettings& s, PathCounts& counts) const {
    render::FrameStatistics statistics;
    core::Memory memory;
    const render::FrameImages images = render::render_frame(
        mesh.committed.sampler(), s, mesh.committed.threads, memory, &statistics);
    counts = statistics.paths;
    EXPECT_EQ(counts.violations, 0);
    core::Image copy = images.color; // not counted
    return copy;
  }
  PlacedMesh mesh;
  render::ScalarField one;
};

/// (1 - exp(-a s)) / a, also at a = 0.
double saturation(double a, double s) {
  return a == 0 ? s : -std::expm1(-a * s) / a;
}

/// What a light of irradiance pi along x, from x = 0 (side -1) or x = 1 (side 1), sends back to a
/// viewer at x = 0 after one and after two scatterings in the slab, for an albedo of 1.
struct Orders {
  double first, second;
};
Orders orders(double k, double g, int side) {
  using render::henyey_greenstein;
  const auto lit = [&](double x) { return std::exp(-k * (side < 0 ? x : 1 - x)); };
  const Rule depth(0, 1), back(-1, 0), forth(0, 1);
  Orders o{};
  o.first = M_PI * henyey_greenstein(side, g) *
            depth([&](double x) { return k * std::exp(-k * x) * lit(x); });
  o.second = M_PI * depth([&](double x) {
               // From x on by cosine m for a length up to s, where it is lit by lit(x) exp(side k m
               // l).
               const auto by_cosine = [&](double m) {
                 const double s = m < 0 ? x / -m : (1 - x) / m;
                 return 2 * M_PI * henyey_greenstein(m, g) * henyey_greenstein(m * side, g) *
                        lit(x) * k * saturation(k * (1 - m * side), s);
               };
               return k * std::exp(-k * x) * (back(by_cosine) + forth(by_cosine));
             });
  return o;
}

/// The quadrature's own error is below 1e-6: twice as many nodes change less.
TEST(PathOrders, TwoScatteringsMatchTheirQuadrature) {
  const Color albedo{0.9f, 0.6f, 0.2f};
  const float albedos[] = {albedo.r, albedo.g, albedo.b};
  const double k = 1.6;
  for (const Shape shape : {Shape::hexahedron, Shape::pyramid}) {
    const Slab slab(shape);
    for (const double g : {0.0, 0.6})
      for (const int side : {-1, 1}) {
        SCOPED_TRACE(testing::Message()
                     << "g " << g << ", side " << side << ", shape " << int(shape));
        const Orders truth = orders(k, g, side);
        FrameSettings s = slab.frame(albedo, k, 1);
        s.path_tracing->anisotropy = g;
        s.path_tracing->samples = 400;
        s.lighting.lights = {{Light::Kind::directional, {double(side), 0, 0}, {1, 1, 1}}};
        for (const int most : {1, 2}) {
          s.path_tracing->max_bounces = most;
          s.path_tracing->seed = std::uint64_t(most);
          PathCounts counts;
          const core::Image image = slab.draw(s, counts);
          EXPECT_GT(counts.cut, 0);
          for (int c = 0; c < 3; ++c) {
            const double a = double(albedos[c]);
            const double second = a * a * truth.second;
            const double expected = a * truth.first + (most == 2 ? second : 0.0);
            const Estimate e = estimate(image, c);
            expect_mean(e, expected, most == 2 ? "two orders" : "one order");
            if (c == 0) {
              EXPECT_LT(most_errors * e.error, 0.25 * second) << "the second order would not show";
            }
          }
        }
      }
  }
}

/// Chandrasekhar's H for isotropic scattering: his second form of its integral equation, iterated.
double chandrasekhar_h(double albedo, double cosine) {
  const Rule rule(0, 1, 64);
  std::vector<double> h(rule.x.size(), 1.0);
  const auto next = [&](double m) {
    double sum = 0;
    for (std::size_t j = 0; j < h.size(); ++j)
      sum += rule.w[j] * rule.x[j] * h[j] / (m + rule.x[j]);
    return 1 / (std::sqrt(1 - albedo) + 0.5 * albedo * sum);
  };
  for (int i = 0; i < 500; ++i) {
    std::vector<double> better;
    for (const double m : rule.x)
      better.push_back(next(m));
    for (std::size_t j = 0; j < h.size(); ++j)
      h[j] = 0.5 * (h[j] + better[j]);
  }
  double mean = 0; // which has a closed form
  for (std::size_t j = 0; j < h.size(); ++j)
    mean += rule.w[j] * h[j];
  EXPECT_NEAR(mean, 2 / albedo * (1 - std::sqrt(1 - albedo)), 1e-6);
  return next(cosine);
}

/// All orders: a half-space under a dome of radiance 1 shows 1 - sqrt(1 - albedo) H(cosine). The
/// slab is 40 mean free paths deep, of which exp(-20) is left even at an albedo of 0.9.
TEST(PathOrders, AHalfSpaceUnderADomeIsChandrasekhars) {
  const float albedos[] = {0.9f, 0.5f, 0.2f};
  for (const Shape shape : {Shape::tetrahedron, Shape::wedge}) {
    const Slab slab(shape);
    FrameSettings s = slab.frame({albedos[0], albedos[1], albedos[2]}, 10, 0.25);
    s.path_tracing->samples = 150;
    s.path_tracing->cells_per_macrocell = 1;
    s.lighting.lights = {{Light::Kind::dome, {}, {1, 1, 1}}};
    PathCounts counts;
    const core::Image image = slab.draw(s, counts);
    EXPECT_EQ(counts.cut, 0);
    for (int c = 0; c < 3; ++c) {
      const double a = double(albedos[c]);
      const Estimate e = estimate(image, c);
      expect_mean(e, 1 - std::sqrt(1 - a) * chandrasekhar_h(a, 1), "reflected");
      EXPECT_LT(e.error, 0.02 * e.mean);
    }
  }
}

} // namespace
} // namespace insitu::test
