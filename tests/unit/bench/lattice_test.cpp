#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <set>

#include "count_faces.h"
#include "workload/lattice.h"
#include "workload/queries.h"

namespace insitu::workload {
namespace {

using math::Vec3d;

constexpr Spacing all_spacings[] = {Spacing::even, Spacing::graded, Spacing::layers,
                                    Spacing::sparse};

struct Edges {
  double shortest = 1e300, longest = 0.0;
  void add(double length) {
    shortest = std::min(shortest, length);
    longest = std::max(longest, length);
  }
};

/// Lengths of hexahedra's edges along each axis.
void measure(const Mesh& mesh, Edges (&along)[3]) {
  const int ends[3][2] = {{0, 1}, {0, 3}, {0, 4}};
  for (std::int64_t c = 0; c < mesh.cell_count(); ++c)
    for (int a = 0; a < 3; ++a) {
      const Vec3d d = mesh.point(mesh.ids(c)[ends[a][1]]) - mesh.point(mesh.ids(c)[ends[a][0]]);
      along[a].add(std::sqrt(dot(d, d)));
    }
}

TEST(Lattice, GradedEdgesSpanFourDecades) {
  Edges along[3];
  const Mesh mesh = make_box(Kind::hexahedra, 12, 0.0, Spacing::graded);
  measure(mesh, along);
  for (const Edges& edges : along)
    EXPECT_NEAR(edges.longest / edges.shortest, 1e4, 1.0); // differences of rounded coordinates
  EXPECT_DOUBLE_EQ(mesh.smallest_edge, along[0].shortest);
  for (int a = 0; a < 3; ++a)
    EXPECT_EQ(mesh.points[mesh.points.size() - 3 + std::size_t(a)], 1.0);
}

TEST(Lattice, LayersAreAtLeastTenThousandTimesAsWideAsThick) {
  Edges along[3];
  measure(make_box(Kind::hexahedra, 12, 0.0, Spacing::layers), along);
  EXPECT_NEAR(along[0].shortest / along[2].longest, 1e4, 1e-3);
  EXPECT_NEAR(along[0].longest / along[2].shortest, 1e6, 1e-1);
}

TEST(Lattice, SparseFillsAboutFivePercentAndKeepsNoUnusedVertex) {
  EXPECT_NEAR(filled_share(Spacing::sparse), 0.05, 0.005);
  EXPECT_EQ(filled_share(Spacing::graded), 1.0);
  for (const Kind kind : {Kind::hexahedra, Kind::pyramids, Kind::mixed}) {
    const int n = box_size(kind, 20'000, Spacing::sparse);
    const Mesh mesh = make_box(kind, n, 0.2, Spacing::sparse);
    EXPECT_NEAR(double(mesh.cell_count()), 20'000.0, 2000.0) << name(kind);
    const std::set<std::int32_t> used(mesh.connectivity.begin(), mesh.connectivity.end());
    EXPECT_EQ(std::int64_t(used.size()), mesh.vertex_count());
    EXPECT_EQ(*used.rbegin(), mesh.vertex_count() - 1);
  }
}

/// Of a sparse box, every block is that of the full box, whatever its vertices are called.
TEST(Lattice, SparseCellsAreThoseOfTheFullBox) {
  const int n = 20;
  const auto cells = [](const Mesh& mesh) {
    std::set<std::vector<double>> all;
    for (std::int64_t c = 0; c < mesh.cell_count(); ++c) {
      Vec3d x[8];
      std::vector<double> flat;
      for (int v = 0, count = mesh.gather(c, x); v < count; ++v)
        flat.insert(flat.end(), {x[v].x, x[v].y, x[v].z});
      all.insert(flat);
    }
    return all;
  };
  const auto full = cells(make_box(Kind::hexahedra, n, 0.2));
  const auto sparse = cells(make_box(Kind::hexahedra, n, 0.2, Spacing::sparse));
  EXPECT_GT(sparse.size(), 100u);
  EXPECT_TRUE(std::includes(full.begin(), full.end(), sparse.begin(), sparse.end()));
}

TEST(Lattice, NoFaceIsSharedByMoreThanTwoCells) {
  for (const Spacing spacing : all_spacings) {
    const Mesh mesh = make_box(Kind::mixed, spacing == Spacing::sparse ? 20 : 6, 0.2, spacing);
    int shared = 0;
    for (const auto& [ids, count] : count_faces(mesh)) {
      EXPECT_LE(count, 2);
      shared += count == 2;
    }
    EXPECT_GT(shared, 100) << name(spacing);
  }
}

TEST(Lattice, NamesRoundTrip) {
  for (const Spacing spacing : all_spacings)
    EXPECT_EQ(spacing_from_name(name(spacing)), spacing);
  EXPECT_FALSE(spacing_from_name("odd"));
}

TEST(MortonOrder, IsAStablePermutationByInterleavedBits) {
  std::vector<Vec3d> points;
  for (int i = 0; i < 3000; ++i) // every point of a lattice of 8 along each axis, several times
    points.push_back({double(i * 7 % 8), double(i * 5 / 8 % 8), double(i / 64 % 8)});
  const auto order = morton_order(points);
  ASSERT_EQ(order.size(), points.size());
  const auto code = [](const Vec3d& p) {
    int out = 0;
    for (int bit = 0; bit < 3; ++bit)
      for (int a = 0; a < 3; ++a)
        out |= (int(p[a]) >> bit & 1) << (3 * bit + a);
    return out;
  };
  std::vector<bool> met(points.size(), false);
  for (std::size_t k = 0; k < order.size(); ++k) {
    ASSERT_LT(order[k], points.size());
    EXPECT_FALSE(met[order[k]]);
    met[order[k]] = true;
    if (k == 0)
      continue;
    const int before = code(points[order[k - 1]]), now = code(points[order[k]]);
    EXPECT_TRUE(before < now || (before == now && order[k - 1] < order[k])) << k;
  }
  EXPECT_TRUE(morton_order({}).empty());
}

} // namespace
} // namespace insitu::workload
