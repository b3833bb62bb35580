// Cameras, backgrounds and images of frames: values read, defaults, errors.
#include <gtest/gtest.h>

#include "scene_test.h"

using namespace insitu;
using namespace insitu::scene;
using test::error_of;
using test::parse;

namespace {

Frame frame(const std::string& keys) {
  return parse(test::frame(keys)).frames[0];
}
std::string frame_error(const std::string& keys) {
  return error_of(test::frame(keys));
}
/// Of a camera's keys.
std::string camera_error(const std::string& keys) {
  return frame_error("camera: {" + keys + "}");
}

void expect_error(const std::string& error, const std::string& part) {
  EXPECT_NE(error.find("s.yaml:2: "), std::string::npos) << error;
  EXPECT_NE(error.find(part), std::string::npos) << error;
}

} // namespace

TEST(SceneCameras, Keys) {
  const Camera turned =
      frame("camera: {azimuth: -45, elevation: 90, zoom: 2, fov: 60, up: [0, 2, 0], "
            "orbit: {azimuth_per_frame: 1.5}}")
          .camera;
  EXPECT_EQ(turned.azimuth, -45);
  EXPECT_EQ(turned.elevation, 90);
  EXPECT_EQ(turned.zoom, 2);
  EXPECT_EQ(turned.fov, 60);
  EXPECT_EQ(turned.up, (math::Vec3d{0, 2, 0}));
  EXPECT_EQ(turned.orbit_azimuth_per_frame, 1.5);
  const Camera placed = frame("camera: {position: [1, 2, 3], look_at: [4, 5, 7]}").camera;
  EXPECT_EQ(placed.position, (math::Vec3d{1, 2, 3}));
  EXPECT_EQ(placed.look_at, (math::Vec3d{4, 5, 7}));
  EXPECT_FALSE(frame("camera: auto").camera.position);
}

TEST(SceneCameras, KeyErrors) {
  EXPECT_EQ(
      frame_error("camera: {azimut: 3}"),
      "s.yaml:2: key 'azimut' is unknown in frames[0].camera; did you mean 'azimuth'? (keys: "
      "azimuth, "
      "elevation, zoom, position, look_at, up, fov, orthographic, fit, orbit, path, longitude, "
      "latitude, altitude)");
  EXPECT_EQ(frame_error("camera: {elevation: 91}"),
            "s.yaml:2: frames[0].camera.elevation: a number from -90 to 90 expected, '91' found");
  EXPECT_EQ(frame_error("camera: {azimuth: 361}"),
            "s.yaml:2: frames[0].camera.azimuth: a number from -360 to 360 expected, '361' found");
  EXPECT_NE(frame_error("camera: {fov: 0}").find("a number above 0 and up to 170 expected"),
            std::string::npos);
  EXPECT_NE(frame_error("camera: {zoom: 0}").find("frames[0].camera.zoom"), std::string::npos);
  EXPECT_EQ(frame_error("camera: {position: [0, 0, 1], zoom: 2}"),
            "s.yaml:2: frames[0].camera.zoom: a camera has either a position or azimuth, elevation "
            "and zoom");
  EXPECT_NE(frame_error("camera: {look_at: [0, 0, 1]}").find("'look_at' needs a 'position'"),
            std::string::npos);
  EXPECT_NE(frame_error("camera: {up: [0, 0, 0]}").find("frames[0].camera.up"), std::string::npos);
  EXPECT_NE(frame_error("camera: {position: [1, 1, 1], look_at: [1, 1, 1]}").find("the same point"),
            std::string::npos);
  EXPECT_NE(frame_error("camera: {position: [0, 0, 5], look_at: [0, 0, 0]}")
                .find("'up' points along the view"),
            std::string::npos);
  EXPECT_NE(frame_error("camera: path.json").find("frames[0].camera: auto or a map of azimuth"),
            std::string::npos);
  EXPECT_NE(frame_error("camera: {orbit: {}}")
                .find("key 'azimuth_per_frame' is missing in frames[0].camera.orbit"),
            std::string::npos);
}

