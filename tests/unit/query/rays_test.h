#pragma once

#include "accel/ray_locator.h"
#include "query_test.h"

/// What the tests of ray methods share.
namespace insitu::test {

using accel::Method;
using query::Location;

inline constexpr Method ray_methods[] = {Method::user_geometry, Method::replicated_faces,
                                         Method::shared_faces, Method::shared_bilinear_faces};

struct Answers {
  std::vector<Location> at;
  std::vector<std::uint8_t> reasons;
};

inline Answers ask(const fixtures::Committed& m, const std::vector<Vec3d>& points,
                   insitu_accuracy accuracy) {
  Answers a{std::vector<Location>(points.size()), std::vector<std::uint8_t>(points.size())};
  m.sampler().locate(m.threads, points, a.at, {accuracy, 1.0}, a.reasons);
  return a;
}

/// Points of all sorts: within cells, on and near their boundaries, outside, and none at all.
inline std::vector<Vec3d> points_of(const mesh::MeshView& view, int count, std::uint64_t seed) {
  std::vector<Vec3d> points = inner_points(view, count, seed);
  const std::vector<Vec3d> hard = hard_points(view, count, seed + 1);
  points.insert(points.end(), hard.begin(), hard.end());
  for (std::size_t i = 0; i < points.size(); i += 17)
    points[i].x += 1000;
  points[3].y = std::numeric_limits<double>::quiet_NaN();
  points[4].z = std::numeric_limits<double>::infinity();
  points[5].x = -1e300;
  return points;
}

inline void expect_same(const Answers& a, const Answers& wanted, const std::vector<Vec3d>& points,
                        const std::string& what) {
  for (std::size_t i = 0; i < points.size(); ++i)
    ASSERT_TRUE(same_bits(a.at[i], wanted.at[i]))
        << what << ", point " << i << " " << text(points[i]) << ": " << a.at[i].cell << " for "
        << wanted.at[i].cell;
}

/// The fixture's tetrahedra, all the same way round.
inline TestMesh upright(TestMesh mesh) {
  for (MeshCell& cell : mesh.cells) {
    const Vertices x = mesh.cell_vertices(cell);
    if (cell.shape == mesh::Shape::tetrahedron &&
        dot(cross(x[1] - x[0], x[2] - x[0]), x[3] - x[0]) < 0)
      std::swap(cell.vertices[0], cell.vertices[1]);
  }
  return mesh;
}

/// Hexahedra whose layers of vertices are turned about each cell's axis by turns, the next layer
/// the other way: quads between columns are bent by `amplitude` of a cell, every second one in
/// each direction, and below 0.5 no cell folds, since a section of a cell at height t is the square
/// under I + (1 - 2t) M with det > 0. (Vertices of the boundary stay.)
inline TestMesh twisted_box(int size, double amplitude) {
  TestMesh mesh = box(MeshKind::hexahedra, size, 0.0);
  for (Vec3d& p : mesh.vertices) {
    const auto inner = [size](double x) { return x > 0 && x < size; };
    if (!inner(p.x) || !inner(p.y) || !inner(p.z))
      continue;
    const auto sign = [](double x) { return int(x) % 2 == 0 ? 1.0 : -1.0; };
    p += (amplitude * sign(p.z)) * Vec3d{sign(p.y), -sign(p.x), 0};
  }
  return mesh;
}

/// How points of a batch were answered.
struct Shares {
  double kept, by_neighbour, by_tree;
};
/// Of random points within cells, in the mesh as it was committed.
inline Shares shares_of(const fixtures::Committed& m, insitu_accuracy accuracy, int count = 2000) {
  const query::RayCounts& counts = m.mesh.locators().ray_counts();
  const std::int64_t before[] = {counts.kept, counts.by_neighbour, counts.by_tree};
  ask(m, inner_points(m.sampler().mesh(), count, 83), accuracy);
  return {double(counts.kept - before[0]) / count, double(counts.by_neighbour - before[1]) / count,
          double(counts.by_tree - before[2]) / count};
}

} // namespace insitu::test
