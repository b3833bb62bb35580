// Each point has the owner that the definition says, on every shape, at any offset and aspect.
#include "query_test.h"

using namespace insitu;
using math::Vec3d;
using test::all_kinds;
using test::box;
using test::check_owners;
using test::same_bits;

TEST(Owner, OfPointsWithinFacesEdgesAndVertices) {
  for (const auto kind : all_kinds) {
    const fixtures::Committed m(box(kind, 5));
    const mesh::MeshView& view = m.mesh.mesh().view();
    check_owners(m, test::inner_points(view, 1000, 1), kind_name(kind));
    check_owners(m, test::hard_points(view, 1500, 2), kind_name(kind));
  }
}

TEST(Owner, IsTheLowestCellOfAVertex) {
  for (const auto kind : all_kinds) {
    const fixtures::Committed m(box(kind, 4));
    std::vector<std::int64_t> lowest(std::size_t(m.arrays.vertex_count()), -1);
    for (std::int64_t c = m.arrays.cell_count(); c-- > 0;)
      for (std::int64_t i = m.arrays.offsets[std::size_t(c)];
           i < m.arrays.offsets[std::size_t(c) + 1]; ++i)
        lowest[std::size_t(m.arrays.ids[std::size_t(i)])] = c;
    for (std::size_t v = 0; v < lowest.size(); ++v) {
      const double* x = &m.arrays.points[3 * v];
      for (const auto accuracy : {INSITU_FAST, INSITU_STANDARD, INSITU_EXACT})
        ASSERT_EQ(m.sampler().locate({x[0], x[1], x[2]}, -1, {accuracy, 1.0}).cell, lowest[v])
            << kind_name(kind) << ", vertex " << v;
    }
  }
}

TEST(Owner, FarFromZeroAndOnThinCells) {
  for (const auto kind : all_kinds)
    for (const double offset : {0.0, 1e7, -3e7})
      for (const Vec3d scale : {Vec3d{1, 1, 1}, Vec3d{1e4, 1e4, 1}, Vec3d{1, 1e-4, 1e-4}}) {
        const fixtures::Committed m(box(kind, 3, 0.2, offset, scale));
        const std::string what = std::string(kind_name(kind)) + ", offset " +
                                 std::to_string(offset) + ", scale " + test::text(scale);
        check_owners(m, test::hard_points(m.mesh.mesh().view(), 400, 3), what, 200);
      }
}

TEST(Owner, OfFloatCoordinates) {
  for (const auto kind : all_kinds) {
    fixtures::Committed m;
    m.arrays = fixtures::SolverArrays(box(kind, 4, 0.2, 1000));
    std::vector<float> points(m.arrays.points.begin(), m.arrays.points.end());
    const insitu_array a =
        insitu_array_of(points.data(), INSITU_FLOAT32, m.arrays.vertex_count(), 3);
    const insitu_cells cells = m.arrays.cells();
    m.mesh.mesh().set_points(0, &a, 1);
    m.mesh.mesh().set_cells(0, &cells);
    m.commit();
    check_owners(m, test::hard_points(m.mesh.mesh().view(), 1000, 4), kind_name(kind));
  }
}

TEST(Owner, IsNobodyOneUlpOutside) {
  for (const auto kind : all_kinds)
    for (const double offset : {0.0, 1e7}) {
      const test::TestMesh from = box(kind, 4, 0.2, offset);
      const fixtures::Committed m(from);
      test::Random random(5);
      for (int i = 0; i < 600; ++i) {
        Vec3d p = random.uniform(from.low, from.high);
        const int axis = i % 3;
        const bool high = random.below(2) == 0;
        p[axis] = high ? from.high[axis] : from.low[axis]; // on the boundary
        const Vec3d outside = [&] {
          Vec3d q = p;
          q[axis] = std::nextafter(q[axis], high ? HUGE_VAL : -HUGE_VAL);
          return q;
        }();
        for (const auto accuracy : {INSITU_STANDARD, INSITU_EXACT}) {
          const query::LocateOptions options{accuracy, 1.0};
          ASSERT_TRUE(m.sampler().locate(p, -1, options)) << kind_name(kind) << test::text(p);
          ASSERT_FALSE(m.sampler().locate(outside, -1, options))
              << kind_name(kind) << test::text(outside);
        }
      }
      for (const double bad : {double(NAN), double(INFINITY), -double(INFINITY), 1e300, -1e38})
        for (int axis = 0; axis < 3; ++axis) {
          std::vector<Vec3d> points(3, 0.5 * (from.low + from.high));
          points[1][axis] = bad;
          std::vector<query::Location> found(3);
          m.sampler().locate(m.threads, points, found);
          EXPECT_TRUE(found[0] && found[2] && !found[1]);
          EXPECT_FALSE(m.sampler().locate(points[1]));
        }
    }
}

