#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "unit/render/render_mesh.h"

/// Roots of a field along rays in single cells, and the normals of surfaces.
namespace insitu::test {
namespace {

using render::FrameSettings;
using render::Normals;
using render::RootSearch;

double random(std::uint64_t item, std::uint64_t channel) {
  return core::random_unit(303, 8 * item + channel / 8, channel % 8);
}

/// A cell with its reference corners moved by up to `jitter`.
mesh::CellVertices cell_of(Shape shape, double jitter, std::uint64_t seed) {
  mesh::CellVertices cell;
  cell.shape = shape;
  cell.count = mesh::vertex_count(shape);
  const TestMesh box = box_cells(1, shape, 0);
  for (int v = 0; v < cell.count; ++v) {
    cell.ids[v] = v;
    cell.x[v] = box.vertices[std::size_t(box.cells[0].vertices[std::size_t(v)])];
    for (int a = 0; a < 3; ++a)
      cell.x[v][a] += jitter * (random(seed, std::uint64_t(3 * v + a)) - 0.5);
  }
  return cell;
}

std::vector<double> roots(const mesh::CellVertices& cell, const render::Ray& ray,
                          const double* values, double level, RootSearch search = RootSearch::exact,
                          std::int64_t* evaluations = nullptr) {
  const cells::RaySpace space(ray);
  render::CellRoots finder(cell, space, 0, HUGE_VAL);
  std::vector<double> found;
  finder.find(
      values, level,
      [&](const render::LevelHit& hit) {
        found.push_back(hit.t);
        return true;
      },
      search);
  if (evaluations)
    *evaluations = finder.evaluations();
  return found;
}

/// The field along the ray, by the inverse map alone; NaN outside.
double value_at(const mesh::CellVertices& cell, const render::Ray& ray, const double* values,
                double t) {
  const auto map = cells::inverse_map(cell.shape, cell.x, ray.origin + t * ray.direction);
  if (!map.converged || map.margin < -1e-9)
    return std::nan("");
  double weights[8], sum = 0;
  cells::shape_functions(cell.shape, map.r, weights);
  for (int v = 0; v < cell.count; ++v)
    sum += weights[v] * values[v];
  return sum;
}

/// Against dense sampling: every change of side between samples has a root between them, and every
/// root changes sides or nearly touches.
TEST(CellRoots, AgreeWithSamplingInCurvedCells) {
  int several = 0, all = 0, entering_twice = 0, by_cubics = 0, unlike = 0;
  std::int64_t evaluations = 0;
  for (const Shape shape : {Shape::hexahedron, Shape::wedge, Shape::pyramid, Shape::tetrahedron})
    for (std::uint64_t i = 0; i < 600; ++i) {
      const bool grazes = i >= 400;
      const std::uint64_t seed = 10 * i + std::uint64_t(shape) * 100000;
      const mesh::CellVertices cell = cell_of(shape, 0.5, seed);
      double values[8];
      for (int v = 0; v < cell.count; ++v)
        values[v] = random(seed + 5, std::uint64_t(v)) - 0.5;
      Vec3d through; // a place inside
      for (int v = 0; v < cell.count; ++v)
        through += (1.0 / cell.count) * cell.x[v];
      const auto r = [&](std::uint64_t c) { return random(seed + 7, c) - 0.5; };
      const Vec3d from{4 * r(0), 4 * r(1), 3 + r(2)};
      const Vec3d d = through + 0.3 * Vec3d{r(3), r(4), r(5)} - from;
      render::Ray ray{from, d / std::sqrt(dot(d, d))};
      if (grazes) { // along a face, which is a saddle: in, out and in again
        const int quad[4] = {0, 1, shape == Shape::wedge ? 4 : 2, 3};
        const Vec3d along = cell.x[quad[2]] - cell.x[quad[0]], to = 0.02 * Vec3d{r(3), r(4), r(5)};
        Vec3d middle;
        for (const int v : quad)
          middle += 0.25 * cell.x[v];
        ray.direction = along / std::sqrt(dot(along, along));
        ray.origin = middle + to - 3.0 * ray.direction;
      }
      const double level = 0.2 * r(6);
      std::int64_t took = 0;
      const auto found = roots(cell, ray, values, level, RootSearch::exact, &took);
      evaluations += took;
      all += int(found.size());
      // By cubics no root is wrong, and pairs alone are missed.
      const auto cubic = roots(cell, ray, values, level, RootSearch::cubic);
      by_cubics += int(cubic.size());
      unlike += cubic.size() != found.size();
      ASSERT_LE(cubic.size(), found.size()) << shape_name(shape) << " case " << i;
      ASSERT_EQ((found.size() - cubic.size()) % 2, 0u) << shape_name(shape) << " case " << i;
      for (const double root : cubic)
        ASSERT_TRUE(std::any_of(found.begin(), found.end(),
                                [&](double other) { return std::fabs(root - other) < 1e-7; }))
            << shape_name(shape) << " case " << i;
      several += found.size() > 1;
      const double end = grazes ? 6 : std::sqrt(dot(d, d)) + 2;
      constexpr int samples = 4000;
      double before = std::nan("");
      int changes = 0, entries = 0;
      bool was_inside = false;
      for (int k = 0; k <= samples; ++k) {
        const double t = end * k / samples;
        const double f = value_at(cell, ray, values, t) - level;
        entries += !std::isnan(f) && !was_inside;
        was_inside = !std::isnan(f);
        if (std::isnan(f) || std::isnan(before) || (f >= 0) == (before >= 0)) {
          before = f;
          continue;
        }
        before = f;
        ++changes;
        int between = 0;
        for (const double root : found)
          between += root >= end * (k - 1) / samples - 1e-9 && root <= t + 1e-9;
        ASSERT_EQ(between % 2, 1) << shape_name(shape) << " case " << i << " at " << t;
      }
      entering_twice += entries > 1;
      ASSERT_GE(int(found.size()), changes) << shape_name(shape) << " case " << i;
      for (std::size_t k = 0; k < found.size(); ++k) {
        if (k > 0) {
          ASSERT_LT(found[k - 1], found[k]);
        }
        const double f = value_at(cell, ray, values, found[k]);
        if (!std::isnan(f)) { // on the cell's rim the sampling's inverse map may not tell
          ASSERT_NEAR(f, level, 1e-9) << shape_name(shape) << " case " << i;
        }
      }
    }
  EXPECT_GT(all, 600);
  EXPECT_GT(several, 20);
  EXPECT_GT(entering_twice, 70) << "of 2400 rays; 143 when this was set";
  EXPECT_LE(unlike, 2) << by_cubics << " of " << all << " roots by cubics; all when this was set";
  EXPECT_LT(double(evaluations) / 2400, 16.0); // 12 in cells as bent as these
}

/// Along the diagonal of a cube, f = -(x + y + z) / 3 + (x y + y z + z x) / 3 is t^2 - t, whose
/// levels just above its minimum at t = 1/2 have two roots however near; and a bent cube's as well.
TEST(CellRoots, PairsHoweverNear) {
  for (const double jitter : {0.0, 0.2}) {
    mesh::CellVertices cell = cell_of(Shape::hexahedron, jitter, 77);
    const Vec3d d{1 / std::sqrt(3.0), 1 / std::sqrt(3.0), 1 / std::sqrt(3.0)};
    const render::Ray ray{Vec3d{0.01, 0.005, 0} - d, d};
    double values[8];
    for (int v = 0; v < 8; ++v) {
      const Vec3d& p = cell_of(Shape::hexahedron, 0, 0).x[v];
      values[v] = -(p.x + p.y + p.z) / 3 + (p.x * p.y + p.y * p.z + p.z * p.x) / 3;
    }
    // The minimum along the ray, by golden sections over the sampling's inverse map.
    double low = 1.5, high = 2.2;
    for (int k = 0; k < 200; ++k) {
      const double a = low + 0.382 * (high - low), b = low + 0.618 * (high - low);
      const bool left = value_at(cell, ray, values, a) < value_at(cell, ray, values, b);
      (left ? high : low) = left ? b : a;
    }
    const double bottom = value_at(cell, ray, values, 0.5 * (low + high));
    for (const double above : {1e-2, 1e-4, 1e-6, 1e-8, 1e-9}) {
      const auto found = roots(cell, ray, values, bottom + above);
      ASSERT_EQ(found.size(), 2u) << jitter << ", " << above;
      EXPECT_NEAR(value_at(cell, ray, values, found[0]), bottom + above, 1e-11);
      EXPECT_NEAR(value_at(cell, ray, values, found[1]), bottom + above, 1e-11);
      EXPECT_GT(found[1], found[0]);
      EXPECT_EQ(roots(cell, ray, values, bottom - above).size(), 0u) << jitter << ", " << above;
      // Cubics are the field in a parallelepiped, and near it elsewhere.
      if (jitter == 0 || above >= 1e-2) {
        EXPECT_EQ(roots(cell, ray, values, bottom + above, RootSearch::cubic).size(), 2u)
            << jitter << ", " << above;
      }
      EXPECT_EQ(roots(cell, ray, values, bottom - above, RootSearch::cubic).size(), 0u)
          << jitter << ", " << above;
    }
    // The fast search does not see them, but sees what changes side.
    EXPECT_EQ(roots(cell, ray, values, bottom + 1e-2, RootSearch::neubauer).size(), 0u);
  }
}

TEST(CellRoots, NeubauersSearchIsNear) {
  int both = 0;
  for (std::uint64_t i = 0; i < 300; ++i) {
    const mesh::CellVertices cell = cell_of(Shape::hexahedron, 0.2, 50000 + 10 * i);
    double values[8];
    for (int v = 0; v < 8; ++v) // a plane, nearly
      values[v] = dot(cell.x[v], Vec3d{1, 0.5, 2}) + 0.2 * random(90000 + i, std::uint64_t(v));
    const render::Ray ray{{0.4, 0.55, -1}, {0, 0, 1}};
    const auto exact = roots(cell, ray, values, 1.75);
    std::int64_t took = 0;
    const auto fast = roots(cell, ray, values, 1.75, RootSearch::neubauer, &took);
    if (exact.size() != 1)
      continue;
    ASSERT_EQ(fast.size(), 1u);
    EXPECT_NEAR(fast[0], exact[0], 3e-3); // the secant's error twice over
    EXPECT_LE(took, 2);
    ++both;
  }
  EXPECT_GT(both, 200);
}

/// Levels met along the whole ray, at vertices, in flat and in folded cells end, and soon.
void expect_an_end(RootSearch search) {
  mesh::CellVertices cell = cell_of(Shape::hexahedron, 0, 0);
  const render::Ray ray{{0.5, 0.4, -1}, {0, 0, 1}};
  double values[8] = {0, 1, 1, 0, 0, 1, 1, 0}; // f = x, and the ray at x = 1/2
  std::int64_t took = 0;
  EXPECT_LE(roots(cell, ray, values, 0.5, search, &took).size(), 1u);
  EXPECT_LT(took, 200);
  const double constant[8] = {3, 3, 3, 3, 3, 3, 3, 3};
  EXPECT_EQ(roots(cell, ray, constant, 3, search).size(), 0u);
  double with_nan[8] = {0, 1, 1, 0, 0, std::nan(""), 1, 0};
  EXPECT_EQ(roots(cell, ray, with_nan, 0.5, search).size(), 0u);
  const double tiny[8] = {0, 0, 0, 0, 1e-300, 1e-300, 1e-300, 1e-300};
  EXPECT_EQ(roots(cell, ray, tiny, 5e-301, search).size(), 1u);
  const double huge[8] = {0, 0, 0, 0, 1e300, 1e300, 1e300, 1e300};
  EXPECT_EQ(roots(cell, ray, huge, 5e299, search).size(), 1u);
  const double infinite[8] = {0, 0, 0, 0, HUGE_VAL, 1, 1, 1};
  EXPECT_EQ(roots(cell, ray, infinite, 0.5, search).size(), 0u);
  for (int flat = 0; flat < 3; ++flat) {
    mesh::CellVertices none = cell;
    for (Vec3d& p : none.x)
      p[flat] = 0.5;
    const double z[8] = {0, 0.1, 0.2, 0.3, 1, 1.1, 1.2, 1.3};
    EXPECT_LE(roots(none, ray, z, 0.65, search, &took).size(), 2u);
    EXPECT_LT(took, 500);
  }
  // Long and thin, far from the origin.
  mesh::CellVertices thin = cell_of(Shape::hexahedron, 0.2, 4242);
  const Vec3d offset{6.4e6, -6.4e6, 6.4e6};
  for (int v = 0; v < 8; ++v) {
    thin.x[v].z *= 1e-5;
    thin.x[v] += offset;
    values[v] = thin.x[v].z - offset.z;
  }
  const render::Ray across{offset + Vec3d{0.5, 0.5, -1}, {0, 0, 1}};
  const auto found = roots(thin, across, values, 5e-6, search);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0], 1 + 5e-6, 2e-9); // a rounding of the coordinates is 1e-9
}

