// Frames from space: a geodetic mesh drawn in geocentric coordinates, its heights exaggerated.
#include <cmath>
#include <gtest/gtest.h>

#include "geocentric_sea.h"
#include "parallel/world.h"
#include "scene/earth/globe.h"

namespace insitu::test {
namespace {

/// Seen from 2000 km above, each pixel's distance is that of the ellipsoid, but for the facets:
/// these lie below it by at most the sag of their longest edge, which an oblique ray lengthens.
TEST(Geocentric, TheSeaSurfaceIsTheEllipsoid) {
  SeaRun run("frames: []");
  const Drawn drawn(run, 100);
  render::FrameSettings s = view_from(15, 35, 2e6, 65);
  s.camera.fov = 20;
  s.boundary.emplace();
  const render::FrameImages images = drawn.draw(s, run.context);
  const render::RayGenerator rays(s.camera, 65, 65);
  const double edge = extent / cells_along * degree * 6.4e6 * std::sqrt(2.0); // a diagonal
  const double sag = edge * edge / (8 * 6.33e6); // of the least radius of curvature here
  int hits = 0;
  double largest = 0;
  for (int i = 0; i < 65 * 65; ++i) {
    const render::Ray ray = rays(i % 65, i / 65);
    const double exact = distance_to_ellipsoid(ray);
    Vec3d place = ray.origin + exact * ray.direction;
    const Vec3d up = (1 / std::sqrt(dot(place, place))) * place;
    geo::from_geocentric(geo::Frame::geodetic(), {&place, 1}, {&place, 1});
    if (place.x < west + 0.01 || place.x > west + extent - 0.01 || place.y < south + 0.01 ||
        place.y > south + extent - 0.01)
      continue;
    ++hits;
    const double below = double(images.depth[std::size_t(i)]) - exact;
    const double slant = -1 / dot(up, ray.direction);
    EXPECT_GT(below, -0.25) << "pixel " << i; // float32 at 2000 km
    EXPECT_LT(below, 1.01 * sag * slant + 0.25) << "pixel " << i;
    largest = std::max(largest, below);
    // The cell is one that touches the surface and holds the place in its own coordinates.
    const std::int64_t cell = images.cell[std::size_t(i)];
    ASSERT_GE(cell, 2 * cells_along * cells_along * (cells_along - 1)) << "pixel " << i;
  }
  EXPECT_GT(hits, 2000);
  EXPECT_GT(largest, 0.5 * sag) << "cells are straight in geocentric space";
}

/// Straight below and above a vertex there is no sag: heights are the factor's multiple.
TEST(Geocentric, TheExaggerationIsExact) {
  SeaRun run("frames: []");
  for (const double factor : {1.0, 20.0, 250.0}) {
    SCOPED_TRACE(factor);
    const Drawn drawn(run, factor);
    // A vertex, but for 0.1 m, so that no ray meets an edge.
    const double lon = 15 + 1e-6, lat = 35 + 0.3e-6;
    render::FrameSettings s = view_from(lon, lat, 1e5, 1);
    s.boundary.emplace();
    EXPECT_NEAR(drawn.draw(s, run.context).depth[0], 1e5, 0.02); // float32 at 100 km, and the sag
    s.boundary.reset();
    s.isosurfaces.push_back({{drawn.mesh.mesh().field("height"), -1}, {-1500.0}, 1});
    const double below = 1e5 + 1500 * factor;
    EXPECT_NEAR(drawn.draw(s, run.context).depth[0], below, 1e-6 * below);
    // From below: the bottom.
    s.isosurfaces.clear();
    s.boundary.emplace();
    const double bottom = -deepest * factor, stand = bottom - 1e5;
    const scene::LocalAxes axes = scene::local_axes(lon, lat);
    s.camera.position = geocentric_place(lon, lat, stand);
    s.camera.look_at = s.camera.position + 1e6 * axes.up;
    EXPECT_NEAR(drawn.draw(s, run.context).depth[0], 1e5, 0.02);
  }
}

/// A block of which only axes are stored is drawn as the same cells given one by one.
TEST(Geocentric, BlocksAreDrawnAsCells) {
  SeaRun cells("frames: []", Shape::hexahedron), block("frames: []", Shape::hexahedron);
  insitu_block b = insitu_block_default();
  b.kind = INSITU_BLOCK_UNIFORM;
  const double origin[3] = {west, south, -deepest}, size[3] = {extent, extent, deepest};
  for (int a = 0; a < 3; ++a) {
    b.vertices[a] = cells_along + 1;
    b.origin[a] = origin[a];
    b.spacing[a] = size[a] / cells_along;
  }
  block.mesh.committed.mesh.mesh().set_block(0, &b);
  block.mesh.committed.commit();
  render::FrameSettings s = view_from(12, 33, 3e6, 32);
  s.camera.fov = 40;
  s.boundary.emplace();
  const render::FrameImages one = Drawn(cells, 30).draw(s, cells.context);
  const render::FrameImages other = Drawn(block, 30).draw(s, block.context);
  int seen = 0;
  for (std::size_t i = 0; i < one.depth.size(); ++i) {
    if (std::isfinite(one.depth[i])) {
      ++seen;
      EXPECT_NEAR(other.depth[i], one.depth[i], 1) << i; // axes are added up with other roundings
    } else {
      EXPECT_FALSE(std::isfinite(other.depth[i])) << i;
    }
  }
  EXPECT_GT(seen, 100);
}

TEST(Geocentric, NothingIsMadeThatNoFrameAsksFor) {
  SeaRun run("frames: [{name: f, size: [16, 16], boundary: {}}]\n"
             "probes: [{name: p, points: [[15, 35, -10]], fields: [height]}]");
  EXPECT_EQ(run.execute(0), "");
  EXPECT_EQ(run.runner.geocentric_conversions(), 0);
  EXPECT_EQ(run.bytes(), 0);
}

TEST(Geocentric, VerticesAreConvertedOncePerGeometry) {
  SeaRun run("frames: [{name: f, size: [16, 16], geocentric: {exaggeration: 100}, boundary: {}},\n"
             "         {name: g, size: [16, 16], geocentric: {exaggeration: 100}, isosurfaces: "
             "[{field: height, values: [-100]}]},\n"
             "         {name: h, size: [16, 16], geocentric: {}, every: 100, volume: {field: "
             "height}}]");
  const auto vertices = std::int64_t(run.mesh.cells.vertices.size());
  const auto bytes_each = std::int64_t(sizeof(Vec3d));
  EXPECT_EQ(run.execute(1), "");
  EXPECT_EQ(run.runner.geocentric_conversions(), 1);
  EXPECT_EQ(run.bytes(), vertices * bytes_each);
  run.mesh.committed.commit(INSITU_CHANGED_FIELDS);
  EXPECT_EQ(run.execute(2), "");
  EXPECT_EQ(run.runner.geocentric_conversions(), 1);
  run.mesh.committed.commit(INSITU_CHANGED_GEOMETRY | INSITU_CHANGED_FIELDS);
  EXPECT_EQ(run.execute(3), "");
  EXPECT_EQ(run.runner.geocentric_conversions(), 2);
  EXPECT_EQ(run.execute(100), ""); // another factor, other vertices
  EXPECT_EQ(run.runner.geocentric_conversions(), 3);
  EXPECT_EQ(run.bytes(), 2 * vertices * bytes_each);
  std::int64_t planned = 0;
  const scene::Plan plan = run.runner.plan(run.meshes);
  for (const scene::Plan::Entry& e : plan.entries())
    if (e.needed && !e.shared && e.item.rfind("geocentric vertices", 0) == 0)
      planned += e.bytes;
  EXPECT_EQ(planned, run.bytes());
  // A mesh that is gone takes its vertices with it.
  EXPECT_NE(run.runner.execute({}, 101, 101), "");
  EXPECT_EQ(run.bytes(), 0);
  EXPECT_EQ(run.runner.geocentric_conversions(), 3);
}

/// After the vertices moved, the frame shows where they are: the bottom as it sinks.
TEST(Geocentric, FollowsTheMesh) {
  SeaRun run("frames: []");
  scene::FrameStructures structures(run.context);
  const double lon = 15 + 1e-6, lat = 35 + 0.3e-6;
  render::FrameSettings s = view_from(lon, lat, 1e5, 1);
  const auto depth = [&] {
    const commit::CommittedMesh& drawn = structures.geocentric(run.mesh.committed.mesh, 10);
    s.isosurfaces.assign(1, {{drawn.mesh().field("height"), -1}, {-1000.0}, 1});
    return double(
        render::render_frame(drawn.sampler(), s, run.context.threads, run.context.memory).depth[0]);
  };
  EXPECT_NEAR(depth(), 1e5 + 1e4, 0.2);
  for (std::size_t i = 2; i < run.mesh.committed.arrays.points.size(); i += 3)
    run.mesh.committed.arrays.points[i] *= 1.5; // the field's values go along
  run.mesh.committed.commit(INSITU_CHANGED_GEOMETRY);
  EXPECT_NEAR(depth(), 1e5 + 1.5e4, 0.2);
}

TEST(Geocentric, SaysWhatCannotBeDrawnSo) {
  SeaRun cartesian(boundary);
  cartesian.mesh.committed.mesh.reference_frame = insitu_frame_default();
  EXPECT_NE(
      cartesian.execute(0).find("s.yaml:2: geocentric: mesh 'test' has Cartesian coordinates"),
      std::string::npos);
  SeaRun deep("frames: [{name: f, size: [8, 8], geocentric: {exaggeration: 2000}, boundary: {}}]");
  const std::string message = deep.execute(0);
  EXPECT_NE(message.find("an exaggeration of 2000 takes a vertex of mesh 'test' at height -4000 m "
                         "to -8e+06 m"),
            std::string::npos)
      << message;
}

/// Cells that wrap around have copies in the solver's own chart, not where they are drawn: no point
/// tells what an image shows, and none is planned.
TEST(Geocentric, ImagesOfCellsThatWrapNeedNoDepth) {
  const auto is_needed = [](const std::string& geocentric) {
    SeaRun run("frames: [{name: f, size: [16, 16], boundary: {}, images: [cell]" + geocentric +
               "}]");
    std::vector<double>& points = run.mesh.committed.arrays.points;
    for (std::size_t i = 0; i < points.size(); i += 3)
      points[i] += points[i] > west + 0.45 * extent ? -195 : 165;
    run.mesh.committed.commit(INSITU_CHANGED_ALL);
    EXPECT_TRUE(run.mesh.committed.mesh.mesh().has_stand_in());
    const scene::Plan plan = run.runner.plan(run.meshes);
    EXPECT_EQ(run.execute(0), "");
    for (const scene::Plan::Entry& e : plan.entries())
      if (e.item == "image of depth")
        return e.needed;
    ADD_FAILURE() << plan.text();
    return false;
  };
  EXPECT_TRUE(is_needed(""));
  EXPECT_FALSE(is_needed(", geocentric: {}"));
}

/// All kinds of surfaces and volumes are drawn in such frames, alike by one thread and many.
TEST(Geocentric, EveryKindOfFrameIsDrawn) {
  for (const char* what : {"boundary: {color: {field: height}}", "volume: {field: height}",
                           "isosurfaces: [{field: height, values: [-500]}]",
                           "effects: [lighting, shadows], boundary: {}"}) {
    SCOPED_TRACE(what);
    SeaRun run(std::string("frames: [{name: f, size: [32, 32], geocentric: {exaggeration: 100}, ") +
               what + "}]");
    EXPECT_EQ(run.execute(0), "");
    EXPECT_EQ(run.statistics.frames, 1);
  }
}

/// Radians, kilometres and depths are the same sea.
TEST(Geocentric, UnitsAreTheMeshs) {
  SeaRun plain("frames: []"), other("frames: []");
  std::vector<double>& points = other.mesh.committed.arrays.points;
  for (std::size_t i = 0; i < points.size(); i += 3) {
    points[i] *= degree;
    points[i + 1] *= degree;
    points[i + 2] *= -1e-3;
  }
  insitu_frame frame = geodetic();
  frame.angle = INSITU_RADIANS;
  frame.length = INSITU_KILOMETRES;
  frame.vertical = INSITU_DOWN;
  other.mesh.committed.mesh.reference_frame = frame;
  other.mesh.committed.commit(INSITU_CHANGED_ALL);
  const Drawn a(plain, 40), b(other, 40);
  const mesh::PieceView &one = a.mesh.mesh().view().pieces[0],
                        &two = b.mesh.mesh().view().pieces[0];
  ASSERT_EQ(one.vertex_count, two.vertex_count);
  for (std::int64_t v = 0; v < one.vertex_count; ++v) { // rounding of 6.4e6, and of pi
    const Vec3d d = one.point(v) - two.point(v);
    ASSERT_LT(dot(d, d), 1e-14 * 6.4e6) << v;
  }
}

/// Land is where the ellipsoid is seen and the mesh does not cover it, and nowhere else; the sea
/// keeps its depths.
TEST(Geocentric, LandIsWhereTheMeshIsNot) {
  SeaRun run("frames: []");
  const Drawn drawn(run, 100);
  render::FrameSettings s = view_from(15, 38, 2e6, 65);
  s.camera.fov = 90;
  s.boundary.emplace();
  const render::FrameImages before = drawn.draw(s, run.context);
  render::FrameImages images = drawn.draw(s, run.context);
  scene::Geocentric asked;
  asked.globe = render::Color{1, 0, 0};
  parallel::SerialWorld world;
  scene::draw_globe(asked, run.mesh.committed.mesh, s, world, run.context, images);
  const render::RayGenerator rays(s.camera, 65, 65);
  int land = 0, sea = 0, space = 0;
  for (int i = 0; i < 65 * 65; ++i) {
    const auto at = std::size_t(i);
    const render::Ray ray = rays(i % 65, i / 65);
    const double exact = distance_to_ellipsoid(ray);
    const float* pixel = images.color.pixel(i % 65, i / 65);
    if (!std::isfinite(exact)) {
      ++space;
      EXPECT_EQ(images.depth[at], before.depth[at]);
      continue;
    }
    Vec3d place = ray.origin + exact * ray.direction;
    geo::from_geocentric(geo::Frame::geodetic(), {&place, 1}, {&place, 1});
    if (place.x > west && place.x < west + extent && place.y > south && place.y < south + extent) {
      ++sea;
      EXPECT_EQ(images.depth[at], before.depth[at]) << i;
      EXPECT_EQ(images.cell[at], before.cell[at]) << i;
    } else {
      ++land;
      EXPECT_EQ(images.depth[at], float(exact)) << i;
      EXPECT_EQ(images.cell[at], -1) << i;
      EXPECT_GE(pixel[0], 0.34f);
      EXPECT_EQ(pixel[1], 0);
    }
  }
  EXPECT_GT(land, 500);
  EXPECT_GT(sea, 50);
  EXPECT_GT(space, 100);
}

TEST(Geocentric, TheGraticuleLiesOnItsMultiples) {
  SeaRun run("frames: []");
  const Drawn drawn(run, 1);
  render::FrameSettings s = view_from(15, 35, 2e6, 201);
  s.camera.fov = 25;
  s.background = {1, 1, 1};
  render::FrameImages images = drawn.draw(s, run.context); // nothing but the background
  scene::Geocentric asked;
  asked.graticule = 5;
  parallel::SerialWorld world;
  scene::draw_globe(asked, run.mesh.committed.mesh, s, world, run.context, images);
  const render::RayGenerator rays(s.camera, 201, 201);
  const auto dark_near = [&](double lon, double lat) {
    const auto at = *rays.project(geocentric_place(lon, lat, 0));
    bool dark = false;
    for (int y = int(at[1]) - 1; y <= int(at[1]) + 1; ++y)
      for (int x = int(at[0]) - 1; x <= int(at[0]) + 1; ++x)
        dark = dark || images.color.pixel(x, y)[0] < 0.9f;
    return dark;
  };
  for (const double along : {11.0, 12.3, 13.7, 16.4, 18.1}) {
    EXPECT_TRUE(dark_near(along, 35)) << along;
    EXPECT_TRUE(dark_near(15, along + 20)) << along;
    EXPECT_FALSE(dark_near(along, along + 20)) << along;
  }
}

} // namespace
} // namespace insitu::test
