#include <cmath>
#include <cstdint>
#include <gtest/gtest.h>

#include "core/random.h"
#include "render/volume/macrocells.h"

namespace insitu::test {
namespace {

using math::Vec3d;
using render::MacrocellGrid;

double random(std::uint64_t a, std::uint64_t b) {
  return core::random_unit(77, a, b);
}

/// Walks and compares with where points of the ray are.
TEST(Macrocells, RaysPassThroughAllOfTheirMacrocellsInOrder) {
  const MacrocellGrid grids[] = {{{0, 0, 0}, {0.1, 0.25, 0.2}, {10, 4, 5}},
                                 {{6.4e6, -6.4e6, 6.4e6}, {0.1, 0.25, 0.2}, {10, 4, 5}},
                                 {{-1, 2, 3}, {0.5, 0, 1e-5}, {4, 1, 7}},
                                 {{0, 0, 0}, {1, 1, 1}, {1, 1, 1}}};
  std::int64_t visits = 0;
  for (const MacrocellGrid& grid : grids)
    for (std::uint64_t i = 0; i < 3000; ++i) {
      const auto r = [&](int k) { return random(i, 100 + std::uint64_t(k)); };
      Vec3d extent;
      for (int a = 0; a < 3; ++a)
        extent[a] = grid.counts[a] * grid.size[a];
      const auto somewhere = [&](int k, double reach) {
        Vec3d p;
        for (int a = 0; a < 3; ++a)
          p[a] = grid.low[a] + (reach * (r(k + a) - 0.5) + 0.5) * extent[a];
        return p;
      };
      Vec3d from = somewhere(0, 3), to = somewhere(3, 1);
      if (i % 5 == 1) // along a plane of the grid, and an edge
        from.x = to.x = grid.plane(0, int(i / 5) % grid.counts[0]);
      if (i % 10 == 1)
        from.z = to.z = grid.plane(2, int(i / 5) % (grid.counts[2] + 1));
      if (i % 5 == 2) { // through its corners
        from = grid.low;
        to = grid.low + extent;
      }
      if (i % 5 == 3) // beside it, but not quite parallel
        to.x = from.x + 1e-17 * extent.x;
      const Vec3d d = to - from;
      const double length = std::sqrt(dot(d, d));
      if (!(length > 0))
        continue;
      render::Ray ray{from, d / length};
      const double near = 0.3 * length * r(7), far = near + 2 * length * r(8);
      if (i % 3 == 0)
        ray.direction = -ray.direction;
      double upto = near;
      std::int64_t count = 0;
      for_each_macrocell(grid, ray, near, far, [&](std::int64_t m, double t0, double t1) {
        EXPECT_EQ(t0, upto);
        EXPECT_LE(t0, t1);
        EXPECT_GE(m, 0);
        EXPECT_LT(m, grid.count());
        upto = t1;
        ++count;
        // The points of the stretch are in this macrocell, as far as they can be told.
        const int at[3] = {int(m % grid.counts[0]), int(m / grid.counts[0] % grid.counts[1]),
                           int(m / grid.counts[0] / grid.counts[1])};
        for (const double w : {0.0, 0.5, 1.0})
          for (int a = 0; a < 3; ++a) {
            const double t = t0 + w * (t1 - t0), x = ray.origin[a] + t * ray.direction[a];
            const double slack = 1e-15 * (std::fabs(ray.origin[a]) + t + std::fabs(grid.low[a]));
            EXPECT_TRUE(at[a] == 0 || x >= grid.plane(a, at[a]) - slack) << i;
            EXPECT_TRUE(at[a] + 1 == grid.counts[a] || x <= grid.plane(a, at[a] + 1) + slack) << i;
          }
        return true;
      });
      EXPECT_EQ(upto, far);
      EXPECT_LE(count, grid.counts[0] + grid.counts[1] + grid.counts[2]);
      visits += count;
      int only = 0;
      for_each_macrocell(grid, ray, near, far, [&](std::int64_t, double, double) {
        ++only;
        return false;
      });
      EXPECT_EQ(only, 1);
    }
  EXPECT_GT(visits, 10000);
  int infinite = 0;
  double last = 0;
  for_each_macrocell(grids[0], {{-1, 0.5, 0.5}, {1, 0, 0}}, 0, HUGE_VAL,
                     [&](std::int64_t, double, double to) {
                       ++infinite;
                       last = to;
                       return true;
                     });
  EXPECT_EQ(infinite, 10);
  EXPECT_EQ(last, HUGE_VAL);
  for_each_macrocell(grids[0], {{-1, 0.5, 0.5}, {1, 0, 0}}, 2, 1,
                     [&](std::int64_t, double, double) {
                       ADD_FAILURE();
                       return true;
                     });
}

} // namespace
} // namespace insitu::test
