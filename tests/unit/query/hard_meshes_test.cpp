// Meshes of hard cells, asked through the whole path (tree, batches, hints): the owner is the one
// that the definition says, found by brute force with exact arithmetic.
#include <algorithm>
#include <functional>

#include "core/status.h"
#include "query_test.h"

using namespace insitu;
using math::Vec3d;
using test::all_kinds;
using test::box;
using test::check_owners;

namespace {

std::vector<Vec3d> points_of(const fixtures::Committed& m, int count, std::uint64_t seed) {
  const mesh::MeshView& view = m.mesh.mesh().view();
  std::vector<Vec3d> points = test::hard_points(view, count, seed);
  const std::vector<Vec3d> inner = test::inner_points(view, count / 2, seed + 1);
  points.insert(points.end(), inner.begin(), inner.end());
  return points;
}

test::TestMesh moved(test::TestMesh mesh, const std::function<Vec3d(const Vec3d&)>& to) {
  for (Vec3d& v : mesh.vertices)
    v = to(v);
  return mesh;
}

/// Turned upside down in its ids: the volume by VTK's rule is negative.
void turn_inside_out(test::MeshCell& cell) {
  auto& v = cell.vertices;
  switch (cell.shape) {
  case mesh::Shape::voxel:
  case mesh::Shape::hexahedron:
    std::swap_ranges(v.begin(), v.begin() + 4, v.begin() + 4);
    break;
  case mesh::Shape::wedge:
    std::swap_ranges(v.begin(), v.begin() + 3, v.begin() + 3);
    break;
  case mesh::Shape::pyramid:
    std::swap(v[1], v[3]);
    break;
  default:
    std::swap(v[0], v[1]);
  }
}

/// A second piece beside the first, of the same arrays' form.
void add_piece(fixtures::Committed& m, const fixtures::SolverArrays& arrays) {
  const insitu_array a = arrays.point_array();
  const insitu_cells c = arrays.cells();
  m.mesh.mesh().set_points(1, &a, 1);
  m.mesh.mesh().set_cells(1, &c);
  m.commit(INSITU_CHANGED_ALL);
}

} // namespace

TEST(HardMeshes, SliversNeedlesAndPancakes) {
  for (const auto kind : all_kinds)
    for (const Vec3d scale : {Vec3d{1, 1, 1e-12}, Vec3d{1e-6, 1e-6, 1}, Vec3d{1, 1, 1e-6},
                              Vec3d{1e-12, 1, 1}, Vec3d{1e5, 1e5, 1}}) {
      const fixtures::Committed m(box(kind, 3, 0.2, 0.0, scale));
      check_owners(m, points_of(m, 300, 31), std::string(kind_name(kind)) + " " + test::text(scale),
                   200);
    }
}

/// Cells of a box, bent over a hill: no coordinate plane separates thin layers any more.
TEST(HardMeshes, ThinLayersOverAHill) {
  for (const auto kind :
       {test::MeshKind::hexahedra, test::MeshKind::wedges, test::MeshKind::mixed}) {
    const fixtures::Committed m(moved(box(kind, 4, 0.2), [](const Vec3d& p) {
      return Vec3d{p.x, p.y, 1e-5 * p.z + std::sin(p.x) * std::cos(0.7 * p.y)};
    }));
    check_owners(m, points_of(m, 400, 32), kind_name(kind), 0);
  }
}

// The top of every layer is turned against its bottom. Up to a right angle a hexahedron of unit
// width has a positive Jacobian in places only; beyond, its sides pass through each other.
TEST(HardMeshes, TwistedAndNearlyFoldedHexahedra) {
  for (const double degrees : {30.0, 60.0, 80.0, 89.9, 90.0, 100.0}) {
    const double pi = 3.14159265358979323846;
    test::TestMesh one = box(test::MeshKind::hexahedra, 1, 0.0);
    const test::TestMesh twisted = moved(one, [&](const Vec3d& p) {
      const double a = p.z > 0.5 ? degrees * pi / 180 : 0.0, x = p.x - 0.5, y = p.y - 0.5;
      return Vec3d{std::cos(a) * x - std::sin(a) * y, std::sin(a) * x + std::cos(a) * y, p.z};
    });
    const fixtures::Committed m(twisted);
    std::vector<Vec3d> points = test::hard_points(m.mesh.mesh().view(), 1500, 33);
    check_owners(m, points, "twisted by " + std::to_string(degrees), 0);
  }
}

