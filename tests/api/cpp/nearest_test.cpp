/// The nearest cells and vertices through insitu.hpp.
#include <cmath>
#include <gtest/gtest.h>
#include <insitu/insitu.hpp>

#include "two.h"

TEST(WrappedNearest, CellsAndVertices) {
  Two two;
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
  mesh.points(two.x.data(), two.y.data(), two.z.data(), two.x.size());
  mesh.hexahedra(two.ids.data(), 2);
  mesh.cell_field("rho", two.density.data());
  mesh.commit();
  const std::vector<std::array<double, 3>> points{{1.5, 0.5, 0.5}, {5, 0.25, 0.5}, {-1, -1, 0.5}};
  insitu::LocateOptions options;
  options.nearest = true;
  options.greatest_distance = 4;
  const insitu::Samples s = mesh.sample("rho", points, options);
  EXPECT_EQ(s.found, (std::vector<std::uint8_t>{1, 0, 0}));
  EXPECT_EQ(s.cells, (std::vector<std::int64_t>{1, 1, 0}));
  EXPECT_EQ(s.distances, (std::vector<double>{0, 3, std::sqrt(2.0)}));
  EXPECT_EQ(s.nearest, (std::vector<double>{1.5, 0.5, 0.5, 2, 0.25, 0.5, 0, 0, 0.5}));
  EXPECT_EQ(s(1), two.density[1]);
  EXPECT_EQ(s.parametric[3], 1.0);
  options.greatest_distance = 2;
  EXPECT_EQ(mesh.locate(points, options).cells, (std::vector<std::int64_t>{1, -1, 0}));

  const insitu::NearestVertices v = mesh.nearest_vertices(points, 2);
  ASSERT_EQ(v.vertices.size(), 6u);
  EXPECT_EQ(v.distances[0], std::sqrt(0.75));
  for (std::size_t k = 0; k < 6; ++k) {
    const auto id = std::size_t(v.vertices[k]);
    EXPECT_EQ(v.places[3 * k], two.x[id]);
    EXPECT_EQ(v.places[3 * k + 2], two.z[id]);
    EXPECT_EQ(v.pieces[k], 0);
  }
}
