// Frames from space: a geodetic mesh drawn in geocentric coordinates, its heights exaggerated.
#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>
#include <unistd.h>

#include "../render/render_mesh.h"
#include "core/context.h"
#include "geo/reference_frames.h"
#include "scene/earth/geocentric_view.h"
#include "scene/earth/globe.h"
#include "scene/frames/frame_settings.h"
#include "scene/parse/parse.h"
#include "scene/run/runner.h"
#include "scene_test.h"

namespace insitu::test {
namespace {

using scene::geocentric_place;

constexpr double west = 10, south = 30, extent = 10, deepest = 4000; // degrees, metres
constexpr int cells_along = 20;
constexpr double degree = 3.14159265358979323846 / 180;

/// Longitude, latitude, height of a place in the unit cube.
Vec3d on_earth(const Vec3d& p) {
  return {west + extent * p.x, south + extent * p.y, deepest * (p.z - 1)};
}

insitu_frame geodetic() {
  insitu_frame frame = insitu_frame_default();
  frame.kind = INSITU_FRAME_GEODETIC;
  return frame;
}

/// A sea from 10 to 20 E, 30 to 40 N, 4 km deep.
TestMesh sea(Shape shape) {
  TestMesh mesh = box_cells(cells_along, shape, 0);
  for (Vec3d& p : mesh.vertices)
    p = on_earth(p);
  return mesh;
}

/// Its frames, cycle by cycle.
struct SeaRun {
  explicit SeaRun(const std::string& items, Shape shape = Shape::wedge)
      : mesh(sea(shape)), folder(std::filesystem::temp_directory_path() /
                                 ("insitu-geocentric-" + std::to_string(::getpid()))),
        context(0, mesh.committed.log),
        runner(scene::parse_scene_text("insitu: 1\n" + items, "s.yaml"), folder.string(), context,
               statistics) {
    mesh.committed.mesh.reference_frame = geodetic();
    mesh.field("height", INSITU_VERTEX, [](const Vec3d& p) { return p.z; });
    mesh.committed.commit(INSITU_CHANGED_ALL);
  }
  ~SeaRun() { std::filesystem::remove_all(folder); }

  std::string execute(std::int64_t cycle) { return runner.execute(meshes, cycle, double(cycle)); }
  std::int64_t bytes() const { return context.memory.current(INSITU_MEMORY_GEOCENTRIC); }

