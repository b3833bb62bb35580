// Voronoi cells of nearly degenerate sites: faces and edges that are a billionth of the cells.
#include "fixtures/voronoi.h"
#include "owners.h"

namespace insitu {

namespace {

using fixtures::CommittedFaces;
using fixtures::NearlyDegenerateVoronoi;

/// How many edges are shorter than this.
int short_edges(const fixtures::FaceMesh& mesh, double length) {
  int count = 0;
  for (const auto& ring : mesh.faces)
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const math::Vec3d d = mesh.vertices[std::size_t(ring[i])] -
                            mesh.vertices[std::size_t(ring[(i + 1) % ring.size()])];
      count += dot(d, d) < length * length;
    }
  return count;
}

double linear(const math::Vec3d& x) {
  return 3.0 + 0.5 * x.x - 2.0 * x.y + 1.25 * x.z;
}

TEST(VoronoiCells, OfNearlyDegenerateSitesOwnEachPointOnce) {
  for (const double epsilon : {1e-3, 1e-9, 1e-12}) {
    SCOPED_TRACE(epsilon);
    const NearlyDegenerateVoronoi cells(3, epsilon);
    EXPECT_GT(short_edges(cells.mesh, 4 * epsilon), 200);
    const CommittedFaces m(cells.mesh);
    fixtures::expect_one_owner(m);
    fixtures::expect_filled(m, {-0.49, -0.49, -0.49}, {2.49, 2.49, 2.49}, 600, 31);
    test::Random random(5);
    for (int i = 0; i < 2000; ++i) { // in the middle of cells the nearest site's
      const math::Vec3d p = random.uniform({-0.49, -0.49, -0.49}, {2.49, 2.49, 2.49});
      const double x = std::round(p.x), y = std::round(p.y), z = std::round(p.z);
      if (std::max({std::abs(p.x - x), std::abs(p.y - y), std::abs(p.z - z)}) < 0.495) {
        ASSERT_EQ(m.owner(p), std::int64_t(x + 3 * y + 9 * z)) << test::text(p);
      }
    }
  }
}

/// In all parts, on their faces, edges and vertices.
TEST(VoronoiCells, OfNearlyDegenerateSitesMeetLinearFields) {
  for (const double epsilon : {1e-3, 1e-9, 1e-12}) {
    SCOPED_TRACE(epsilon);
    const NearlyDegenerateVoronoi cells(3, epsilon);
    CommittedFaces m(cells.mesh);
    std::vector<double> values;
    for (const math::Vec3d& x : cells.mesh.vertices)
      values.push_back(linear(x));
    const insitu_array array =
        insitu_array_of(values.data(), INSITU_FLOAT64, std::int64_t(values.size()), 1);
    m.mesh.mesh().set_field(0, "f", INSITU_VERTEX, &array, 1);
    m.commit();
    const query::Sampler sampler = m.sampler();
    const mesh::FieldView field = m.mesh.mesh().field("f");
    const mesh::MeshView& view = m.mesh.mesh().view();
    double worst = 0;
    for (const std::vector<math::Vec3d>& points :
         {test::inner_points(view, 2000, 21), test::hard_points(view, 2000, 22)})
      for (const math::Vec3d& p : points) {
        const query::Location at = sampler.locate(p);
        if (!at) // a point of the boundary, outside by a rounding
          continue;
        double value = 0.0;
        sampler.interpolate(field, at, &value);
        worst = std::max(worst, std::abs(value - linear(p)));
      }
    // Values are of some 10, rounded. In parts that are needles, a billionth of the cell wide and
    // thinner, Newton's last step, below 1e-5 of the part, is right to some four digits.
    EXPECT_LT(worst, epsilon > 1e-6 ? 1e-13 : 1e-9);
  }
}

} // namespace

} // namespace insitu
