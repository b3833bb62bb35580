// Nearest cells and vertices of flat meshes, by their distances in the plane.
#include <gtest/gtest.h>

#include "flat_meshes.h"

using namespace flat_meshes;

namespace {

double squared_distance(const Flat& m, int a, int b, double px, double py) {
  const auto ia = std::size_t(a), ib = std::size_t(b);
  const double ex = m.x[ib] - m.x[ia], ey = m.y[ib] - m.y[ia];
  const double t =
      std::clamp(((px - m.x[ia]) * ex + (py - m.y[ia]) * ey) / (ex * ex + ey * ey), 0.0, 1.0);
  const double dx = m.x[ia] + t * ex - px, dy = m.y[ia] + t * ey - py;
  return dx * dx + dy * dy;
}

} // namespace

TEST(FlatNearest, DistancesAreThoseInThePlane) {
  constexpr int n = 4;
  for (const Kind kind : {Kind::triangles, Kind::quads, Kind::pixels, Kind::mixed}) {
    const Flat m = flat_mesh(n, kind, true);
    Arrays arrays(m, kind);
    insitu::Session session;
    insitu::Mesh mesh = session.mesh("m");
    arrays.give(mesh, kind);
    mesh.commit();
    const std::vector<double> xyz = points_of(m, n);
    insitu::LocateOptions options;
    options.nearest = true;
    const insitu::Locations found = mesh.locate(xyz, options);
    const insitu::NearestVertices near = mesh.nearest_vertices(xyz, 3);
    for (std::size_t i = 0; i < xyz.size() / 3; ++i) {
      const double x = xyz[3 * i], y = xyz[3 * i + 1];
      ASSERT_GE(found.cells[i], 0);
      EXPECT_EQ(found.found[i] != 0, owner(m, x, y) >= 0);
      double least = 1e300;
      for (const auto& ring : m.cells)
        for (std::size_t v = 0; v < ring.size(); ++v)
          least = std::min(least, squared_distance(m, ring[v], ring[(v + 1) % ring.size()], x, y));
      if (found.found[i]) {
        EXPECT_EQ(found.distances[i], 0.0);
      } else {
        EXPECT_NEAR(found.distances[i], std::sqrt(least), 1e-14) << x << " " << y;
        EXPECT_EQ(found.parametric[3 * i + 2], 0.5);
      }
      EXPECT_EQ(found.nearest[3 * i + 2], 0.0);
      std::vector<std::pair<double, std::int64_t>> all;
      for (std::size_t v = 0; v < m.vertices(); ++v) {
        const double dx = m.x[v] - x, dy = m.y[v] - y;
        all.emplace_back(dx * dx + dy * dy, std::int64_t(v));
      }
      std::sort(all.begin(), all.end());
      for (std::size_t k = 0; k < 3; ++k) {
        ASSERT_EQ(near.vertices[3 * i + k], all[k].second) << x << " " << y;
        EXPECT_EQ(near.distances[3 * i + k], std::sqrt(all[k].first));
        EXPECT_EQ(near.places[3 * (3 * i + k) + 2], 0.0);
      }
    }
  }
}