TEST(SceneCameras, Orthographic) {
  EXPECT_FALSE(frame("camera: auto").camera.orthographic);
  EXPECT_FALSE(frame("camera: {orthographic: false}").camera.orthographic);
  const Camera automatic = frame("camera: {orthographic: true, fit: box}").camera;
  EXPECT_TRUE(automatic.orthographic);
  EXPECT_FALSE(automatic.orthographic_height);
  EXPECT_EQ(automatic.fit, render::Fit::box);
  const Camera given = frame("camera: {orthographic: 2.5}").camera;
  EXPECT_TRUE(given.orthographic);
  EXPECT_EQ(given.orthographic_height, 2.5);
  expect_error(camera_error("orthographic: 0"), "camera.orthographic: a number above 0 expected");
  expect_error(camera_error("orthographic: yes"), "camera.orthographic: a number above 0 expected");
  expect_error(camera_error("orthographic: [1]"), "true, false or the height of the view expected");
  expect_error(camera_error("fit: tight"), "'tight' is not one of sphere, box");
}

TEST(SceneCameras, PathsTakeTheCamerasOwnWhereAKeyIsSilent) {
  const Camera angles =
      frame("camera: {azimuth: 5, fov: 20, path: [{cycle: -3, zoom: 2}, {cycle: 100, azimuth: "
            "725, elevation: 90}]}")
          .camera;
  ASSERT_EQ(angles.path.size(), 2u);
  EXPECT_FALSE(angles.path_by_time);
  EXPECT_EQ(angles.path[0].at, -3);
  EXPECT_EQ(angles.path[0].azimuth, 5);
  EXPECT_EQ(angles.path[0].zoom, 2);
  EXPECT_EQ(angles.path[0].fov, 20);
  EXPECT_EQ(angles.path[1].at, 100);
  EXPECT_EQ(angles.path[1].azimuth, 725);
  EXPECT_EQ(angles.path[1].elevation, 90);
  EXPECT_EQ(angles.path[1].zoom, 1);
  const Camera placed = frame("camera: {look_at: [0, 0, 1], position: [9, 9, 9], up: [0, 1, 0], "
                              "path: [{time: 0.5}, {time: 1.5, position: [1, 2, 3], up: [1, 0, "
                              "0]}]}")
                            .camera;
  EXPECT_TRUE(placed.path_by_time);
  EXPECT_EQ(placed.path[0].position, (math::Vec3d{9, 9, 9}));
  EXPECT_EQ(placed.path[0].up, (math::Vec3d{0, 1, 0}));
  EXPECT_EQ(placed.path[1].at, 1.5);
  EXPECT_EQ(placed.path[1].position, (math::Vec3d{1, 2, 3}));
  EXPECT_EQ(placed.path[1].look_at, (math::Vec3d{0, 0, 1}));
  EXPECT_EQ(placed.path[1].up, (math::Vec3d{1, 0, 0}));
}

TEST(SceneCameras, PathErrors) {
  const std::string where = "frames[0].camera.path";
  expect_error(camera_error("path: 3"), where + ": a list expected");
  expect_error(camera_error("path: []"), where + ": at least 2 keys expected");
  expect_error(camera_error("path: [{cycle: 1}]"), where + ": at least 2 keys expected");
  expect_error(camera_error("path: [{zoom: 1}, {cycle: 1}]"),
               where + "[0]: a key of a path has a 'cycle' or a 'time'");
  expect_error(camera_error("path: [{cycle: 1, time: 2}, {cycle: 1}]"),
               where + "[0]: a key of a path has a 'cycle' or a 'time'");
  expect_error(camera_error("path: [{cycle: 1}, {time: 2}]"),
               where + "[1]: the keys of a path have all a 'cycle' or all a 'time'");
  expect_error(camera_error("path: [{cycle: 2}, {cycle: 2}]"),
               where + "[1]: 'cycle' must be above the one of the key before");
  expect_error(camera_error("path: [{time: 2}, {time: 1.5}]"),
               where + "[1]: 'time' must be above the one of the key before");
  expect_error(camera_error("path: [{cycle: 1}, {cycle: 2, position: [1, 2, 3]}]"),
               where + "[1]: the keys of a path have all a position, or none has one");
  expect_error(camera_error("position: [1, 2, 3], path: [{cycle: 1}, {cycle: 2, zoom: 2}]"),
               where + "[1].zoom: a camera has either a position or azimuth, elevation and zoom");
  expect_error(camera_error("path: [{cycle: 1}, {cycle: 2.5}]"), where + "[1].cycle: an integer");
  expect_error(camera_error("path: [{cycle: 1}, {cycle: 2, look_at: [0, 0, 0]}]"),
               where + "[1].look_at: 'look_at' needs a 'position'");
  expect_error(camera_error("path: [{cycle: 1}, {cycle: 2}], orbit: {azimuth_per_frame: 1}"),
               where + ": a camera has either a path or an orbit");
  expect_error(
      camera_error("position: [0, 0, 9], up: [0, 1, 0], look_at: [0, 0, 0], path: [{cycle: "
                   "1}, {cycle: 2, position: [0, 5, 0]}]"),
      where + "[1]: 'up' points along the view");
}

