// Values: linear fields come back to rounding on every shape, and so do their gradients.
#include "query_test.h"

using namespace insitu;
using math::Vec3d;
using test::all_kinds;
using test::box;

namespace {

constexpr Vec3d slope{1.5, -2.0, 0.25};
double linear(const Vec3d& p) {
  return 3.0 + dot(slope, p);
}

} // namespace

TEST(Sampling, LinearFieldsComeBackToRounding) {
  for (const auto kind : all_kinds) {
    fixtures::Committed m(box(kind, 6, 0.25));
    std::vector<double> f;
    std::vector<float> single;
    for (std::size_t v = 0; v < m.arrays.points.size(); v += 3) {
      const double* x = &m.arrays.points[v];
      f.push_back(linear({x[0], x[1], x[2]}));
      single.insert(single.end(), {float(f.back()), float(2 * f.back())});
    }
    std::vector<double> density;
    for (std::int64_t c = 0; c < m.arrays.cell_count(); ++c)
      density.push_back(double(c));
    const insitu_array af = insitu_array_of(f.data(), INSITU_FLOAT64, m.arrays.vertex_count(), 1),
                       as = insitu_array_of(single.data(), INSITU_FLOAT32, m.arrays.vertex_count(),
                                            2),
                       ad = insitu_array_of(density.data(), INSITU_FLOAT64, m.arrays.cell_count(),
                                            1);
    mesh::Mesh& mesh = m.mesh.mesh();
    mesh.set_field(0, "f", INSITU_VERTEX, &af, 1);
    mesh.set_field(0, "single", INSITU_VERTEX, &as, 1);
    mesh.set_field(0, "density", INSITU_CELL, &ad, 1);
    m.commit();
    const mesh::FieldView fields[] = {mesh.field("density"), mesh.field("f"), mesh.field("single")};
    const query::Sampler sampler = m.sampler();
    double worst = 0, worst_gradient = 0;
    for (const Vec3d& p : test::inner_points(sampler.mesh(), 3000, 41)) {
      const query::Location at = sampler.locate(p);
      ASSERT_TRUE(at);
      double value, all[4];
      sampler.interpolate(fields[1], at, &value);
      worst = std::max(worst, std::fabs(value - linear(p)));
      sampler.interpolate(fields, at, all);
      ASSERT_EQ(all[0], double(at.cell));
      ASSERT_EQ(all[1], value);
      ASSERT_NEAR(all[2], linear(p), 2e-6);
      ASSERT_NEAR(all[3], 2 * linear(p), 4e-6);
      EXPECT_EQ(sampler.gradient(fields[0], 0, at), Vec3d{});
      if (kind == test::MeshKind::pyramids && at.parametric.z > 0.9)
        continue; // near the apex the map's derivatives vanish
      const Vec3d g = sampler.gradient(fields[1], 0, at) - slope;
      worst_gradient = std::max(worst_gradient, std::sqrt(dot(g, g)));
      const Vec3d g2 = sampler.gradient(fields[2], 1, at) - 2.0 * slope;
      ASSERT_LE(dot(g2, g2), 1e-8);
    }
    // Values up to 28, so one rounding is 3.6e-15; derivatives lose a cell's condition besides.
    EXPECT_LE(worst, 8 * 28 * 0x1p-53) << kind_name(kind);
    EXPECT_LE(worst_gradient, 1e-11) << kind_name(kind);
  }
}

TEST(Sampling, GradientsFollowTheBlendedMesh) {
  fixtures::Committed m(box(test::MeshKind::hexahedra, 4));
  m.mesh.mesh().keep_earlier({}, m.threads);
  for (std::size_t v = 0; v < m.arrays.points.size(); v += 3)
    m.arrays.points[v] *= 3; // stretched along x
  std::vector<double> f;     // linear in the earlier mesh's x
  for (std::size_t v = 0; v < m.arrays.points.size(); v += 3)
    f.push_back(m.arrays.points[v] / 3);
  const insitu_array a = insitu_array_of(f.data(), INSITU_FLOAT64, m.arrays.vertex_count(), 1);
  m.mesh.mesh().set_field(0, "f", INSITU_VERTEX, &a, 1);
  m.commit(INSITU_CHANGED_GEOMETRY);
  m.mesh.show_earlier(m.threads);
  const mesh::FieldView field = m.mesh.mesh().field("f");
  for (const double alpha : {0.0, 0.5, 1.0}) {
    const query::Location at = m.sampler().locate({1.3, 1.4, 1.6}, -1, {INSITU_STANDARD, alpha});
    ASSERT_TRUE(at);
    const Vec3d g = m.sampler().gradient(field, 0, at, alpha);
    EXPECT_NEAR(g.x, 1 / (1 + 2 * alpha), 1e-13);
    EXPECT_NEAR(g.y, 0, 1e-13);
  }
}
