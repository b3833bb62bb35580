// Fields that change without the mesh, come, go, or change their shape during a run.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <yaml-cpp/yaml.h>

#include "coupled.h"

namespace {

using runs::Coupled;

TEST(Fields, NewValuesOnAMeshThatStays) {
  const test::Folder folder;
  Coupled run({.scene = "insitu: 1\nprobes:\n"
                        "  - {name: p, points: [[0.31, 0.4, 0.5], [1.1, 1.1, 1.1]], "
                        "fields: [pressure]}\n",
               .output = folder.path()});
  ASSERT_TRUE(run.execute());
  const insitu::Report built = run.session.report();
  EXPECT_EQ(built.rebuilds, 1);
  for (int cycle = 1; cycle <= 3; ++cycle) {
    std::fill(run.solver.pressure.begin(), run.solver.pressure.end(), double(cycle));
    run.mesh.changed(insitu::fields);
    ASSERT_TRUE(run.session.execute(cycle, cycle));
  }
  ASSERT_TRUE(run.session.execute(4, 4.0)); // nothing changed
  const insitu::Report r = run.session.report();
  EXPECT_EQ(r.rebuilds, 1);
  EXPECT_EQ(r.refits, 0);
  EXPECT_EQ(r.keeps, 4);
  EXPECT_EQ(r.bytes_by_purpose[INSITU_MEMORY_TREE], built.bytes_by_purpose[INSITU_MEMORY_TREE]);
  run.session.close();
  const runs::Table t = runs::parse_table(test::content(folder / "p.csv"));
  ASSERT_EQ(t.rows.size(), 10u);
  for (std::size_t i = 2; i < 8; ++i)
    EXPECT_EQ(t.number(i, "pressure"), double(i / 2));
  EXPECT_EQ(t.number(8, "pressure"), 3.0);
}

// A probe that names no fields keeps the columns that its table began with.
TEST(Fields, OneThatComesLaterDoesNotDisturbATable) {
  const test::Folder folder;
  Coupled run({.scene = "insitu: 1\nprobes:\n  - {name: all, points: [[0.3, 0.3, 0.3]]}\n",
               .output = folder.path()});
  ASSERT_TRUE(run.execute());
  run.mesh.cell_field("energy", run.solver.energy);
  run.run(2);
  run.session.close();
  const runs::Table t = runs::parse_table(test::content(folder / "all.csv"));
  EXPECT_EQ(t.rows.size(), 3u);
  EXPECT_EQ(t.columns,
            (std::vector<std::string>{"cycle", "time", "point", "cell", "r", "s", "t", "density",
                                      "pressure", "velocity_x", "velocity_y", "velocity_z"}));
}

// One that goes, or comes back in another shape, is an error of the actions that use it alone.
TEST(Fields, OneThatGoesOrChangesItsShapeCostsItsActionsOnly) {
  const test::Folder folder;
  Coupled run({.scene = "insitu: 1\nprobes:\n"
                        "  - {name: a, points: [[0.3, 0.3, 0.3]], fields: [pressure]}\n"
                        "  - {name: b, points: [[0.3, 0.3, 0.3]], fields: [density]}\n"
                        "tracers:\n"
                        "  - {name: t, velocity: velocity, fields: [pressure], "
                        "seeds: [[0.3, 0.3, 0.3]]}\n",
               .output = folder.path()});
  ASSERT_TRUE(run.execute());
  run.mesh.remove_field("pressure");
  EXPECT_FALSE(run.step());
  EXPECT_NE(std::string(insitu_last_message()).find("no field 'pressure'"), std::string::npos)
      << insitu_last_message();
  run.mesh.vertex_field("pressure", {run.solver.u, run.solver.v});
  EXPECT_FALSE(run.step());
  const std::string message = insitu_last_message();
  EXPECT_NE(message.find("pressure_x,pressure_y"), std::string::npos) << message;
  EXPECT_NE(message.find("probe 'a'"), std::string::npos) << message;
  EXPECT_NE(message.find("tracer 't'"), std::string::npos) << message;
  EXPECT_EQ(message.find("INTERNAL"), std::string::npos) << message;
  run.mesh.remove_field("pressure");
  run.mesh.cell_field("pressure", run.solver.pressure);
  EXPECT_TRUE(run.step()) << insitu_last_message();
  EXPECT_EQ(run.session.report().failures, 4);
  run.session.close();
  EXPECT_EQ(runs::parse_table(test::content(folder / "a.csv")).rows.size(), 2u);
  EXPECT_EQ(runs::parse_table(test::content(folder / "b.csv")).rows.size(), 4u);
  const runs::Table t = runs::parse_table(test::content(folder / "t.csv"));
  ASSERT_EQ(t.rows.size(), 3u); // two cycles, and the end of the session
  EXPECT_EQ(t.text(2, "ending"), "killed");
}

TEST(Fields, TheDefaultSceneWithoutAScalarFieldIsNoReasonToStop) {
  const test::Folder folder;
  Coupled run({.output = folder.path(), .default_scene = true});
  run.mesh.remove_field("density");
  run.mesh.remove_field("pressure");
  for (int cycle = 0; cycle < 3; ++cycle)
    EXPECT_FALSE(run.session.execute(cycle, cycle));
  EXPECT_NE(std::string(insitu_last_message()).find("scalar field"), std::string::npos);
  EXPECT_EQ(run.log.size(), 1u);
  EXPECT_EQ(run.session.report().failures, 3);
  run.mesh.cell_field("density", run.solver.density);
  EXPECT_TRUE(run.session.execute(10, 10.0)) << insitu_last_message();
  EXPECT_EQ(runs::names_of(runs::files_of(folder.path())),
            (std::vector<std::string>{"data.csv", "frame_000010.png", "index.html", "run.js"}));
}

// NaN, infinite, huge, tiny and constant values, in every place that reads them.
TEST(Fields, StrangeValuesAreWrittenAsTheyAreAndEndParticles) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const std::string scene = R"(
insitu: 1
probes:
  - {name: p, points: [[0.31, 0.41, 0.51]], fields: [density, velocity], output: [csv, json, vtp]}
tracers:
  - {name: t, velocity: velocity, seeds: [[0.31, 0.41, 0.51], [0.1, 0.1, 0.1]]}
  - {name: l, kind: streamline, velocity: velocity, seeds: [[0.31, 0.41, 0.51]]}
frames:
  - {name: v, size: [32, 32], volume: {field: density}, scalar_bar: true}
  - {name: s, size: [32, 32], volume: {field: density, smooth: true}}
  - {name: i, size: [32, 32], isosurfaces: [{field: velocity, component: 0, values: [0.5],
     color: {field: density}}]}
)";
  for (const double value : {nan, infinity, -infinity, 1e308, -1e308, 5e-324, 0.0, 1.0}) {
    SCOPED_TRACE(value);
    const test::Folder folder;
    Coupled run({.scene = scene, .output = folder.path(), .cells = 6});
    ASSERT_TRUE(run.execute()) << insitu_last_message();
    std::fill(run.solver.density.begin(), run.solver.density.end(), value);
    std::fill(run.solver.u.begin(), run.solver.u.end(), value);
    run.mesh.changed(insitu::fields);
    EXPECT_TRUE(run.session.execute(1, 1.0)) << insitu_last_message();
    for (std::size_t i = 0; i < run.solver.density.size(); i += 2)
      run.solver.density[i] = 1.0;
    for (std::size_t i = 0; i < run.solver.u.size(); i += 2)
      run.solver.u[i] = 1.0;
    run.mesh.changed(insitu::fields);
    EXPECT_TRUE(run.session.execute(2, 2.0)) << insitu_last_message();
    const insitu::Report r = run.session.report();
    if (!std::isfinite(value)) {
      EXPECT_EQ(r.particles[INSITU_END_NOT_FINITE], 2 + 2); // pathlines; streamlines of cycles 1, 2
    } else if (std::abs(value) == 1e308) {
      EXPECT_EQ(r.particles[INSITU_END_ALIVE], 0);
    }
    run.session.close();
    const runs::Table p = runs::parse_table(test::content(folder / "p.csv"));
    ASSERT_EQ(p.rows.size(), 3u);
    const double written = p.number(1, "density");
    EXPECT_TRUE(written == value || (std::isnan(written) && std::isnan(value))) << written;
    const YAML::Node json = YAML::LoadFile(folder / "p_000001.json");
    EXPECT_EQ(json["points"][0][1].IsNull(), !std::isfinite(value));
    EXPECT_EQ(runs::names_of(runs::files_of(folder.path()), ".png").size(), 9u);
  }
}

} // namespace
