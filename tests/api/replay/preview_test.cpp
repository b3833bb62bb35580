// insitu-replay --preview: every frame of a scene, small, of the last step.
#include <utility>

#include "replay.h"

namespace {

struct Preview : Replay {
  /// The size that the header of a PNG file tells.
  std::pair<int, int> size_of(const std::string& image) const {
    const std::string png = contents(path(image));
    const auto side = [&](std::size_t at) {
      int n = 0;
      for (std::size_t i = 0; i < 4; ++i)
        n = 256 * n + static_cast<unsigned char>(png[at + i]);
      return n;
    };
    return png.size() < 24 ? std::pair{0, 0} : std::pair{side(16), side(20)};
  }
};

} // namespace

TEST_F(Preview, EveryFrameOfTheLastStepAloneAtItsOwnAspect) {
  mesh("m_0.vtu", 0.0, 40, 4.0);
  mesh("m_1.vtu", 1.0, 41, 5.0);
  put("scene.yaml", R"(insitu: 1
every: 100
checkpoint: {every: 1}
probes:
  - {name: g, points: points.csv, fields: [linear], every: 1}
frames:
  - {name: wide, size: [1024, 512], samples_per_pixel: 16, isosurfaces: [{field: linear, values: [2]}]}
  - {name: square, every: 1, when: time < 0, boundary: {}}
  - {name: high, size: [2, 4000], boundary: {}}
  - {name: small, size: [16, 9], images: [color, depth], boundary: {}}
  - {name: views, size: [320, 240], boundary: {}, cameras: {a: {azimuth: 0}, b: {azimuth: 90}}}
  - {name: paths, size: [320, 240], volume: {field: linear}, path_tracing: {samples: 4096}}
)");
  const Outcome o = run("--preview --scene scene.yaml --out out m_0.vtu m_1.vtu");
  ASSERT_EQ(o.code, 0) << o.err;
  EXPECT_EQ(o.out + o.err, "");
  const std::map<std::string, std::pair<int, int>> expected = {
      {"wide_000041.png", {160, 80}},      {"square_000041.png", {120, 120}},
      {"high_000041.png", {1, 120}},       {"small_000041.png", {16, 9}},
      {"small_depth_000041.png", {16, 9}}, {"views_a_000041.png", {160, 120}},
      {"views_b_000041.png", {160, 120}},  {"paths_000041.png", {160, 120}}};
  for (const auto& [image, size] : expected)
    EXPECT_EQ(size_of("out/preview/" + image), size) << image;
  std::size_t images = 0;
  for (const auto& file : fs::recursive_directory_iterator(folder / "out")) {
    images += file.path().extension() == ".png";
    EXPECT_TRUE(file.path().filename() == "preview" ||
                file.path().parent_path() == folder / "out" / "preview")
        << file.path();
    EXPECT_TRUE(file.is_directory() || file.path().extension() == ".png" ||
                file.path().filename() == "data.csv")
        << file.path();
  }
  EXPECT_EQ(images, expected.size());
}

/// A run that writes to the same folder keeps its images, and a preview is the frame that a scene
/// of that size draws.
TEST_F(Preview, IsTheFrameOfItsSizeAndReplacesNoImage) {
  mesh("m.vtu", 0.0, 7);
  const auto scene = [&](const char* name, const char* size) {
    put(name, std::string("insitu: 1\npage: false\noutput: here\nframes:\n  - {name: f, size: ") +
                  size + ", isosurfaces: [{field: linear, values: [2]}]}\n");
  };
  scene("large.yaml", "[200, 150]");
  scene("small.yaml", "[160, 120]");
  ASSERT_EQ(run("--scene large.yaml m.vtu").code, 0);
  const std::string large = contents(path("here/f_000007.png"));
  ASSERT_EQ(run("--preview --scene large.yaml m.vtu").code, 0);
  EXPECT_EQ(contents(path("here/f_000007.png")), large);
  ASSERT_EQ(run("--scene small.yaml m.vtu").code, 0);
  EXPECT_EQ(size_of("here/preview/f_000007.png"), std::pair(160, 120));
  EXPECT_EQ(contents(path("here/preview/f_000007.png")), contents(path("here/f_000007.png")));
}

/// A step's number is its place among all, though the others are not read; what is no file of the
/// last step may be damaged.
TEST_F(Preview, ReadsTheLastStepAlone) {
  put("m_0.vtu", "no mesh");
  mesh("m_1.vtu", 0.0, -1, -2.0);
  const Outcome o = run("--preview --out out m_0.vtu m_1.vtu");
  ASSERT_EQ(o.code, 0) << o.err; // the default scene
  EXPECT_EQ(size_of("out/preview/frame_000001.png"), std::pair(120, 120));
  EXPECT_EQ(run("--preview --out out m_1.vtu m_0.vtu").code, 1);
}

TEST_F(Preview, WhatCannotBePreviewedIsRefused) {
  mesh("m.vtu", 0.0);
  Outcome o = run("--preview --scene scene.yaml --out out m.vtu"); // probes alone
  EXPECT_EQ(o.code, 1);
  EXPECT_NE(o.err.find("scene.yaml: the scene has no frame to preview"), std::string::npos)
      << o.err;
  put("lacks.yaml", "insitu: 1\nframes:\n  - {name: a, volume: {field: liner}}\n"
                    "  - {name: b, boundary: {}}\n");
  o = run("--preview --scene lacks.yaml --out out m.vtu");
  EXPECT_EQ(o.code, 3);
  EXPECT_NE(o.err.find("liner"), std::string::npos) << o.err;
  EXPECT_EQ(size_of("out/preview/b_000000.png"), std::pair(120, 120));
  for (const char* other : {"--plan", "--validate", "--reverse", "--probe points.csv"}) {
    o = run(std::string("--preview m.vtu ") + other);
    EXPECT_EQ(o.code, 2) << other;
    EXPECT_NE(o.err.find("--preview and --"), std::string::npos) << o.err;
  }
  EXPECT_EQ(run("--preview=1 m.vtu").code, 2);
  EXPECT_EQ(run("--preview").code, 2);
  EXPECT_EQ(run("--preview --scene scene.yaml none.vtu").code, 1);
}