TEST(HardMeshes, InsideOut) {
  for (const auto kind : all_kinds) {
    test::TestMesh every = box(kind, 3), some = every;
    for (std::size_t c = 0; c < every.cells.size(); ++c) {
      turn_inside_out(every.cells[c]);
      if (c % 3 == 0)
        turn_inside_out(some.cells[c]);
    }
    for (const test::TestMesh* mesh : {&every, &some}) {
      const fixtures::Committed m(*mesh);
      EXPECT_FALSE(m.warnings.empty()) << kind_name(kind);
      check_owners(m, points_of(m, 400, 34), kind_name(kind));
    }
  }
}

// Every cell with vertices of its own: each face twice, by coordinates alone. The lowest id still
// owns.
TEST(HardMeshes, CoincidentVertices) {
  for (const auto kind : all_kinds) {
    const test::TestMesh from = box(kind, 3);
    test::TestMesh apart = from;
    apart.vertices.clear();
    for (test::MeshCell& cell : apart.cells)
      for (int i = 0; i < mesh::vertex_count(cell.shape); ++i) {
        apart.vertices.push_back(from.vertices[std::size_t(cell.vertices[std::size_t(i)])]);
        cell.vertices[std::size_t(i)] = int(apart.vertices.size()) - 1;
      }
    const fixtures::Committed whole(from), m(apart);
    const std::vector<Vec3d> points = points_of(whole, 600, 35);
    check_owners(m, points, kind_name(kind));
    for (const Vec3d& p : points)
      ASSERT_EQ(m.sampler().locate(p).cell, whole.sampler().locate(p).cell)
          << kind_name(kind) << ", point " << test::text(p);
  }
}

// Hexahedra that are wedges, pyramids and tetrahedra: edges collapsed in the ids.
TEST(HardMeshes, HexahedraThatAreOtherShapes) {
  for (const auto kind :
       {test::MeshKind::wedges, test::MeshKind::pyramids, test::MeshKind::tetrahedra}) {
    const test::TestMesh from = box(kind, 3);
    test::TestMesh as = from;
    for (test::MeshCell& cell : as.cells) {
      const auto v = cell.vertices;
      if (cell.shape == mesh::Shape::wedge)
        cell.vertices = {v[0], v[2], v[1], v[1], v[3], v[5], v[4], v[4]};
      else if (cell.shape == mesh::Shape::pyramid)
        cell.vertices = {v[0], v[1], v[2], v[3], v[4], v[4], v[4], v[4]};
      else
        cell.vertices = {v[0], v[1], v[2], v[2], v[3], v[3], v[3], v[3]};
      cell.shape = mesh::Shape::hexahedron;
    }
    const fixtures::Committed m(as), plain(from);
    const std::vector<Vec3d> points = points_of(plain, 600, 36);
    check_owners(m, points, kind_name(kind), 0);
    for (const Vec3d& p : points) { // collapsed, the cell is the same set of points
      const std::int64_t a = m.sampler().locate(p).cell, b = plain.sampler().locate(p).cell;
      ASSERT_EQ(a, b) << kind_name(kind) << ", point " << test::text(p);
    }
  }
}

