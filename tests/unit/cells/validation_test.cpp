// Every kind of finding: which cell, what was expected, how many; the same for any thread count.
#include <gtest/gtest.h>

#include "cells/checks/validate.h"
#include "core/status.h"
#include "fixtures/committed.h"

using namespace insitu;
using math::Vec3d;
using mesh::Shape;

namespace {

constexpr std::int64_t cells_a_side = 22; // 10,648 cells: several chunks

/// Hexahedra whose arrays a test spoils.
struct Spoiled : fixtures::Committed {
  explicit Spoiled(int thread_limit = 0, test::MeshKind kind = test::MeshKind::hexahedra)
      : Committed(
            [kind] {
              test::Random random(31);
              test::MeshOptions options;
              options.kind = kind;
              options.size = kind == test::MeshKind::mixed ? 6 : int(cells_a_side);
              options.jitter = 0.1;
              return test::make_mesh(options, random);
            }(),
            thread_limit) {}
  cells::Validation validate() { return mesh.validate(threads); }
  void use(const insitu_cells& cells) { mesh.mesh().set_cells(0, &cells); }
};

void expect_in(const std::string& text, const std::string& message) {
  EXPECT_NE(message.find(text), std::string::npos) << message;
}

} // namespace

TEST(Validation, AcceptsAGoodMesh) {
  for (const auto kind : {test::MeshKind::hexahedra, test::MeshKind::mixed}) {
    Spoiled m(0, kind);
    const cells::Validation v = m.validate();
    EXPECT_EQ(v.counts.cells, m.arrays.cell_count());
    EXPECT_EQ(v.findings, "");
    EXPECT_EQ(v.warning, "");
    EXPECT_TRUE(m.warnings.empty());
  }
}

TEST(Validation, NamesTheFirstBadIdWhateverTheThreads) {
  std::string first;
  for (const int threads : {1, 2, 4}) {
    Spoiled m(threads);
    for (const std::size_t cell : {9000u, 123u, 5000u, 8500u, 123u, 10647u})
      m.arrays.ids[8 * cell + 3] = cell == 5000 ? -7 : std::int32_t(m.arrays.vertex_count());
    m.arrays.points[3 * std::size_t(m.arrays.ids[8 * 2535])] = NAN; // an inner vertex
    const cells::Validation v = m.validate();
    EXPECT_EQ(v.counts.index_errors, 5);
    EXPECT_EQ(v.counts.coordinate_errors, 8);
    expect_in("mesh 'test', piece 0, cell 123: vertex 3 has id 12167, 0 to 12166 expected",
              v.findings.substr(0, v.findings.find('\n')));
    expect_in("13 cells with errors in all", v.findings);
    if (first.empty())
      first = v.findings;
    EXPECT_EQ(v.findings, first);
  }
}

TEST(Validation, IdsCountFromTheirBase) {
  Spoiled m;
  insitu_cells cells = m.arrays.cells();
  cells.index_base = 1; // so id 0 is out of range
  m.use(cells);
  const cells::Validation v = m.validate();
  EXPECT_EQ(v.counts.index_errors, 1);
  expect_in("cell 0: vertex 0 has id 0, 1 to 12167 expected", v.findings);
}

TEST(Validation, SurvivesTheEndsOfTheNumberRange) {
  Spoiled m;
  std::vector<std::int64_t> ids(m.arrays.ids.begin(), m.arrays.ids.end());
  ids[8 * 5] = INT64_MIN;
  ids[8 * 6] = INT64_MAX;
  insitu_cells cells = m.arrays.cells();
  cells.connectivity = insitu_array_of(ids.data(), INSITU_INT64, cells.count, 8);
  for (const int base : {0, 1}) {
    cells.index_base = base;
    m.use(cells);
    const cells::Validation v = m.validate();
    EXPECT_EQ(v.counts.index_errors, 2 + base);
    expect_in("cell 5: vertex 0 has id -9223372036854775808", v.findings);
    expect_in("cell 6: vertex 0 has id 9223372036854775807", v.findings);
  }
}

