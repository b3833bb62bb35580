// The same answer, bit for bit, however it is asked for and however the mesh is given.
#include "query_test.h"

using namespace insitu;
using math::Vec3d;
using test::all_kinds;
using test::box;
using test::same_bits;

namespace {

std::vector<query::Location> locate_all(const fixtures::Committed& m,
                                        const std::vector<Vec3d>& points,
                                        const query::LocateOptions& options = {}) {
  std::vector<query::Location> found(points.size());
  m.sampler().locate(m.threads, points, found, options);
  return found;
}

void expect_same(const std::vector<query::Location>& a, const std::vector<query::Location>& b,
                 const std::vector<Vec3d>& points, const std::string& what) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i)
    ASSERT_TRUE(same_bits(a[i], b[i])) << what << ", point " << i << " " << test::text(points[i])
                                       << ": cells " << a[i].cell << " " << b[i].cell;
}

std::vector<Vec3d> many_points(const fixtures::Committed& m, int count) {
  const mesh::MeshView& view = m.mesh.mesh().view();
  std::vector<Vec3d> points = test::hard_points(view, count / 2, 21);
  const std::vector<Vec3d> inner = test::inner_points(view, count / 2, 22);
  points.insert(points.end(), inner.begin(), inner.end());
  for (std::size_t i = 0; i < points.size(); i += 7)
    points[i].x += 100; // outside
  return points;
}

} // namespace

TEST(SameAnswers, ForAnyThreadCountBatchAndHint) {
  for (const auto kind : all_kinds)
    for (const auto accuracy : {INSITU_STANDARD, INSITU_EXACT}) {
      const test::TestMesh from = box(kind, 8);
      const query::LocateOptions options{accuracy, 1.0};
      std::vector<query::Location> first;
      for (const int threads : {1, 2, 4}) {
        const fixtures::Committed m(from, threads);
        const std::vector<Vec3d> points = many_points(m, 10000);
        const std::vector<query::Location> found = locate_all(m, points, options);
        if (first.empty())
          first = found;
        expect_same(found, first, points, kind_name(kind));
        if (threads > 1)
          continue;
        std::vector<query::Location> other(points.size());
        m.sampler().locate_serial(points, other, options);
        expect_same(other, first, points, "one batch");
        for (std::size_t i = 0; i < points.size(); i += 37) // batches of other sizes
          m.sampler().locate_serial(
              std::span(points).subspan(i, std::min<std::size_t>(37, points.size() - i)),
              std::span(other).subspan(i, std::min<std::size_t>(37, points.size() - i)), options);
        expect_same(other, first, points, "batches of 37");
        test::Random random(23);
        for (std::size_t i = 0; i < points.size(); ++i) {
          const std::int64_t hints[] = {-1,
                                        found[i].cell,
                                        i ? found[i - 1].cell : -1,
                                        random.below(int(m.arrays.cell_count())),
                                        m.arrays.cell_count(),
                                        INT64_MAX};
          for (const std::int64_t hint : hints)
            ASSERT_TRUE(same_bits(m.sampler().locate(points[i], hint, options), found[i]))
                << kind_name(kind) << ", hint " << hint << ", point " << i;
        }
      }
    }
}

TEST(SameAnswers, StandardAndExactWhereNothingOverlaps) {
  for (const auto kind : all_kinds) {
    const fixtures::Committed m(box(kind, 8));
    const std::vector<Vec3d> points = many_points(m, 6000);
    expect_same(locate_all(m, points, {INSITU_STANDARD, 1.0}),
                locate_all(m, points, {INSITU_EXACT, 1.0}), points, kind_name(kind));
  }
}

