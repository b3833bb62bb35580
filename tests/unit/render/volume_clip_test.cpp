// A homogeneous medium that clips cut: what is left of each pixel's ray absorbs, by Beer and
// Lambert's law, whatever the step.
#include <cmath>
#include <gtest/gtest.h>

#include "unit/render/render_mesh.h"

namespace insitu::test {
namespace {

using render::Clip;

/// The length of a ray in the unit box that a clip of one stretch leaves.
double left_of(const render::Ray& ray, const Clip& clip) {
  auto [from, to] = box_stretch(ray);
  switch (clip.kind) {
  case Clip::Kind::plane: { // cut on the side that the normal points to
    const double speed = dot(clip.vector, ray.direction);
    const double t = dot(clip.vector, clip.point - ray.origin) / speed;
    (speed > 0 ? to : from) = speed > 0 ? std::min(to, t) : std::max(from, t);
    break;
  }
  case Clip::Kind::box:
    for (int a = 0; a < 3; ++a) {
      const double t0 = (clip.point[a] - ray.origin[a]) / ray.direction[a];
      const double t1 = (clip.vector[a] - ray.origin[a]) / ray.direction[a];
      from = std::max(from, std::min(t0, t1));
      to = std::min(to, std::max(t0, t1));
    }
    break;
  case Clip::Kind::sphere: {
    const Vec3d d = ray.origin - clip.point;
    const double b = dot(d, ray.direction), root = b * b - dot(d, d) + clip.radius * clip.radius;
    if (!(root > 0))
      return 0;
    from = std::max(from, -b - std::sqrt(root));
    to = std::min(to, -b + std::sqrt(root));
  }
  }
  return std::max(0.0, to - from);
}

class ClippedVolume : public testing::TestWithParam<Shape> {};

TEST_P(ClippedVolume, IsWhatIsLeftOfIt) {
  RenderMesh mesh(5, GetParam(), 0.2);
  const render::ScalarField field =
      mesh.field("f", INSITU_VERTEX, [](const Vec3d&) { return 0.5; });
  const double opacity = 0.7, unit = 0.4;
  for (const Clip& clip : {Clip{Clip::Kind::plane, {0.43, 0.5, 0.5}, {1, 0.3, -0.2}},
                           Clip{Clip::Kind::plane, {0.3, 0, 0}, {-1, 0, 0}},
                           Clip{Clip::Kind::box, {0.21, 0.33, 0.17}, {0.81, 0.9, 0.71}},
                           Clip{Clip::Kind::sphere, {0.5, 0.4, 0.6}, {}, 0.37}})
    for (const int kind : {0, 1, 2}) {
      SCOPED_TRACE(testing::Message() << "clip " << int(clip.kind) << ", kind " << kind);
      render::FrameSettings s = box_frame(20);
      s.background_alpha = 0;
      s.clips = {clip};
      s.volume = render::VolumeSettings{field, constant_function(opacity)};
      s.volume->unit_distance = unit;
      s.volume->step = 0.07;
      s.volume->preintegrated = kind == 1;
      if (kind == 2)
        s.volume->tolerance = 0.1;
      const core::Image image = mesh.draw(s);
      const render::RayGenerator rays(s.camera, 20, 20);
      int cut = 0;
      for (int i = 0; i < 400; ++i) {
        const render::Ray ray = rays(i % 20, i / 20);
        const auto [from, to] = box_stretch(ray);
        const double left = left_of(ray, clip);
        cut += left > 0 && left < to - from - 1e-3;
        // A float's rounding of the sum over some tens of samples.
        const double expected = -std::expm1(left / unit * std::log1p(-opacity));
        EXPECT_NEAR(image.pixel(i % 20, i / 20)[3], expected, 2e-6) << "pixel " << i;
      }
      EXPECT_GT(cut, 40);
    }
}

INSTANTIATE_TEST_SUITE_P(Shapes, ClippedVolume,
                         testing::Values(Shape::hexahedron, Shape::tetrahedron, Shape::wedge,
                                         Shape::pyramid));

} // namespace
} // namespace insitu::test