TEST(Validation, NamesCoordinatesThatAreNotFinite) {
  Spoiled m;
  const auto vertex = std::size_t(m.arrays.ids[8 * 77 + 6]);
  m.arrays.points[3 * vertex + 2] = -INFINITY;
  const cells::Validation v = m.validate();
  EXPECT_EQ(v.counts.coordinate_errors, 8);
  expect_in("vertex id " + std::to_string(vertex) + ": coordinate z is infinite", v.findings);
  EXPECT_THROW(m.commit(INSITU_CHANGED_GEOMETRY), core::Error);
  m.arrays.points[3 * vertex + 2] = 1.0;
  EXPECT_EQ(m.commit().action, INSITU_REFIT) << "of the mesh as it is now";
}

TEST(Validation, DoesNotLookAtCoordinatesThatNoCellUses) {
  fixtures::Committed m;
  test::Random random(31);
  m.arrays = fixtures::SolverArrays(test::make_mesh({}, random));
  m.arrays.points.insert(m.arrays.points.end(), {NAN, NAN, NAN}); // an unused slot of the solver
  const insitu_array points = m.arrays.point_array();
  const insitu_cells cells = m.arrays.cells();
  m.mesh.mesh().set_points(0, &points, 1);
  m.mesh.mesh().set_cells(0, &cells);
  EXPECT_EQ(m.mesh.validate(m.threads).findings, "");
  m.commit();
  EXPECT_TRUE(m.sampler().locate({1.5, 1.5, 1.5}));
}

TEST(Validation, DoesNotReadGhostCells) {
  Spoiled m;
  std::vector<std::uint8_t> ghosts(std::size_t(m.arrays.cell_count()), 0);
  for (const std::size_t cell : {0u, 4096u, 10647u}) {
    ghosts[cell] = 1;
    for (std::size_t v = 0; v < 8; ++v)
      m.arrays.ids[8 * cell + v] = v % 2 ? INT32_MAX : INT32_MIN;
  }
  const insitu_array bits = insitu_array_of(ghosts.data(), INSITU_UINT8, m.arrays.cell_count(), 1);
  m.mesh.mesh().set_ghosts(0, &bits, INSITU_GHOSTS_VTK);
  const cells::Validation v = m.validate();
  EXPECT_EQ(v.findings, "");
  EXPECT_EQ(v.counts.ghost_cells, 3);
  m.commit();
  m.commit(INSITU_CHANGED_GEOMETRY);
  // All are ghosts: nothing is read, nothing is found, nothing fails.
  std::fill(ghosts.begin(), ghosts.end(), 1);
  m.arrays.ids.assign(m.arrays.ids.size(), -1);
  EXPECT_EQ(m.commit(INSITU_CHANGED_TOPOLOGY).action, INSITU_REBUILD);
  EXPECT_TRUE(m.mesh.tree().empty());
  EXPECT_EQ(m.commit(INSITU_CHANGED_GEOMETRY).cells, m.arrays.cell_count());
  std::vector<Vec3d> points(3, Vec3d{0.5, 0.5, 0.5});
  std::vector<query::Location> found(3, query::Location{5, {}});
  m.sampler().locate(m.threads, points, found);
  EXPECT_FALSE(found[0] || found[1] || found[2] || m.sampler().locate(points[0]));
}

