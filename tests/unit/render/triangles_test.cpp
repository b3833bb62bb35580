#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <unistd.h>

#include "core/status.h"
#include "unit/output/folder.h"
#include "unit/query/registered_amr.h"
#include "unit/render/render_mesh.h"

/// Triangles among surfaces: the mesh's boundary, bodies of files; and the outline.
namespace insitu::test {
namespace {

using render::BodySettings;
using render::BoundarySettings;
using render::Color;
using render::FrameSettings;
using render::SurfaceHit;
using render::TriangleList;

struct Tracer {
  Tracer(RenderMesh& mesh, const std::optional<BoundarySettings>& boundary,
         const std::vector<BodySettings>& bodies = {})
      : structures(mesh.committed.memory) {
    structures.begin(mesh.sampler(), 0, 0, mesh.committed.threads);
    surfaces.emplace(mesh.sampler(), boundary, bodies, 0, structures);
  }
  std::vector<SurfaceHit> operator()(const render::Ray& ray) const {
    std::vector<SurfaceHit> hits;
    surfaces->trace(ray, hits, nullptr);
    return hits;
  }
  render::Structures structures;
  std::optional<render::TriangleSurfaces> surfaces;
};

/// A square of two triangles across x, from y and z of 0 to `size`, around `centre`.
std::shared_ptr<TriangleList> square(const Vec3d& centre, double size) {
  const auto list = std::make_shared<TriangleList>();
  list->source = "square";
  const auto corner = [&](int y, int z) {
    list->corners.push_back(centre + Vec3d{0, (y - 0.5) * size, (z - 0.5) * size});
  };
  corner(0, 0), corner(1, 0), corner(1, 1);
  corner(0, 0), corner(1, 1), corner(0, 1);
  return list;
}

TEST(Triangles, BoundaryOfABoxInEveryShape) {
  for (const Shape shape : {Shape::hexahedron, Shape::tetrahedron, Shape::wedge, Shape::pyramid}) {
    RenderMesh mesh(4, shape, 0.25);
    const Tracer both(mesh, BoundarySettings{0.5}), first(mesh, BoundarySettings{});
    const render::FrameSettings s = box_frame(40);
    const render::RayGenerator rays(s.camera, 40, 40);
    int hit = 0;
    for (int i = 0; i < 1600; ++i) {
      const render::Ray ray = rays(i % 40, i / 40);
      const auto [near, far] = box_stretch(ray);
      const auto hits = both(ray);
      if (far - near < 1e-6) { // misses, or an edge
        EXPECT_LE(hits.size(), 2u);
        if (near > far + 1e-6) {
          EXPECT_TRUE(hits.empty());
        }
        continue;
      }
      ASSERT_EQ(hits.size(), 2u) << shape_name(shape) << " pixel " << i;
      EXPECT_NEAR(hits[0].t, near, 1e-12);
      EXPECT_NEAR(hits[1].t, far, 1e-12);
      const Vec3d p = ray.origin + (near + 1e-9) * ray.direction;
      EXPECT_EQ(mesh.sampler().locate(p, hits[0].cell).cell, hits[0].cell);
      const auto opaque = first(ray);
      ASSERT_EQ(opaque.size(), 1u);
      EXPECT_EQ(opaque[0].t, hits[0].t);
      ++hit;
    }
    EXPECT_GT(hit, 500);
  }
}

/// Gridlets and stitching cells are numbered apart; what is left is the domain's surface.
TEST(Triangles, BoundaryOfAnAdaptiveMesh) {
  int boxes = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Recipe recipe{.seed = seed, .kind = int(seed % 3), .roots = 3, .levels = 3};
    if (!is_box(recipe))
      continue;
    RegisteredAmr mesh(recipe, INSITU_DUAL, [](const Vec3d& p) { return p.x; });
    const query::Sampler sampler = mesh.committed.sampler();
    const auto boundary =
        render::TriangleMesh::boundary(sampler.mesh(), sampler.facts().bounds, nullptr,
                                       mesh.committed.threads, mesh.committed.memory);
    double area = 0;
    for (std::uint32_t i = 0; i < boundary->count(); ++i)
      area += 0.5 * std::sqrt(dot(boundary->normal(i), boundary->normal(i)));
    const Vec3d d = sampler.tree().bounds_max() - sampler.tree().bounds_min();
    const double expected = 2 * (d.x * d.y + d.y * d.z + d.z * d.x);
    // The tree's bounds are rounded to float, outwards; a face too many or too few is far more.
    EXPECT_NEAR(area, expected, 2e-6 * expected) << recipe.name();
    ++boxes;
  }
  EXPECT_GT(boxes, 0);
}

TEST(Triangles, ColoursOfTheBoundary) {
  RenderMesh mesh(4, Shape::hexahedron, 0.2);
  mesh.field("y", INSITU_VERTEX, [](const Vec3d& p) { return p.y; });
  mesh.field("c", INSITU_CELL, [](const Vec3d& p) { return p.y; });
  const render::TransferFunction ramp(
      render::ColorMap("ramp", render::ColorSpace::linear, {{0, 0, 0, 0}, {1, 1, 1, 1}}), 0, 1);
  FrameSettings s;
  s.width = s.height = 1;
  s.camera.position = {-1, 0.45, 0.55};
  s.camera.look_at = {0, 0.45, 0.55};
  s.camera.up = {0, 0, 1};
  s.lighting.enabled = false;
  const render::ScalarField y{mesh.committed.mesh.mesh().field("y"), -1};
  s.boundary = BoundarySettings{1, render::ColorByField{y, ramp}};
  EXPECT_NEAR(mesh.draw(s).pixel(0, 0)[0], 0.45, 1e-5); // weights in float
  const render::ScalarField c{mesh.committed.mesh.mesh().field("c"), -1};
  s.boundary->color = render::ColorByField{c, ramp};
  const query::Location at = mesh.sampler().locate({1e-9, 0.45, 0.55});
  EXPECT_NEAR(mesh.draw(s).pixel(0, 0)[0], c.load(0, at.cell), 1e-6);
  s.boundary->color = Color{0.1f, 0.2f, 0.3f};
  EXPECT_FLOAT_EQ(mesh.draw(s).pixel(0, 0)[1], 0.2f);
  s.lighting.enabled = true; // seen from the front
  EXPECT_FLOAT_EQ(mesh.draw(s).pixel(0, 0)[1], 0.2f);
  s.lighting.lights = {{render::Light::Kind::directional, {-3, 0, 4}}};
  EXPECT_FLOAT_EQ(mesh.draw(s).pixel(0, 0)[1], 0.2f * (0.3f + 0.7f * 0.6f));
  s.boundary->color = render::ColorByField{{y.field, 2}, ramp};
  EXPECT_THROW(mesh.draw(s), core::Error);
}

TEST(Triangles, BodiesLieAmongSurfacesAndMedia) {
  RenderMesh mesh(4, Shape::hexahedron, 0.2);
  const auto x = mesh.field("x", INSITU_VERTEX, [](const Vec3d& p) { return p.x; });
  FrameSettings s;
  s.width = s.height = 1;
  s.camera.position = {-1, 0.45, 0.55};
  s.camera.look_at = {0, 0.45, 0.55};
  s.camera.up = {0, 0, 1};
  s.background = {0, 0, 0};
  s.lighting.enabled = false;
  s.depth = s.cell = true;
  const auto draw = [&] {
    return render::render_frame(mesh.sampler(), s, mesh.committed.threads, mesh.committed.memory);
  };
  s.isosurfaces.push_back({x, {0.2}, 0.25, Color{1, 0, 0}});
  s.isosurfaces.push_back({x, {0.8}, 1, Color{0, 0, 1}});
  s.bodies.push_back({square({0.5, 0.45, 0.55}, 2), 0.5, Color{0, 1, 0}});
  render::FrameImages images = draw();
  EXPECT_NEAR(images.color.pixel(0, 0)[0], 0.25, 1e-6);
  EXPECT_NEAR(images.color.pixel(0, 0)[1], 0.75 * 0.5, 1e-6);
  EXPECT_NEAR(images.color.pixel(0, 0)[2], 0.75 * 0.5, 1e-6);
  EXPECT_FLOAT_EQ(images.depth[0], 1.5f);
  EXPECT_EQ(images.cell[0], -1);
  s.bodies[0].opacity = 1;
  images = draw();
  EXPECT_NEAR(images.color.pixel(0, 0)[1], 0.75, 1e-6);
  EXPECT_NEAR(images.color.pixel(0, 0)[2], 0, 1e-6);
  // Within a medium, and cut away.
  s.isosurfaces.clear();
  s.volume = render::VolumeSettings{x, constant_function(0.75, 1.0)};
  s.volume->unit_distance = 1;
  s.volume->step = 0.25;
  images = draw();
  EXPECT_NEAR(images.color.pixel(0, 0)[0], 1 - std::pow(0.25, 0.5), 1e-5);
  s.volume.reset();
  s.isosurfaces.push_back({x, {0.8}, 1, Color{0, 0, 1}});
  s.clips.push_back({render::Clip::Kind::plane, {0.6, 0, 0}, {-1, 0, 0}});
  images = draw();
  EXPECT_NEAR(images.color.pixel(0, 0)[1], 0, 1e-6);
  EXPECT_NEAR(images.color.pixel(0, 0)[2], 1, 1e-6);
}

TEST(Triangles, EdgesAreHitOnceAtAnyOffsetAndFromAfar) {
  RenderMesh mesh(1);
  for (const auto& [size, offset, distance] :
       {std::tuple{1.0, 0.0, 2.0}, {1.0, 6.4e6, 2.0}, {1e-6, 0.0, 1e-5}, {2.0, 0.0, 1e6}}) {
    const Vec3d centre{offset, -offset, offset};
    const Tracer tracer(mesh, std::nullopt, {{square(centre, size), 0.5}});
    for (int i = 1; i < 20; ++i) {
      const double a = (i / 20.0 - 0.5) * size;
      // Along the diagonal that both triangles have.
      const render::Ray ray{centre + Vec3d{-distance, a, a}, {1, 0, 0}};
      const auto hits = tracer(ray);
      ASSERT_EQ(hits.size(), 1u) << size << " " << offset << " " << i;
      EXPECT_NEAR(hits[0].t, distance, 4e-16 * (std::fabs(offset) + distance));
    }
    EXPECT_TRUE(tracer({centre + Vec3d{-distance, 0, 0}, {-1, 0, 0}}).empty());
    EXPECT_TRUE(tracer({centre + Vec3d{-distance, 0.51 * size, 0}, {1, 0, 0}}).empty());
    EXPECT_TRUE(tracer({centre, {0, 1, 0}}).empty()); // within it, edge-on
  }
}

TEST(Triangles, AreKeptWhileTheGeometryHolds) {
  RenderMesh mesh(3);
  core::Memory& memory = mesh.committed.memory;
  const std::int64_t before = memory.current();
  render::Structures kept(memory);
  FrameSettings s = box_frame(8);
  s.boundary = BoundarySettings{};
  s.bodies.push_back({square({0.5, 0.5, 0.5}, 2)});
  const auto draw = [&](std::uint64_t geometry, std::uint64_t fields) {
    kept.begin(mesh.sampler(), geometry, fields, mesh.committed.threads);
    render::render_frame(mesh.sampler(), s, kept, mesh.committed.threads);
    kept.end();
  };
  draw(0, 0);
  draw(0, 1);
  EXPECT_EQ(kept.counts().boundaries, 1);
  EXPECT_EQ(kept.counts().bodies, 1);
  draw(1, 2);
  EXPECT_EQ(kept.counts().boundaries, 2);
  EXPECT_EQ(kept.counts().bodies, 1);
  EXPECT_GT(memory.current(), before);
  s.boundary.reset();
  s.bodies.clear();
  draw(1, 2);
  EXPECT_EQ(memory.current(), before);
}

std::string write(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

std::string binary_stl(const std::vector<float>& corners, std::uint32_t stated) {
  std::string bytes = "solid, says the header of a binary file";
  bytes.resize(80, ' ');
  const auto put = [&](const void* p, std::size_t n) {
    bytes.append(static_cast<const char*>(p), n);
  };
  put(&stated, 4);
  for (std::size_t i = 0; i < corners.size(); i += 9) {
    const float normal[3] = {NAN, 0, 0};
    put(normal, 12);
    put(&corners[i], 36);
    bytes += "ab";
  }
  return bytes;
}

TEST(Triangles, StlFiles) {
  const ::test::Folder folder;
  const std::string path = folder.path() + "/body.stl";
  const auto error = [&](const std::string& bytes) -> std::string {
    try {
      render::read_stl(write(path, bytes));
    } catch (const core::Error& e) {
      return e.what();
    }
    return "no error";
  };
  write(path, "solid a part\r\n facet normal nan 0 1\n  outer loop\n   vertex 0 0 0.5\n"
              "   vertex +1e0 -2 0\n   vertex 0 1 0\n  endloop\n endfacet\nendsolid a part\n"
              "solid b\nendsolid\n");
  const TriangleList ascii = render::read_stl(path);
  ASSERT_EQ(ascii.corners.size(), 3u);
  EXPECT_EQ(ascii.corners[0], (Vec3d{0, 0, 0.5}));
  EXPECT_EQ(ascii.corners[1], (Vec3d{1, -2, 0}));
  EXPECT_EQ(ascii.source, path);
  const std::vector<float> corners{0, 0, 0.5f, 1, -2, 0, 0, 1, 0, 1, 2, 3, 4, 5, 6, 7, 8, 10};
  const TriangleList binary = render::read_stl(write(path, binary_stl(corners, 2)));
  ASSERT_EQ(binary.corners.size(), 6u);
  EXPECT_EQ(binary.corners[1], (Vec3d{1, -2, 0}));
  EXPECT_EQ(binary.corners[5], (Vec3d{7, 8, 10}));

  std::filesystem::remove(path);
  EXPECT_THROW(render::read_stl(path), core::Error);
  EXPECT_EQ(error("PLY"), "body " + path +
                              ": no STL: it neither begins with 'solid' nor has the 84 bytes of a "
                              "binary header");
  std::string other = binary_stl(corners, 3);
  other[0] = 'S';
  EXPECT_EQ(error(other), "body " + path +
                              ": no STL: it does not begin with 'solid', and as a binary file of 3 "
                              "triangles it would have 234 bytes, not 184");
  EXPECT_EQ(error(binary_stl({}, 0)), "body " + path + ": no triangle in it");
  EXPECT_EQ(error(binary_stl({0, 0, 0, NAN, 0, 0, 0, 0, 0}, 1)),
            "body " + path + ": a corner of triangle 0 is not finite");
  EXPECT_EQ(error("solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 x1\n"),
            path + ":4: a number expected, 'x1' found");
  EXPECT_EQ(error("solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 1\n"),
            path + ":5: 'vertex' expected, the end of the file found");
  EXPECT_EQ(error("solid\nfoo"), path + ":2: 'facet' or 'endsolid' expected, 'foo' found");
  EXPECT_EQ(error("solid\nendsolid\n"), "body " + path + ": no triangle in it");
}

TEST(Outline, LinesAreWhereTheEdgesAreAndBehindWhatHidesThem) {
  RenderMesh mesh(2);
  FrameSettings s = box_frame(101);
  s.background = {1, 1, 1};
  s.outline = render::OutlineSettings{{1, 0, 0}, 3};
  s.lighting.enabled = false;
  s.camera.fov = 60;
  for (const double height : {0.0, 2.0}) {
    s.camera.orthographic_height = height;
    const render::RayGenerator rays(s.camera, 101, 101);
    // The pixel whose ray passes nearest by a point, and how near, in pixels.
    const auto pixel_of = [&](const Vec3d& p) {
      std::pair<int, double> best{0, HUGE_VAL};
      for (int i = 0; i < 101 * 101; ++i) {
        const render::Ray ray = rays(i % 101, i / 101);
        const Vec3d d = p - ray.origin, off = d - dot(d, ray.direction) * ray.direction;
        if (dot(off, off) < best.second)
          best = {i, dot(off, off)};
      }
      return best.first;
    };
    const auto color = [&](const core::Image& image, const Vec3d& p) {
      const int i = pixel_of(p);
      return Color{image.pixel(i % 101, i / 101)[0], image.pixel(i % 101, i / 101)[1],
                   image.pixel(i % 101, i / 101)[2]};
    };
    s.boundary.reset();
    core::Image image = mesh.draw(s);
    // All twelve edges show; inside of faces nothing does.
    for (const double u : {0.0, 0.3, 0.7, 1.0})
      for (int axis = 0; axis < 3; ++axis)
        for (int side = 0; side < 4; ++side) {
          Vec3d p;
          p[axis] = u;
          p[(axis + 1) % 3] = side & 1;
          p[(axis + 2) % 3] = side >> 1;
          EXPECT_EQ(color(image, p).g, 0) << p.x << ", " << p.y << ", " << p.z;
          EXPECT_EQ(color(image, p).r, 1);
        }
    EXPECT_EQ(color(image, {0.8, 0.8, 1}).g, 1);
    EXPECT_EQ(image.pixel(0, 0)[1], 1);
    // Those behind opaque faces are hidden, those on them are not.
    s.boundary = BoundarySettings{1, Color{0, 0, 1}};
    image = mesh.draw(s);
    EXPECT_EQ(color(image, {0, 0.4, 0}).b, 1);
    EXPECT_EQ(color(image, {0, 0, 0.4}).b, 1);
    EXPECT_EQ(color(image, {1, 0.4, 1}).r, 1);
    EXPECT_EQ(color(image, {0.4, 1, 1}).r, 1);
    EXPECT_EQ(color(image, {1, 1, 1}).r, 1);
    EXPECT_EQ(color(image, {0, 1, 0.6}).r, 1); // at the silhouette
  }
  // A camera on an edge, looking along it.
  s.camera.orthographic_height = 0;
  s.camera.position = {0, 0, 0.5};
  s.camera.look_at = {0.1, 0.1, 1};
  s.boundary.reset();
  const core::Image image = mesh.draw(s);
  for (const float value : image.rgba)
    EXPECT_TRUE(std::isfinite(value));
}

} // namespace
} // namespace insitu::test
