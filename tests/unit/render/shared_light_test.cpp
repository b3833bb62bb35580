// Light on frames of several processes: its rays go where cells are.
#include "unit/render/shared_frames.h"

namespace insitu::test {
namespace {

/// A triangle beside the mesh, which casts a shadow on it.
render::BodySettings triangle(double opacity) {
  render::BodySettings body;
  auto list = std::make_shared<render::TriangleList>();
  list->source = "a triangle";
  list->corners.assign({Vec3d{0.2, 0.2, 1.3}, Vec3d{0.9, 0.3, 1.2}, Vec3d{0.4, 0.9, 1.1}});
  body.triangles = list;
  body.opacity = opacity;
  return body;
}

/// Shadows and ambient occlusion: rays of light go to the processes whose cells they may meet.
TEST(SharedFrames, RaysOfLight) {
  using render::Light;
  int seed = 0;
  for (const Shape shape : shapes) {
    const TestMesh whole = box_cells(6, shape, 0.2);
    for (const int mode : {0, 1, 2, 3, 4, 5}) {
      if (++seed % 2 == 0) // the other modes with the next shape
        continue;
      SCOPED_TRACE(testing::Message() << "shape " << int(shape) << ", mode " << mode);
      expect_same(
          whole,
          [&](const ScalarField& f, const ScalarField& c) {
            FrameSettings s = frame();
            s.lighting.lights = {{Light::Kind::directional, {0.3, 0.2, 1}},
                                 {Light::Kind::point, {0.5, 0.4, 1.6}, {0.5f, 0.7f, 0.9f}}};
            s.lighting.shadows = mode != 1;
            s.isosurfaces.push_back({f, {0.2, 0.5}, mode == 2 || mode == 4 ? 0.4 : 1.0});
            if (mode == 0)
              s.isosurfaces[0].normals = render::Normals::smooth;
            if (mode == 1 || mode == 2)
              s.lighting.occlusion_samples = 5;
            if (mode == 1 || mode == 3) {
              s.boundary = render::BoundarySettings{mode == 1 ? 0.5 : 1.0, {}};
              s.clips.push_back({render::Clip::Kind::plane, {0.3, 0, 0.7}, {0.2, 0.2, 1}});
            }
            if (mode == 2)
              s.bodies = {triangle(1)};
            if (mode == 3) {
              s.bodies = {triangle(0.5)};
              s.lighting.lights = {{Light::Kind::dome}};
            }
            if (mode == 4) {
              s.isosurfaces[0].search = render::RootSearch::cubic;
              s.outline = render::OutlineSettings{};
            }
            if (mode == 5) {
              s.lighting.volume_shadows = true;
              s.bodies = {triangle(0.7)};
              s.isosurfaces[0].values = {0.7};
              s.volume = soft(shape == Shape::pyramid ? c : f);
              s.volume->shading = true;
            }
            return s;
          },
          seed, mode == 0 || mode == 1 || mode == 3);
    }
    ++seed;
  }
}

/// Volumes that are lit by lights at a place, and by those that surfaces hide.
TEST(SharedFrames, LightOnVolumes) {
  using render::Light;
  int seed = 0;
  for (const int mode : {0, 1, 2, 3, 4, 5}) {
    const TestMesh whole = box_cells(6, shapes[mode % 4], 0.2);
    SCOPED_TRACE(testing::Message() << "mode " << mode);
    expect_same(
        whole,
        [&](const ScalarField& f, const ScalarField& c) {
          FrameSettings s = frame();
          s.lighting.lights = {{Light::Kind::point, {0.5, 0.4, 1.6}, {0.5f, 0.7f, 0.9f}}};
          if (mode > 1)
            s.lighting.lights.push_back(
                {mode == 2 ? Light::Kind::dome : Light::Kind::directional, {0.3, 0.2, 1}});
          s.volume = soft(mode == 5 ? c : f); // cells have no gradient
          s.volume->shading = true;
          s.volume->preintegrated = mode % 2 == 0;
          s.lighting.volume_shadows = s.lighting.shadows = mode > 0;
          s.bodies = {triangle(0.7)};
          if (mode > 1)
            s.isosurfaces.push_back({f, {0.7}, mode == 2 ? 0.5 : 1.0});
          if (mode == 3)
            s.volume->step = 0.8; // thin rays
          if (mode == 4)
            s.clips.push_back({render::Clip::Kind::sphere, {0.5, 0.5, 0.9}, {}, 0.3, false});
          return s;
        },
        seed++);
  }
}

} // namespace
} // namespace insitu::test
