// Streamlines with effects on meshes in longitude and latitude.
#include <cmath>
#include <gtest/gtest.h>

#include "earth_flow.h"
#include "line_view.h"

namespace insitu::test {
namespace {

using advect::AtBoundary;
using advect::Effects;
using advect::Tracer;

// On the Earth lines go where particles do that a steady flow carries: along a coast that leans,
// over the date line, down a slope.
TEST(GeodeticLines, EndWhereParticlesDo) {
  core::Memory memory;
  core::Threads threads;
  advect::StreamlineSettings settings;
  TestMesh mesh = fixtures::lattice({.west = 175,
                                     .south = 55,
                                     .east = 185,
                                     .north = 65,
                                     .across = 10,
                                     .along = 10,
                                     .levels = {-1000, -500, 0}});
  for (Vec3d& p : mesh.vertices) {
    p.x += 1.5 * (p.y - 60);
    p.z += -p.z / 1000 * 40 * (p.x - 175);
  }
  Ocean sea(mesh, constant({0.8, -0.1, 0}));
  const std::vector<Vec3d> seeds{{182, 58, -50}, {179.9, 60, -20}, {-179.5, 60.5, 0}};
  for (const AtBoundary response : {AtBoundary::slide, AtBoundary::stop}) {
    Effects effects = boundary(response);
    effects.drifts.push_back({{0, 0, -0.002}, {}, 1.0, {}});
    const double end = 6e5;
    const Tracer t = sea.run(effects, seeds, end);
    settings.effects = effects;
    settings.duration = end;
    settings.integrator = sea.settings.integrator;
    for (const double even : {0.0, 5e3}) {
      settings.even_length = even;
      const advect::Streamlines s =
          advect::trace_streamlines(sea.sampler(), sea.flow(), seeds, settings, threads, memory);
      for (std::size_t l = 0; l < seeds.size(); ++l) {
        const LineView of = line(s, l);
        EXPECT_EQ(of.ending,
                  response == AtBoundary::stop ? INSITU_END_STOPPED : INSITU_END_EXPIRED);
        EXPECT_EQ(of.times.back(), t.particles().times[l]);
        EXPECT_EQ(of.points.back(), t.positions()[l]) << int(response);
        int bends = 0; // where it comes to a wall within a step
        for (std::size_t v = 1; v + 1 < of.points.size() && even > 0.0; ++v) {
          const Vec3d middle = 0.5 * (of.points[v] + of.points[v - 1]);
          const Vec3d m = metres_per_degree(middle.y, middle.z);
          Vec3d d = of.points[v] - of.points[v - 1];
          d.x = std::remainder(d.x, 360.0);
          const double apart = std::hypot(d.x * m.x, d.y * m.y, d.z);
          // A degree is 2e-4 longer or shorter a step along the coast further.
          EXPECT_LT(apart, 5e3 + 1.0) << l << " " << v;
          bends += apart < 5e3 - 1.0;
        }
        EXPECT_LE(bends, 3);
      }
    }
  }
}

} // namespace
} // namespace insitu::test
