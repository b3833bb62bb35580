// What lights a frame and what is cut away of it: values read, errors.
#include <gtest/gtest.h>

#include "scene_test.h"

using namespace insitu;
using namespace insitu::scene;

namespace {

Frame frame(const std::string& keys) {
  return test::parse(test::frame(keys)).frames[0];
}
std::string frame_error(const std::string& keys) {
  return test::error_of(test::frame(keys));
}
bool tells(const std::string& message, const std::string& part) {
  return message.find(part) != std::string::npos;
}

} // namespace

TEST(SceneLights, Kinds) {
  EXPECT_TRUE(frame("size: [1, 1]").lights.empty());
  const auto lights = frame("lights: [{head: true}, {directional: [0, 0, 2], intensity: 3}, "
                            "{point: [1, 2, 3], color: red}, {dome: true, color: [0.5, 1, 0]}]")
                          .lights;
  ASSERT_EQ(lights.size(), 4u);
  EXPECT_EQ(lights[0].kind, render::Light::Kind::head);
  EXPECT_EQ(lights[0].color, render::linear_of_srgb(1, 1, 1));
  EXPECT_EQ(lights[1].kind, render::Light::Kind::directional);
  EXPECT_EQ(lights[1].vector, (math::Vec3d{0, 0, 2}));
  EXPECT_EQ(lights[1].color, (render::Color{3, 3, 3}));
  EXPECT_EQ(lights[2].kind, render::Light::Kind::point);
  EXPECT_EQ(lights[2].vector, (math::Vec3d{1, 2, 3}));
  EXPECT_EQ(lights[2].color, render::linear_of_srgb(1, 0, 0));
  EXPECT_EQ(lights[3].kind, render::Light::Kind::dome);
  EXPECT_EQ(lights[3].color, render::linear_of_srgb(0.5, 1, 0));
}

TEST(SceneLights, Errors) {
  EXPECT_EQ(frame_error("lights: [{color: red}]"),
            "s.yaml:2: frames[0].lights[0]: a light needs 'head', 'directional', 'point' or "
            "'dome'");
  EXPECT_EQ(frame_error("lights: [{head: true, dome: true}]"),
            "s.yaml:2: frames[0].lights[0]: a light has one of 'head' and 'dome', not both");
  EXPECT_TRUE(tells(frame_error("lights: [{head: false}]"), "head: true expected"));
  EXPECT_TRUE(tells(frame_error("lights: [{directional: [0, 0, 0]}]"), "is not zero"));
  EXPECT_TRUE(tells(frame_error("lights: [{point: [0, 0]}]"), "lights[0].point: "));
  EXPECT_TRUE(tells(frame_error("lights: [{dome: true, intensity: -1}]"), "a number from 0"));
  EXPECT_TRUE(tells(frame_error("lights: {dome: true}"), "a list expected"));
  std::string many = "{head: true}";
  for (int i = 1; i < 65; ++i)
    many += ", {head: true}";
  EXPECT_TRUE(tells(frame_error("lights: [" + many + "]"), "65 items, more than 64"));
}

TEST(SceneClip, Kinds) {
  EXPECT_TRUE(frame("size: [1, 1]").clips.empty());
  const auto clips = frame("clip: [{plane: {point: [1, 2, 3], normal: [0, 1, 0]}}, "
                           "{box: {min: [0, 0, 0], max: [1, 2, 3]}}, "
                           "{box: {min: [0, 0, 0], max: [1, 2, 3], keep: outside}}, "
                           "{sphere: {center: [4, 5, 6], radius: 7, keep: outside}}]")
                         .clips;
  ASSERT_EQ(clips.size(), 4u);
  EXPECT_EQ(clips[0].kind, render::Clip::Kind::plane);
  EXPECT_EQ(clips[0].point, (math::Vec3d{1, 2, 3}));
  EXPECT_EQ(clips[0].vector, (math::Vec3d{0, 1, 0}));
  EXPECT_EQ(clips[1].kind, render::Clip::Kind::box);
  EXPECT_EQ(clips[1].vector, (math::Vec3d{1, 2, 3}));
  EXPECT_TRUE(clips[1].keep_inside);
  EXPECT_FALSE(clips[2].keep_inside);
  EXPECT_EQ(clips[3].kind, render::Clip::Kind::sphere);
  EXPECT_EQ(clips[3].point, (math::Vec3d{4, 5, 6}));
  EXPECT_EQ(clips[3].radius, 7);
  EXPECT_FALSE(clips[3].keep_inside);
}