  RenderMesh mesh;
  std::filesystem::path folder;
  core::Context context;
  scene::Statistics statistics;
  scene::Runner runner;
  commit::CommittedMesh* list[1] = {&mesh.committed.mesh};
  scene::MeshList meshes{list};
};

/// How far along the ray WGS84 is first met.
double distance_to_ellipsoid(const render::Ray& ray) {
  const double a = 6378137.0, b = a * (1 - 1 / 298.257223563);
  const Vec3d o{ray.origin.x / a, ray.origin.y / a, ray.origin.z / b};
  const Vec3d d{ray.direction.x / a, ray.direction.y / a, ray.direction.z / b};
  const double dd = dot(d, d), od = dot(o, d), oo = dot(o, o) - 1;
  const double root = od * od - dd * oo;
  return root < 0 ? HUGE_VAL : (-od - std::sqrt(root)) / dd;
}

render::FrameSettings view_from(double longitude, double latitude, double height, int size) {
  render::FrameSettings s;
  s.width = s.height = size;
  s.depth = s.cell = true;
  s.camera.position = geocentric_place(longitude, latitude, height);
  const scene::LocalAxes axes = scene::local_axes(longitude, latitude);
  s.camera.look_at = s.camera.position - 1e6 * axes.up;
  s.camera.up = axes.north;
  return s;
}

struct Drawn {
  Drawn(SeaRun& run, double exaggeration)
      : structures(run.context),
        mesh(structures.geocentric(run.mesh.committed.mesh, exaggeration)) {}
  render::FrameImages draw(const render::FrameSettings& settings, core::Context& context) const {
    return render::render_frame(mesh.sampler(), settings, context.threads, context.memory);
  }
  scene::FrameStructures structures;
  const commit::CommittedMesh& mesh;
};

constexpr const char* boundary = "frames: [{name: f, size: [16, 16], geocentric: {exaggeration: "
                                 "100}, boundary: {color: {field: height}}}]";

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
  scene::draw_globe(asked, run.mesh.committed.mesh, s, run.context, images);
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
  scene::draw_globe(asked, run.mesh.committed.mesh, s, run.context, images);
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

double length(const Vec3d& v) {
  return std::sqrt(dot(v, v));
}

TEST(GeocentricCamera, StandsAbovePlaces) {
  const auto camera = [](const std::string& keys) {
    return scene::test::parse("frames: [{name: f, boundary: {}, geocentric: {}, camera: {" + keys +
                              "}}]")
        .frames[0]
        .camera;
  };
  const scene::Camera down = camera("longitude: -30, latitude: 40, altitude: 3e6");
  EXPECT_LT(length(*down.position - geocentric_place(-30, 40, 3e6)), 1e-6);
  EXPECT_LT(length(*down.look_at - geocentric_place(-30, 40, 0)), 1e-6);
  EXPECT_LT(length(down.up - scene::local_axes(-30, 40).north), 1e-12);
  const scene::Camera at =
      camera("longitude: -30, latitude: 10, altitude: 3e6, look_at: {longitude: -30, latitude: 40, "
             "height: 10}");
  EXPECT_LT(length(*at.look_at - geocentric_place(-30, 40, 10)), 1e-6);
  EXPECT_LT(length(at.up - scene::local_axes(-30, 10).up), 1e-12);
  const scene::Camera pole = camera("longitude: 0, latitude: 90, altitude: 1e6");
  EXPECT_LT(length(pole.up - Vec3d{-1, 0, 0}), 1e-12);
  const scene::Camera keyed = camera(
      "path: [{cycle: 0, longitude: 0, latitude: 0, altitude: 1e6}, {cycle: 9, longitude: 90, "
      "latitude: 0, altitude: 2e6}]");
  EXPECT_LT(length(*keyed.path[1].look_at - geocentric_place(90, 0, 0)), 1e-6);
}

TEST(GeocentricCamera, Errors) {
  const auto error = [](const std::string& keys) {
    return scene::test::error_of("frames: [{name: f, boundary: {}, " + keys + "}]");
  };
  EXPECT_NE(error("camera: {longitude: 1, latitude: 2, altitude: 3}").find("'geocentric'"),
            std::string::npos);
  EXPECT_NE(error("geocentric: {}, camera: {longitude: 1, altitude: 3}").find("latitude"),
            std::string::npos);
  EXPECT_NE(error("geocentric: {}, camera: {position: [1e7, 0, 0], longitude: 1, latitude: 2, "
                  "altitude: 3}")
                .find("either a position or longitude"),
            std::string::npos);
  EXPECT_NE(error("geocentric: {exaggeration: -1}").find("exaggeration"), std::string::npos);
}

/// The automatic camera: above the mesh's middle, north up, and all of it in the image.
TEST(GeocentricCamera, SeesTheWholeMeshFromAbove) {
  SeaRun run(boundary);
  const Drawn drawn(run, 100);
  const scene::Frame frame = scene::test::parse(boundary).frames[0];
  core::Context& context = run.context;
  scene::CinemaTable table({}, run.folder.string());
  const scene::Environment environment{
      context, run.statistics, *const_cast<scene::FrameStructures*>(&drawn.structures),
      table,   "s.yaml",       run.folder.string()};
  const scene::FrameSettingsMaker maker(frame, environment);
  const render::Camera camera =
      maker.camera(frame.camera, drawn.mesh, {run.meshes, 0, 0.0, true, 0.0}, 0);
  Vec3d place = camera.position;
  geo::from_geocentric(geo::Frame::geodetic(), {&place, 1}, {&place, 1});
  EXPECT_NEAR(place.x, 15, 1);
  EXPECT_NEAR(place.y, 35, 1);
  EXPECT_GT(place.z, 1e6);
  const render::RayGenerator rays(camera, 100, 100);
  const auto pixel = [&](double lon, double lat) {
    return *rays.project(geocentric_place(lon, lat, 0));
  };
  for (const double lon : {west, west + extent})
    for (const double lat : {south, south + extent})
      for (const double at : pixel(lon, lat)) {
        EXPECT_GT(at, 0);
        EXPECT_LT(at, 100);
      }
  EXPECT_LT(pixel(15, 40)[1], pixel(15, 30)[1]) << "north is up";
  EXPECT_LT(pixel(10, 35)[0], pixel(20, 35)[0]) << "east is right";
}

} // namespace
} // namespace insitu::test
