// What frames of a run show of the mesh: how cameras fit it, pixel for pixel.
#include <cmath>
#include <gtest/gtest.h>

#include "coupled.h"
#include "output/image/png.h"

namespace {

using runs::Coupled;

/// Pixels of a PNG file that are not white.
int drawn(const std::string& path) {
  const insitu::output::PngImage image = insitu::output::read_png(path);
  int count = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const std::uint8_t* p = image.pixel(x, y);
      count += p[0] < 255 || p[1] < 255 || p[2] < 255;
    }
  return count;
}

/// What is left of the cube by planes, a box, or both fills the image; a sphere fit stays.
TEST(Frames, FitsWhatClipsLeave) {
  const test::Folder folder;
  const std::string frame = "size: [100, 100], boundary: {color: blue}, ",
                    above = "camera: {elevation: 90, azimuth: -90, orthographic: true, fit: box}";
  Coupled run(
      {.scene = "insitu: 1\nframes:\n"
                "  - {name: box, " +
                frame + above +
                ", clip: [{box: {min: [0.25, 0.25, -9], max: [0.5, 0.5, 9]}}]}\n"
                "  - {name: plane, " +
                frame + above +
                ", clip: [{plane: {point: [0.5, 0, 0], normal: [1, 0, 0]}}, {plane: {point: "
                "[0, 0.5, 0], normal: [0, 1, 0]}}]}\n"
                "  - {name: ball, " +
                frame + above +
                ", clip: [{sphere: {center: [0, 0, 0], radius: 0.3}}]}\n"
                "  - {name: perspective, " +
                frame +
                "camera: {azimuth: 40, fit: box}, clip: [{box: {min: [0.25, 0.25, 0.25], "
                "max: [0.5, 0.5, 0.5]}}], volume: {field: pressure, opacity: [[0, 1]]}}\n"
                "  - {name: nothing, " +
                frame + above + ", clip: [{plane: {point: [-1, 0, 0], normal: [1, 0, 0]}}]}\n",
       .output = folder.path()});
  ASSERT_TRUE(run.execute()) << insitu_last_message();
  EXPECT_NEAR(drawn(folder / "box_000000.png"), 98 * 98, 200);
  EXPECT_NEAR(drawn(folder / "plane_000000.png"), 98 * 98, 200);
  EXPECT_NEAR(drawn(folder / "ball_000000.png"), 0.785 * 98 * 98, 300); // a quarter of a disc
  EXPECT_GT(drawn(folder / "perspective_000000.png"), 5500);
  EXPECT_EQ(drawn(folder / "nothing_000000.png"), 0);
}

TEST(Frames, OrthographicCamerasFitAsTheyShould) {
  const test::Folder folder;
  // The blast's box is a cube seen along x: a square.
  Coupled run({.scene = R"(insitu: 1
frames:
  - name: f
    size: [100, 50]
    cameras:
      tight: {azimuth: 0, elevation: 0, orthographic: true, fit: box}
      twice: {azimuth: 0, elevation: 0, orthographic: true, fit: box, zoom: 0.5}
      near: {azimuth: 0, elevation: 0, fit: box}
      sphere: {azimuth: 0, elevation: 0, orthographic: true}
      placed: {position: [9, 0, 0], look_at: [0, 0, 0], orthographic: true, fit: box}
    volume: {field: density, opacity: [[0, 1]], range: [0, 9]}
)",
               .output = folder.path()});
  ASSERT_TRUE(run.execute()) << insitu_last_message();
  const auto side = [&](const std::string& camera) {
    return std::sqrt(double(drawn(folder / ("f_" + camera + "_000000.png"))));
  };
  EXPECT_NEAR(side("tight"), 49, 1); // 2 % of either half stay free
  EXPECT_NEAR(side("twice"), 24.5, 1);
  EXPECT_NEAR(side("near"), 49, 1);
  EXPECT_NEAR(side("sphere"), 50 / std::sqrt(3.0), 1);
  // Looks at the cube's corner: only a quarter of the image is left to it.
  EXPECT_NEAR(side("placed"), 24.5, 1);
}

TEST(Frames, HardCameras) {
  const test::Folder folder;
  Coupled run({.scene = R"(insitu: 1
frames:
  - name: f
    size: [9, 9]
    cameras:
      inside: {position: [0.5, 0.5, 0.5], look_at: [2, 0.5, 0.5]}
      face: {position: [0, 0.5, 0.5], look_at: [1, 0.5, 0.5]}
      corner: {position: [0, 0, 0], look_at: [1, 1, 1]}
      far: {position: [0.5e6, 0.5e6, 0.5e6], fov: 1.2e-4}
      above: {position: [0.5, 0.5, 9]}
    volume: {field: density, opacity: [[0, 1]], range: [0, 9]}
  - {name: dot, size: [1, 1], volume: {field: density, opacity: [[0, 1]]}}
  - {name: row, size: [16383, 1], camera: {fit: box}, volume: {field: density, opacity: [[0, 1]]}}
  - {name: column, size: [1, 16383], camera: {orthographic: true}, volume: {field: density, opacity: [[0, 1]]}}
)",
               .output = folder.path()});
  ASSERT_TRUE(run.execute()) << insitu_last_message();
  for (const char* camera : {"inside", "face", "corner"})
    EXPECT_EQ(drawn(folder / ("f_" + std::string(camera) + "_000000.png")), 81) << camera;
  // The field of view of the last one is 1.05e-6 * 866025 * 2 = 1.8 high: the cube all but fills
  // it.
  EXPECT_GT(drawn(folder / "f_far_000000.png"), 40);
  EXPECT_LT(drawn(folder / "f_far_000000.png"), 81);
  // "Up" points along the view there; another one is taken.
  EXPECT_GT(drawn(folder / "f_above_000000.png"), 4);
  EXPECT_EQ(drawn(folder / "dot_000000.png"), 1);
  // All of the mesh is in the middle pixel of a row; at half a pixel beside it little is left.
  const int row = drawn(folder / "row_000000.png");
  EXPECT_GE(row, 1);
  EXPECT_LE(row, 3);
  const int column = drawn(folder / "column_000000.png");
  EXPECT_GE(column, 1);
  EXPECT_LE(column, 3);
}

} // namespace
