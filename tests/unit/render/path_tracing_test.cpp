// Path tracing against closed forms: means within their errors.
#include <cmath>
#include <gtest/gtest.h>

#include "render/path/phase_function.h"
#include "unit/query/registered_amr.h"
#include "unit/render/block_mesh.h"
#include "unit/render/path_mesh.h"

namespace insitu::test {
namespace {

using render::Color;
using render::FrameSettings;
using render::Light;
using render::PathCounts;
using render::Scattering;
using render::VolumeSettings;

double x_of(const Vec3d& p) {
  return p.x;
}
double one_of(const Vec3d&) {
  return 1.0;
}

VolumeSettings volume_of(const render::ScalarField& field, const Color& c, double first,
                         double last) {
  VolumeSettings v{field, medium_of(c, first, last)};
  v.unit_distance = 1;
  return v;
}

/// The length of ray in the unit box from a point inside.
double exit_of(const Vec3d& from, const Vec3d& direction) {
  double far = HUGE_VAL;
  for (int a = 0; a < 3; ++a)
    if (direction[a] != 0)
      far = std::min(far, ((direction[a] > 0 ? 1.0 : 0.0) - from[a]) / direction[a]);
  return far;
}

/// Simpson's rule.
template <class F>
double integral(double from, double to, int intervals, F&& f) {
  double sum = 0;
  const double h = (to - from) / intervals;
  for (int i = 0; i < intervals; ++i)
    sum += h / 6 * (f(from + i * h) + 4 * f(from + (i + 0.5) * h) + f(from + (i + 1) * h));
  return sum;
}

/// 1 024 000 paths each: the share that collides is a binomial.
TEST(PathTracing, TransmittanceIsBeerAndLamberts) {
  constexpr int side = 32, samples = 1000;
  for (const Shape shape : {Shape::hexahedron, Shape::tetrahedron}) {
    RenderMesh mesh(6, shape, 0.2);
    const auto x = mesh.field("x", INSITU_VERTEX, x_of);
    struct Case {
      double first, last, density;
    };
    // Constant, thin and thick; and ramps of opacity o x, of the optical depth
    // -density * integral of log(1 - o x) = density * ((1 - o) log(1 - o) + o) / o.
    for (const Case& c : {Case{0.5, 0.5, 1}, Case{0.01, 0.01, 1}, Case{0.9, 0.9, 2},
                          Case{0, 0.7, 1}, Case{0, 0.999, 0.5}}) {
      const double o = c.last;
      const double depth = c.first == c.last ? -c.density * std::log1p(-o)
                                             : c.density * ((1 - o) * std::log1p(-o) + o) / o;
      FrameSettings s = one_ray(side);
      s.volume = volume_of(x, {1, 1, 1}, c.first, c.last);
      s.path_tracing->scattering = Scattering::none;
      s.path_tracing->samples = samples;
      s.path_tracing->density = c.density;
      s.path_tracing->seed = 11;
      PathCounts counts;
      const core::Image image = draw_paths(mesh, s, &counts);
      const double n = double(side) * side * samples, p = -std::expm1(-depth);
      EXPECT_EQ(counts.paths, std::int64_t(n));
      const double z = (estimate(image, 3).mean - p) / std::sqrt(p * (1 - p) / n);
      EXPECT_LT(std::fabs(z), most_errors) << "opacity " << o << " density " << c.density;
      EXPECT_EQ(counts.scatterings + counts.shadow_rays, 0);
    }
  }
}

/// Red rises from 0 to 1 along the ray, the extinction is constant.
TEST(PathTracing, WithoutScatteringItEmitsAndAbsorbs) {
  RenderMesh mesh(5, Shape::wedge, 0.2);
  const auto x = mesh.field("x", INSITU_VERTEX, x_of);
  const double k = 1.7;
  FrameSettings s = one_ray(32);
  s.volume = VolumeSettings{
      x,
      {render::ColorMap("ramp", render::ColorSpace::linear, {{0, 0, 0, 1}, {1, 1, 0, 1}}),
       0.0,
       1.0,
       {{0.0, opacity_of(k)}}}};
  s.volume->unit_distance = 1;
  s.path_tracing->scattering = Scattering::none;
  s.path_tracing->samples = 300;
  const core::Image image = draw_paths(mesh, s);
  expect_mean(estimate(image, 0), (1 - (1 + k) * std::exp(-k)) / k, "red");
  expect_mean(estimate(image, 2), 1 - std::exp(-k), "blue");
  EXPECT_EQ(estimate(image, 1).mean, 0);
  // Ray marching of fine steps tends to the same.
  s.path_tracing.reset();
  s.volume->step = 1e-3;
  const core::Image marched = mesh.draw(s);
  EXPECT_NEAR(double(marched.pixel(0, 0)[0]) * double(marched.pixel(0, 0)[3]),
              (1 - (1 + k) * std::exp(-k)) / k, 2e-3);
}

/// The camera's ray at y, z, and a light; the truth by quadrature along the ray.
TEST(PathTracing, SingleScatteringMatchesItsQuadrature) {
  RenderMesh mesh(5, Shape::tetrahedron, 0.2);
  const auto one = mesh.field("one", INSITU_VERTEX, one_of);
  const double k = 2.1;
  const Color albedo{0.9f, 0.5f, 0.1f};
  using Kind = Light::Kind;
  for (const double g : {0.0, 0.6})
    for (const Light& light :
         {Light{Kind::directional, {0, 0, 3}, {1, 2, 4}},
          Light{Kind::directional, {-2, 1, 0.5}, {1, 1, 1}}, Light{Kind::head, {}, {1, 1, 1}},
          Light{Kind::point, {0.4, -0.5, 1.8}, {3, 3, 3}},
          Light{Kind::point, {0.6, 0.1, 0.9}, {1, 1, 1}}, Light{Kind::dome, {}, {1, 0.5f, 2}}}) {
      FrameSettings s = one_ray();
      s.volume = volume_of(one, albedo, opacity_of(k), opacity_of(k));
      s.path_tracing->scattering = Scattering::single;
      s.path_tracing->samples = 150;
      s.path_tracing->anisotropy = g;
      s.path_tracing->seed = 5;
      s.lighting.lights = {light};
      PathCounts counts;
      const core::Image image = draw_paths(mesh, s, &counts);
      const bool dome = light.kind == Kind::dome;
      EXPECT_EQ(counts.shadow_rays > 0, !dome);
      EXPECT_EQ(counts.scatterings > 0, dome);
      const double in_scattered = integral(0, 1, dome ? 32 : 1000, [&](double x) {
        const Vec3d at{x, 0.45, 0.55};
        double got = 0;
        if (dome) {
          // Over the polar angle around the view (by cosine) and the azimuth.
          got = integral(-1, 1, 64, [&](double c) {
            const double sine = std::sqrt(std::max(0.0, 1 - c * c));
            double around = 0;
            for (int i = 0; i < 128; ++i) {
              const double a = 2 * M_PI * (i + 0.5) / 128;
              around += std::exp(-k * exit_of(at, {c, sine * std::cos(a), sine * std::sin(a)}));
            }
            return 2 * M_PI * around / 128 * render::henyey_greenstein(c, g);
          });
        } else {
          Vec3d to = light.kind == Kind::directional ? light.vector
                     : light.kind == Kind::head      ? Vec3d{-1, 0, 0}
                                                     : light.vector - at;
          const double distance = std::sqrt(dot(to, to));
          to = to / distance;
          const bool is_point = light.kind == Kind::point;
          const double through =
              std::exp(-k * std::min(exit_of(at, to), is_point ? distance : HUGE_VAL));
          got = M_PI * (is_point ? 1 / (distance * distance) : 1.0) * through *
                render::henyey_greenstein(to.x, g);
        }
        return k * std::exp(-k * x) * got;
      });
      const auto what = "light " + std::to_string(int(light.kind)) + " g " + std::to_string(g);
      // The dome's quadrature has kinks at the box's edges: 1e-4 of it.
      const double slack = dome ? 1e-4 : 0;
      const float albedos[] = {albedo.r, albedo.g, albedo.b};
      const float colors[] = {light.color.r, light.color.g, light.color.b};
      for (int c = 0; c < 3; ++c) {
        const double truth = double(albedos[c]) * double(colors[c]) * in_scattered;
        Estimate e = estimate(image, c);
        e.mean += std::clamp(truth - e.mean, -slack * truth, slack * truth);
        expect_mean(e, truth, what.c_str());
        EXPECT_LT(e.error, 0.03 * truth) << what; // it says something
      }
    }
}

/// Albedo 1 in a white dome: nobody can see the medium. Every path brings the dome's light, so
/// this is exact; what were lost on the way would show.
void expect_white(const fixtures::Committed& committed, core::Memory& memory,
                  const render::ScalarField& field, double g) {
  FrameSettings s = box_frame(24);
  s.background = {1, 1, 1};
  s.volume = volume_of(field, {1, 1, 1}, 0, 0.99);
  s.path_tracing.emplace().samples = 8;
  s.path_tracing->anisotropy = g;
  render::FrameStatistics statistics;
  const core::Image image =
      render::render_frame(committed.sampler(), s, committed.threads, memory, &statistics).color;
  const PathCounts& counts = statistics.paths;
  EXPECT_EQ(counts.cut + counts.violations, 0);
  EXPECT_GT(counts.scatterings, counts.paths / 3);
  for (int i = 0; i < 24 * 24; ++i)
    for (int c = 0; c < 4; ++c)
      ASSERT_NEAR(image.pixel(i % 24, i / 24)[c], 1, 1e-6) << "pixel " << i;
}

TEST(PathTracing, WhiteFurnace) {
  for (const double g : {0.0, 0.7, -0.5})
    for (const bool homogeneous : {true, false}) {
      const auto f = [&](const Vec3d& p) {
        return homogeneous ? 1.0 : 0.5 + 0.5 * std::sin(9 * p.x + 5 * p.y - 7 * p.z);
      };
      for (const Shape shape :
           {Shape::hexahedron, Shape::tetrahedron, Shape::wedge, Shape::pyramid}) {
        SCOPED_TRACE(testing::Message() << "shape " << int(shape) << ", g " << g);
        RenderMesh mesh(5, shape, 0.2);
        const render::ScalarField field = mesh.field("f", INSITU_VERTEX, f);
        expect_white(mesh.committed, mesh.committed.memory, field, g);
      }
      for (const insitu_block_kind kind : block_kinds) {
        SCOPED_TRACE(testing::Message() << "block " << int(kind) << ", g " << g);
        BlockMesh mesh(kind, 6, f);
        expect_white(mesh.committed, mesh.committed.memory, mesh.field, g);
      }
    }
}

TEST(PathTracing, WhiteFurnaceOnAdaptiveMeshes) {
  for (int kind = 0; kind < 3; ++kind) {
    const Recipe recipe{.seed = 2, .kind = kind, .roots = 3, .levels = 3};
    RegisteredAmr mesh(recipe, INSITU_DUAL, [](const Vec3d& p) { return std::sin(p.x + p.y); });
    const query::Sampler sampler = mesh.committed.sampler();
    const Vec3d low = sampler.tree().bounds_min(), high = sampler.tree().bounds_max();
    FrameSettings s;
    s.width = s.height = 24;
    s.camera = render::Camera::around(low, high, 30, 20);
    s.background = {1, 1, 1};
    s.volume =
        VolumeSettings{{mesh.committed.mesh.mesh().field("f"), 0}, medium_of({1, 1, 1}, 0.02, 0.1)};
    s.path_tracing.emplace().samples = 8;
    s.path_tracing->anisotropy = 0.4;
    render::FrameStatistics statistics;
    const core::Image image =
        render::render_frame(sampler, s, mesh.committed.threads, mesh.committed.memory, &statistics)
            .color;
    EXPECT_EQ(statistics.paths.violations + statistics.paths.cut, 0);
    EXPECT_GT(statistics.paths.scatterings, statistics.paths.paths / 2) << kind;
    for (const float v : image.rgba)
      ASSERT_NEAR(v, 1, 1e-6) << kind;
  }
}

/// The dome made of directional lights evenly around: now shadow rays bring all of the light, with
/// noise, and the furnace still stands. 200 directions stand for all to 1 in 200 here.
TEST(PathTracing, WhiteFurnaceOfManySuns) {
  RenderMesh mesh(4, Shape::hexahedron, 0.2);
  const auto field = mesh.field("f", INSITU_VERTEX, [](const Vec3d& p) { return p.x * p.y; });
  for (const double g : {0.0, 0.5}) {
    FrameSettings s = one_ray();
    s.volume = volume_of(field, {1, 1, 1}, 0.8, 0.99);
    s.path_tracing->samples = 250;
    s.path_tracing->anisotropy = g;
    constexpr int suns = 200;
    for (int i = 0; i < suns; ++i) { // on a spiral
      const double z = 1 - (2.0 * i + 1) / suns, r = std::sqrt(1 - z * z), a = 2.399963 * i;
      const float radiance = 4.0f / suns; // irradiance pi c is radiance 1 times 4 pi / suns
      s.lighting.lights.push_back({Light::Kind::directional,
                                   {r * std::cos(a), r * std::sin(a), z},
                                   {radiance, radiance, radiance}});
    }
    const core::Image image = draw_paths(mesh, s);
    const Estimate e = estimate(image, 1), alpha = estimate(image, 3);
    EXPECT_LT(e.error, 0.005);
    EXPECT_LT(std::fabs(e.mean - alpha.mean), most_errors * (e.error + alpha.error) + 0.005)
        << e.mean << " +- " << e.error << ", alpha " << alpha.mean;
  }
}

TEST(PathTracing, RouletteDoesNotChangeTheMean) {
  RenderMesh mesh(4, Shape::hexahedron, 0.2);
  const auto one = mesh.field("one", INSITU_VERTEX, one_of);
  FrameSettings s = one_ray();
  s.volume = volume_of(one, {0.8f, 0.6f, 0.3f}, opacity_of(5), opacity_of(5));
  s.path_tracing->samples = 200;
  s.lighting.lights = {{Light::Kind::dome, {}, {1, 1, 1}},
                       {Light::Kind::directional, {-1, 1, 2}, {1, 1, 1}}};
  s.path_tracing->roulette = 0;
  PathCounts without, with;
  const core::Image all = draw_paths(mesh, s, &without);
  s.path_tracing->seed = 1;
  for (const double roulette : {0.25, 1.0}) {
    s.path_tracing->roulette = roulette;
    const core::Image some = draw_paths(mesh, s, &with);
    EXPECT_LT(with.locations, without.locations);
    for (int c = 0; c < 3; ++c) {
      const Estimate a = estimate(all, c), b = estimate(some, c);
      EXPECT_LT(std::fabs(a.mean - b.mean), most_errors * std::hypot(a.error, b.error))
          << roulette << ": " << a.mean << ", " << b.mean;
      EXPECT_LT(b.error, 0.01 * b.mean);
    }
  }
}

/// Whatever the majorants, the mean is the same; finer ones are tighter.
TEST(PathTracing, MajorantsOfAnyResolutionBoundAndAgree) {
  RenderMesh mesh(12, Shape::tetrahedron, 0.2);
  const auto blob = mesh.field("blob", INSITU_VERTEX, [](const Vec3d& p) {
    const Vec3d d = p - Vec3d{0.5, 0.45, 0.55};
    return std::exp(-30 * dot(d, d));
  });
  FrameSettings s = one_ray();
  s.volume = volume_of(blob, {0.9f, 0.9f, 0.9f}, 0, 0.9999);
  s.path_tracing->samples = 100;
  std::vector<Estimate> means;
  std::int64_t last = 0;
  for (const double cells : {0.5, 8.0, 64.0, 1000.0, 1e9}) {
    s.path_tracing->cells_per_macrocell = cells;
    PathCounts counts;
    const core::Image image = draw_paths(mesh, s, &counts); // no violations
    means.push_back(estimate(image, 1));
    EXPECT_GT(counts.locations, last) << cells;
    last = counts.locations;
  }
  for (const Estimate& m : means)
    EXPECT_LT(std::fabs(m.mean - means[0].mean),
              most_errors * std::hypot(m.error, means[0].error) + 1e-9);
}

/// A single pixel's variance falls as one over the samples.
TEST(PathTracing, VarianceFallsWithTheSamples) {
  RenderMesh mesh(4, Shape::hexahedron, 0.2);
  const auto x = mesh.field("x", INSITU_VERTEX, x_of);
  FrameSettings s = one_ray(32);
  s.volume = volume_of(x, {0.9f, 0.9f, 0.9f}, 0.2, 0.95);
  double first = 0;
  for (const int samples : {4, 16, 64}) {
    s.path_tracing->samples = samples;
    s.path_tracing->seed = std::uint64_t(samples);
    const double error = estimate(draw_paths(mesh, s), 1).error;
    const double variance = error * error * samples;
    if (samples == 4)
      first = variance;
    // 1024 pixels tell a variance to about 4.4 % (one standard error).
    EXPECT_NEAR(variance / first, 1, 4.5 * 0.044 * std::sqrt(2.0)) << samples;
  }
}

} // namespace
} // namespace insitu::test
