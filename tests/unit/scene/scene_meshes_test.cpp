// Frames of several meshes: their keys and errors.
#include <gtest/gtest.h>

#include "scene_test.h"

namespace insitu::test {
namespace {

using scene::test::error_of;

std::string frame_of(const std::string& meshes, const std::string& keys = "") {
  return "frames: [{name: f, size: [24, 24], " + keys + "meshes: " + meshes + "}]";
}

TEST(SceneMeshes, Keys) {
  const scene::Frame f =
      scene::test::parse(frame_of("[{mesh: water, volume: {field: p}}, {mesh: steel, boundary: {}, "
                                  "isosurfaces: [{field: q, values: [1, 2]}]}]"))
          .frames[0];
  ASSERT_EQ(f.layers.size(), 2u);
  EXPECT_EQ(f.layers[0].mesh.text, "water");
  EXPECT_EQ(f.layers[0].volume->field.text, "p");
  EXPECT_TRUE(f.layers[0].isosurfaces.empty() && !f.layers[0].boundary);
  EXPECT_EQ(f.layers[1].mesh.text, "steel");
  EXPECT_EQ(f.layers[1].mesh.line, 2);
  EXPECT_EQ(f.layers[1].isosurfaces[0].values.size(), 2u);
  EXPECT_TRUE(f.layers[1].boundary && !f.layers[1].volume);
  EXPECT_EQ(scene::test::parse(frame_of("[{mesh: a, boundary: {}}, {mesh: b, volume: {field: p}}]",
                                        "path_tracing: {samples: 7}, "))
                .frames[0]
                .path_tracing->samples,
            7);
  const auto one = scene::test::parse("frames: [{name: f, mesh: m, boundary: {}}]").frames[0];
  ASSERT_EQ(one.layers.size(), 1u);
  EXPECT_EQ(one.layers[0].mesh.text, "m");
}

TEST(SceneMeshes, Errors) {
  const std::string two = "[{mesh: a, boundary: {}}, {mesh: b, volume: {field: p}}]";
  const auto error = [](const std::string& text) { return error_of(text); };
  EXPECT_EQ(error(frame_of("[]")), "s.yaml:2: frames[0].meshes: at least one mesh expected");
  EXPECT_EQ(error(frame_of("[{boundary: {}}]")),
            "s.yaml:2: key 'mesh' is missing in frames[0].meshes[0]");
  EXPECT_NE(
      error(frame_of("[{mesh: a}]")).find("frames[0].meshes[0]: nothing of the mesh is drawn"),
      std::string::npos);
  EXPECT_NE(error(frame_of("[{mesh: a, boundry: {}}]"))
                .find("key 'boundry' is unknown in frames[0].meshes[0]; did you mean 'boundary'?"),
            std::string::npos);
  for (const char* key : {"mesh: a, ", "volume: {field: p}, ", "boundary: {}, ",
                          "isosurfaces: [{field: p, values: [1]}], "})
    EXPECT_NE(error(frame_of(two, key)).find("a frame with 'meshes' has it in their list"),
              std::string::npos)
        << key;
  EXPECT_NE(
      error(frame_of("[{mesh: a/b, boundary: {}}, {mesh: b, boundary: {}}]", "images: [cell], "))
          .find("'a/b' cannot name a file, as the image of its cells would be"),
      std::string::npos);
  EXPECT_NE(error("frames: [{name: f, images: [color, cell], meshes: " + two +
                  "}, {name: f_a_cell, mesh: a, boundary: {}}]")
                .find("'f_a_cell' is already used in this scene"),
            std::string::npos);
  const std::string surfaces = "[{mesh: a, boundary: {}}, {mesh: b, boundary: {}}]";
  for (const char* key : {"path_tracing: {}, ", "effects: [multiple_scattering], "})
    EXPECT_NE(error(frame_of(surfaces, key)).find("path tracing needs a 'volume'"),
              std::string::npos)
        << key;
  EXPECT_NE(error(frame_of(two, "geocentric: {graticule: 10}, ")).find("neither 'globe' nor"),
            std::string::npos);
}

} // namespace
} // namespace insitu::test
