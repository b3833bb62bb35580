// When structures of ray methods are built anew, refitted or left as they are.
#include <algorithm>
#include <cmath>

#include "rays_test.h"

using namespace insitu;
using accel::Method;
using test::box;
using test::MeshKind;
using test::ray_methods;

namespace {

fixtures::SolverArrays sheared(const fixtures::SolverArrays& from, double shear) {
  fixtures::SolverArrays out = from;
  for (std::size_t i = 0; i < out.points.size(); i += 3)
    out.points[i] += shear * std::sin(9.0 * out.points[i + 1]); // waves: none folds
  return out;
}

} // namespace

TEST(RaysUpdate, AreBuiltAnewWhenTheTreeIs) {
  for (const Method method : ray_methods) {
    fixtures::Committed m(box(MeshKind::hexahedra, 8, 0.0), 2);
    m.mesh.set_builder(accel::Builder::morton); // not another tree after many queries
    m.mesh.set_locator({method, accel::Backend::cpu});
    m.commit();
    const query::Locators& locators = m.mesh.locators();
    EXPECT_EQ(locators.upkeep().builds, 1);
    const fixtures::SolverArrays first = m.arrays;
    bool refitted = false, rebuilt = false;
    // Boxes of these cells overlap more and more, until the tree costs 1.3 times as much.
    for (int step = 1; step <= 12 && !rebuilt; ++step) {
      const std::vector<double> moved = sheared(first, 0.125 * step).points;
      std::copy(moved.begin(), moved.end(), m.arrays.points.begin()); // where the mesh reads them
      const query::Locators::Upkeep before = locators.upkeep();
      const insitu_commit_report report = m.commit(INSITU_CHANGED_GEOMETRY);
      const std::string what = std::string(accel::name(method)) + ", step " + std::to_string(step);
      rebuilt = report.action == INSITU_REBUILD;
      refitted = refitted || !rebuilt;
      EXPECT_EQ(locators.upkeep().builds - before.builds, rebuilt) << what;
      EXPECT_EQ(locators.upkeep().refits - before.refits, !rebuilt) << what;
      // Whichever was done, it was done to the vertices as they are.
      EXPECT_GT(test::shares_of(m, INSITU_EXACT).kept, 0.85) << what;
    }
    EXPECT_TRUE(refitted && rebuilt) << accel::name(method);
  }
}

TEST(RaysUpdate, FieldsAloneBuildAndRefitNothing) {
  for (const Method method : ray_methods) {
    fixtures::Committed m(box(MeshKind::mixed, 5), 2);
    std::vector<double> of_vertices(std::size_t(m.arrays.vertex_count()));
    std::vector<double> of_cells(std::size_t(m.arrays.cell_count()));
    const auto set = [&](double base) {
      for (std::size_t v = 0; v < of_vertices.size(); ++v)
        of_vertices[v] = base + m.arrays.points[3 * v]; // linear: interpolated to rounding
      for (std::size_t c = 0; c < of_cells.size(); ++c)
        of_cells[c] = base + double(c);
    };
    set(0);
    const insitu_array v =
        insitu_array_of(of_vertices.data(), INSITU_FLOAT64, m.arrays.vertex_count(), 1);
    const insitu_array c =
        insitu_array_of(of_cells.data(), INSITU_FLOAT64, m.arrays.cell_count(), 1);
    m.mesh.mesh().set_field(0, "v", INSITU_VERTEX, &v, 1);
    m.mesh.mesh().set_field(0, "c", INSITU_CELL, &c, 1);
    m.mesh.set_locator({method, accel::Backend::cpu});
    m.commit();
    const query::Locators::Upkeep before = m.mesh.locators().upkeep();
    for (const double base : {100.0, -7.0}) {
      set(base);
      const insitu_commit_report report = m.commit(INSITU_CHANGED_FIELDS);
      EXPECT_EQ(report.action, INSITU_KEEP) << accel::name(method);
      EXPECT_EQ(m.mesh.locators().upkeep().builds, before.builds) << accel::name(method);
      EXPECT_EQ(m.mesh.locators().upkeep().refits, before.refits) << accel::name(method);
      const auto points = test::inner_points(m.sampler().mesh(), 500, 12);
      std::vector<double> values[2];
      const mesh::FieldView fields[] = {m.mesh.mesh().field("v"), m.mesh.mesh().field("c")};
      for (auto& of_field : values)
        of_field.assign(points.size(), 0.0);
      double* out[] = {values[0].data(), values[1].data()};
      const query::Sampler sampler = m.sampler();
      std::vector<std::int64_t> cells(points.size());
      const std::int64_t kept = m.mesh.locators().ray_counts().kept;
      sampler.visit(m.threads, points, {INSITU_EXACT, 1.0}, [&](const query::Answered& answered) {
        for (std::size_t k = 0; k < answered.locations.size(); ++k)
          cells[std::size_t(answered.item(k))] = answered.locations[k].cell;
        sampler.interpolate(fields, answered, 0, out);
      });
      EXPECT_GT(m.mesh.locators().ray_counts().kept - kept, 450) << accel::name(method);
      for (std::size_t i = 0; i < points.size(); ++i) {
        ASSERT_NEAR(values[0][i], base + points[i].x, 1e-12) << accel::name(method);
        ASSERT_EQ(values[1][i], base + double(cells[i])) << accel::name(method);
      }
    }
  }
}
