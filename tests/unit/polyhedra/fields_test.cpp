// Values on cells given by faces: linear fields are met, values of cells are the solver's, and
// vertices that move move the centres.
#include "../query/query_test.h"
#include "fixtures/poly_dual.h"
#include "fixtures/subdivided.h"

using namespace insitu;
using fixtures::CommittedFaces;
using fixtures::FaceMesh;
using math::Vec3d;
using test::Random;

namespace {

double linear(const Vec3d& x) {
  return 3.0 + 0.5 * x.x - 2.0 * x.y + 1.25 * x.z;
}

void give(CommittedFaces& m, const std::string& name, insitu_association of,
          const std::vector<double>& values, int components = 1) {
  const insitu_array array = insitu_array_of(values.data(), INSITU_FLOAT64,
                                             std::int64_t(values.size()) / components, components);
  m.mesh.mesh().set_field(0, name, of, &array, 1);
}

double bent(const Vec3d& x) {
  return std::sin(1.3 * x.x) * x.y + 0.2 * x.z * x.z - std::exp(0.3 * x.y);
}

std::vector<double> at_vertices(const CommittedFaces& m, double (*field)(const Vec3d&) = linear) {
  std::vector<double> values;
  const auto& x = m.arrays_of_faces.points;
  for (std::size_t i = 0; i < x.size(); i += 3)
    values.push_back(field({x[i], x[i + 1], x[i + 2]}));
  return values;
}

/// The values add a few terms of up to about 40, each rounded at its own size.
constexpr double rounding = 1e-13;

void expect_linear(const CommittedFaces& m, std::uint64_t seed) {
  const query::Sampler sampler = m.sampler();
  const mesh::FieldView field = m.mesh.mesh().field("f");
  for (const Vec3d& p : test::inner_points(m.mesh.mesh().view(), 800, seed)) {
    double value = 0.0;
    const query::Location at = sampler.locate(p);
    ASSERT_TRUE(bool(at));
    sampler.interpolate(field, at, &value);
    ASSERT_NEAR(value, linear(p), rounding) << test::text(p);
  }
}

} // namespace

TEST(PolyhedralFields, LinearOnesAreMet) {
  FaceMesh dented; // whose centre is not the mean
  dented.vertices = {{0, 0, 0}, {9, 0, 0}, {0, 9, 0}, {0, 0, 9}, {0.5, 0.5, 0.5}};
  dented.add_cell({{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 4}, {2, 3, 4}, {3, 1, 4}});
  for (const FaceMesh& mesh :
       {fixtures::octahedra(3, 0.2), fixtures::cut_hexahedra(4, 4), dented, fixtures::poly_dual(),
        fixtures::dual_of(
            test::make_mesh({.kind = test::MeshKind::tetrahedra, .size = 3, .jitter = 0.1}, 8))}) {
    CommittedFaces m(mesh);
    const std::vector<double> values = at_vertices(m);
    give(m, "f", INSITU_VERTEX, values);
    m.commit();
    expect_linear(m, 21);
  }
}

/// Cells that have a shape have its values, of any data: they are that shape, from another vertex
/// on. Places in a cell are told to some 1e-15 of it, and the field goes up and down by about 10 in
/// one; hence 1e-13.
TEST(PolyhedralFields, AnyDataAreThoseOfTheSameCellsByShapes) {
  for (const auto kind : test::all_kinds) {
    const test::TestMesh shapes = test::box(kind, 4, 0.2);
    fixtures::Committed want(shapes);
    CommittedFaces m(fixtures::faces_of(shapes));
    const std::vector<double> values = at_vertices(m, bent);
    const insitu_array array =
        insitu_array_of(values.data(), INSITU_FLOAT64, std::int64_t(values.size()), 1);
    want.mesh.mesh().set_field(0, "f", INSITU_VERTEX, &array, 1);
    give(m, "f", INSITU_VERTEX, values);
    m.commit();
    want.commit();
    for (const Vec3d& p : test::inner_points(want.mesh.mesh().view(), 500, 41)) {
      double is = 0.0, expected = 1.0;
      m.sampler().interpolate(m.mesh.mesh().field("f"), m.sampler().locate(p), &is);
      want.sampler().interpolate(want.mesh.mesh().field("f"), want.sampler().locate(p), &expected);
      ASSERT_NEAR(is, expected, 1e-13) << test::kind_name(kind) << " " << test::text(p);
    }
  }
}

