#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <list>

#include "core/status.h"
#include "unit/render/render_mesh.h"

namespace insitu::test {
namespace {

using render::FrameSettings;
using render::IsosurfaceSettings;
using render::IsosurfaceTracer;
using render::Ray;
using render::SurfaceHit;

std::vector<SurfaceHit> trace(RenderMesh& mesh, const std::vector<IsosurfaceSettings>& settings,
                              const Ray& ray) {
  render::Structures structures(mesh.committed.memory);
  structures.begin(mesh.sampler(), 0, 0, mesh.committed.threads);
  const IsosurfaceTracer tracer(mesh.sampler(), settings, structures);
  std::vector<SurfaceHit> hits;
  render::SurfaceCounts counts;
  tracer.trace(ray, hits, counts);
  return hits;
}

double plane(const Vec3d& p) {
  return p.x + 2 * p.y + 3 * p.z;
}

TEST(Isosurface, PlaneIsExactInEveryShape) {
  for (const Shape shape : {Shape::hexahedron, Shape::tetrahedron, Shape::wedge, Shape::pyramid}) {
    RenderMesh mesh(4, shape, 0.25);
    const std::vector<IsosurfaceSettings> settings{
        {mesh.field("plane", INSITU_VERTEX, plane), {2.0, 3.0, 4.1}, 0.5}};
    render::Structures structures(mesh.committed.memory);
    structures.begin(mesh.sampler(), 0, 0, mesh.committed.threads);
    const IsosurfaceTracer tracer(mesh.sampler(), settings, structures);
    const FrameSettings s = box_frame(40);
    const render::RayGenerator rays(s.camera, 40, 40);
    std::vector<SurfaceHit> hits;
    render::SurfaceCounts counts;
    int found = 0;
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 40; ++x) {
        const Ray ray = rays(x, y);
        tracer.trace(ray, hits, counts);
        // The planes' own hits within the box, nearest first; those on its rim may go either way.
        std::vector<std::pair<double, int>> expected;
        const auto [near, far] = box_stretch(ray);
        bool rim = false;
        for (int k = 0; k < 3; ++k) {
          const double value = settings[0].values[std::size_t(k)];
          const double t = (value - plane(ray.origin)) / plane(ray.direction);
          rim |= std::fabs(t - near) < 1e-9 || std::fabs(t - far) < 1e-9;
          if (t > near && t < far)
            expected.push_back({t, k});
        }
        if (rim)
          continue;
        std::sort(expected.begin(), expected.end());
        ASSERT_EQ(hits.size(), expected.size()) << shape_name(shape) << " " << x << ", " << y;
        for (std::size_t h = 0; h < hits.size(); ++h) {
          EXPECT_NEAR(hits[h].t, expected[h].first, 1e-10);
          EXPECT_EQ(hits[h].surface, expected[h].second);
          EXPECT_NEAR(hits[h].gradient.x, 1, 1e-9);
          EXPECT_NEAR(hits[h].gradient.y, 2, 1e-9);
          EXPECT_NEAR(hits[h].gradient.z, 3, 1e-9);
          ++found;
        }
      }
    EXPECT_GT(found, 1000);
  }
}

TEST(Isosurface, SurfaceThroughFacesIsHitOnce) {
  // Vertices lie on the surface x = 1/2, rays pass through faces, edges and vertices.
  for (const Shape shape : {Shape::hexahedron, Shape::tetrahedron, Shape::wedge, Shape::pyramid}) {
    RenderMesh mesh(4, shape);
    const std::vector<IsosurfaceSettings> settings{
        {mesh.field("x", INSITU_VERTEX, [](const Vec3d& p) { return p.x; }), {0.5}, 0.5}};
    for (const double direction : {1.0, -1.0})
      for (int j = 1; j < 16; ++j)
        for (int k = 1; k < 16; ++k) {
          const Ray ray{{0.5 - 2 * direction, j / 16.0, k / 16.0}, {direction, 0, 0}};
          const auto hits = trace(mesh, settings, ray);
          ASSERT_EQ(hits.size(), 1u) << shape_name(shape) << " " << j << ", " << k;
          EXPECT_NEAR(hits[0].t, 2.0, 1e-12);
        }
  }
}

TEST(Isosurface, SeveralFieldsInOneTraversal) {
  RenderMesh mesh(8, Shape::hexahedron, 0.2);
  const std::vector<IsosurfaceSettings> all{
      {mesh.field("r", INSITU_VERTEX,
                  [](const Vec3d& p) {
                    return dot(p - Vec3d{0.5, 0.5, 0.5}, p);
                  }),
       {0.1, 0.2},
       0.5},
      {mesh.field("x", INSITU_VERTEX, [](const Vec3d& p) { return p.x; }), {0.4}, 0.5},
      {mesh.field("c", INSITU_CELL, [](const Vec3d& p) { return p.y + p.z; }), {0.9}, 0.5}};
  const query::Sampler sampler = mesh.sampler();
  render::Structures structures(mesh.committed.memory);
  structures.begin(sampler, 0, 0, mesh.committed.threads);
  const render::IsosurfaceTracer together(sampler, all, structures);
  std::vector<std::vector<IsosurfaceSettings>> each;
  for (const IsosurfaceSettings& one : all)
    each.push_back({one});
  std::list<render::IsosurfaceTracer> alone;
  for (const auto& one : each)
    alone.emplace_back(sampler, one, structures);
  render::SurfaceCounts at_once, apart;
  std::size_t found = 0;
  for (int i = 0; i < 400; ++i) {
    const Vec3d from{-1, 0.3 + 0.001 * i, 2}, to{0.6, 0.05 * (i % 20), 0.05 * (i / 20)};
    const Vec3d d = to - from;
    const Ray ray{from, d / std::sqrt(dot(d, d))};
    std::vector<render::SurfaceHit> hits, one;
    together.trace(ray, hits, at_once);
    std::vector<double> expected;
    for (const render::IsosurfaceTracer& tracer : alone) {
      tracer.trace(ray, one, apart);
      for (const render::SurfaceHit& hit : one)
        expected.push_back(hit.t);
    }
    std::sort(expected.begin(), expected.end());
    ASSERT_EQ(hits.size(), expected.size()) << i;
    for (std::size_t h = 0; h < hits.size(); ++h)
      EXPECT_EQ(hits[h].t, expected[h]) << i;
    found += hits.size();
  }
  EXPECT_GT(found, 500u);
  // A cell that several of them pass is looked at once.
  EXPECT_LT(at_once.cells_tested, apart.cells_tested);
  EXPECT_EQ(structures.counts().value_ranges, 3);
}

TEST(Isosurface, AllRootsWithinACell) {
  // In one cube, f = (x - 0.3)(z - 0.6) + ... along a diagonal is a cubic with three roots: f = x y
  // z
  // - a x y - ... has f(t, t, t) = (t - 0.2)(t - 0.5)(t - 0.7).
  RenderMesh mesh(1);
  const auto f = [](const Vec3d& p) {
    const double s1 = 1.4, s2 = 0.1 + 0.14 + 0.35, s3 = 0.07;
    const double pairs = (p.x * p.y + p.y * p.z + p.z * p.x) / 3, sum = (p.x + p.y + p.z) / 3;
    return p.x * p.y * p.z - s1 * pairs + s2 * sum - s3;
  };
  const std::vector<IsosurfaceSettings> settings{{mesh.field("cubic", INSITU_VERTEX, f), {0}, 0.5}};
  const double c = 1 / std::sqrt(3.0);
  // Not exactly on the diagonal, which is an edge of nothing but passes two corners.
  const auto hits = trace(mesh, settings, {Vec3d{-1, -1, -1}, {c, c, c}});
  ASSERT_EQ(hits.size(), 3u);
  const double expected[] = {0.2, 0.5, 0.7};
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(hits[i].t * c - 1, expected[i], 1e-9);
}

TEST(Isosurface, CellFieldIsAveragedToItsVertices) {
  RenderMesh mesh(8);
  const auto field = mesh.field("x", INSITU_CELL, [](const Vec3d& p) { return p.x; });
  const std::int64_t before = mesh.committed.memory.current();
  const std::vector<IsosurfaceSettings> settings{{field, {0.55}, 1}};
  // Inside, the average of a linear field is the field.
  const auto hits = trace(mesh, settings, {{-1, 0.4, 0.6}, {1, 0, 0}});
  ASSERT_EQ(hits.size(), 1u);
  EXPECT_NEAR(hits[0].t, 1.55, 1e-10);
  EXPECT_NEAR(hits[0].gradient.x, 1, 1e-9);
  EXPECT_EQ(mesh.committed.memory.current(), before); // all given back

  const mesh::MeshView& view = mesh.sampler().mesh();
  const core::Threads threads(4);
  const render::VertexCells around(view, nullptr, nullptr, threads, mesh.committed.memory);
  EXPECT_EQ(around.bytes(), render::VertexCells::bytes_for(view, threads));
  const render::VertexAverage one(view, field, around, core::Threads(1), mesh.committed.memory);
  const render::VertexAverage four(view, field, around, threads, mesh.committed.memory);
  EXPECT_GT(mesh.committed.memory.current(), before);
  for (std::size_t v = 0; v < mesh.cells.vertices.size(); ++v) {
    const double a = one.field().load(0, std::int64_t(v));
    EXPECT_EQ(a, four.field().load(0, std::int64_t(v)));
    const double x = mesh.cells.vertices[v].x;
    EXPECT_NEAR(a, x == 0 ? 1 / 16.0 : x == 1 ? 15 / 16.0 : x, 1e-12);
  }
}

TEST(Isosurface, CameraInsideSeesOnlyWhatIsAhead) {
  RenderMesh mesh(3, Shape::hexahedron, 0.2);
  const std::vector<IsosurfaceSettings> settings{
      {mesh.field("x", INSITU_VERTEX, [](const Vec3d& p) { return p.x; }), {0.25, 0.5, 0.75}, 0.5}};
  const auto hits = trace(mesh, settings, {{0.49, 0.45, 0.55}, {1, 0, 0}});
  ASSERT_EQ(hits.size(), 2u);
  EXPECT_NEAR(hits[0].t, 0.01, 1e-10);
  EXPECT_NEAR(hits[1].t, 0.26, 1e-10);
  EXPECT_EQ(trace(mesh, settings, {{0.49, 0.45, 0.55}, {-1, 0, 0}}).size(), 1u);
}

TEST(Isosurface, RefusesWhatDoesNotFit) {
  RenderMesh mesh(1);
  const auto field = mesh.field("p", INSITU_VERTEX, plane);
  const auto message = [&](IsosurfaceSettings s) -> std::string {
    try {
      trace(mesh, {s}, {{-1, 0.5, 0.5}, {1, 0, 0}});
    } catch (const core::Error& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_EQ(message({field, {}}), "isosurface of 'p': no value given");
  EXPECT_EQ(message({field, {std::nan("")}}), "isosurface of 'p': a value is not finite");
  EXPECT_EQ(message({field, {1}, 1.5}), "isosurface of 'p': opacity 1.500000; 0 to 1 expected");
  EXPECT_EQ(message({{field.field, 3}, {1}}), "isosurface of 'p': component 3 asked for, 1 held");
  EXPECT_EQ(message({field, {1}}), "no error");
}

} // namespace
} // namespace insitu::test
