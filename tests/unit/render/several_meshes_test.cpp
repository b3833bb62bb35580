// Several volumes in one frame: depth order and what overlaps, against closed forms.
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
  const std::span<const render::VolumeStretch> both[] = {b, a};
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
  const std::span<const render::VolumeStretch> both[] = {a, b};
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

} // namespace
} // namespace insitu::test