// Two blocks of different widths of cells whose common boundary does not fit: a gap here, an
// overlap there. The rule holds cell by cell, and gaps and overlaps are the mesh's.
TEST(HardMeshes, GapsAndOverlapsBetweenBlocks) {
  for (const double off : {0.0, 1e-3, 1e-15}) {
    const test::TestMesh left = box(test::MeshKind::hexahedra, 4);
    const test::TestMesh right = moved(box(test::MeshKind::hexahedra, 3), [&](const Vec3d& p) {
      const double width = left.high.x - left.low.x;
      // Its left side waves about the right side of the other: beyond, upon and within.
      return Vec3d{left.high.x + p.x + (p.x == 0 ? off * std::sin(5 * p.y + 3 * p.z) * width : 0.0),
                   p.y * 4.0 / 3.0, p.z * 4.0 / 3.0};
    });
    fixtures::Committed m(left);
    const fixtures::SolverArrays second(right);
    add_piece(m, second);
    const mesh::MeshView& view = m.mesh.mesh().view();
    std::vector<Vec3d> points = points_of(m, 800, 37);
    test::Random random(38);
    for (int i = 0; i < 800; ++i) // near the common boundary
      points.push_back({left.high.x + random.uniform(-3, 3) * std::max(off, 1e-16),
                        random.uniform(left.low.y, left.high.y),
                        random.uniform(left.low.z, left.high.z)});
    int lost = 0, twice = 0;
    std::vector<query::Location> batch(points.size());
    m.sampler().locate(m.threads, points, batch, {INSITU_EXACT, 1.0});
    for (std::size_t i = 0; i < points.size(); ++i) {
      const std::int64_t expected = test::owner(view, points[i]);
      ASSERT_EQ(batch[i].cell, expected) << "off by " << off << ", " << test::text(points[i]);
      for (const std::int64_t hint : {std::int64_t(-1), expected, std::int64_t(0)}) {
        const query::Location standard = m.sampler().locate(points[i], hint);
        ASSERT_EQ(bool(standard), expected >= 0) << test::text(points[i]);
        twice += standard.cell != expected;
      }
      lost += expected < 0;
    }
    if (off == 1e-3) {
      EXPECT_GT(lost, 50) << "the case is what it is meant to be";
    }
    if (off == 0.0) {
      EXPECT_EQ(twice, 0);
    }
  }
}

TEST(HardMeshes, CoordinatesAtTheEdgeOfNumbers) {
  for (const auto kind : all_kinds)
    for (const double size : {1e-30, 1e30, 1e-37, 1e36}) {
      const fixtures::Committed m(box(kind, 3, 0.2, 0.0, {size, size, size}));
      check_owners(m, points_of(m, 200, 39), std::string(kind_name(kind)) + std::to_string(size),
                   0);
    }
}

// Below what float boxes can tell apart, down to denormal coordinates: either the mesh is refused
// with a message, or every answer is right.
TEST(HardMeshes, BeyondFloatAndDenormal) {
  for (const auto kind : all_kinds)
    for (const double size : {1e-45, 1e-100, 1e-300, 1e-312, 1e39, 1e100, 1e150}) {
      const std::string what = std::string(kind_name(kind)) + " of " + std::to_string(size);
      try {
        const fixtures::Committed m(box(kind, 3, 0.2, 0.0, {size, size, size}));
        check_owners(m, points_of(m, 100, 40), what, 0);
      } catch (const core::Error& e) {
        EXPECT_NE(std::string(e.what()).find("coordinate"), std::string::npos)
            << what << ": " << e.what();
      }
    }
}

TEST(HardMeshes, OneUnitInTheLastPlaceFromEveryFace) {
  for (const auto kind : all_kinds)
    for (const double offset : {0.0, 6.4e6}) {
      const fixtures::Committed m(box(kind, 3, 0.2, offset));
      const mesh::MeshView& view = m.mesh.mesh().view();
      test::Random random(41);
      std::vector<Vec3d> points;
      for (std::int64_t c = 0; c < view.cell_count(); ++c) {
        mesh::CellVertices cell;
        mesh::gather(view, c, cell);
        const cells::FaceTable table = cells::face_table(cell.shape);
        const cells::Face& face = table.faces[random.below(table.face_count)];
        const Vec3d on =
            test::face_point(face, cell.x, random.uniform(0, 0.5), random.uniform(0, 0.5));
        for (int axis = 0; axis < 3; ++axis)
          for (const double to : {-HUGE_VAL, HUGE_VAL}) {
            Vec3d p = on;
            p[axis] = std::nextafter(p[axis], to);
            points.push_back(p);
          }
        points.push_back(on);
      }
      check_owners(m, points, std::string(kind_name(kind)) + " at " + std::to_string(offset));
    }
}
