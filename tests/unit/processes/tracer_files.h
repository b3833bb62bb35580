#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "part_session.h"

/// Tracers of scenes over processes: the files of one process, to the byte.
namespace insitu::test {

/// Seeds in the mesh and outside, some on faces.
inline const char* const seeds =
    "{box: {min: [0.5, 0.5, 0.5], max: [5.5, 4.5, 4.5], counts: [6, 5, 3]}}";

inline const Act five_cycles = [](PartSession& process, parallel::World&) {
  for (int cycle = 0; cycle < 5; ++cycle)
    EXPECT_EQ(process.execute(cycle), "");
};

/// The same on a mesh whose vertices move.
inline const Act five_cycles_of_moving = [](PartSession& process, parallel::World&) {
  const TestMesh whole = jittered_cubes();
  for (int cycle = 0; cycle < 5; ++cycle) {
    std::vector<Vec3d> points;
    for (const Vec3d& x : whole.vertices)
      points.push_back(x + 0.03 * cycle * Vec3d{std::sin(x.y), 0.5 * x.z, std::cos(x.x)});
    if (cycle > 0 && !process.part().empty())
      process.part().move(process.mesh().mesh(), points);
    EXPECT_EQ(process.execute(cycle), "");
  }
};

/// quick: on a few ways to cut the mesh.
inline void expect_files_of_one(const std::string& scene, const std::vector<int>& sizes,
                                const Act& act = five_cycles, const std::string& ending = "killed",
                                bool quick = false) {
  const TestMesh whole = jittered_cubes();
  PartSession::Options options;
  options.scene = scene;
  const auto expected = run_parts(whole, fixtures::slabs(whole, 1), options, act);
  std::string rows; // of many endings, not of some alone
  for (const auto& [name, text] : expected)
    if (name.ends_with(".csv"))
      rows += text;
  EXPECT_GT(std::ranges::count(rows, '\n'), 100);
  EXPECT_NE(rows.find(ending), std::string::npos);
  for (const int processes : sizes)
    for (const fixtures::Partition& partition :
         quick ? std::vector{fixtures::slabs(whole, processes),
                             fixtures::in_pieces(fixtures::boxes(whole, processes), 2)}
               : fixtures::partitions(whole, processes))
      expect_same(expected, run_parts(whole, partition, options, act),
                  partition.name + " on " + std::to_string(processes));
}

} // namespace insitu::test
