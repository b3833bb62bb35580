// What lies nearest to a place, held against the definition: all cells, all vertices, all points
// of a face on a fine grid.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "commit/nearest.h"
#include "fixtures/polyhedra.h"
#include "geo/geodesic.h"
#include "geodetic_earth.h"
#include "query/nearest/nearest_cells.h"
#include "query/nearest/nearest_on_cell.h"
#include "registered_amr.h"

namespace insitu {
namespace {

using math::Vec3d;

constexpr double any = std::numeric_limits<double>::infinity();

double length(const Vec3d& a) {
  return std::sqrt(math::dot(a, a));
}

/// Within a cube that is three times as large as the mesh's box.
Vec3d around(const test::TestMesh& mesh, test::Random& random) {
  const Vec3d size = mesh.high - mesh.low;
  return random.uniform(mesh.low - size, mesh.high + size);
}

TEST(NearestOnCell, IsNoFartherThanAnyPointOfTheFaces) {
  constexpr int steps = 60;
  test::Random random(101);
  for (const mesh::Shape shape : fixtures::all_shapes)
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
      const std::vector<Vec3d> x =
          fixtures::jittered_cell(shape, seed % 3 == 0 ? 0.0 : 0.3, 17, seed);
      const Vec3d p = random.uniform({-1.5, -1.5, -1.5}, {2.5, 2.5, 2.5});
      const query::NearestOnCell found = query::nearest_on_cell(shape, x.data(), p, {}, any);
      ASSERT_TRUE(found.on);
      // The point is as far as is said, and on the feature: its coordinates there lead back.
      EXPECT_NEAR(length(found.point - p), std::sqrt(found.squared), 1e-14) << "seed " << seed;
      const Vec3d r = cells::parametric_in(shape, x.data(), found.point, found.on);
      EXPECT_LT(length(cells::map_to_physical(shape, x.data(), r) - found.point), 1e-12);
      const cells::FaceTable table = cells::face_table(shape);
      double least = any;
      for (int f = 0; f < table.face_count; ++f)
        for (int i = 0; i <= steps; ++i)
          for (int j = 0; j <= (table.faces[f].vertex_count == 3 ? steps - i : steps); ++j)
            least = std::min(least, length(test::face_point(table.faces[f], x.data(),
                                                            double(i) / steps, double(j) / steps) -
                                           p));
      EXPECT_LE(std::sqrt(found.squared), least * (1 + 1e-14)) << "seed " << seed;
      EXPECT_GE(std::sqrt(found.squared), least - 2.0 / steps) << "seed " << seed;
    }
}

// On a saddle z = x y over [-1, 1]^2 points of the axis at height h are nearest to the middle while
// |h| < 1, and to two points of a diagonal beyond it, sqrt(2 |h| - 1) away: the middle of the
// saddle then lies farther than they do, and descent from there would end in the wrong place.
TEST(NearestOnCell, OnASaddle) {
  std::vector<Vec3d> x{{-1, -1, 1},  {1, -1, -1}, {1, 1, 1},  {-1, 1, -1},
                       {-1, -1, -4}, {1, -1, -4}, {1, 1, -4}, {-1, 1, -4}};
  std::swap_ranges(x.begin(), x.begin() + 4, x.begin() + 4); // the saddle is on top
  for (const double h : {0.25, 0.5, 0.99, 1.01, 1.25, 1.4}) {
    const query::NearestOnCell found =
        query::nearest_on_cell(mesh::Shape::hexahedron, x.data(), {0, 0, h}, {}, any);
    const double expected = h < 1 ? h : std::sqrt(2 * h - 1);
    EXPECT_NEAR(std::sqrt(found.squared), expected, 1e-14) << h;
    EXPECT_EQ(found.on.reason(), cells::Reason::on_face) << h;
  }
}

// Down its axis a warped quad has places that a whole arc of it is equally far from: bounded work,
// and no point of a fine grid is nearer.
TEST(NearestOnCell, WhereAnArcIsEquallyNear) {
  constexpr int steps = 40;
  const std::vector<Vec3d> x{{0, 0, 0}, {1, 0, 0}, {1, 1, 1}, {0, 1, 0},
                             {0, 0, 3}, {1, 0, 3}, {1, 1, 3}, {0, 1, 3}};
  for (int i = 0; i < 200; ++i) {
    const Vec3d p{0.5, 0.5, 0.25 - 0.02 * i};
    const double found =
        std::sqrt(query::nearest_on_cell(mesh::Shape::hexahedron, x.data(), p, {}, any).squared);
    double least = any;
    for (int u = 0; u <= steps; ++u)
      for (int v = 0; v <= steps; ++v) {
        const double s = double(u) / steps, t = double(v) / steps;
        least = std::min(least, length(Vec3d{s, t, s * t} - p));
      }
    EXPECT_LE(found, least * (1 + 1e-14)) << i;
    EXPECT_GE(found, least - 2.0 / steps) << i;
  }
}

TEST(Nearest, IsTheLowestOfTheNearestCells) {
  for (const auto kind : test::all_kinds)
    for (const double offset : {0.0, 1e6}) {
      const test::TestMesh from = test::box(kind, 4, 0.25, offset);
      const fixtures::Committed m(from);
      const mesh::MeshView& view = m.mesh.mesh().view();
      const query::NearestCells nearest(m.mesh.own_sampler());
      test::Random random(7);
      for (int i = 0; i < 30; ++i) {
        Vec3d p = around(from, random);
        if (i % 3 == 0) // straight over a vertex: a tie of all of its cells
          for (int a = 0; a < 2; ++a)
            p[a] = from.vertices[std::size_t(random.below(int(from.vertices.size())))][a];
        if (m.sampler().locate(p))
          continue;
        query::NearestOnCell least;
        std::int64_t lowest = -1;
        for (std::int64_t c = 0; c < view.cell_count(); ++c) {
          mesh::CellVertices cell;
          mesh::gather(view, c, cell);
          const query::NearestOnCell on = query::nearest_on_cell(cell.shape, cell.x, p, {}, any);
          if (on.squared < least.squared) {
            least = on;
            lowest = c;
          }
        }
        const query::NearestCell found = nearest.find(p, any);
        ASSERT_EQ(found.at.cell, lowest) << test::kind_name(kind) << test::text(p);
        EXPECT_EQ(found.squared, least.squared) << test::text(p);
        EXPECT_EQ(found.point, least.point) << test::text(p);
        const double distance = std::sqrt(found.squared);
        EXPECT_FALSE(nearest.find(p, distance * (1 - 1e-12)).at) << test::text(p);
        EXPECT_EQ(nearest.find(p, distance * (1 + 1e-12)).at.cell, lowest) << test::text(p);
      }
    }
}

TEST(Nearest, OfABoxIsItsNearestPoint) {
  const test::TestMesh from = test::box(test::MeshKind::voxels, 5, 0.0);
  const fixtures::Committed m(from);
  const query::NearestCells nearest(m.mesh.own_sampler());
  test::Random random(8);
  for (int i = 0; i < 500; ++i) {
    const Vec3d p = around(from, random);
    Vec3d on;
    for (int a = 0; a < 3; ++a)
      on[a] = std::clamp(p[a], from.low[a], from.high[a]);
    if (on == p)
      continue;
    const query::NearestCell found = nearest.find(p, any);
    EXPECT_EQ(found.point, on) << test::text(p);
    EXPECT_EQ(found.at.cell, m.sampler().locate(on).cell) << test::text(p);
    EXPECT_NEAR(std::sqrt(found.squared), length(p - on), 1e-15 * length(p - on));
  }
  for (const double bad : {double(NAN), double(INFINITY)})
    EXPECT_FALSE(nearest.find({0.0, bad, 0.0}, any).at);
}

TEST(Nearest, OfAdaptiveMeshesIsALeafAtTheNearestPoint) {
  for (const auto reconstruction : {INSITU_DUAL, INSITU_NEAREST}) {
    const test::RegisteredAmr m(test::Recipe{}, reconstruction, [](const Vec3d& p) { return p.x; });
    const commit::CommittedMesh& mesh = m.committed.mesh;
    const Vec3d low = mesh.tree().bounds_min(), high = mesh.tree().bounds_max();
    const query::NearestCells nearest(mesh.own_sampler());
    test::Random random(9);
    int found = 0;
    for (int i = 0; i < 200; ++i) {
      const Vec3d p = random.uniform(low - (high - low), high + (high - low));
      if (mesh.sampler().locate(p))
        continue;
      const commit::NearestOwn own = commit::own_of(mesh, nearest.find(p, any));
      ASSERT_TRUE(own.at) << test::text(p);
      EXPECT_NEAR(own.distance, length(own.place - p), 1e-14 * length(high - low));
      ++found;
    }
    EXPECT_GT(found, 100);
  }
}

TEST(Nearest, OfPolyhedraIsThatOfTheSameCellsAsShapes) {
  const test::TestMesh from = test::box(test::MeshKind::hexahedra, 4, 0.25);
  const fixtures::Committed shapes(from);
  const fixtures::CommittedFaces faces(fixtures::faces_of(from));
  const query::NearestCells of_shapes(shapes.mesh.own_sampler()),
      of_faces(faces.mesh.own_sampler());
  test::Random random(10);
  for (int i = 0; i < 200; ++i) {
    const Vec3d p = around(from, random);
    if (shapes.sampler().locate(p))
      continue;
    const commit::NearestOwn a = commit::own_of(shapes.mesh, of_shapes.find(p, any));
    const commit::NearestOwn b = commit::own_of(faces.mesh, of_faces.find(p, any));
    EXPECT_EQ(a.at.cell, b.at.cell) << test::text(p);
    EXPECT_EQ(a.distance, b.distance) << test::text(p);
  }
  // Cells that are cut around a centre: the nearest is one of their faces all the same.
  const fixtures::CommittedFaces cut(fixtures::cut_hexahedra(3, 2));
  const query::NearestCells of_cut(cut.mesh.own_sampler());
  for (int i = 0; i < 100; ++i) {
    const Vec3d p = random.uniform({-3, -3, -3}, {6, 6, 6});
    Vec3d on;
    for (int a = 0; a < 3; ++a)
      on[a] = std::clamp(p[a], 0.0, 3.0);
    if (cut.sampler().locate(p))
      continue;
    const commit::NearestOwn own = commit::own_of(cut.mesh, of_cut.find(p, any));
    EXPECT_NEAR(own.distance, length(p - on), 1e-14) << test::text(p);
    EXPECT_LT(length(own.place - on), 1e-7) << test::text(p);
  }
}

TEST(NearestVertices, AreTheFirstOfAll) {
  for (const auto kind : test::all_kinds) {
    const test::TestMesh from = test::box(kind, 4, 0.25);
    const fixtures::Committed m(from);
    test::Random random(11);
    std::vector<Vec3d> points;
    for (int i = 0; i < 60; ++i)
      points.push_back(i % 4 ? around(from, random) : from.vertices[std::size_t(i)]);
    for (const std::size_t most : {1u, 3u, 17u, 1000u}) {
      std::atomic<std::size_t> visited = 0;
      commit::nearest_vertices(
          m.mesh, points, most, any, 0, m.threads,
          [&](std::size_t i, const query::NearVertices& found) {
            std::vector<std::pair<double, std::int64_t>> all;
            for (std::size_t v = 0; v < from.vertices.size(); ++v) {
              const Vec3d step = from.vertices[v] - points[i];
              all.emplace_back(math::dot(step, step), std::int64_t(v));
            }
            std::sort(all.begin(), all.end());
            all.resize(std::min(most, all.size()));
            ASSERT_EQ(found.found().size(), all.size()) << test::kind_name(kind);
            for (std::size_t k = 0; k < all.size(); ++k) {
              EXPECT_EQ(found.found()[k].vertex, all[k].second) << test::text(points[i]);
              EXPECT_EQ(found.found()[k].squared, all[k].first) << test::text(points[i]);
            }
            ++visited;
          });
      EXPECT_EQ(visited, points.size());
    }
  }
}

// Around a pole too, where longitudes tell nothing: the vertex that is found is the nearest by the
// geodesic, or as near as a chart's lengths are right, a hundredth.
TEST(NearestVertices, AroundAPole) {
  const test::TestMesh from =
      fixtures::globe({.subdivisions = 4, .tilt = 0.3, .levels = {-100, 0}});
  const test::Earth m(from);
  test::Random random(12);
  std::vector<Vec3d> points;
  for (int i = 0; i < 100; ++i)
    points.push_back(
        random.uniform({-180, i % 2 ? 87.0 : -90.0, 0}, {180, i % 2 ? 90.0 : -87.0, 0}));
  commit::nearest_vertices(m.mesh, points, 1, any, 0, m.threads,
                           [&](std::size_t i, const query::NearVertices& found) {
                             double least = any;
                             for (const Vec3d& x : from.vertices)
                               if (x.z == 0.0)
                                 least = std::min(least, geo::separation(points[i], x).distance);
                             ASSERT_EQ(found.found().size(), 1u);
                             EXPECT_NEAR(std::sqrt(found.found()[0].squared), least, 0.01 * least)
                                 << test::text(points[i]);
                           });
}

// A strait of cells from 170 degrees east to 170 west; gauges stand on its shores, on both sides of
// the seam and near a pole. To a hundredth of the distance the lengths of a degree are those of the
// geodesic.
TEST(Nearest, InLongitudeAndLatitudeIsMeasuredInMetres) {
  for (const geo::ChartUnits& units :
       {geo::ChartUnits{}, geo::ChartUnits{true, false, false}, geo::ChartUnits{false, true, true}})
    for (const double south : {-10.0, 50.0, 84.0}) {
      const test::Earth m(fixtures::lattice({.units = units,
                                             .west = 170,
                                             .south = south,
                                             .east = 190,
                                             .north = south + 5,
                                             .across = 20,
                                             .along = 10,
                                             .jump = -360}),
                          units);
      const query::NearestCells nearest(m.mesh.own_sampler());
      const double half = 0.02;
      for (const Vec3d& gauge :
           {Vec3d{169.98, south + 2.2, -50}, Vec3d{-169.98, south + 2.2, -50},
            Vec3d{-170.5 + 360, south - half, -50}, Vec3d{179.9, south - half, -50},
            Vec3d{-179.9, south + 5.01, -50}, Vec3d{175.3, south + 1.1, 25.0}}) {
        const query::NearestCell found = nearest.find(fixtures::in_units(units, gauge), any);
        const commit::NearestOwn own = commit::own_of(m.mesh, found);
        ASSERT_TRUE(own.at);
        const Vec3d place = own.place;
        const double angle = units.radians ? 1 / test::degree : 1.0;
        const double over = gauge.z - place.z * units.up_per_unit();
        const double along =
            geo::separation(gauge, {place.x * angle, place.y * angle, 0.0}).distance;
        const double expected = std::hypot(along, over);
        EXPECT_NEAR(own.distance, expected, 0.01 * expected) << test::text(gauge);
        EXPECT_LT(own.distance, 3000.0) << test::text(gauge);
        // Where that point is, that cell is.
        const std::int64_t owner = m.owner(place);
        if (owner >= 0) {
          EXPECT_EQ(owner, own.at.cell) << test::text(gauge);
        }
      }
    }
}

} // namespace
} // namespace insitu
