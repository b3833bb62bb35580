// Path traced frames of a run: what accumulates from cycle to cycle, and when it begins anew.
#include <cstdlib>
#include <gtest/gtest.h>

#include "coupled.h"
#include "output/image/png.h"

namespace {

using runs::Coupled;

/// Frames that differ in their samples alone; the camera stands but for cycles 6 to 7.
const std::string scene = [] {
  const auto frame = [](const std::string& name, const std::string& paths) {
    return "  - name: " + name + R"(
    size: [24, 20]
    camera: {path: [{cycle: 0, azimuth: 40}, {cycle: 6, azimuth: 40}, {cycle: 7, azimuth: 50}, {cycle: 9, azimuth: 50}]}
    volume: {field: density, range: [0, 5], opacity: [[0, 0.1], [5, 0.7]]}
    effects: [multiple_scattering]
    lights: [{directional: [1, 0.5, 0.7]}, {dome: true, intensity: 0.5}]
    path_tracing: {anisotropy: 0.3, )" +
           paths + "}\n";
  };
  return "insitu: 1\npage: false\nframes:\n" + frame("sum", "samples: 8, accumulate: true") +
         frame("eight", "samples: 8") + frame("more", "samples: 24");
}();

struct Accumulated {
  Accumulated() : run({.scene = scene, .output = folder.path(), .cells = 6}) {}

  /// Draws a cycle; `changed` is what the solver did before.
  void draw(int cycle, insitu::Change changed) {
    if (changed != insitu::Change{})
      run.mesh.changed(changed);
    ASSERT_TRUE(run.session.execute(cycle, cycle)) << insitu_last_message();
  }
  std::string file(const std::string& name, int cycle) const {
    return folder / (name + "_00000" + std::to_string(cycle) + ".png");
  }
  /// The most by which a channel of a pixel differs, of 255.
  int difference(const std::string& a, int cycle_a, const std::string& b, int cycle_b) const {
    const auto p = insitu::output::read_png(file(a, cycle_a)),
               q = insitu::output::read_png(file(b, cycle_b));
    int most = 0;
    for (int y = 0; y < p.height; ++y)
      for (int x = 0; x < p.width; ++x)
        for (int c = 0; c < 3; ++c)
          most = std::max(most, std::abs(int(p.pixel(x, y)[c]) - int(q.pixel(x, y)[c])));
    return most;
  }

  test::Folder folder;
  Coupled run;
};

/// Sums are made in another order, which may round a pixel to the next of 255 steps; noise of 8
/// samples is tens of them.
TEST(PathTracing, ThreeCyclesAreOneFrameOfAllTheirSamples) {
  Accumulated frames;
  for (int cycle = 0; cycle < 3; ++cycle)
    frames.draw(cycle, {});
  EXPECT_EQ(frames.difference("sum", 0, "eight", 0), 0);
  EXPECT_LE(frames.difference("sum", 2, "more", 0), 1);
  EXPECT_GT(frames.difference("sum", 1, "more", 0), 8);
  EXPECT_GT(frames.difference("sum", 1, "sum", 0), 8) << "nothing was added";
  EXPECT_GT(frames.difference("eight", 1, "eight", 0), 8) << "the noise does not change";
}

TEST(PathTracing, SamplesBeginAnewWithWhatIsDrawn) {
  Accumulated frames;
  const auto expect_anew = [&](int cycle, const char* why) {
    EXPECT_EQ(frames.difference("sum", cycle, "eight", cycle), 0) << why;
    // And go on from there: else nothing would tell that they did before.
    frames.draw(cycle + 1, {});
    EXPECT_GT(frames.difference("sum", cycle + 1, "eight", cycle + 1), 8) << why;
  };
  frames.draw(0, {});
  expect_anew(0, "the first frame");
  for (double& value : frames.run.solver.density)
    value *= 1.1;
  frames.draw(2, insitu::fields);
  expect_anew(2, "new values");
  for (double& x : frames.run.solver.x)
    x *= 1.05;
  frames.draw(4, insitu::geometry);
  expect_anew(4, "moved vertices");
  frames.draw(6, {});
  EXPECT_GT(frames.difference("sum", 6, "eight", 6), 8) << "nothing changed";
  frames.draw(7, {});
  expect_anew(7, "a moved camera");
  frames.draw(9, insitu::topology);
  EXPECT_EQ(frames.difference("sum", 9, "eight", 9), 0) << "other cells";
}

} // namespace
