#include <cmath>
#include <cstring>
#include <gtest/gtest.h>

#include "core/status.h"
#include "render/structures/structures.h"
#include "unit/query/registered_amr.h"
#include "unit/render/render_mesh.h"

/// What a volume may ask for beyond even steps: skipping, pre-integration, a tolerance, light.
namespace insitu::test {
namespace {

using render::FrameSettings;
using render::FrameStatistics;
using render::OpacityPoint;
using render::TransferFunction;
using render::VolumeSettings;

TransferFunction with_opacity(std::vector<OpacityPoint> points, double low = 0, double high = 1) {
  return {render::ColorMap::built_in("viridis"), low, high, std::move(points)};
}

bool same(const core::Image& a, const core::Image& b) {
  return a.rgba.size() == b.rgba.size() &&
         std::memcmp(a.rgba.data(), b.rgba.data(), a.rgba.size() * sizeof(float)) == 0;
}

double largest_difference(const core::Image& a, const core::Image& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.rgba.size(); ++i)
    most = std::max(most, std::fabs(double(a.rgba[i]) - double(b.rgba[i])));
  return most;
}

double blob(const Vec3d& p) {
  const Vec3d d = p - Vec3d{0.4, 0.5, 0.6};
  return std::max(0.0, 1 - 9 * dot(d, d));
}

/// What a ray along +z through the middle of the unit box gathers.
render::RayState gathered(const query::Sampler& sampler, const VolumeSettings& settings,
                          render::Structures& structures) {
  const render::VolumeMarcher marcher(sampler, settings,
                                      volume_structures(sampler, settings, 1 << 20, structures));
  render::RayState ray;
  ray.ray = {{0.47, 0.52, -0.7}, {0, 0, 1}};
  marcher.start(ray);
  marcher.march({&ray, 1});
  return ray;
}

/// The images of all of these are the same with and without skipping, and fewer samples are taken.
TEST(VolumeSkipping, ImagesAreTheSame) {
  const std::vector<std::vector<OpacityPoint>> functions = {
      {{0, 0}, {1, 0.6}},
      {{0, 0}, {0.3, 0}, {0.3, 0.2}, {0.5, 0.2}, {0.5, 0}, {1, 0}}, // a shell with steps
      {{0, 0}, {0.97, 0}, {1, 1}},                                  // next to nothing
      {{0, 0}}};                                                    // nothing at all
  int skipping = 0;
  for (const Shape shape : {Shape::hexahedron, Shape::tetrahedron, Shape::wedge, Shape::pyramid})
    for (const insitu_association association : {INSITU_VERTEX, INSITU_CELL}) {
      RenderMesh mesh(shape == Shape::hexahedron ? 16 : 12, shape, 0.3);
      const auto field = mesh.field("f", association, blob);
      for (std::size_t f = 0; f < functions.size(); ++f)
        for (const int mode : {0, 1, 2, 3}) {
          FrameSettings s = box_frame(20);
          s.volume = VolumeSettings{field, with_opacity(functions[f])};
          s.volume->step = 0.008;
          s.volume->unit_distance = 0.1;
          s.volume->preintegrated = mode == 1;
          if (mode == 2)
            s.volume->tolerance = 0.02;
          if (mode == 3) {
            s.clips.push_back({render::Clip::Kind::plane, {0.3, 0, 0}, {-1, 0.2, 0}});
            s.clips.push_back({render::Clip::Kind::sphere, {0.5, 0.5, 0.9}, {}, 0.2, false});
            if (association == INSITU_VERTEX)
              s.isosurfaces.push_back({field, {0.4}, 0.5});
          }
          FrameStatistics with, without;
          const core::Image skipped = mesh.draw(s, 0, &with);
          s.volume->skip_empty = false;
          const core::Image all = mesh.draw(s, 0, &without);
          EXPECT_TRUE(same(skipped, all)) << int(shape) << " " << association << " " << f << " "
                                          << mode << ": " << largest_difference(skipped, all);
          EXPECT_EQ(without.skipped, 0);
          skipping += with.skipped > 0;
          EXPECT_LE(with.samples, without.samples) << f << " " << mode;
          if (f == 3) {
            EXPECT_LE(with.samples, 20); // of rays across the box's corners, shorter than a step
          }
          if (mode == 0 && f > 0) { // nothing saturates a ray
            EXPECT_EQ(with.samples + with.skipped, without.samples) << f;
          }
        }
    }
  EXPECT_GE(skipping, 100); // of 128; in the others less than a tenth of the macrocells is empty
}

TEST(VolumeSkipping, AdaptiveMeshes) {
  for (int kind = 0; kind < 3; ++kind) {
    RegisteredAmr mesh({.seed = 3, .kind = kind, .roots = 4, .levels = 3}, INSITU_DUAL,
                       [](const Vec3d& p) { return p.x + 0.5 * p.y; });
    const query::Sampler sampler = mesh.committed.sampler();
    const Vec3d low = sampler.tree().bounds_min(), high = sampler.tree().bounds_max();
    const double first = low.x + 0.5 * low.y, last = high.x + 0.5 * high.y;
    FrameSettings s;
    s.width = s.height = 48;
    s.camera = render::Camera::around(low, high, 30, 20);
    const double from = first + 0.7 * (last - first);
    s.volume = VolumeSettings{{mesh.committed.mesh.mesh().field("f"), 0},
                              with_opacity({{from, 0}, {last, 1}}, first, last)};
    FrameStatistics with, without;
    for (const bool preintegrated : {false, true}) {
      s.volume->preintegrated = preintegrated;
      s.volume->skip_empty = true;
      const core::Image skipped =
          render_frame(sampler, s, mesh.committed.threads, mesh.committed.memory, &with).color;
      s.volume->skip_empty = false;
      const core::Image all =
          render_frame(sampler, s, mesh.committed.threads, mesh.committed.memory, &without).color;
      EXPECT_TRUE(same(skipped, all)) << kind << ": " << largest_difference(skipped, all);
      EXPECT_GT(with.skipped, 0) << kind;
      EXPECT_LT(with.samples, without.samples);
    }
  }
}

TEST(VolumeSkipping, IsLeftOutWhereItCannotPay) {
  RenderMesh mesh(16);
  const auto field = mesh.field("f", INSITU_VERTEX, blob);
  render::Structures structures(mesh.committed.memory);
  structures.begin(mesh.sampler(), 1, 1, mesh.committed.threads);
  const auto asked = [&](std::vector<OpacityPoint> points, std::int64_t rays) {
    return volume_structures(mesh.sampler(), VolumeSettings{field, with_opacity(std::move(points))},
                             rays, structures)
               .majorants != nullptr;
  };
  EXPECT_FALSE(asked({{0, 0.1}, {1, 1}}, 1000000)); // nothing is empty
  EXPECT_FALSE(asked({{0, 0}, {1, 1}}, 10));        // too few rays
  EXPECT_EQ(structures.counts().macrocells, 0);
  EXPECT_TRUE(asked({{0, 0}, {1, 1}}, 1000000));
  EXPECT_EQ(structures.counts().macrocells, 1);
}

/// Transmittance and emission of a homogeneous slab, whatever the steps.
TEST(VolumeModes, HomogeneousSlab) {
  for (const Shape shape : {Shape::hexahedron, Shape::tetrahedron, Shape::wedge, Shape::pyramid}) {
    RenderMesh mesh(5, shape, 0.2);
    const auto field = mesh.field("one", INSITU_VERTEX, [](const Vec3d&) { return 1.0; });
    render::Structures structures(mesh.committed.memory);
    structures.begin(mesh.sampler(), 1, 1, mesh.committed.threads);
    for (const double step : {0.5, 0.1, 0.037, 0.003, 7.0}) // the last longer than the slab
      for (const double opacity : {0.9, 0.2, 1e-3, 0.0})
        for (const int mode : {0, 1, 2}) {
          VolumeSettings s{field, constant_function(opacity, 0.25)};
          s.step = step;
          s.unit_distance = 0.8;
          s.preintegrated = mode == 1;
          if (mode == 2)
            s.tolerance = 1e-3;
          const render::RayState ray = gathered(mesh.sampler(), s, structures);
          const double expected = 1 - std::pow(1 - opacity, 1 / 0.8);
          EXPECT_NEAR(ray.alpha, expected, 1e-6) << step << " " << opacity << " " << mode;
          EXPECT_NEAR(ray.color.r, 0.25 * expected, 1e-6) << step << " " << opacity << " " << mode;
        }
  }
}

/// Opacity that grows from 0 to a along the ray: the optical depth is the integral of -ln(1 - a z),
/// ((1 - a) ln(1 - a) + a) / a.
class LinearRamp : public testing::TestWithParam<Shape> {};

TEST_P(LinearRamp, MatchesItsClosedForm) {
  RenderMesh mesh(5, GetParam(), 0.25);
  const auto field = mesh.field("z", INSITU_VERTEX, [](const Vec3d& p) { return p.z; });
  render::Structures structures(mesh.committed.memory);
  structures.begin(mesh.sampler(), 1, 1, mesh.committed.threads);
  const double a = 0.8, depth = ((1 - a) * std::log(1 - a) + a) / a / 0.5;
  VolumeSettings s{field,
                   {render::ColorMap("grey", render::ColorSpace::linear, {{0, 0.5, 0.5, 0.5}}),
                    0,
                    1,
                    {{0, 0}, {1, a}}}};
  s.unit_distance = 0.5;
  for (const double step : {0.25, 0.1, 0.03, 0.01}) {
    s.step = step;
    s.preintegrated = false;
    const render::RayState plain = gathered(mesh.sampler(), s, structures);
    // The midpoint rule: step^2 / 24 of the slopes' difference at the ends, which is
    // (a / (1 - a) - a) / 0.5; the ends' longer stretches are off the middle by up to half a step.
    EXPECT_NEAR(plain.alpha, 1 - std::exp(-depth), 3 * step * step) << step;
    s.preintegrated = true;
    const render::RayState exact = gathered(mesh.sampler(), s, structures);
    // Between samples exact; half a step at either end has its sample's value.
    const double ends = 2 * 0.5 * step * step / 0.5 * (a / (1 - a)) * std::exp(-depth);
    EXPECT_NEAR(exact.alpha, 1 - std::exp(-depth), std::max(2e-6, ends)) << step;
    EXPECT_NEAR(exact.color.r, double(plain.color.r) / plain.alpha * exact.alpha, 1e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(VolumeModes, LinearRamp,
                         testing::Values(Shape::hexahedron, Shape::tetrahedron, Shape::wedge,
                                         Shape::pyramid));

/// A peak of the opacity that lies between the values of any two samples.
TEST(VolumeModes, PreintegrationSeesThinPeaks) {
  RenderMesh mesh(4, Shape::tetrahedron, 0.2);
  const auto field = mesh.field("z", INSITU_VERTEX, [](const Vec3d& p) { return p.z; });
  render::Structures structures(mesh.committed.memory);
  structures.begin(mesh.sampler(), 1, 1, mesh.committed.threads);
  VolumeSettings s{field,
                   with_opacity({{0, 0}, {0.55, 0}, {0.55, 0.9}, {0.56, 0.9}, {0.56, 0}, {1, 0}})};
  s.unit_distance = 0.01;
  s.step = 0.3; // samples at z = 0.05, 0.35, 0.65, 0.95
  EXPECT_EQ(gathered(mesh.sampler(), s, structures).alpha, 0);
  s.preintegrated = true;
  EXPECT_NEAR(gathered(mesh.sampler(), s, structures).alpha, 0.9, 2e-6);
}

/// Samples of a shell in a smooth ball draw rings where rays meet it at other places of their
/// lattice; integrals between samples leave less than a third of them at the default step.
TEST(VolumeModes, PreintegrationDrawsNoRingsOnASmoothBall) {
  RenderMesh mesh(20);
  const auto field = mesh.field("r", INSITU_VERTEX, [](const Vec3d& p) {
    return std::sqrt(std::pow(p.x - 0.5, 2) + std::pow(p.y - 0.5, 2) + std::pow(p.z - 0.5, 2));
  });
  FrameSettings s = box_frame(48);
  s.volume = VolumeSettings{
      field, with_opacity({{0, 0}, {0.3, 0}, {0.31, 0.4}, {0.36, 0.4}, {0.37, 0}, {1, 0}})};
  s.volume->unit_distance = 0.05;
  s.volume->step = 0.001;
  const core::Image truth = mesh.draw(s);
  s.volume->step.reset();
  const double rings = largest_difference(mesh.draw(s), truth);
  s.volume->preintegrated = true;
  const double rest = largest_difference(mesh.draw(s), truth);
  EXPECT_GT(rings, 0.015);
  EXPECT_LT(rest, rings / 3);
}

/// The error found stays below the one asked for, and less asked for costs less.
TEST(VolumeModes, ToleranceBoundsTheError) {
  for (const Shape shape : {Shape::hexahedron, Shape::wedge})
    for (const auto& points : {std::vector<OpacityPoint>{{0, 0}, {1, 0.7}},
                               {{0, 0}, {0.3, 0}, {0.3, 0.4}, {0.5, 0.4}, {0.5, 0}, {1, 0}}}) {
      RenderMesh mesh(12, shape, 0.2);
      const auto field = mesh.field("f", INSITU_VERTEX, [](const Vec3d& p) {
        return 0.5 + 0.5 * std::sin(5 * p.x) * std::cos(4 * p.y + 2 * p.z);
      });
      FrameSettings s = box_frame(20);
      s.volume = VolumeSettings{field, with_opacity(points)};
      s.volume->unit_distance = 0.3;
      s.volume->step = 0.001;
      const core::Image truth = mesh.draw(s);
      s.volume->step.reset();
      std::int64_t before = INT64_MAX;
      for (const double tolerance : {0.005, 0.05, 0.5}) {
        s.volume->tolerance = tolerance;
        FrameStatistics statistics;
        const core::Image image = mesh.draw(s, 1, &statistics);
        EXPECT_LT(largest_difference(image, truth), tolerance)
            << int(shape) << " " << points.size();
        EXPECT_LT(statistics.samples, before);
        before = statistics.samples;
        EXPECT_TRUE(same(image, mesh.draw(s, 4)));
      }
    }
}

TEST(VolumeModes, ToleranceTakesLongStepsThroughWhatIsEven) {
  RenderMesh mesh(24);
  const auto field = mesh.field("f", INSITU_VERTEX, [](const Vec3d& p) { // even but in one corner
    return std::max(0.0, p.x + p.y + p.z - 2.7);
  });
  FrameSettings s = box_frame(32);
  s.volume = VolumeSettings{field, with_opacity({{0, 0.2}, {0.8, 0.9}})};
  s.volume->unit_distance = 1;
  FrameStatistics even, adapted;
  mesh.draw(s, 0, &even);
  s.volume->tolerance = 0.05;
  mesh.draw(s, 0, &adapted);
  EXPECT_LT(adapted.samples, even.samples);
  s.volume->preintegrated = true;
  EXPECT_THROW(mesh.draw(s), core::Error);
  s.volume->preintegrated = false;
  s.volume->tolerance = 0.0;
  EXPECT_THROW(mesh.draw(s), core::Error);
}

/// A linear field's gradient is the same everywhere, so light is a factor.
TEST(VolumeModes, ShadingByTheGradient) {
  RenderMesh mesh(5, Shape::wedge, 0.2);
  const Vec3d g{1, 2, -2}; // of length 3
  const auto field =
      mesh.field("f", INSITU_VERTEX, [&](const Vec3d& p) { return dot(g, p) / 10 + 0.4; });
  FrameSettings s = box_frame(1);
  s.camera = {{0.5, 0.5, 3}, {0.5, 0.5, 0.5}, {0, 1, 0}, 10};
  s.background_alpha = 0;
  s.volume = VolumeSettings{field, constant_function(0.5, 0.8)};
  s.volume->unit_distance = 0.2;
  for (const bool preintegrated : {false, true}) {
    s.volume->preintegrated = preintegrated;
    s.volume->shading = false;
    EXPECT_NEAR(mesh.draw(s).pixel(0, 0)[0], 0.8, 1e-5);
    s.volume->shading = true;
    s.lighting.lights.clear();
    EXPECT_NEAR(mesh.draw(s).pixel(0, 0)[0], 0.8 * (0.3 + 0.7 * 2 / 3.0), 1e-5);
    // From x, where the side that is seen, (-1, -2, 2) / 3, is turned away; and from -y.
    s.lighting.lights = {{render::Light::Kind::directional, {2, 0, 0}, {1, 1, 1}}};
    EXPECT_NEAR(mesh.draw(s).pixel(0, 0)[0], 0.8 * 0.3, 1e-5);
    s.lighting.lights = {{render::Light::Kind::directional, {0, -5, 0}, {0.5f, 1, 0}}};
    EXPECT_NEAR(mesh.draw(s).pixel(0, 0)[0], 0.8 * (0.3 + 0.7 * 2 / 3.0 * 0.5), 1e-5);
    EXPECT_NEAR(mesh.draw(s).pixel(0, 0)[1], 0.8 * (0.3 + 0.7 * 2 / 3.0), 1e-5);
    EXPECT_NEAR(mesh.draw(s).pixel(0, 0)[2], 0.8 * 0.3, 1e-5);
    s.lighting.lights = {{render::Light::Kind::dome, {}, {1, 1, 1}}};
    EXPECT_NEAR(mesh.draw(s).pixel(0, 0)[0], 0.8, 1e-5);
  }
  // A field without a gradient keeps its colours.
  s.volume->preintegrated = false;
  s.volume->field = mesh.field("c", INSITU_VERTEX, [](const Vec3d&) { return 1.0; });
  EXPECT_NEAR(mesh.draw(s).pixel(0, 0)[0], 0.8, 1e-5);
  s.volume->field = mesh.field("k", INSITU_CELL, [](const Vec3d& p) { return p.x; });
  EXPECT_NEAR(mesh.draw(s).pixel(0, 0)[0], 0.8, 1e-5);
}

/// A clip that takes nothing away asks every sample for what is left of its ray.
TEST(VolumeModes, SamplesThatNothingIsAskedOfGiveTheSameBytes) {
  for (const Shape shape : {Shape::hexahedron, Shape::pyramid}) {
    RenderMesh mesh(8, shape, 0.3);
    FrameSettings plain = box_frame(70);
    plain.volume = VolumeSettings{mesh.field("f", INSITU_VERTEX, blob),
                                  with_opacity({{0, 0}, {0.2, 0.05}, {1, 0.9}})};
    plain.depth = plain.cell = true;
    for (const double opacity : {0.02, 0.9})
      for (const double step : {0.5, 3.0}) {
        plain.volume->function = with_opacity({{0, 0}, {0.2, 0.5 * opacity}, {1, opacity}});
        plain.volume->step_factor = step;
        FrameSettings asked = plain;
        asked.clips.push_back({render::Clip::Kind::box, {-9, -9, -9}, {9, 9, 9}, 0.0, true});
        const auto draw = [&](const FrameSettings& s) {
          return render::render_frame(mesh.sampler(), s, mesh.committed.threads,
                                      mesh.committed.memory);
        };
        const render::FrameImages a = draw(plain), b = draw(asked);
        EXPECT_TRUE(same(a.color, b.color)) << opacity << " " << step;
        EXPECT_EQ(a.depth, b.depth);
        EXPECT_EQ(a.cell, b.cell);
      }
  }
}

// Whole rays in one group and parts of them; opaque ones end early and so take fewer samples of
// small groups.
TEST(VolumeModes, SampleGroupsChangeTheWorkAlone) {
  RenderMesh mesh(8, Shape::hexahedron, 0.3);
  FrameSettings s = box_frame(70);
  s.volume = VolumeSettings{mesh.field("f", INSITU_VERTEX, blob), with_opacity({{0, 0}, {1, 0.9}})};
  for (const bool preintegrated : {false, true}) {
    s.volume->preintegrated = preintegrated;
    s.volume->sample_group = 0;
    const core::Image chosen = mesh.draw(s, 1);
    std::int64_t before = 0;
    for (const int group : {1, 3, 16, 32}) {
      s.volume->sample_group = group;
      render::FrameStatistics statistics;
      const core::Image image = render::render_frame(mesh.sampler(), s, mesh.committed.threads,
                                                     mesh.committed.memory, &statistics)
                                    .color;
      // Newton's method begins where floats about the middle of a group put a sample.
      EXPECT_LT(largest_difference(image, chosen), 1e-6) << group;
      EXPECT_GE(statistics.samples, before) << group;
      before = statistics.samples;
    }
  }
  for (const int group : {-1, 33}) {
    s.volume->sample_group = group;
    EXPECT_THROW(mesh.draw(s, 1), core::Error) << group;
  }
}

TEST(VolumeModes, SameBytesForAnyNumberOfThreads) {
  RenderMesh mesh(8, Shape::tetrahedron, 0.3);
  const auto field = mesh.field("f", INSITU_VERTEX, blob);
  for (const int mode : {0, 1, 2}) {
    FrameSettings s = box_frame(70);
    s.volume = VolumeSettings{field, with_opacity({{0, 0}, {1, 0.9}})};
    s.volume->shading = true;
    s.volume->preintegrated = mode == 1;
    if (mode == 2)
      s.volume->tolerance = 0.05;
    const core::Image one = mesh.draw(s, 1);
    for (const int threads : {2, 4})
      EXPECT_TRUE(same(mesh.draw(s, threads), one)) << mode << " " << threads;
  }
}

} // namespace
} // namespace insitu::test
