// Several volumes in one frame, marched and path traced: depth order and what overlaps, against
// closed forms.
#include "render/volume/volumes_together.h"
#include "unit/render/several_meshes.h"

namespace insitu::test {
namespace {

TEST_F(SeveralMeshes, BoxesBehindEachOther) {
  const Box near{{0, 0, 0.6}, {1, 1, 1}}, far{{0, 0, -0.5}, {1, 1, 0.3}};
  expect_closed_form({{near, 0.7, 0.9}, {far, 0.5, 0.1}});
  expect_closed_form({{near, 0.5, 0.1}, {far, 0.8, 0.9}});
}

TEST_F(SeveralMeshes, BoxesThatOverlapAddTheirOpticalDepths) {
  const Box a{{0, 0, 0}, {1, 1, 1}}, b{{0.3, 0.2, 0.4}, {1.2, 0.7, 1.1}},
      c{{0.2, 0.3, -0.2}, {0.6, 0.6, 1.3}};
  expect_closed_form({{a, 0.6, 0.9}, {b, 0.8, 0.1}});
  expect_closed_form({{a, 0.5, 0.2}, {a, 0.5, 0.8}});
  expect_closed_form({{a, 0.4, 0.9}, {b, 0.5, 0.1}, {c, 0.7, 0.5}});
}

TEST_F(SeveralMeshes, AnOpaqueMediumHidesThoseInItsPlace) {
  std::vector<render::VolumeStretch> a{{1, 2, 0.5f, {1, 0, 0}}, {2, 3, 1.0f, {1, 0, 0}}};
  std::vector<render::VolumeStretch> b{{2, 3, 0.75f, {0, 1, 0}}};
  render::RayState ray;
  const render::LayerStretches both[] = {{b}, {a}};
  render::blend_together(ray, both);
  EXPECT_EQ(ray.alpha, 1.0f);
  EXPECT_EQ(ray.color.r, 1.0f);
  EXPECT_EQ(ray.color.g, 0.0f);
  EXPECT_EQ(ray.depth, 2.0); // a half
  a[1].color = {0, 0, 1};
  b[0].alpha = 1;
  ray.begin({});
  render::blend_together(ray, both);
  EXPECT_EQ(ray.alpha, 1.0f);
  EXPECT_EQ(ray.color.g, 0.25f);
  EXPECT_EQ(ray.color.b, 0.25f);
}

/// Ends of stretches and hits cut stretches into pieces of their optical depths.
TEST_F(SeveralMeshes, PiecesOfStretches) {
  const std::vector<render::VolumeStretch> a{{0, 4, 0.75f, {1, 0, 0}}};
  const std::vector<render::VolumeStretch> b{{1, 3, 0.5f, {0, 1, 0}}};
  render::RayState ray;
  render::SurfaceHit hit;
  hit.t = 2;
  hit.opacity = 0.5f;
  hit.color = {0, 0, 1};
  ray.hits = {hit};
  const render::LayerStretches both[] = {{a}, {b}};
  render::blend_together(ray, both);
  const double ta = std::log(4.0) / 4, tb = std::log(2.0) / 2, t = ta + tb;
  const double at_1 = std::exp(-ta), at_2 = at_1 * std::exp(-t), behind = 0.5 * at_2;
  const double at_3 = behind * std::exp(-t), at_4 = at_3 * std::exp(-ta);
  const double mixed = (at_1 - at_2) + (behind - at_3);
  EXPECT_NEAR(ray.alpha, 1 - at_4, 1e-6);
  EXPECT_NEAR(ray.color.r, (1 - at_1) + mixed * ta / t + (at_3 - at_4), 1e-6);
  EXPECT_NEAR(ray.color.g, mixed * tb / t, 1e-6);
  EXPECT_NEAR(ray.color.b, 0.5 * at_2, 1e-6);
  EXPECT_NEAR(ray.depth, 1 + std::log(2 * at_1) / t, 1e-6);
}

/// Where a ray meets one of the meshes only, it shows that mesh to the bit; where a volume is lit,
/// but for the rounding of coordinates in cells, which start from those of neighbouring rays.
TEST_F(SeveralMeshes, PixelsOfOneMeshAreThatMeshAlone) {
  RenderMesh& a = mesh(cells_of({{0, 0, 0}, {1, 1, 1}}));
  RenderMesh& b = mesh(cells_of({{0.7, 0.6, -0.4}, {1.4, 1.3, 0.5}}, 5));
  const auto f = [](const Vec3d& p) { return 0.5 + 0.5 * std::sin(5 * p.x) * std::cos(4 * p.y); };
  const render::TransferFunction function(render::ColorMap::built_in("viridis"), 0, 1,
                                          {{0, 0.0}, {0.4, 0.1}, {1, 0.5}});
  FrameSettings s = frame;
  s.depth = true;
  s.lighting.enabled = true;
  FrameSettings of_b = s;
  s.volume = VolumeSettings{a.field("f", INSITU_VERTEX, f), function};
  s.isosurfaces.push_back({s.volume->field, {0.7}, 0.5, Color{0.9f, 0.2f, 0.1f}});
  of_b.volume = VolumeSettings{b.field("f", INSITU_VERTEX, f), function};
  of_b.boundary = render::BoundarySettings{0.3, Color{0.2f, 0.9f, 0.1f}};
  const auto expect_pixel = [](const float* found, const float* expected, bool is_lit) {
    for (int c = 0; c < 4; ++c)
      EXPECT_NEAR(found[c], expected[c], is_lit ? 1e-6 : 0);
  };
  for (const bool preintegrated : {false, true})
    for (const bool shading : {false, true}) {
      s.volume->preintegrated = of_b.volume->preintegrated = preintegrated;
      s.volume->shading = of_b.volume->shading = shading;
      std::vector<float> depth_a, depth_b, depth;
      const core::Image one = draw({{&a, s}}, 1, nullptr, &depth_a);
      const core::Image other = draw({{&b, of_b}}, 1, nullptr, &depth_b);
      const core::Image both = draw({{&a, s}, {&b, of_b}}, 3, nullptr, &depth);
      int of_one = 0, of_other = 0;
      for (int y = 0; y < s.height; ++y)
        for (int x = 0; x < s.width; ++x) {
          const std::size_t at = std::size_t(y * s.width + x);
          if (other.pixel(x, y)[3] == 0) {
            expect_pixel(both.pixel(x, y), one.pixel(x, y), shading);
            EXPECT_EQ(depth[at], depth_a[at]);
            of_one += one.pixel(x, y)[3] > 0;
          } else if (one.pixel(x, y)[3] == 0) {
            expect_pixel(both.pixel(x, y), other.pixel(x, y), shading);
            EXPECT_EQ(depth[at], depth_b[at]);
            ++of_other;
          }
        }
      EXPECT_GT(of_one, 100);
      EXPECT_GT(of_other, 30);
    }
}

/// So many standard deviations from the truth fail: by chance one comparison in 150 000, and the
/// seeds are fixed.
constexpr double most_deviations = 4.5;

/// What collides first in media that overlap is known, and what it shows.
TEST_F(SeveralMeshes, PathsMeetMediaByTheSumOfTheirExtinctions) {
  const Box a{{0, 0, 0}, {1, 1, 1}}, b{{0.3, 0.2, 0.4}, {1.2, 0.7, 1.1}},
      c{{0.2, 0.3, -0.2}, {0.6, 0.6, 1.3}}, far{{0, 0, -1.5}, {1, 1, -0.7}};
  constexpr int samples = 64;
  for (const std::vector<Medium>& media : {std::vector<Medium>{{a, 0.6, 0.9}, {b, 0.8, 0.1}},
                                           {{a, 0.5, 0.2}, {a, 0.5, 0.8}},
                                           {{a, 0.4, 0.9}, {b, 0.5, 0.1}, {c, 0.7, 0.5}},
                                           {{far, 0.7, 0.9}, {b, 0.5, 0.1}}}) {
    std::vector<Layer> layers;
    int n = 3;
    for (const Medium& m : media) {
      layers.push_back(layer(m, n++)); // grids of majorants differ
      layers.back().settings.path_tracing.emplace().samples = samples;
      layers.back().settings.path_tracing->scattering = render::Scattering::none;
    }
    render::FrameStatistics done;
    const core::Image image = draw(layers, 2, &done);
    EXPECT_EQ(done.paths.violations, 0);
    EXPECT_EQ(done.samples, 0); // nothing was marched
    const RayGenerator rays(frame.camera, frame.width, frame.height);
    double met = 0, met_variance = 0, shown = 0, shown_variance = 0;
    for (int y = 0; y < frame.height; ++y)
      for (int x = 0; x < frame.width; ++x) {
        const auto [alpha, grey] = seen(rays(x, y), media);
        const float* p = image.pixel(x, y);
        met += double(p[3]) - alpha;
        met_variance += alpha * (1 - alpha) / samples;
        shown += double(p[0]) * double(p[3]) - alpha * grey;
        // Of one path, whose greys lie between 0 and 1: at most that of alpha * grey out of 1.
        shown_variance += alpha * grey * (1 - alpha * grey) / samples;
      }
    EXPECT_GT(met_variance, 1.0 / samples);
    EXPECT_LT(std::fabs(met), most_deviations * std::sqrt(met_variance));
    EXPECT_LT(std::fabs(shown), most_deviations * std::sqrt(shown_variance));
  }
}

/// Halves have majorants and random numbers of their own, so that light that scatters in a cut mesh
/// is that of the whole by its mean alone: that of 8 images.
TEST_F(SeveralMeshes, PathsThroughHalvesBringTheLightOfTheWhole) {
  const TestMesh cells = box_cells(6, Shape::hexahedron, 0.0);
  const auto [left, right] = halves_of(cells);
  RenderMesh &whole = mesh(cells), &a = mesh(left), &b = mesh(right);
  const auto settings = [&](RenderMesh& of) {
    FrameSettings s = frame;
    const auto f = of.field("f", INSITU_VERTEX, [](const Vec3d& p) { return p.x * p.y + p.z; });
    s.volume = VolumeSettings{f, render::TransferFunction(render::ColorMap::built_in("viridis"), 0,
                                                          2, {{0, 0.3}, {2, 0.95}})};
    s.volume->unit_distance = 0.5;
    s.path_tracing.emplace().samples = 24;
    s.lighting.lights = {{render::Light::Kind::directional, {-3, 1, 0.5}},
                         {render::Light::Kind::dome, {}, {0.3f, 0.4f, 0.5f}}};
    return s;
  };
  FrameSettings of_whole = settings(whole);
  std::vector<Layer> halves{{&a, settings(a)}, {&b, settings(b)}};
  constexpr int images = 8;
  double sum[4] = {}, squares[4] = {}, light[4] = {};
  for (int i = 0; i < images; ++i) {
    of_whole.path_tracing->seed = std::uint64_t(i);
    for (Layer& half : halves)
      half.settings.path_tracing->seed = std::uint64_t(100 + i);
    const core::Image one = whole.draw(of_whole), two = draw(halves);
    for (int c = 0; c < 4; ++c) {
      double difference = 0;
      for (std::size_t p = 0; p < one.rgba.size(); p += 4) {
        const auto of = [&](const core::Image& image) {
          return double(image.rgba[p + std::size_t(c)]) * (c < 3 ? double(image.rgba[p + 3]) : 1);
        };
        difference += of(two) - of(one);
        light[c] += of(one);
      }
      sum[c] += difference;
      squares[c] += difference * difference;
    }
  }
  for (int c = 0; c < 4; ++c) {
    const double error = std::sqrt(squares[c]); // of the sum, if its mean is 0
    EXPECT_LT(std::fabs(sum[c]), most_deviations * error) << c;
    EXPECT_LT(error, 0.01 * light[c]) << c;
  }
}

/// Paths of rays that miss the other medium take no random number for it.
TEST_F(SeveralMeshes, PathsOfOneMediumAreThatMediumAlone) {
  const Medium m{{{0, 0, 0}, {1, 1, 1}}, 0.6, 0.9},
      n{{{0.7, 0.6, -0.4}, {1.4, 1.3, 0.5}}, 0.8, 0.3};
  std::vector<Layer> both{layer(m), layer(n, 5)};
  for (Layer& of : both) {
    of.settings.path_tracing.emplace().samples = 16;
    of.settings.path_tracing->scattering = render::Scattering::none;
    of.settings.depth = true;
  }
  std::vector<float> depth, depth_of_both;
  const core::Image one = draw({both[0]}, 1, nullptr, &depth),
                    two = draw(both, 3, nullptr, &depth_of_both);
  const RayGenerator rays(frame.camera, frame.width, frame.height);
  int alone = 0, met = 0;
  for (int y = 0; y < frame.height; ++y)
    for (int x = 0; x < frame.width; ++x) {
      const Stretch in = stretch_of(rays(x, y), n.box);
      if (in.from < in.to) {
        met += two.pixel(x, y)[3] > one.pixel(x, y)[3];
        continue;
      }
      alone += one.pixel(x, y)[3] > 0;
      for (int c = 0; c < 4; ++c)
        EXPECT_EQ(one.pixel(x, y)[c], two.pixel(x, y)[c]) << x << ", " << y;
      const auto at = std::size_t(y * frame.width + x);
      EXPECT_EQ(depth[at], depth_of_both[at]);
    }
  EXPECT_GT(alone, 100);
  EXPECT_GT(met, 50);
}

/// A boundary of one mesh between the light and the medium of another: of two faces that let half
/// through a quarter is left, to rounding, and behind an opaque one nothing.
TEST_F(SeveralMeshes, SurfacesShadeTheMediaOfOtherMeshes) {
  const Layer fog = layer({{{0, 0, 0}, {1, 1, 1}}, 0.7, 1.0});
  RenderMesh& plate = mesh(cells_of({{-0.5, 1.5, -0.5}, {1.5, 1.6, 1.5}}, 2, 0));
  for (const bool plate_first : {false, true}) {
    const auto drawn = [&](double opacity) {
      std::vector<Layer> layers{fog, {&plate, frame}};
      layers[1].settings.boundary = render::BoundarySettings{opacity, Color{0, 0, 0}};
      for (Layer& of : layers) {
        of.settings.path_tracing.emplace().samples = 4;
        of.settings.path_tracing->scattering = render::Scattering::single;
        of.settings.lighting.volume_shadows = true;
        of.settings.lighting.lights = {{render::Light::Kind::directional, {0, 1, 0}}};
        of.settings.camera.position = {0.5, 0.5, 4};
        of.settings.camera.orthographic_height = 1.6; // past the plate
      }
      if (plate_first)
        std::swap(layers[0], layers[1]);
      return draw(layers);
    };
    const core::Image lit = drawn(0), half = drawn(0.5), dark = drawn(1);
    double light = 0;
    for (std::size_t i = 0; i < lit.rgba.size(); i += 4) {
      light += double(lit.rgba[i]);
      EXPECT_NEAR(half.rgba[i], 0.25f * lit.rgba[i], 1e-6);
      EXPECT_EQ(dark.rgba[i], 0.0f);
      EXPECT_EQ(dark.rgba[i + 3], lit.rgba[i + 3]);
    }
    EXPECT_GT(light, 10);
  }
}

/// A furnace: light that neither media nor the walls around them take is the same everywhere, by
/// whichever mesh it scatters and ends.
TEST_F(SeveralMeshes, ScatteredLightMeetsTheWallsOfOtherMeshes) {
  const Layer fog = layer({{{0.2, 0.2, 0.2}, {0.8, 0.8, 0.8}}, 0.9, 1.0}),
              mist = layer({{{0.4, 0.1, 0.3}, {1.3, 0.6, 0.7}}, 0.5, 1.0});
  RenderMesh& room = mesh(cells_of({{-1, -1, -1}, {2, 2, 3}}, 2, 0));
  std::vector<Layer> layers{fog, mist, {&room, frame}};
  layers[2].settings.boundary = render::BoundarySettings{1, Color{1, 1, 1}};
  for (Layer& of : layers) {
    of.settings.path_tracing.emplace().samples = 4;
    of.settings.path_tracing->anisotropy = 0.4;
    of.settings.lighting.volume_shadows = true;
    of.settings.lighting.lights = {{render::Light::Kind::dome, {}, {0, 0, 0}}};
  }
  for (int turn = 0; turn < 3; ++turn) {
    render::FrameStatistics done;
    const core::Image image = draw(layers, 2, &done);
    EXPECT_GT(done.paths.scatterings, 1000);
    for (int y = 0; y < frame.height; ++y)
      for (int x = 0; x < frame.width; ++x)
        for (int c = 0; c < 4; ++c)
          EXPECT_NEAR(image.pixel(x, y)[c], 1, 1e-5) << x << ", " << y;
    std::rotate(layers.begin(), layers.begin() + 1, layers.end());
  }
}

} // namespace
} // namespace insitu::test
