// Path traced frames as a whole: the same bytes however made, surfaces, samples that add up,
// counts, hard cases.
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>

#include "core/status.h"
#include "unit/render/path_mesh.h"

namespace insitu::test {
namespace {

using render::FrameSettings;
using render::Light;
using render::PathCounts;
using render::PathTracingSettings;
using render::Scattering;
using render::VolumeSettings;

double x_of(const Vec3d& p) {
  return p.x;
}
double one_of(const Vec3d&) {
  return 1.0;
}
double blob_of(const Vec3d& p) {
  const Vec3d d = p - Vec3d{0.6, 0.5, 0.4};
  return std::exp(-20 * dot(d, d));
}

VolumeSettings volume_of(const render::ScalarField& field, double first, double last) {
  VolumeSettings v{field, medium_of({0.9f, 0.7f, 0.4f}, first, last)};
  v.unit_distance = 0.2;
  return v;
}

/// Of a blob, with all kinds of lights.
FrameSettings blob_frame(const render::ScalarField& blob, int size) {
  FrameSettings s = box_frame(size);
  s.volume = volume_of(blob, 0, 0.9);
  s.path_tracing.emplace().samples = 4;
  s.path_tracing->anisotropy = 0.3;
  using Kind = Light::Kind;
  s.lighting.lights = {{Kind::dome, {}, {0.3f, 0.4f, 0.5f}},
                       {Kind::directional, {1, 2, 1}, {1, 1, 1}},
                       {Kind::point, {1.5, 0.5, 0.5}, {1, 1, 1}},
                       {Kind::head, {}, {0.2f, 0.2f, 0.2f}}};
  return s;
}

bool same_bytes(const core::Image& a, const core::Image& b) {
  return a.rgba.size() == b.rgba.size() &&
         std::memcmp(a.rgba.data(), b.rgba.data(), a.rgba.size() * sizeof(float)) == 0;
}

bool is_finite(const core::Image& image) {
  for (const float v : image.rgba)
    if (!std::isfinite(v))
      return false;
  return true;
}

TEST(PathFrames, SameBytesHoweverDrawn) {
  RenderMesh mesh(8, Shape::tetrahedron, 0.2);
  const auto blob = mesh.field("blob", INSITU_VERTEX, blob_of);
  FrameSettings s = blob_frame(blob, 40);
  s.width = 53; // not a multiple of a tile
  s.isosurfaces.push_back({mesh.field("x", INSITU_VERTEX, x_of), {0.3}, 0.5});
  const core::Image one = draw_paths(mesh, s, nullptr, 1);
  for (const int threads : {2, 5})
    EXPECT_TRUE(same_bytes(one, draw_paths(mesh, s, nullptr, threads))) << threads;
  using Locate = PathTracingSettings::Locate;
  for (const Locate locate : {Locate::single, Locate::last_cell}) {
    s.path_tracing->locate = locate;
    EXPECT_TRUE(same_bytes(one, draw_paths(mesh, s))) << int(locate);
  }
  s.path_tracing->locate = Locate::batch;
  for (const accel::Method method :
       {accel::Method::user_geometry, accel::Method::replicated_faces, accel::Method::shared_faces,
        accel::Method::shared_bilinear_faces}) {
    query::LocatorChoice choice;
    choice.method = method;
    mesh.committed.mesh.set_locator(choice);
    mesh.committed.commit(INSITU_CHANGED_ALL);
    EXPECT_TRUE(same_bytes(one, draw_paths(mesh, s))) << int(method);
  }
  // The keys of the random numbers are pixel, sample, cycle and seed.
  for (const int key : {0, 1}) {
    FrameSettings other = s;
    ++(key == 0 ? other.path_tracing->seed : other.path_tracing->cycle);
    EXPECT_FALSE(same_bytes(one, draw_paths(mesh, other)));
  }
}

/// The same ray through the medium with surfaces in it, whose colours are plain.
TEST(PathFrames, SurfacesWithinTheMedium) {
  RenderMesh mesh(5, Shape::hexahedron, 0.2);
  const auto x = mesh.field("x", INSITU_VERTEX, x_of);
  const double k = 1.3;
  FrameSettings s = one_ray();
  s.volume = VolumeSettings{x, medium_of({0, 0, 1}, opacity_of(k), opacity_of(k))};
  s.volume->unit_distance = 1;
  s.path_tracing->scattering = Scattering::none;
  s.path_tracing->samples = 400;
  s.isosurfaces.push_back({x, {0.4}, 0.5, render::Color{1, 0, 0}});
  s.isosurfaces.push_back({x, {0.85}, 1, render::Color{0, 1, 0}});
  const core::Image image = draw_paths(mesh, s);
  const double first = std::exp(-0.4 * k), second = std::exp(-0.45 * k);
  expect_mean(estimate(image, 0), first * 0.5, "translucent");
  expect_mean(estimate(image, 1), first * 0.5 * second, "opaque");
  expect_mean(estimate(image, 2), 1 - first + first * 0.5 * (1 - second), "medium");
  for (int i = 0; i < 256; ++i)
    ASSERT_EQ(image.pixel(i % 16, i / 16)[3], 1.0f);
}

TEST(PathFrames, ClipsCutTheMedium) {
  RenderMesh mesh(5, Shape::hexahedron, 0.2);
  const auto one = mesh.field("one", INSITU_VERTEX, one_of);
  const double k = 2;
  FrameSettings s = one_ray();
  s.volume = VolumeSettings{one, medium_of({1, 1, 1}, opacity_of(k), opacity_of(k))};
  s.volume->unit_distance = 1;
  s.path_tracing->scattering = Scattering::none;
  s.path_tracing->samples = 200;
  render::Clip ball;
  ball.kind = render::Clip::Kind::sphere;
  ball.point = {0.5, 0.45, 0.55};
  ball.radius = 0.2;
  ball.keep_inside = false; // two stretches of 0.3 are left
  s.clips = {ball};
  expect_mean(estimate(draw_paths(mesh, s), 3), 1 - std::exp(-0.6 * k), "around the ball");
  s.clips[0].keep_inside = true;
  expect_mean(estimate(draw_paths(mesh, s), 3), 1 - std::exp(-0.4 * k), "in the ball");
}

TEST(PathFrames, SamplesAddUpOverFrames) {
  RenderMesh mesh(6, Shape::hexahedron, 0.2);
  FrameSettings s = blob_frame(mesh.field("blob", INSITU_VERTEX, blob_of), 32);
  s.path_tracing->samples = 12;
  const core::Image at_once = draw_paths(mesh, s);
  render::PathSums sums(mesh.committed.memory);
  s.path_tracing->sums = &sums;
  s.path_tracing->samples = 4;
  core::Image image;
  for (int frame = 0; frame < 3; ++frame)
    image = draw_paths(mesh, s);
  EXPECT_EQ(sums.samples, 12);
  for (std::size_t i = 0; i < image.rgba.size(); ++i) // summed in another order, in double
    ASSERT_NEAR(image.rgba[i], at_once.rgba[i], 1e-6 * (1 + std::fabs(at_once.rgba[i])));
  sums.restart();
  image = draw_paths(mesh, s);
  EXPECT_EQ(sums.samples, 4);
  s.path_tracing->sums = nullptr;
  EXPECT_TRUE(same_bytes(image, draw_paths(mesh, s)));
}

TEST(PathFrames, EmptySpaceCostsNoLocation) {
  RenderMesh mesh(16);
  // Nothing but in one corner, away from the rays.
  const auto corner = mesh.field("corner", INSITU_VERTEX, [](const Vec3d& p) {
    return p.x > 0.8 && p.y > 0.8 && p.z > 0.8 ? 1.0 : 0.0;
  });
  FrameSettings s = one_ray();
  s.background = {0.25f, 0.5f, 1};
  s.background_alpha = 1;
  s.volume = volume_of(corner, 0, 1);
  s.path_tracing->cells_per_macrocell = 8;
  PathCounts counts;
  const core::Image image = draw_paths(mesh, s, &counts);
  EXPECT_EQ(counts.locations + counts.paths, 0);
  EXPECT_GT(counts.macrocells, 0);
  EXPECT_EQ(image.pixel(3, 3)[1], 0.5f);
  // Through the corner it is another thing, but only there.
  s.camera.position = {-1, 0.9, 0.9};
  s.camera.look_at = {0, 0.9, 0.9};
  draw_paths(mesh, s, &counts);
  EXPECT_GT(counts.locations, 0);
}

TEST(PathFrames, ANewFunctionOnlyClassifiesAnew) {
  RenderMesh mesh(6);
  FrameSettings s = blob_frame(mesh.field("blob", INSITU_VERTEX, blob_of), 16);
  render::Structures kept(mesh.committed.memory);
  const auto draw = [&] {
    kept.begin(mesh.sampler(), 0, 0, mesh.committed.threads);
    render::render_frame(mesh.sampler(), s, kept, mesh.committed.threads);
    kept.end();
  };
  draw();
  EXPECT_EQ(kept.counts().macrocells, 1);
  EXPECT_EQ(kept.counts().majorants, 1);
  s.path_tracing->density = 3; // not even that
  draw();
  EXPECT_EQ(kept.counts().majorants, 1);
  s.volume->function = medium_of({1, 1, 1}, 0.1, 0.3);
  draw();
  EXPECT_EQ(kept.counts().macrocells, 1);
  EXPECT_EQ(kept.counts().macrocells_refreshed, 0);
  EXPECT_EQ(kept.counts().majorants, 2);
  // Without path tracing nothing of it is made.
  render::Structures none(mesh.committed.memory);
  s.volume.reset();
  s.isosurfaces.push_back({mesh.field("x", INSITU_VERTEX, x_of), {0.5}});
  none.begin(mesh.sampler(), 0, 0, mesh.committed.threads);
  render::FrameStatistics statistics;
  render::render_frame(mesh.sampler(), s, none, mesh.committed.threads, &statistics);
  EXPECT_EQ(none.counts().macrocells + none.counts().majorants, 0);
  EXPECT_EQ(statistics.paths.paths + statistics.paths.macrocells, 0);
}

TEST(PathFrames, PathsThatAreCutAreCounted) {
  RenderMesh mesh(4);
  FrameSettings s = one_ray(8);
  s.volume = VolumeSettings{mesh.field("one", INSITU_VERTEX, one_of), medium_of({1, 1, 1}, 1, 1)};
  s.volume->unit_distance = 0.2;
  s.path_tracing->max_bounces = 3;
  PathCounts counts;
  draw_paths(mesh, s, &counts);
  EXPECT_GT(counts.cut, counts.paths / 4); // far more than ten free paths thick
  s.path_tracing->max_bounces = 1000000;
  draw_paths(mesh, s, &counts);
  EXPECT_EQ(counts.cut, 0);
}

TEST(PathFrames, DomeIsSeenWhereAskedFor) {
  RenderMesh mesh(4);
  FrameSettings s = one_ray(4);
  s.volume = volume_of(mesh.field("x", INSITU_VERTEX, x_of), 0, 0); // nothing to see
  s.lighting.lights = {{Light::Kind::dome, {}, {0.5f, 0.25f, 1}}};
  s.isosurfaces.push_back({s.volume->field, {0.5}, 0.5, render::Color{1, 1, 1}});
  EXPECT_EQ(draw_paths(mesh, s).pixel(1, 1)[3], 0.5f);
  s.path_tracing->shows_dome = true;
  const core::Image image = draw_paths(mesh, s);
  EXPECT_EQ(image.pixel(1, 1)[3], 1.0f);
  EXPECT_FLOAT_EQ(image.pixel(1, 1)[0], 0.75f);
  EXPECT_FLOAT_EQ(image.pixel(1, 1)[1], 0.625f);
}

TEST(PathFrames, HardCases) {
  RenderMesh mesh(5, Shape::hexahedron, 0.2);
  const auto blob = mesh.field("blob", INSITU_VERTEX, blob_of);
  // One pixel; the camera inside, on a face, very far away.
  for (const Vec3d& from : {Vec3d{0.5, 0.5, 0.5}, Vec3d{0, 0.5, 0.5}, Vec3d{1e6, 3e5, 2e5}}) {
    FrameSettings s = blob_frame(blob, 1);
    s.camera.position = from;
    s.camera.look_at = {0.61, 0.52, 0.43};
    s.camera.up = {0, 0, 1};
    s.path_tracing->samples = 200;
    PathCounts counts;
    const core::Image image = draw_paths(mesh, s, &counts);
    EXPECT_TRUE(is_finite(image));
    EXPECT_GT(image.pixel(0, 0)[0], 0.05f) << from.x;
    EXPECT_GT(counts.collisions, 20) << from.x;
  }
  // No opacity at all, and the most there is: by its first unit distance nothing comes through.
  for (const double opacity : {0.0, 1.0}) {
    FrameSettings s = one_ray();
    s.volume = volume_of(mesh.field("one", INSITU_VERTEX, one_of), opacity, opacity);
    s.path_tracing->samples = 20;
    PathCounts counts;
    const core::Image image = draw_paths(mesh, s, &counts);
    EXPECT_TRUE(is_finite(image));
    for (int i = 0; i < 256; ++i)
      ASSERT_EQ(image.pixel(i % 16, i / 16)[3], float(opacity));
    EXPECT_EQ(counts.locations > 0, opacity > 0);
  }
  // A field without numbers, all of it and half of it: nothing there.
  const auto none = mesh.field("nan", INSITU_VERTEX, [](const Vec3d&) { return std::nan(""); });
  FrameSettings s = one_ray(4);
  s.volume = volume_of(none, 0.5, 0.5);
  PathCounts counts;
  EXPECT_EQ(draw_paths(mesh, s, &counts).pixel(0, 0)[3], 0.0f);
  EXPECT_EQ(counts.locations, 0);
  const auto half =
      mesh.field("half", INSITU_CELL, [](const Vec3d& p) { return p.x < 0.5 ? std::nan("") : 1; });
  s = one_ray();
  s.volume = VolumeSettings{half, medium_of({1, 1, 1}, 0.9, 0.9)};
  s.volume->unit_distance = 1;
  s.path_tracing->scattering = Scattering::none;
  s.path_tracing->samples = 100;
  const double alpha = estimate(draw_paths(mesh, s), 3).mean;
  EXPECT_GT(alpha, 1 - std::pow(0.1, 0.25));
  EXPECT_LT(alpha, 1 - std::pow(0.1, 0.75));
  // Values of 1e300 and 1e-300.
  for (const double scale : {1e300, 1e-300}) {
    const auto huge = mesh.field("huge" + std::to_string(scale > 1), INSITU_VERTEX,
                                 [&](const Vec3d& p) { return scale * p.x; });
    s = one_ray();
    s.volume = VolumeSettings{
        huge, {render::ColorMap::built_in("viridis"), 0.0, scale, {{0.0, 0.0}, {scale, 0.7}}}};
    s.volume->unit_distance = 1;
    s.path_tracing->scattering = Scattering::none;
    s.path_tracing->samples = 200;
    const double depth = (0.3 * std::log(0.3) + 0.7) / 0.7; // as of a ramp from 0 to 0.7
    expect_mean(estimate(draw_paths(mesh, s), 3), -std::expm1(-depth), "a huge ramp");
  }
}

/// Transmittance, where coordinates leave no more than nine digits for the mesh.
TEST(PathFrames, MeshFarFromTheOrigin) {
  TestMesh cells = box_cells(5, Shape::hexahedron, 0.2);
  const Vec3d offset{6.4e6, -6.4e6, 6.4e6};
  for (Vec3d& p : cells.vertices)
    p += offset;
  fixtures::Committed committed(cells);
  std::vector<double> values;
  for (const Vec3d& p : cells.vertices)
    values.push_back(p.x - offset.x);
  const insitu_array a =
      insitu_array_of(values.data(), INSITU_FLOAT64, std::int64_t(values.size()), 1);
  committed.mesh.mesh().set_field(0, "x", INSITU_VERTEX, &a, 1);
  committed.commit(INSITU_CHANGED_FIELDS);
  FrameSettings s = one_ray();
  s.camera.position += offset;
  s.camera.look_at += offset;
  s.volume = VolumeSettings{{committed.mesh.mesh().field("x"), -1}, medium_of({1, 1, 1}, 0, 0.7)};
  s.volume->unit_distance = 1;
  s.path_tracing->scattering = Scattering::none;
  s.path_tracing->samples = 400;
  render::FrameStatistics statistics;
  const core::Image image =
      render::render_frame(committed.sampler(), s, committed.threads, committed.memory, &statistics)
          .color;
  EXPECT_EQ(statistics.paths.violations, 0);
  expect_mean(estimate(image, 3), -std::expm1(-(0.3 * std::log(0.3) + 0.7) / 0.7), "far away");
}

TEST(PathFrames, MeshWithoutThickness) {
  TestMesh cells = box_cells(3, Shape::hexahedron, 0);
  for (Vec3d& p : cells.vertices)
    p.x = 0.5;
  fixtures::Committed committed(cells);
  std::vector<double> values(cells.vertices.size(), 1.0);
  const insitu_array a =
      insitu_array_of(values.data(), INSITU_FLOAT64, std::int64_t(values.size()), 1);
  committed.mesh.mesh().set_field(0, "one", INSITU_VERTEX, &a, 1);
  committed.commit(INSITU_CHANGED_FIELDS);
  FrameSettings s = one_ray(4);
  s.volume = VolumeSettings{{committed.mesh.mesh().field("one"), -1}, medium_of({1, 1, 1}, 1, 1)};
  for (const Vec3d& at : {Vec3d{0, 0.45, 0.55}, Vec3d{-0.2, 0.1, 0.3}}) { // across, and along
    s.camera.look_at = at;
    if (at.x < 0)
      s.camera.position = {0.5, -1, 0.5}, s.camera.look_at = {0.5, 0, 0.5};
    render::FrameStatistics statistics;
    const core::Image image = render::render_frame(committed.sampler(), s, committed.threads,
                                                   committed.memory, &statistics)
                                  .color;
    EXPECT_TRUE(is_finite(image));
    EXPECT_EQ(statistics.paths.violations, 0);
    if (at.x == 0) {
      EXPECT_EQ(image.pixel(1, 1)[3], 0.0f); // a ray across has no length in it
    }
  }
}

TEST(PathFrames, RefusesWhatIsOutOfRange) {
  RenderMesh mesh(2);
  FrameSettings good = one_ray(1);
  good.volume = volume_of(mesh.field("x", INSITU_VERTEX, x_of), 0, 1);
  EXPECT_NO_THROW(mesh.draw(good));
  const auto refused = [&](auto&& change) {
    FrameSettings s = good;
    change(s);
    EXPECT_THROW(mesh.draw(s), core::Error);
  };
  refused([](FrameSettings& s) { s.path_tracing->samples = 0; });
  refused([](FrameSettings& s) { s.path_tracing->anisotropy = 1; });
  refused([](FrameSettings& s) { s.path_tracing->anisotropy = std::nan(""); });
  refused([](FrameSettings& s) { s.path_tracing->density = -1; });
  refused([](FrameSettings& s) { s.path_tracing->max_bounces = 0; });
  refused([](FrameSettings& s) { s.path_tracing->roulette = 2; });
  refused([](FrameSettings& s) { s.path_tracing->cells_per_macrocell = 0; });
  refused([](FrameSettings& s) { s.volume->field.component = 1; });
  refused([](FrameSettings& s) {
    s.lighting.lights = {{Light::Kind::directional, {0, 0, 0}, {1, 1, 1}}};
  });
}

} // namespace
} // namespace insitu::test
