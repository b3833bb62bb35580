// The table of cells across faces in whole runs: where it comes in, it changes no file, and a
// restart knows when it came.
#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <insitu/insitu.hpp>
#include <random>
#include <string>
#include <vector>

#include "coupled.h"

namespace {

const std::string scene = R"(
insitu: 1
page: false
tracers:
  - name: paths
    velocity: velocity
    seeds: {box: {min: [0.3, 0.3, 0.3], max: [0.7, 0.7, 0.7], counts: [5, 5, 4]}}
)";

/// Boxes of n^3 hexahedra, numbered at random, that overlap where there are two: each with values
/// of its own, so that it matters which of them answers.
class Boxes {
public:
  Boxes(int boxes, const std::string& output, int threads) : session(options(output, threads)) {
    constexpr int n = 5, m = n + 1;
    std::vector<std::array<std::int32_t, 8>> cells;
    for (int b = 0; b < boxes; ++b) {
      const auto first = std::int32_t(x.size());
      for (int v = 0; v < m * m * m; ++v) {
        const double p[3] = {double(v % m) / n + 0.07 * b, double(v / m % m) / n + 0.05 * b,
                             double(v / (m * m)) / n + 0.03 * b};
        x.push_back(p[0]);
        y.push_back(p[1]);
        z.push_back(p[2]);
        for (const double u :
             {0.5 - p[1] + 0.1 * b, p[0] - 0.5, 0.1 * std::sin(9 * p[0]) - 0.03 * b})
          velocity.push_back(u);
      }
      for (int c = 0; c < n * n * n; ++c) {
        const auto id = [&](int i, int j, int k) {
          return first + std::int32_t(c % n + i + m * (c / n % n + j + m * (c / (n * n) + k)));
        };
        cells.push_back({id(0, 0, 0), id(1, 0, 0), id(1, 1, 0), id(0, 1, 0), id(0, 0, 1),
                         id(1, 0, 1), id(1, 1, 1), id(0, 1, 1)});
      }
    }
    std::shuffle(cells.begin(), cells.end(), std::mt19937(2));
    for (const auto& cell : cells)
      connectivity.insert(connectivity.end(), cell.begin(), cell.end());
    insitu::Mesh mesh = session.mesh("boxes");
    mesh.points(x, y, z);
    mesh.hexahedra(connectivity);
    mesh.vertex_field("velocity", insitu::Array(velocity).components(3));
  }

  void run(int first, int last) {
    for (int cycle = first; cycle <= last; ++cycle)
      ASSERT_TRUE(session.execute(cycle, 0.1 * cycle)) << insitu_last_message();
  }
  std::int64_t table() const { return session.report().bytes_by_purpose[INSITU_MEMORY_NEIGHBOURS]; }

  std::vector<double> x, y, z, velocity;
  std::vector<std::int32_t> connectivity;
  insitu::Session session;

private:
  static insitu::Options options(const std::string& output, int threads) {
    insitu::Options o;
    o.scene_text = scene;
    o.output = output;
    o.threads = threads;
    return o;
  }
};

TEST(Neighbours, ComeWhenTheyAreDueAndARestartKnows) {
  constexpr int cycles = 24;
  for (const int boxes : {1, 2}) {
    SCOPED_TRACE(std::to_string(boxes) + " boxes");
    const test::Folder whole;
    int came = -1;
    {
      Boxes run(boxes, whole.path(), 1);
      const std::string plan = run.session.plan();
      EXPECT_NE(plan.find("needed   cells across faces"), std::string::npos) << plan;
      for (int cycle = 0; cycle <= cycles; ++cycle) {
        run.run(cycle, cycle);
        if (came < 0 && run.table() > 0)
          came = cycle;
      }
      // 24 bytes a hexahedron.
      EXPECT_EQ(run.table(), 24 * std::int64_t(run.connectivity.size() / 8));
    }
    ASSERT_GT(came, 2) << "not at once";
    ASSERT_LT(came, cycles - 4);
    const std::string wanted = test::content(whole / "paths.csv");
    for (const int stop : {came - 2, came - 1, came, came + 3}) {
      const test::Folder parts, state;
      {
        Boxes run(boxes, parts.path(), 2);
        run.run(0, stop);
        run.session.checkpoint(state / "s");
      }
      Boxes run(boxes, parts.path(), 1);
      run.session.restart(state / "s");
      run.run(stop + 1, cycles);
      run.session.close();
      EXPECT_EQ(test::content(parts / "paths.csv"), wanted) << "stopped at " << stop;
    }
  }
}

} // namespace
