// Isosurfaces cell by cell in tiles of the screen have the hits of the search by the ray: none
// missed, none more, depths to rounding.
#include <cstdlib>
#include <gtest/gtest.h>

#include "unit/query/ghosted_amr.h"
#include "unit/render/tile_hits.h"

namespace insitu::test {
namespace {

/// The side of a frame: of the soak, ten million rays in all, or a few thousand.
int size_of_frames() {
  const char* const asked = std::getenv("INSITU_TILE_PIXELS");
  return asked ? std::atoi(asked) : 16;
}

/// So many boxes along each axis, fewer of pyramids, of which six fill one.
int along_axis(int n, Shape shape) {
  return shape == Shape::pyramid ? n / 2 + 1 : n;
}

class Tiles : public testing::TestWithParam<Shape> {};

/// Compares all views of one mesh.
void expect_same(const query::Sampler& sampler, const std::vector<IsosurfaceSettings>& settings,
                 const std::vector<View>& views, core::Memory& memory, const std::string& what,
                 const std::vector<render::Clip>& clips = {}, double tolerance = 1e-8) {
  render::Structures structures(memory);
  structures.begin(sampler, 0, 0, core::Threads(1));
  const int size = size_of_frames();
  std::int64_t hits = 0, rays = 0, light = 0, shadowed = 0;
  for (const View& view : views) {
    const Compared found =
        compare(sampler, settings, structures, view.camera, size, size + 4, clips);
    EXPECT_EQ(found.other, 0) << what << ", " << view.name << ", of " << found.rays << ": "
                              << found.first;
    EXPECT_LT(found.worst, tolerance) << what << ", " << view.name;
    hits += found.hits;
    rays += found.rays;
    const Compared lit =
        compare_light(sampler, settings, structures, view.camera, std::max(6, size / 4), clips);
    EXPECT_EQ(lit.other, 0) << what << ", light in " << view.name << ", of " << lit.rays << ": "
                            << lit.first;
    light += lit.rays;
    shadowed += lit.hits;
  }
  EXPECT_GT(light, 0) << what;
  EXPECT_GT(shadowed, 0) << what;
  EXPECT_GT(hits, rays / 20) << what;
}

TEST_P(Tiles, HitsAreThoseOfRays) {
  for (const double jitter : {0.0, 0.15, 0.35}) {
    PlacedMesh mesh(placed(along_axis(7, GetParam()), GetParam(), {1, 1, 1}, {0, 0, 0}, jitter));
    for (const auto of : {sphere, gyroid}) {
      const render::ScalarField field = mesh.field(at_vertices(mesh.cells, of));
      std::vector<double> levels{0.4, 0.25};
      if (of == gyroid)
        levels = {0.0, 0.7};
      for (const double opacity : {1.0, 0.5})
        if (opacity < 1 || jitter == 0.15)
          expect_same(mesh.committed.sampler(), {{field, levels, opacity}}, views(),
                      mesh.committed.memory,
                      (of == sphere ? "sphere" : "gyroid") + (" jitter " + std::to_string(jitter)));
    }
  }
}

/// Far from zero, where a cell has few bits, and stretched, where cells are thin.
TEST_P(Tiles, HitsAreThoseOfRaysInHardPlaces) {
  struct Place {
    const char* name;
    Vec3d scale, offset;
    double unit;
  };
  const Place places[] = {{"far away", {1, 1, 1}, {1e7, -3e6, 2e6}, 1},
                          {"flat", {1, 1, 1e-4}, {0, 0, 0}, 1},
                          {"tiny, of tiny values", {1e-9, 1e-9, 1e-9}, {0, 0, 0}, 1e-290},
                          {"huge, of huge values", {1e9, 1e9, 1e9}, {0, 0, 0}, 1e290}};
  const int n = along_axis(6, GetParam());
  for (const Place& place : places) {
    PlacedMesh mesh(placed(n, GetParam(), place.scale, place.offset, 0.2));
    const TestMesh unit = placed(n, GetParam(), {1, 1, 1}, {0, 0, 0}, 0.2);
    std::vector<double> values = at_vertices(unit, gyroid);
    for (double& v : values)
      v *= place.unit;
    std::vector<View> seen = views();
    for (View& view : seen)
      for (Vec3d* const p : {&view.camera.position, &view.camera.look_at})
        for (int a = 0; a < 3; ++a)
          (*p)[a] = place.offset[a] + place.scale[a] * (*p)[a];
    for (View& view : seen)
      view.camera.orthographic_height *= place.scale.x;
    expect_same(mesh.committed.sampler(), {{mesh.field(values), {0.0, 0.7 * place.unit}, 0.5}},
                seen, mesh.committed.memory, place.name, {},
                place.offset.x > 0 ? 1e-6 : 1e-8); // coordinates of 1e7 are rounded to 1e-9
  }
}

TEST_P(Tiles, SeveralFieldsAndClips) {
  RenderMesh mesh(6, GetParam(), 0.2);
  const std::vector<IsosurfaceSettings> settings{
      {mesh.field("a", INSITU_VERTEX, sphere), {0.3}, 0.5},
      {mesh.field("b", INSITU_VERTEX, gyroid), {0.1}, 1.0},
      {mesh.field("c", INSITU_CELL, gyroid), {-0.5}, 0.7}};
  render::Clip plane;
  plane.point = {0.5, 0.5, 0.5};
  plane.vector = {0.3, -0.8, 0.5};
  render::Clip ball;
  ball.kind = render::Clip::Kind::sphere;
  ball.point = {0.6, 0.5, 0.4};
  ball.radius = 0.3;
  ball.keep_inside = false;
  for (const auto& clips : {std::vector<render::Clip>{}, {plane}, {plane, ball}})
    expect_same(mesh.sampler(), settings, views(), mesh.committed.memory,
                std::to_string(clips.size()) + " clips", clips);
}

INSTANTIATE_TEST_SUITE_P(Shapes, Tiles,
                         testing::Values(Shape::hexahedron, Shape::tetrahedron, Shape::wedge,
                                         Shape::pyramid));

/// Gridlets and the cells between them.
TEST(TilesOfAdaptiveMeshes, HitsAreThoseOfRays) {
  for (int kind = 0; kind < 3; ++kind) {
    const Recipe recipe{.seed = 2, .kind = kind, .roots = 3, .levels = 3};
    RegisteredAmr mesh(recipe, INSITU_DUAL, [](const Vec3d& p) {
      return std::sin(p.x) * std::cos(p.y) + std::sin(p.y) * std::cos(p.z) +
             std::sin(p.z) * std::cos(p.x);
    });
    const query::Sampler sampler = mesh.committed.sampler();
    const Vec3d low = sampler.tree().bounds_min(), high = sampler.tree().bounds_max();
    std::vector<View> seen = views();
    for (View& view : seen) {
      for (Vec3d* const p : {&view.camera.position, &view.camera.look_at})
        for (int a = 0; a < 3; ++a)
          (*p)[a] = low[a] + (high[a] - low[a]) * (*p)[a];
      view.camera.orthographic_height *= high.x - low.x;
    }
    const render::ScalarField field{mesh.committed.mesh.mesh().field("f"), 0};
    const render::ScalarRange range = render::scalar_range(sampler.mesh(), field, core::Threads(1));
    const auto part = [&](double p) { return range.low + p * (range.high - range.low); };
    expect_same(sampler, {{field, {part(0.4), part(0.7)}, 0.5}}, seen, mesh.committed.memory,
                recipe.name());
  }
}

} // namespace
} // namespace insitu::test
