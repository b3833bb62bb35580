#pragma once

#include <algorithm>
#include <gtest/gtest.h>
#include <memory>

#include "unit/render/path_mesh.h"

/// Frames that are drawn more than once, by other means, and have to be the same to the byte.
namespace insitu::test {

using render::FrameImages;
using render::FrameSettings;
using render::ScalarField;

inline constexpr accel::Method methods[] = {
    accel::Method::user_geometry, accel::Method::replicated_faces, accel::Method::shared_faces,
    accel::Method::shared_bilinear_faces};

inline double blob(const Vec3d& p) {
  const Vec3d d = p - Vec3d{0.6, 0.5, 0.4};
  return std::exp(-8 * dot(d, d));
}

inline render::TransferFunction colors() {
  return {render::ColorMap::built_in("viridis"), 0.0, 1.0, {{0.2, 0.0}, {0.5, 0.4}, {0.5, 0.1}}};
}

/// Within the unit box, whose corners it does not touch.
inline render::BodySettings small_body() {
  auto list = std::make_shared<render::TriangleList>();
  list->source = "two triangles";
  list->corners = {{0.1, 0.15, 0.3}, {0.9, 0.2, 0.35}, {0.3, 0.85, 0.4},
                   {0.3, 0.85, 0.4}, {0.9, 0.2, 0.35}, {0.8, 0.8, 0.7}};
  return {list, 0.7, {0.2f, 0.6f, 0.3f}};
}

struct Technique {
  const char* name;
  FrameSettings (*ask)(FrameSettings, const ScalarField&);
};
inline const Technique techniques[] = {
    {"marching",
     [](FrameSettings s, const ScalarField& f) {
       s.volume = render::VolumeSettings{f, colors()};
       return s;
     }},
    {"marching, lit, with a tolerance",
     [](FrameSettings s, const ScalarField& f) {
       s.volume = render::VolumeSettings{f, colors()};
       s.volume->shading = true;
       s.volume->tolerance = 0.05;
       return s;
     }},
    {"marching, pre-integrated, with surfaces",
     [](FrameSettings s, const ScalarField& f) {
       s.volume = render::VolumeSettings{f, colors()};
       s.volume->preintegrated = true;
       s.isosurfaces.push_back({f, {0.7}, 0.5});
       return s;
     }},
    {"marching, clipped, with boundary, body and volume shadows",
     [](FrameSettings s, const ScalarField& f) {
       s.volume = render::VolumeSettings{f, colors()};
       s.volume->shading = true;
       s.boundary.emplace().opacity = 0.3;
       s.boundary->color = render::ColorByField{f, colors()};
       s.bodies.push_back(small_body());
       s.isosurfaces.push_back({f, {0.6}, 0.8});
       using Kind = render::Clip::Kind;
       s.clips = {{Kind::plane, {0.8, 0, 0}, {1, 0.1, 0.2}},
                  {Kind::sphere, {0.4, 0.5, 0.8}, {}, 0.25, false}};
       s.lighting.shadows = s.lighting.volume_shadows = true;
       s.lighting.lights = {{render::Light::Kind::directional, {1, 1, 2}, {1, 1, 1}}};
       return s;
     }},
    {"path tracing with surfaces that cast shadows, clipped",
     [](FrameSettings s, const ScalarField& f) {
       s.volume = render::VolumeSettings{f, colors()};
       s.path_tracing.emplace().samples = 2;
       s.bodies.push_back(small_body());
       s.clips = {{render::Clip::Kind::plane, {0.8, 0, 0}, {1, 0.1, 0.2}}};
       s.lighting.shadows = s.lighting.volume_shadows = true;
       s.lighting.lights = {{render::Light::Kind::directional, {1, 2, 1}, {1, 1, 1}}};
       return s;
     }},
    {"path tracing",
     [](FrameSettings s, const ScalarField& f) {
       s.volume = render::VolumeSettings{f, colors()};
       s.path_tracing.emplace().samples = 3;
       s.lighting.lights = {{render::Light::Kind::dome, {}, {0.3f, 0.4f, 0.5f}},
                            {render::Light::Kind::directional, {1, 2, 1}, {1, 1, 1}}};
       return s;
     }},
    {"isosurfaces",
     [](FrameSettings s, const ScalarField& f) {
       s.isosurfaces.push_back({f, {0.3, 0.6}, 0.5, render::Color{1, 1, 1}});
       s.isosurfaces[0].normals = render::Normals::smooth;
       s.isosurfaces.push_back({f, {0.8}, 1, render::Color{1, 0, 0}});
       s.isosurfaces[1].normals = render::Normals::central; // which locates points
       s.lighting.shadows = true;
       s.lighting.occlusion_samples = 4;
       s.lighting.lights = {{render::Light::Kind::directional, {1, 1, 2}, {1, 1, 1}}};
       return s;
     }},
};

inline FrameImages draw(const fixtures::Committed& mesh, const FrameSettings& s,
                        core::Memory& memory, int threads) {
  return render::render_frame(mesh.sampler(), s, core::Threads(threads), memory);
}

inline void expect_same(const FrameImages& a, const FrameImages& b) {
  EXPECT_EQ(a.color.rgba, b.color.rgba);
  EXPECT_EQ(a.depth, b.depth);
  EXPECT_EQ(a.cell, b.cell);
}

/// Draws with every technique by every locator and by one and several threads. field: of the mesh
/// as it was committed last.
inline void expect_same_by_all(fixtures::Committed& mesh,
                               const std::function<ScalarField()>& field) {
  FrameSettings frame = box_frame(24);
  frame.depth = frame.cell = true;
  for (const Technique& technique : techniques) {
    SCOPED_TRACE(technique.name);
    mesh.mesh.set_locator({accel::Method::bvh, accel::Backend::cpu});
    mesh.commit();
    const auto settings = [&] { return technique.ask(frame, field()); };
    const FrameImages by_bvh = draw(mesh, settings(), mesh.memory, 1);
    const auto [least, most] =
        std::minmax_element(by_bvh.color.rgba.begin(), by_bvh.color.rgba.end());
    EXPECT_LT(*least, *most) << "something is seen";
    expect_same(by_bvh, draw(mesh, settings(), mesh.memory, 4));
    for (const accel::Method method : methods) {
      SCOPED_TRACE(testing::Message() << "method " << int(method));
      mesh.mesh.set_locator({method, accel::Backend::cpu});
      mesh.commit();
      ASSERT_NE(mesh.mesh.locators().rays(), nullptr);
      for (const int threads : {1, 4})
        expect_same(by_bvh, draw(mesh, settings(), mesh.memory, threads));
    }
  }
}

} // namespace insitu::test