TEST(Validation, ChecksTypesAndOffsets) {
  const auto findings = [](auto&& spoil, std::int64_t errors, int base = 0, bool n_plus_1 = true) {
    Spoiled m(0, test::MeshKind::mixed);
    std::vector<std::int64_t> ids(m.arrays.ids.begin(), m.arrays.ids.end());
    for (std::int64_t& id : ids)
      id += base;
    for (std::int64_t& o : m.arrays.offsets)
      o += base;
    spoil(m.arrays);
    insitu_cells cells = m.arrays.cells();
    cells.index_base = base;
    cells.connectivity = insitu_array_of(ids.data(), INSITU_INT64, std::int64_t(ids.size()), 1);
    cells.offsets.count = m.arrays.cell_count() + n_plus_1;
    m.use(cells);
    const cells::Validation v = m.validate();
    EXPECT_EQ(v.counts.shape_errors, errors) << v.findings;
    EXPECT_EQ(v.counts.index_errors + v.counts.coordinate_errors, 0) << v.findings;
    return v.findings;
  };
  using Arrays = fixtures::SolverArrays;
  for (const int base : {0, 1})
    for (const bool n_plus_1 : {false, true})
      EXPECT_EQ(findings([](Arrays&) {}, 0, base, n_plus_1), "");
  expect_in("cell 3: type 15, 10 to 14 expected", findings([](Arrays& a) { a.types[3] = 15; }, 1));
  expect_in("cell 3: type 255", findings([](Arrays& a) { a.types[3] = 255; }, 1));
  // The last cell, by n + 1 offsets only.
  const auto spoil_last = [](Arrays& a) { a.offsets.back() += 1; };
  expect_in("ids between its offsets", findings(spoil_last, 1));
  EXPECT_EQ(findings(spoil_last, 0, 0, false), "");
  // One start moved: the cell before and the cell itself do not fit.
  expect_in("cell 6: ", findings([](Arrays& a) { a.offsets[7] += 1; }, 2));
  expect_in("cell 7: its", findings([](Arrays& a) { a.offsets[7] = -1; }, 2));
  expect_in("start at 9223372036854775807",
            findings([](Arrays& a) { a.offsets[7] = INT64_MAX; }, 2));
  expect_in("start at -9223372036854775808",
            findings([](Arrays& a) { a.offsets[7] = INT64_MIN; }, 2, 1));
  expect_in("start at 0 of", findings([](Arrays& a) { a.offsets[0] = 0; }, 1, 1));
}

TEST(Validation, ChecksThePadding) {
  const auto check = [](std::vector<std::int64_t> ids, int base) {
    Spoiled m;
    insitu_cells cells = insitu_cells_default();
    cells.layout = INSITU_LAYOUT_PADDED;
    cells.count = 1;
    cells.index_base = base;
    cells.connectivity = insitu_array_of(ids.data(), INSITU_INT64, 1, 8);
    m.use(cells);
    const cells::Validation v = m.validate();
    EXPECT_EQ(v.counts.shape_errors, v.findings.empty() ? 0 : 1);
    return v.findings;
  };
  const std::int64_t none = -1;
  EXPECT_EQ(check({0, 1, 24, 23, none, none, none, none}, 0), "");
  EXPECT_EQ(check({1, 2, 25, 24, none, none, none, none}, 1), "");
  expect_in("3 ids before the padding", check({0, 1, 2, none, none, none, none, none}, 0));
  expect_in("7 ids before the padding", check({0, 1, 2, 3, 4, 5, 6, none}, 0));
  expect_in("0 ids before the padding", check({none, 1, 2, 3, 4, 5, 6, 7}, 0));
  expect_in("place 5 holds 9, -1 expected after its 4 ids",
            check({0, 1, 2, 3, none, 9, none, none}, 0));
  expect_in("place 4 holds 0, -1 expected", check({1, 2, 25, 24, 0, none, none, none}, 1));
  expect_in("place 4 holds -2", check({0, 1, 24, 23, -2, none, none, none}, 0));
  expect_in("place 4 holds -9223372036854775808",
            check({0, 1, 24, 23, INT64_MIN, none, none, none}, 0));
}

namespace {

insitu_validation shape_counts(Shape shape, auto&& change) {
  fixtures::Committed m;
  test::TestMesh one;
  const test::Vertices corners = test::unit_cell(shape);
  test::MeshCell cell{shape, {}};
  for (int v = 0; v < mesh::vertex_count(shape); ++v) {
    one.vertices.push_back(corners[std::size_t(v)]);
    cell.vertices[std::size_t(v)] = v;
  }
  one.cells.push_back(cell);
  change(one.vertices);
  m.arrays = fixtures::SolverArrays(one);
  const insitu_array points = m.arrays.point_array();
  const insitu_cells cells = m.arrays.cells();
  m.mesh.mesh().set_points(0, &points, 1);
  m.mesh.mesh().set_cells(0, &cells);
  return m.mesh.validate(m.threads).counts;
}

} // namespace