TEST(CellRoots, DegenerateCasesEnd) {
  for (const RootSearch search : {RootSearch::cubic, RootSearch::exact}) {
    SCOPED_TRACE(int(search));
    expect_an_end(search);
  }
}

TEST(Normals, SmoothAndCentralOnes) {
  RenderMesh mesh(16, Shape::hexahedron, 0.2);
  const Vec3d centre{0.5, 0.5, 0.5};
  const auto r2 =
      mesh.field("r2", INSITU_VERTEX, [&](const Vec3d& p) { return dot(p - centre, p - centre); });
  double worst[3], mean[3];
  for (const Normals normals : {Normals::cell, Normals::smooth, Normals::central}) {
    const std::vector<render::IsosurfaceSettings> settings{
        {r2, {0.16}, 1, render::Color{1, 1, 1}, normals}};
    render::Structures structures(mesh.committed.memory);
    structures.begin(mesh.sampler(), 0, 0, mesh.committed.threads);
    const render::IsosurfaceTracer tracer(mesh.sampler(), settings, structures);
    EXPECT_EQ(structures.counts().gradients, normals == Normals::smooth ? 1 : 0);
    const render::RayGenerator rays(box_frame(48).camera, 48, 48);
    std::vector<render::SurfaceHit> hits;
    render::SurfaceCounts counts;
    double& most = worst[int(normals)] = 0;
    double sum = 0;
    int count = 0;
    for (int i = 0; i < 48 * 48; ++i) {
      const render::Ray ray = rays(i % 48, i / 48);
      tracer.trace(ray, hits, counts);
      if (hits.empty())
        continue;
      const Vec3d p = ray.origin + hits[0].t * ray.direction, out = p - centre;
      const Vec3d g = tracer.gradient(hits[0], p, counts);
      const double cosine = dot(g, out) / std::sqrt(dot(g, g) * dot(out, out));
      const double angle = std::acos(std::min(1.0, cosine));
      most = std::max(most, angle);
      sum += angle;
      ++count;
    }
    ASSERT_GT(count, 300);
    mean[int(normals)] = sum / count;
  }
  // Facets are off by up to a cell's share of the sphere, 1/16 / 0.4 / 2 and more; the others are
  // of second order.
  EXPECT_GT(mean[0], 0.03);
  EXPECT_LT(mean[1], 0.4 * mean[0]);
  EXPECT_LT(mean[2], 0.6 * mean[0]);
  EXPECT_LT(worst[1], 0.06);

  // A linear field's are exact, up to the boundary.
  const auto plane =
      mesh.field("plane", INSITU_VERTEX, [](const Vec3d& p) { return p.x + 2 * p.y + 3 * p.z; });
  for (const Normals normals : {Normals::smooth, Normals::central}) {
    FrameSettings s = box_frame(24);
    s.isosurfaces.push_back({plane, {3.1}, 1, render::Color{1, 1, 1}, normals});
    s.lighting.lights = {{render::Light::Kind::directional, {1, 2, 3}}};
    render::FrameStatistics statistics;
    const core::Image image = mesh.draw(s, 0, &statistics);
    for (int i = 0; i < 24 * 24; ++i)
      if (image.pixel(i % 24, i / 24)[0] > 0) {
        EXPECT_NEAR(image.pixel(i % 24, i / 24)[0], 1, 1e-6);
      }
    EXPECT_GT(statistics.hits, 50);
  }
  // Nothing is made for surfaces that are not lit.
  FrameSettings s = box_frame(8);
  s.isosurfaces.push_back({plane, {3.1}, 1, render::Color{1, 1, 1}, Normals::smooth});
  s.lighting.enabled = false;
  render::Structures kept(mesh.committed.memory);
  kept.begin(mesh.sampler(), 0, 0, mesh.committed.threads);
  render::render_frame(mesh.sampler(), s, kept, mesh.committed.threads);
  EXPECT_EQ(kept.counts().gradients, 0);
}

} // namespace
} // namespace insitu::test