// Standard may answer any of the cells, but always the same one; exact answers the lowest.
TEST(SameAnswers, WhereCellsOverlapWithoutFolding) {
  for (const auto kind : all_kinds) {
    test::TestMesh twice = box(kind, 5);
    const auto vertices = int(twice.vertices.size());
    const std::size_t cells = twice.cells.size();
    for (int v = 0; v < vertices; ++v)
      twice.vertices.push_back(twice.vertices[std::size_t(v)] + Vec3d{0.3, 0.4, 0.2});
    for (std::size_t c = 0; c < cells; ++c) {
      test::MeshCell copy = twice.cells[c];
      for (int& v : copy.vertices)
        v = v >= 0 ? v + vertices : v;
      twice.cells.push_back(copy);
    }
    int others = 0;
    std::vector<query::Location> first;
    for (const int threads : {1, 4}) {
      const fixtures::Committed m(twice, threads);
      const mesh::MeshView& view = m.mesh.mesh().view();
      const std::vector<Vec3d> points = many_points(m, 4000);
      const std::vector<query::Location> found = locate_all(m, points);
      if (first.empty())
        first = found;
      expect_same(found, first, points, kind_name(kind));
      if (threads > 1)
        continue;
      const std::vector<query::Location> exact = locate_all(m, points, {INSITU_EXACT, 1.0});
      std::vector<query::Location> one(1);
      for (std::size_t i = 0; i < points.size(); ++i) {
        ASSERT_EQ(exact[i].cell, test::owner(view, points[i])) << kind_name(kind) << ", " << i;
        ASSERT_TRUE(same_bits(m.sampler().locate(points[i]), found[i]))
            << kind_name(kind) << ", alone, point " << i << " " << test::text(points[i]);
        m.sampler().locate_serial(std::span(points).subspan(i, 1), one);
        ASSERT_TRUE(same_bits(one[0], found[i])) << kind_name(kind) << ", batch of one, " << i;
        if (found[i].cell == exact[i].cell)
          continue;
        ++others;
        mesh::CellVertices cell;
        ASSERT_GE(found[i].cell, 0) << kind_name(kind) << ", point " << i;
        mesh::gather(view, found[i].cell, cell);
        ASSERT_EQ(cells::contain_exact(cell.shape, cell.x, points[i]).where,
                  cells::Containment::inside)
            << kind_name(kind) << ", point " << i;
      }
    }
    if (kind != test::MeshKind::tetrahedra) {
      EXPECT_GT(others, 100) << kind_name(kind) << ": the case is not there";
    }
  }
}

// Hints must not bring back a cell that owns nothing, nor one under a fold that came later.
TEST(SameAnswers, WhateverTheHintAndWhateverMoves) {
  fixtures::Committed m(box(test::MeshKind::hexahedra, 5, 0.1));
  std::vector<std::uint8_t> ghosts(std::size_t(m.arrays.cell_count()), 0);
  ghosts[62] = 1;
  const insitu_array bits = insitu_array_of(ghosts.data(), INSITU_UINT8, m.arrays.cell_count(), 1);
  m.mesh.mesh().set_ghosts(0, &bits, INSITU_GHOSTS_VTK);
  m.commit();
  EXPECT_FALSE(m.sampler().locate({2.5, 2.5, 2.5}, 62));
  m.mesh.mesh().set_ghosts(0, nullptr, INSITU_GHOSTS_VTK);
  m.commit();
  ASSERT_EQ(m.sampler().locate({2.5, 2.5, 2.5}, 62).cell, 62);
  // The middle vertex of two cells goes far into the next cells: they fold.
  const std::size_t vertex = 3 * (2 + 6 * (2 + 6 * 2));
  m.arrays.points[vertex] += 1.4;
  ASSERT_EQ(m.commit(INSITU_CHANGED_GEOMETRY).action, INSITU_REFIT);
  const mesh::MeshView& view = m.mesh.mesh().view();
  const std::vector<Vec3d> points = test::inner_points(view, 2000, 24);
  int folded = 0;
  for (const bool looked : {false, true}) {
    if (looked)
      m.mesh.look_for_folds(m.threads);
    EXPECT_EQ(m.mesh.tree().odd().empty(), !looked);
    for (const Vec3d& p : points) {
      const query::Location plain = m.sampler().locate(p);
      for (std::int64_t hint = 0; hint < view.cell_count(); ++hint) {
        mesh::CellVertices cell;
        mesh::gather(view, hint, cell);
        const auto map = cells::inverse_map(cell.shape, cell.x, p);
        if (!map.converged || map.margin < 0)
          continue; // only cells that might answer
        folded += hint != plain.cell;
        ASSERT_TRUE(same_bits(m.sampler().locate(p, hint), plain))
            << "hint " << hint << ", point " << test::text(p);
      }
    }
    EXPECT_FALSE(view.free_of_folds);
  }
  EXPECT_GT(folded, 0) << "the mesh should have folded";
  m.arrays.points[vertex] -= 1.4; // and back
  m.commit(INSITU_CHANGED_GEOMETRY);
  m.mesh.look_for_folds(m.threads);
  EXPECT_TRUE(view.free_of_folds);
}