TEST(Validation, CountsOddCells) {
  using Points = std::vector<Vec3d>;
  for (const Shape shape : test::all_shapes) {
    SCOPED_TRACE(mesh::shape_name(shape));
    const auto odd = [&](auto&& change) {
      const insitu_validation c = shape_counts(shape, change);
      return std::array<std::int64_t, 4>{c.inverted_cells, c.zero_volume_cells, c.folded_cells,
                                         c.collapsed_cells};
    };
    using Counts = std::array<std::int64_t, 4>;
    EXPECT_EQ(odd([](Points&) {}), (Counts{0, 0, 0, 0}));
    EXPECT_EQ(odd([](Points& x) {
                for (Vec3d& p : x)
                  p.z = -p.z;
              }),
              (Counts{1, 0, 0, 0}));
    EXPECT_EQ(odd([](Points& x) {
                for (Vec3d& p : x)
                  p.z = 0.25 * p.x + 0.5 * p.y;
              })[1],
              1);
    EXPECT_EQ(odd([](Points& x) { x.assign(x.size(), Vec3d{1, 2, 3}); }), (Counts{0, 1, 0, 1}));
    // Sheets and needles have a volume, at any offset and size that doubles resolve.
    for (const double scale : {1e-30, 1.0, 1e30})
      for (const Vec3d thin : {Vec3d{1, 1, 1e-9}, Vec3d{1e-8, 1, 1e-8}})
        EXPECT_EQ(odd([&](Points& x) {
                    for (Vec3d& p : x)
                      p = scale * Vec3d{p.x * thin.x, p.y * thin.y, p.z * thin.z};
                  }),
                  (Counts{0, 0, 0, 0}))
            << scale;
  }
  const insitu_validation folded = shape_counts(Shape::hexahedron, [](Points& x) {
    x[6] = {-0.5, -0.5, 0.5};
  });
  EXPECT_EQ(folded.folded_cells, 1);
  const insitu_validation collapsed =
      shape_counts(Shape::hexahedron, [](Points& x) { x[7] = x[4]; });
  EXPECT_EQ(collapsed.collapsed_cells, 1);
  EXPECT_EQ(collapsed.zero_volume_cells, 0);
}

TEST(Validation, WarnsInOneLineAndGoesOn) {
  Spoiled m;
  std::swap(m.arrays.ids[0], m.arrays.ids[4]);
  m.commit(INSITU_CHANGED_TOPOLOGY);
  ASSERT_EQ(m.warnings.size(), 1u);
  expect_in("of 10648 cells", m.warnings[0]);
  expect_in("1 are folded", m.warnings[0]);
}

TEST(Validation, SaysWhatCoordinatesOf32BitsLose) {
  for (const double offset : {0.0, 1e5}) {
    for (const bool is_float : {false, true}) {
      fixtures::Committed m(test::make_mesh(
          {.kind = test::MeshKind::hexahedra, .size = 4, .jitter = 0.1, .offset = offset}, 7));
      const std::vector<float> points(m.arrays.points.begin(), m.arrays.points.end());
      const insitu_array a =
          insitu_array_of(points.data(), INSITU_FLOAT32, m.arrays.vertex_count(), 3);
      if (is_float)
        m.mesh.mesh().set_points(0, &a, 1);
      // The first cell is a ghost, whose ids nobody looks at.
      std::vector<std::uint8_t> flags(std::size_t(m.arrays.cell_count()), 0);
      flags[0] = 1;
      m.arrays.ids[0] = 1 << 30;
      const insitu_array bits =
          insitu_array_of(flags.data(), INSITU_UINT8, m.arrays.cell_count(), 1);
      m.mesh.mesh().set_ghosts(0, &bits, INSITU_GHOSTS_VTK);
      m.commit(INSITU_CHANGED_TOPOLOGY);
      ASSERT_EQ(m.warnings.size(), is_float && offset > 0 ? 1u : 0u) << offset;
      if (!m.warnings.empty()) // 1e5 2^-24 is 0.006, of cells about 1 wide
        expect_in(" reaches 1e+05 in 32 bits, so that vertices are rounded by up to 0.006, 0.",
                  m.warnings[0]);
    }
  }
}
