// Points carried by the material: what the library answers for them is known in every cycle.
#include <gtest/gtest.h>

#include "coupled.h"
#include "material.h"

namespace {

using runs::Coupled;

/// The position is rounded where corner 0 is added: one rounding of a coordinate. The miniapp's sum
/// over the corners, the library's inverse map and, near the origin, the cell's own size, which is
/// that of its coordinates there, add some more. Three times what is seen, and far from the
/// thousands that a wrong digit makes.
constexpr double most_roundings = 8.0;

struct Case {
  bool block;
  int threads;
  insitu::Accuracy accuracy;
};

class Material : public testing::TestWithParam<Case> {};

TEST_P(Material, PointsKeepTheirCellsThroughRefitsAndRebuilds) {
  const Case c = GetParam();
  Coupled run({.cells = 10, .threads = c.threads, .block = c.block});
  ASSERT_TRUE(run.execute()) << insitu_last_message();
  sedov::MaterialPoints points(5000, run.solver, 20240607);
  insitu::LocateOptions options;
  options.accuracy = c.accuracy;
  sedov::Drift worst;
  const auto look = [&] {
    points.move(run.solver);
    const insitu::Locations found = run.mesh.locate(points.positions, options);
    worst.join(points.compare(run.solver, found.cells, found.parametric));
  };
  look();
  for (int cycle = 1; cycle <= 60; ++cycle) {
    const bool rebuild = cycle % 20 == 0;
    ASSERT_TRUE(run.step(rebuild ? insitu::everything : insitu::geometry | insitu::fields));
    look();
    ASSERT_EQ(worst.lost, 0) << "cycle " << cycle;
    ASSERT_EQ(worst.changed, 0) << "cycle " << cycle;
    ASSERT_LE(worst.roundings, most_roundings) << "cycle " << cycle;
  }
  const insitu::Report report = run.session.report();
  EXPECT_GE(report.rebuilds, 4); // when else is for the library to say
  EXPECT_GT(report.refits, 0);
  EXPECT_EQ(report.rebuilds + report.refits, 61);
  EXPECT_GT(worst.largest, 0.0); // it did compare
}

INSTANTIATE_TEST_SUITE_P(Couplings, Material,
                         testing::Values(Case{false, 1, insitu::Accuracy::standard},
                                         Case{false, 2, insitu::Accuracy::exact},
                                         Case{true, 1, insitu::Accuracy::exact},
                                         Case{true, 2, insitu::Accuracy::standard}),
                         [](const auto& one) {
                           return std::string(one.param.block ? "Block" : "Hexahedra") +
                                  (one.param.accuracy == insitu::Accuracy::exact ? "Exact"
                                                                                 : "Standard");
                         });

/// The comparison is able to fail.
TEST(MaterialPoints, TellsAnswersThatAreOff) {
  const sedov::Solver solver(sedov::Config{.cells = {4, 4, 4}});
  sedov::MaterialPoints points(100, solver, 1);
  points.move(solver);
  std::vector<std::int64_t> cells = points.cells;
  std::vector<double> parametric = points.parametric;
  EXPECT_EQ(points.compare(solver, cells, parametric).roundings, 0.0);
  parametric[5] += 1e-12;
  EXPECT_GT(points.compare(solver, cells, parametric).roundings, 1e3);
  cells[3] = -1;
  cells[4] = cells[4] == 0 ? 1 : 0;
  const sedov::Drift drift = points.compare(solver, cells, parametric);
  EXPECT_EQ(drift.lost, 1);
  EXPECT_EQ(drift.changed, 1);
}

} // namespace