TEST(SceneClip, Errors) {
  EXPECT_EQ(frame_error("clip: [{}]"),
            "s.yaml:2: frames[0].clip[0]: a clip needs 'plane', 'box' or 'sphere'");
  EXPECT_TRUE(tells(frame_error("clip: [{plane: {normal: [1, 0, 0]}}]"), "'point'"));
  EXPECT_TRUE(
      tells(frame_error("clip: [{plane: {point: [1, 0, 0], normal: [0, 0, 0]}}]"), "is not zero"));
  EXPECT_TRUE(tells(frame_error("clip: [{box: {min: [0, 0, 2], max: [1, 1, 1]}}]"),
                    "clip[0].box: min is above max"));
  EXPECT_TRUE(tells(frame_error("clip: [{sphere: {center: [0, 0, 2], radius: 0}}]"), "radius"));
  EXPECT_TRUE(tells(frame_error("clip: [{sphere: {center: [0, 0, 2], radius: 1, keep: in}}]"),
                    "'in' is not one of inside, outside"));
}

TEST(SceneTriangles, BoundaryBodiesAndOutline) {
  const Frame f = test::parse("frames: [{name: f, boundary: {}, bodies: [{file: a/b.stl}], "
                              "outline: {}}]")
                      .frames[0];
  EXPECT_EQ(f.layers[0].boundary->opacity, 1);
  EXPECT_EQ(std::get<render::Color>(f.layers[0].boundary->color),
            render::linear_of_srgb(0.8, 0.8, 0.8));
  EXPECT_EQ(f.bodies[0].path, "/base/a/b.stl");
  EXPECT_EQ(f.bodies[0].opacity, 1);
  EXPECT_EQ(f.bodies[0].line, 2);
  EXPECT_EQ(f.outline->color, render::linear_of_srgb(0, 0, 0));
  EXPECT_EQ(f.outline->width, 1.5);
  EXPECT_FALSE(f.outline->ticks);
  const Frame g =
      frame("boundary: {opacity: 0.25, color: {field: p}}, bodies: [{file: /c.stl, "
            "opacity: 0.5, color: red}], outline: {color: white, width: 3, ticks: true}");
  EXPECT_EQ(g.layers[0].boundary->opacity, 0.25);
  EXPECT_EQ(std::get<ColorBy>(g.layers[0].boundary->color).field.text, "p");
  EXPECT_EQ(g.bodies[0].path, "/c.stl");
  EXPECT_EQ(g.bodies[0].opacity, 0.5);
  EXPECT_EQ(g.bodies[0].color, render::linear_of_srgb(1, 0, 0));
  EXPECT_EQ(g.outline->width, 3);
  EXPECT_TRUE(g.outline->ticks);
  EXPECT_TRUE(tells(frame_error("bodies: [{}]"), "'file'"));
  EXPECT_TRUE(tells(frame_error("outline: {width: 0}"), "a number above 0"));
  EXPECT_TRUE(tells(frame_error("boundary: {opacity: 2}"), "a number from 0 to 1"));
}

TEST(SceneTriangles, NormalsAndSearchOfIsosurfaces) {
  const auto surface = [](const std::string& keys) {
    return test::parse("frames: [{name: f, isosurfaces: [{field: p, values: [1]" + keys + "}]}]")
        .frames[0]
        .layers[0]
        .isosurfaces[0];
  };
  EXPECT_EQ(surface("").normals, render::Normals::cell);
  EXPECT_EQ(surface("").search, render::RootSearch::exact);
  EXPECT_EQ(surface(", search: cubic").search, render::RootSearch::cubic);
  EXPECT_EQ(surface(", normals: smooth").normals, render::Normals::smooth);
  EXPECT_EQ(surface(", normals: central").normals, render::Normals::central);
  EXPECT_EQ(surface(", search: neubauer").search, render::RootSearch::neubauer);
}