// Commits look for folds by themselves where many points are asked, and the answers stay.
TEST(SameAnswers, AfterCommitsThatLookForFolds) {
  for (const auto kind : {test::MeshKind::hexahedra, test::MeshKind::tetrahedra}) {
    fixtures::Committed m(box(kind, 6));
    const mesh::MeshView& view = m.mesh.mesh().view();
    const auto many = int(3 * view.cell_count());
    for (const bool ask_many : {false, true}) {
      const std::vector<Vec3d> points = test::inner_points(view, ask_many ? many : 100, 26);
      locate_all(m, points);
      for (std::size_t i = 2; i < m.arrays.points.size(); i += 3)
        m.arrays.points[i] += 0.01; // up
      ASSERT_EQ(m.commit(INSITU_CHANGED_GEOMETRY).action, INSITU_REFIT);
      EXPECT_EQ(view.free_of_folds, ask_many && kind == test::MeshKind::hexahedra)
          << kind_name(kind);
      const std::vector<Vec3d> asked = many_points(m, 2000);
      const std::vector<query::Location> found = locate_all(m, asked);
      for (std::size_t i = 0; i < asked.size(); ++i)
        ASSERT_EQ(found[i].cell, test::owner(view, asked[i])) << kind_name(kind) << ", " << i;
    }
    // A vertex of the inside goes far into the next cells.
    const std::vector<Vec3d> points = test::inner_points(view, many, 27);
    locate_all(m, points);
    m.arrays.points[3 * (3 + 7 * (3 + 7 * 3))] += 1.4;
    ASSERT_EQ(m.commit(INSITU_CHANGED_GEOMETRY).action, INSITU_REFIT);
    EXPECT_FALSE(view.free_of_folds);
    const std::vector<Vec3d> asked = many_points(m, 2000);
    const std::vector<query::Location> found = locate_all(m, asked);
    for (std::size_t i = 0; i < asked.size(); ++i)
      ASSERT_EQ(found[i].cell, test::owner(view, asked[i])) << kind_name(kind) << ", " << i;
  }
}