// Vertices moved up to 0.45 of a cell: the cells twist, and some fold. Nothing is lost, and exact
// answers are those of the definition, point by point.
TEST(Owner, OnTwistedCells) {
  for (const auto kind : {test::MeshKind::hexahedra, test::MeshKind::wedges, test::MeshKind::mixed})
    for (const double jitter : {0.4, 0.48}) {
      const test::TestMesh from = box(kind, 5, jitter);
      const fixtures::Committed m(from);
      const mesh::MeshView& view = m.mesh.mesh().view();
      std::vector<Vec3d> points = test::hard_points(view, 1500, 6);
      test::Random random(7);
      for (int i = 0; i < 1500; ++i)
        points.push_back(random.uniform(from.low, from.high));
      int differ = 0;
      std::vector<query::Location> batch(points.size());
      m.sampler().locate(m.threads, points, batch, {INSITU_EXACT, 1.0});
      for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec3d& p = points[i];
        const std::int64_t expected = test::owner(view, p);
        const bool in_domain = p.x >= from.low.x && p.x <= from.high.x && p.y >= from.low.y &&
                               p.y <= from.high.y && p.z >= from.low.z && p.z <= from.high.z;
        ASSERT_TRUE(expected >= 0 || !in_domain) << test::text(p);
        ASSERT_EQ(m.sampler().locate(p, -1, {INSITU_EXACT, 1.0}).cell, expected)
            << kind_name(kind) << ", jitter " << jitter << ", point " << test::text(p);
        ASSERT_EQ(batch[i].cell, expected)
            << kind_name(kind) << ", jitter " << jitter << ", point " << test::text(p);
        const query::Location standard = m.sampler().locate(p);
        ASSERT_EQ(bool(standard), expected >= 0) << test::text(p);
        differ += standard.cell != expected;
      }
      // Standard may name another cell that folds over the point.
      EXPECT_LE(differ, view.free_of_folds ? 0 : int(points.size()) / 100)
          << kind_name(kind) << ", jitter " << jitter;
      RecordProperty(kind_name(kind) + std::to_string(jitter), differ);
    }
}

// Edges that collapsed to a vertex, as in meshes that coarsen; some of the cells have no volume.
TEST(Owner, OnCollapsedCells) {
  test::Random random(8);
  test::MeshOptions options;
  options.kind = test::MeshKind::hexahedra;
  options.size = 5;
  options.jitter = 0;
  options.collapse = 0.15;
  for (const double jitter : {0.0, 0.15}) {
    options.jitter = jitter;
    const fixtures::Committed m(test::make_mesh(options, random));
    EXPECT_FALSE(m.warnings.empty());
    const mesh::MeshView& view = m.mesh.mesh().view();
    std::vector<Vec3d> points = test::hard_points(view, 1000, 9);
    const std::vector<Vec3d> inner = test::inner_points(view, 1000, 10);
    points.insert(points.end(), inner.begin(), inner.end());
    int differ = 0;
    std::vector<query::Location> batch(points.size());
    m.sampler().locate(m.threads, points, batch, {INSITU_EXACT, 1.0});
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vec3d& p = points[i];
      const std::int64_t expected = test::owner(view, p);
      const query::Location at = m.sampler().locate(p, -1, {INSITU_EXACT, 1.0}),
                            standard = m.sampler().locate(p);
      ASSERT_TRUE(same_bits(batch[i], at)) << "jitter " << jitter << ", point " << test::text(p);
      ASSERT_EQ(at.cell, expected) << "jitter " << jitter << ", point " << test::text(p);
      ASSERT_EQ(bool(standard), expected >= 0)
          << "jitter " << jitter << ", point " << test::text(p);
      differ += standard.cell != expected;
      if (expected < 0)
        continue;
      // Parametric coordinates are found by least squares where the map is singular.
      for (const query::Location& found : {at, standard}) {
        mesh::CellVertices cell;
        mesh::gather(view, found.cell, cell);
        const Vec3d e = cells::map_to_physical(cell.shape, cell.x, found.parametric) - p;
        ASSERT_LE(std::sqrt(dot(e, e)), 1e-7) << "jitter " << jitter << ", point " << test::text(p);
        for (int a = 0; a < 3; ++a) {
          ASSERT_GE(found.parametric[a], -1e-2);
          ASSERT_LE(found.parametric[a], 1.01);
        }
      }
    }
    // Near the singular edges Newton's parametric coordinates err by the root of rounding, so that
    // standard may miss that a cell of lower id touches the point.
    EXPECT_LE(differ, int(points.size()) / 50) << "jitter " << jitter;
  }
}

TEST(Owner, OfOneCellAndOfNone) {
  for (const auto shape : test::all_shapes) {
    test::TestMesh one;
    test::MeshCell cell{shape, {}};
    for (int v = 0; v < mesh::vertex_count(shape); ++v) {
      one.vertices.push_back(test::unit_cell(shape)[std::size_t(v)]);
      cell.vertices[std::size_t(v)] = v;
    }
    one.cells.push_back(cell);
    const fixtures::Committed m(one);
    test::Random random(11);
    std::vector<Vec3d> points;
    for (int i = 0; i < 1000; ++i)
      points.push_back(test::adversarial_point(shape, one.vertices.data(), random, i % 2 == 0));
    check_owners(m, points, mesh::shape_name(shape));
  }
  fixtures::Committed none;
  none.commit();
  EXPECT_FALSE(none.sampler().locate({0, 0, 0}));
  std::vector<query::Location> found(2, query::Location{3, {}});
  const std::vector<Vec3d> points(2);
  none.sampler().locate(none.threads, points, found);
  EXPECT_FALSE(found[0] || found[1]);
  none.sampler().locate(none.threads, {}, {});
}
