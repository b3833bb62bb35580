#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "commit/standins/geodetic.h"
#include "fixtures/earth_meshes.h"
#include "query_test.h"

/// Committed meshes in longitude and latitude, and which of their cells hold a point.
namespace insitu::test {

constexpr geo::ChartUnits degrees{};
constexpr double degree = std::numbers::pi / 180;

/// A committed geodetic mesh.
struct Earth : fixtures::Committed {
  explicit Earth(const test::TestMesh& from, const geo::ChartUnits& units = {}, int pieces = 1)
      : Committed() {
    arrays = fixtures::SolverArrays(from);
    mesh.reference_frame = fixtures::frame_of(units);
    give(pieces);
    commit();
  }
  void give(int pieces) {
    const insitu_array a = arrays.point_array();
    insitu_cells c = arrays.cells();
    const std::int64_t all = c.count;
    for (int p = 0; p < pieces; ++p) { // of one shape
      const std::int64_t first = all * p / pieces, last = all * (p + 1) / pieces;
      c.count = last - first;
      const int n = c.connectivity.components;
      c.connectivity = insitu_array_of(arrays.ids.data() + first * n, INSITU_INT32, c.count, n);
      mesh.mesh().set_points(p, &a, 1);
      mesh.mesh().set_cells(p, &c);
    }
  }
  const commit::Geodetic* geodetic() const {
    return dynamic_cast<const commit::Geodetic*>(mesh.stand_in());
  }
  const query::ChartImage& image() const { return geodetic()->image(); }
  /// As the solver counts.
  std::int64_t owner(const Vec3d& p, std::int64_t hint = -1) const {
    return mesh.own(sampler().locate(p, hint), p).cell;
  }
  /// The solver's cells that own points, as they lie on a chart.
  struct Placed {
    std::int64_t flat;
    mesh::CellVertices c;
    Vec3d low, high;
  };
  std::vector<Placed> placed(geo::Pole pole) const {
    const mesh::MeshView& view = mesh.mesh().own_view();
    std::vector<Placed> out;
    for (std::int64_t flat = 0; flat < view.cell_count(); ++flat) {
      const std::int32_t piece = view.piece_of(flat);
      if (!view.pieces[piece].owns(flat - view.first_cell[piece]))
        continue;
      Placed cell{flat, {}, {1e300, 1e300, 1e300}, {-1e300, -1e300, -1e300}};
      mesh::gather(view, flat, cell.c);
      for (int v = 0; v < cell.c.count; ++v) {
        Vec3d& x = cell.c.x[v];
        if (pole != geo::Pole::none)
          x = image().turned(pole, x);
        for (int a = 0; a < 3; ++a) {
          cell.low[a] = std::min(cell.low[a], x[a]);
          cell.high[a] = std::max(cell.high[a], x[a]);
        }
      }
      out.push_back(cell);
    }
    return out;
  }
};

/// Which cells hold a point, by the definition: their longitudes taken as near to its own as they
/// go, or on the chart turned to a pole where its image is there.
class Holders {
public:
  explicit Holders(const Earth& earth)
      : image_(earth.image()), cells_{earth.placed(geo::Pole::none), earth.placed(geo::Pole::north),
                                      earth.placed(geo::Pole::south)} {}

  std::vector<std::int64_t> of(const Vec3d& p) const {
    const double turn = image_.units.turn();
    const geo::Pole pole = image_.pole_at(p.y);
    const Vec3d q = pole == geo::Pole::none ? p : image_.turned(pole, p);
    std::vector<std::int64_t> out;
    for (const Earth::Placed& cell : cells_[int(pole)]) {
      bool may = true;
      for (int a = pole == geo::Pole::none ? 1 : 0; a < 3; ++a)
        may &= q[a] >= cell.low[a] - 1e-9 && q[a] <= cell.high[a] + 1e-9;
      if (!may)
        continue;
      mesh::CellVertices c = cell.c;
      if (pole == geo::Pole::none) {
        double low = 1e300, high = -1e300;
        for (int v = 0; v < c.count; ++v) {
          c.x[v].x += turn * std::round((q.x - c.x[v].x) / turn);
          low = std::min(low, c.x[v].x);
          high = std::max(high, c.x[v].x);
        }
        if (high - low >= turn / 2 || q.x < low - 1e-9 || q.x > high + 1e-9)
          continue;
      }
      if (cells::holds(cells::contain_exact(c.shape, c.x, q).where))
        out.push_back(cell.flat);
    }
    return out;
  }

private:
  query::ChartImage image_;
  std::vector<Earth::Placed> cells_[3];
};

/// Evenly over the sphere, at one of some heights.
inline Vec3d random_point(test::Random& random, double height) {
  return {random.uniform(-180, 180), std::asin(random.uniform(-1, 1)) / degree, height};
}

/// Where trouble is: seams, poles, the surface.
inline std::vector<Vec3d> hard_places(std::uint64_t seed) {
  test::Random random(seed);
  std::vector<Vec3d> out;
  for (const double z : {-3999.0, -100.0, -50.0, 0.0}) {
    for (const double lon : {-180.0, -179.999, -1e-13, 0.0, 1e-13, 17.0, 90.0, 179.999, 180.0})
      for (const double lat : {-90.0, -89.999999, -89.9, -45.0, 0.0, 30.0, 89.9, 89.9999999, 90.0})
        out.push_back({lon, lat, z});
    for (int i = 0; i < 60; ++i) {
      const double near = std::pow(10.0, random.uniform(-12, 1));
      out.push_back({random.uniform(-180, 180), (i % 2 ? 1 : -1) * (90 - near), z});
      out.push_back({(i % 2 ? 1 : -1) * (180 - near), random.uniform(-90, 90), z});
      out.push_back({random.uniform(-1e-3, 1e-3), random.uniform(-90, 90), z});
    }
  }
  return out;
}

inline void expect_one_owner(const Earth& earth, const geo::ChartUnits& units,
                             const std::string& what) {
  test::Random random(5);
  std::vector<Vec3d> points = hard_places(4);
  for (int i = 0; i < 600; ++i)
    points.push_back(random_point(random, i % 3 ? random.uniform(-4000, 0) : 0.0));
  for (Vec3d& p : points)
    p = fixtures::in_units(units, p);
  std::vector<query::Location> batch(points.size());
  earth.sampler().locate(earth.threads, points, batch);
  const Holders held(earth);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3d& p = points[i];
    const std::vector<std::int64_t> holders = held.of(p);
    const std::int64_t owner = earth.mesh.own(batch[i], p).cell;
    ASSERT_FALSE(holders.empty()) << what << ": no cell holds " << test::text(p);
    ASSERT_GE(owner, 0) << what << ": lost " << p.x << " " << p.y << " " << p.z;
    ASSERT_NE(std::find(holders.begin(), holders.end(), owner), holders.end())
        << what << ": " << p.x << " " << p.y << " " << p.z << " in " << owner << ", held by "
        << holders[0];
    ASSERT_EQ(earth.owner(p), owner);
    ASSERT_EQ(earth.owner(p, batch[i].cell), owner);
    for (const int turns : {-1, 1}) { // the same place by another name, when that rounds to it
      const Vec3d q{p.x + turns * units.turn(), p.y, p.z};
      const Vec3d a = earth.image()(p), b = earth.image()(q);
      if (a == b) {
        ASSERT_EQ(earth.owner(q), owner) << what << ": " << p.x << " " << p.y;
      }
      ASSERT_GE(earth.owner(q), 0) << what << ": " << q.x << " " << q.y;
    }
  }
}

} // namespace insitu::test
