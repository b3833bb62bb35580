// Drifters on the surface of an ocean in longitude and latitude.
#include <gtest/gtest.h>

#include "../advect/earth_flow.h"

namespace insitu::test {
namespace {

TEST(SurfaceDrifters, NoneIsLostInThirtyDays) {
  // A gyre between coasts, under whose surface water sinks and rises; nothing does at the surface.
  constexpr double west = 10.0, east = 30.0, south = 20.0, north = 45.0, day = 86400.0;
  const auto from = [&](double west_from) {
    return fixtures::lattice({.west = west_from,
                              .south = south,
                              .east = west_from + east - west,
                              .north = north,
                              .across = 10,
                              .along = 12,
                              .levels = {-3000, -700, -100, 0}});
  };
  for (const bool face_aware : {false, true})
    for (const double at : {10.0, 0.0, -7.0 / 3.0})
      for (const auto method : {advect::Method::euler, advect::Method::rk4, advect::Method::bs32,
                                advect::Method::dopri5}) {
        Ocean sea(from(at), [&](const Vec3d& p) {
          const double x = (p.x - at) / (east - west), y = (p.y - south) / (north - south);
          const double pi = std::numbers::pi;
          Vec3d v{-1.2 * std::sin(pi * x) * std::cos(pi * y),
                  0.9 * std::cos(pi * x) * std::sin(pi * y),
                  1e-3 * std::cos(2 * pi * x) * std::cos(3 * pi * y)};
          v.x = p.x == at || p.x == at + east - west ? 0.0 : v.x;
          v.y = p.y == south || p.y == north ? 0.0 : v.y;
          v.z = p.z == 0.0 || p.z == -3000 ? 0.0 : v.z;
          return v;
        });
        sea.settings.integrator.method = method;
        sea.settings.integrator.face_aware = face_aware;
        std::vector<Vec3d> seeds;
        for (int j = 0; j <= 20; ++j)
          for (int i = 0; i <= 20; ++i)
            seeds.push_back({i == 20 ? at + east - west : at + (east - west) * i / 20,
                             j == 20 ? north : south + (north - south) * j / 20, 0.0});
        const advect::Tracer t = sea.run({}, seeds, 30 * day, 30);
        std::int64_t alive = 0, at_surface = 0, inside = 0;
        for (std::size_t i = 0; i < seeds.size(); ++i) {
          alive += t.particles().endings[i] == INSITU_END_ALIVE;
          at_surface += t.positions()[i].z == 0.0;
          inside += bool(sea.sampler().locate(t.positions()[i]));
        }
        EXPECT_EQ(alive, 441) << int(method) << " " << face_aware << " from " << at;
        EXPECT_EQ(at_surface, 441) << int(method) << " " << face_aware << " from " << at;
        EXPECT_EQ(inside, 441) << int(method) << " " << face_aware << " from " << at;
      }
}

} // namespace
} // namespace insitu::test