TEST(SceneCameras, SeveralOfAFrame) {
  const Frame f = frame("cameras: {front: auto, top: {elevation: 90}}");
  ASSERT_EQ(f.cameras.size(), 2u);
  EXPECT_EQ(f.cameras[0].name, "front");
  EXPECT_EQ(f.cameras[0].camera.elevation, 20);
  EXPECT_EQ(f.cameras[1].name, "top");
  EXPECT_EQ(f.cameras[1].camera.elevation, 90);
  expect_error(frame_error("camera: auto, cameras: {a: auto}"),
               "frames[0].cameras: a frame has either a 'camera' or 'cameras'");
  expect_error(frame_error("cameras: [auto]"), "a map of names and cameras expected");
  expect_error(frame_error("cameras: {}"), "a map of names and cameras expected");
  expect_error(frame_error("cameras: {'a/b': auto}"), "'a/b' cannot stand in a file's name");
  expect_error(frame_error("cameras: {a: auto, a: auto}"), "the camera 'a' is given twice");
  expect_error(frame_error("cameras: {a: {zom: 1}}"), "unknown in frames[0].cameras.a");
}

TEST(SceneCameras, ImagesOfTwoItemsAreNotTheSameFile) {
  const std::string second = ", {name: f_top, volume: {field: rho}}]";
  EXPECT_EQ(error_of("frames: [{name: f, volume: {field: rho}, cameras: {top: auto}}" + second),
            "s.yaml:2: frames[1].name: the name 'f_top' is already used in this scene");
  EXPECT_EQ(error_of("frames: [{name: f_depth, volume: {field: rho}}, {name: f, volume: {field: "
                     "rho}, images: [color, depth]}]"),
            "s.yaml:2: frames[1]: its images would be called 'f_depth', a name that is already "
            "used in this scene");
  EXPECT_EQ(error_of("probes: [{name: data, points: [[0, 0, 0]]}]\nframes: [{name: f, volume: "
                     "{field: rho}}]"),
            "s.yaml:2: the name 'data' would make data.csv, which is the table of the frames; give "
            "another one");
  EXPECT_EQ(parse("probes: [{name: data, points: [[0, 0, 0]]}]").probes.size(), 1u);
}

TEST(SceneCameras, ImagesAndFormats) {
  const Frame plain = frame("accuracy: fast");
  EXPECT_EQ(plain.images, std::vector{ImageKind::color});
  EXPECT_EQ(plain.formats, std::vector{ImageFormat::png});
  const Frame f = frame("images: [cell, color, depth], format: [exr, png], axes: true");
  EXPECT_EQ(f.images, (std::vector{ImageKind::cell, ImageKind::color, ImageKind::depth}));
  EXPECT_EQ(f.formats, (std::vector{ImageFormat::exr, ImageFormat::png}));
  EXPECT_TRUE(f.axes);
  EXPECT_FALSE(plain.axes);
  expect_error(frame_error("images: []"), "frames[0].images: at least one image expected");
  expect_error(frame_error("images: [colour]"),
               "frames[0].images[0]: 'colour' is not one of color, depth, cell; did you mean "
               "'color'?");
  expect_error(frame_error("images: [cell, cell]"), "'cell' is given twice");
  expect_error(frame_error("format: [jpg]"), "'jpg' is not one of png, exr");
  expect_error(frame_error("format: png"), "frames[0].format: a list expected");
  expect_error(frame_error("axes: 3"), "frames[0].axes: true or false expected");
}

TEST(SceneCameras, Backgrounds) {
  EXPECT_EQ(frame("accuracy: fast").background_alpha, 1);
  EXPECT_EQ(frame("background: transparent").background_alpha, 0);
  const Frame half = frame("background: {color: black, alpha: 0.5}");
  EXPECT_EQ(half.background, render::linear_of_srgb(0, 0, 0));
  EXPECT_EQ(half.background_alpha, 0.5);
  expect_error(frame_error("background: {color: black}"), "key 'alpha' is missing");
  expect_error(frame_error("background: {alpha: 2}"),
               "frames[0].background.alpha: a number from 0 to 1 expected");
  expect_error(frame_error("background: clear"), "'clear' is not a colour");
}
