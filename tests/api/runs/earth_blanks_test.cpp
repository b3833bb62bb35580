// Land on Earth: where the velocity has no values is a wall, over the seam of longitude as well.
#include <cmath>
#include <gtest/gtest.h>

#include "coupled.h"
#include "on_earth.h"

namespace {

using insitu::fixtures::Lattice;
using runs::OnEarth;

constexpr double fill = -32767;

struct Coast {
  const char* name;
  Lattice lattice;
  double first, last; ///< longitudes of vertices on land, in degrees east of `seed`
  double seed, wall;
};

std::vector<Coast> coasts() {
  Lattice globe{.west = -180,
                .south = -40,
                .east = 180,
                .north = 40,
                .across = 72,
                .along = 16,
                .levels = {-3000, 0}};
  return {{"the Pacific", runs::pacific(), 195, 210, 171, 190},
          {"an island across the seam of a globe", globe, -175, -165, 171, -180},
          {"an island before the seam", globe, 165, 180, 151, 160}};
}

TEST(EarthBlanks, LandIsAWall) {
  for (const Coast& coast : coasts()) {
    SCOPED_TRACE(coast.name);
    const test::Folder folder;
    const std::string seed = "seeds: [[" + std::to_string(coast.seed) + ", 2.2, -1000]]";
    {
      OnEarth run(coast.lattice,
                  "tracers:\n  - {name: paths, velocity: velocity, " + seed +
                      "}\n  - {name: lines, kind: streamline, velocity: velocity, " + seed +
                      ", until: {duration: 1e6}}\n  - {name: slides, velocity: velocity, " + seed +
                      ", effects: [{boundary: slide}]}\n",
                  folder.path());
      run.flow(100.0, 10.0);
      for (std::size_t v = 0; v < run.lon.size(); ++v)
        if (run.lon[v] >= coast.first - 1e-9 && run.lon[v] <= coast.last + 1e-9)
          run.velocity[3 * v] = fill;
      run.mesh.field_blank("velocity", fill);
      run.mesh.changed(insitu::fields);
      for (int cycle = 0; cycle <= 4; ++cycle)
        ASSERT_TRUE(run.session.execute(cycle, 10000.0 * cycle)) << insitu_last_message();
    }
    for (const char* name : {"paths.csv", "lines_000000.csv"}) {
      const runs::Table t = runs::parse_table(test::content(folder / name));
      const std::size_t last = t.rows.size() - 1;
      EXPECT_EQ(t.text(last, "ending"), "blank") << name;
      EXPECT_NEAR(std::remainder(t.number(last, "x") - coast.wall, 360.0), 0.0, 1e-6) << name;
    }
    const runs::Table slides = runs::parse_table(test::content(folder / "slides.csv"));
    const std::size_t last = slides.rows.size() - 1;
    EXPECT_EQ(slides.text(last, "ending"), "killed");
    EXPECT_NEAR(std::remainder(slides.number(last, "x") - coast.wall, 360.0), 0.0, 1e-6);
    EXPECT_GT(slides.number(last, "y"), 4.0); // north along the coast, at 10 m/s for 4e4 s
  }
}

} // namespace