/// Other cells have the values of what they are cut into: by barycentric coordinates over a face of
/// more than four vertices, and over a quad by those of a pyramid; made vertices have means.
TEST(PolyhedralFields, AnyDataAreInterpolatedInTheParts) {
  const FaceMesh mesh = fixtures::octahedra(3, 0.15);
  const fixtures::Subdivided parts(mesh);
  CommittedFaces m(mesh);
  const std::vector<double> values = at_vertices(m, bent);
  give(m, "f", INSITU_VERTEX, values);
  m.commit();
  const std::vector<double> at = parts.with_made(values);
  Random random(42);
  int pyramids = 0;
  for (int i = 0; i < 2000; ++i) {
    const auto part = std::size_t(random.below(int(parts.mesh.cells.size())));
    const test::MeshCell& cell = parts.mesh.cells[part];
    const bool is_pyramid = cell.shape == test::Shape::pyramid;
    const double r = random.uniform(0.02, 0.98), s = random.uniform(0.02, 0.98),
                 t = random.uniform(0.02, 0.95);
    // A tetrahedron is a pyramid of which two corners are one.
    const double w[5] = {(1 - r) * (1 - s) * (1 - t), r * (1 - s) * (1 - t), r * s * (1 - t),
                         (1 - r) * s * (1 - t), t};
    Vec3d p;
    double expected = 0.0, is = 0.0;
    for (std::size_t v = 0; v < 5; ++v) {
      const auto id = std::size_t(cell.vertices[is_pyramid ? v : std::array{0, 1, 2, 2, 3}[v]]);
      p += w[v] * parts.mesh.vertices[id];
      expected += w[v] * at[id];
    }
    const query::Location found = m.sampler().locate(p);
    ASSERT_EQ(m.mesh.own(found, p).cell, parts.cell[part]) << test::text(p);
    m.sampler().interpolate(m.mesh.mesh().field("f"), found, &is);
    ASSERT_NEAR(is, expected, 1e-12) << test::text(p); // values up to 20 in places up to 10
    pyramids += is_pyramid;
  }
  EXPECT_GT(pyramids, 100);
}

TEST(PolyhedralFields, OfFloatsAndVectors) {
  CommittedFaces m(fixtures::octahedra(2, 0.1));
  std::vector<float> values;
  for (std::size_t i = 0; i < m.arrays_of_faces.points.size(); ++i)
    values.push_back(float(m.arrays_of_faces.points[i]));
  const insitu_array array =
      insitu_array_of(values.data(), INSITU_FLOAT32, std::int64_t(values.size()) / 3, 3);
  m.mesh.mesh().set_field(0, "x", INSITU_VERTEX, &array, 1);
  m.commit();
  const query::Sampler sampler = m.sampler();
  for (const Vec3d& p : test::inner_points(m.mesh.mesh().view(), 300, 22)) {
    double x[3];
    sampler.interpolate(m.mesh.mesh().field("x"), sampler.locate(p), x);
    for (int a = 0; a < 3; ++a)
      ASSERT_NEAR(x[a], p[a], 2e-6); // a few roundings of floats up to 6
  }
}

TEST(PolyhedralFields, OfCellsAreTheSolversCells) {
  CommittedFaces m(fixtures::cut_hexahedra(3, 3));
  std::vector<double> numbers;
  for (std::int64_t c = 0; c < m.mesh.mesh().own_view().cell_count(); ++c)
    numbers.push_back(double(c));
  give(m, "number", INSITU_CELL, numbers);
  m.commit();
  const query::Sampler sampler = m.sampler();
  const auto check = [&](double factor) {
    for (const Vec3d& p : test::hard_points(m.mesh.mesh().view(), 500, 23)) {
      const query::Location at = sampler.locate(p, -1, {INSITU_EXACT, 1.0});
      if (!at)
        continue;
      double value = -1.0;
      sampler.interpolate(m.mesh.mesh().field("number"), at, &value);
      ASSERT_EQ(value, factor * double(m.mesh.own(at, p).cell));
    }
  };
  check(1.0);
  for (double& n : numbers) // in place
    n *= 2.0;
  m.commit(INSITU_CHANGED_FIELDS);
  check(2.0);
}