// Few folded, flat or turned cells do not take the certificates from the others; many do.
TEST(SameAnswers, BesideAFewOddCells) {
  int few = 0;
  for (const double reach : {0.30, 0.33, 0.45}) {
    fixtures::Committed m(box(test::MeshKind::hexahedra, 12, reach));
    const mesh::MeshView& view = m.mesh.mesh().view();
    const cells::Validation v = m.mesh.validate(m.threads);
    m.commit();
    const std::int64_t odd = v.counts.folded_cells + v.counts.zero_volume_cells;
    const cells::OddCells found = cells::find_odd_cells(view, m.threads);
    EXPECT_EQ(found.few, odd <= cells::OddCells::most) << odd;
    few += found.few && odd > 0;
    EXPECT_EQ(std::int64_t(found.ids.size()), found.few ? odd : 0);
    EXPECT_EQ(found.ids, cells::find_odd_cells(view, v.counts, m.threads).ids);
    std::vector<Vec3d> asked = many_points(m, 3000);
    for (const std::int64_t id : found.ids) { // in and about them
      mesh::CellVertices cell;
      mesh::gather(view, id, cell);
      for (int i = 0; i < 100; ++i) {
        double r[3];
        for (int a = 0; a < 3; ++a)
          r[a] = 1.4 * core::random_unit(28, std::uint64_t(i), std::uint64_t(a)) - 0.2;
        Vec3d p;
        for (int corner = 0; corner < 8; ++corner) {
          constexpr int at[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                    {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
          double w = 1;
          for (int a = 0; a < 3; ++a)
            w *= at[corner][a] ? r[a] : 1 - r[a];
          p += w * cell.x[corner];
        }
        asked.push_back(p);
      }
    }
    const std::vector<query::Location> batch = locate_all(m, asked);
    for (std::size_t i = 0; i < asked.size(); ++i) {
      const std::int64_t owner = test::owner(view, asked[i]);
      ASSERT_EQ(batch[i].cell, owner) << "reach " << reach << ", " << i;
      ASSERT_EQ(m.sampler().locate(asked[i]).cell, owner) << "reach " << reach << ", " << i;
      ASSERT_EQ(m.sampler().locate(asked[i], owner).cell, owner) << "reach " << reach << ", " << i;
    }
  }
  EXPECT_GT(few, 0);
}

TEST(SameAnswers, ForABlockAndForItsHexahedra) {
  const test::TestMesh from = box(test::MeshKind::hexahedra, 6, 0.3, -2);
  const fixtures::Committed unstructured(from);
  fixtures::Committed block;
  block.arrays = fixtures::SolverArrays(from);
  insitu_block b = insitu_block_default();
  for (std::int64_t& n : b.vertices)
    n = 7;
  const insitu_array points = block.arrays.point_array();
  block.mesh.mesh().set_block(0, &b);
  block.mesh.mesh().set_points(0, &points, 1);
  // The block's number of each hexahedron, which come in another order.
  std::vector<std::int64_t> block_id;
  for (const test::MeshCell& cell : from.cells) {
    const std::int64_t v = cell.vertices[0];
    block_id.push_back(v % 7 + 6 * (v / 7 % 7 + 6 * (v / 49)));
  }
  block.commit();
  const std::vector<Vec3d> at = many_points(unstructured, 6000);
  std::vector<query::Location> a = locate_all(unstructured, at), c = locate_all(block, at);
  for (std::size_t i = 0; i < at.size(); ++i) {
    ASSERT_EQ(bool(a[i]), bool(c[i])) << test::text(at[i]);
    const std::int64_t lowest = test::owner(block.mesh.mesh().view(), at[i]);
    ASSERT_EQ(c[i].cell, lowest);
    if (a[i] && block_id[std::size_t(a[i].cell)] == c[i].cell) {
      ASSERT_EQ(std::memcmp(&a[i].parametric, &c[i].parametric, 24), 0) << i;
    }
  }
  // In the block's own order of cells, everything is equal.
  test::TestMesh ordered = from;
  for (std::size_t i = 0; i < from.cells.size(); ++i)
    ordered.cells[std::size_t(block_id[i])] = from.cells[i];
  const fixtures::Committed same(ordered);
  expect_same(locate_all(same, at), c, at, "hexahedra of a block");
  std::vector<double> field(same.arrays.points.size());
  for (std::size_t i = 0; i < field.size(); ++i)
    field[i] = std::sin(double(i));
  const insitu_array f = insitu_array_of(field.data(), INSITU_FLOAT64, 343, 3);
  fixtures::Committed with_field(ordered);
  for (fixtures::Committed* m : {&with_field, &block}) {
    m->mesh.mesh().set_field(0, "f", INSITU_VERTEX, &f, 1);
    m->commit();
  }
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (!c[i])
      continue;
    double u[3], v[3];
    with_field.sampler().interpolate(with_field.mesh.mesh().field("f"), c[i], u);
    block.sampler().interpolate(block.mesh.mesh().field("f"), c[i], v);
    ASSERT_EQ(std::memcmp(u, v, sizeof u), 0);
  }
}

TEST(SameAnswers, ForOnePieceAndForSeveral) {
  for (const auto kind : all_kinds) {
    const test::TestMesh from = box(kind, 5);
    const fixtures::Committed one(from);
    fixtures::Committed several;
    const auto n = from.cells.size();
    const std::size_t cuts[] = {0, n / 5, n / 5, n / 2, n}; // the second piece is empty
    std::vector<fixtures::SolverArrays> parts;
    for (int p = 0; p < 4; ++p) {
      test::TestMesh part = from;
      part.cells.assign(from.cells.begin() + std::ptrdiff_t(cuts[p]),
                        from.cells.begin() + std::ptrdiff_t(cuts[p + 1]));
      parts.emplace_back(part);
    }
    for (std::int32_t p = 0; p < 4; ++p) {
      const insitu_array points = parts[std::size_t(p)].point_array();
      const insitu_cells cells = parts[std::size_t(p)].cells();
      several.mesh.mesh().set_points(p, &points, 1);
      several.mesh.mesh().set_cells(p, &cells);
    }
    several.commit();
    const std::vector<Vec3d> points = many_points(one, 4000);
    expect_same(locate_all(several, points), locate_all(one, points), points, kind_name(kind));
    EXPECT_EQ(several.mesh.mesh().view().piece_of(std::int64_t(n / 5)), 2);
  }
}

TEST(SameAnswers, ForEitherBuilder) {
  for (const auto kind : all_kinds) {
    const test::TestMesh from = box(kind, 6);
    const fixtures::Committed morton(from, 2, accel::Builder::morton),
        surface_area(from, 2, accel::Builder::surface_area);
    const std::vector<Vec3d> points = many_points(morton, 4000);
    expect_same(locate_all(morton, points), locate_all(surface_area, points), points,
                kind_name(kind));
  }
}