TEST(PolyhedralFields, VerticesThatMoveMoveTheCentres) {
  CommittedFaces m(fixtures::octahedra(3, 0.1));
  std::vector<double> values = at_vertices(m);
  give(m, "f", INSITU_VERTEX, values);
  m.commit();
  (void)m.sampler().locate({1, 1, 1});
  for (std::size_t i = 0; i < m.arrays_of_faces.points.size(); i += 3) { // sheared and moved
    double* const x = &m.arrays_of_faces.points[i];
    x[0] += 0.2 * x[1] + 5.0;
    x[2] *= 1.5;
  }
  values = at_vertices(m);
  const insitu_array array =
      insitu_array_of(values.data(), INSITU_FLOAT64, std::int64_t(values.size()), 1);
  m.mesh.mesh().set_field(0, "f", INSITU_VERTEX, &array, 1);
  const std::uint64_t topology = m.mesh.topology_version();
  const insitu_commit_report report = m.commit(INSITU_CHANGED_GEOMETRY);
  EXPECT_NE(report.action, INSITU_KEEP);
  EXPECT_EQ(m.mesh.topology_version(), topology);
  expect_linear(m, 24);
  for (const Vec3d& p : test::hard_points(m.mesh.mesh().view(), 400, 25))
    ASSERT_EQ(m.sampler().locate(p, -1, {INSITU_EXACT, 1.0}).cell,
              test::owner(m.mesh.mesh().view(), p));
}

// Between two steps: made vertices blend as the solver's do.
TEST(PolyhedralFields, PointsBetweenTwoSteps) {
  CommittedFaces m(fixtures::octahedra(2, 0.1));
  m.mesh.mesh().keep_earlier({}, m.threads);
  for (double& x : m.arrays_of_faces.points)
    x += 0.75;
  m.commit(INSITU_CHANGED_GEOMETRY);
  m.mesh.show_earlier(m.threads);
  const mesh::MeshView& view = m.mesh.mesh().view();
  ASSERT_NE(view.earlier_points, nullptr);
  for (const double alpha : {0.0, 0.5, 1.0})
    for (const Vec3d& p : test::inner_points(view, 200, 26))
      ASSERT_EQ(m.sampler().locate(p, -1, {INSITU_EXACT, alpha}).cell, test::owner(view, p, alpha));
}

TEST(PolyhedralFields, CopiesStandInTheAuditAndTheReport) {
  CommittedFaces m(fixtures::octahedra(2, 0.1));
  std::int64_t copies = 0;
  for (const insitu_audit_entry& e : m.mesh.audit())
    if (!e.borrowed) {
      EXPECT_STREQ(e.name, "piece 0 cells cut from faces");
      copies += e.bytes;
    }
  EXPECT_GT(copies, 0);
  EXPECT_EQ(copies, m.memory.current(INSITU_MEMORY_POLYHEDRA));
  // Cells that are all recognised need no vertices, and their fields no copies.
  CommittedFaces hexahedra(fixtures::faces_of(test::box(test::MeshKind::hexahedra, 3)));
  const std::vector<double> values = at_vertices(hexahedra);
  give(hexahedra, "f", INSITU_VERTEX, values);
  hexahedra.commit();
  const mesh::FieldView field = hexahedra.mesh.mesh().field("f");
  EXPECT_EQ(field.pieces[0].component[0], reinterpret_cast<const std::byte*>(values.data()));
  EXPECT_EQ(hexahedra.mesh.mesh().view().pieces[0].points.component[0],
            hexahedra.mesh.mesh().own_view().pieces[0].points.component[0]);
}
