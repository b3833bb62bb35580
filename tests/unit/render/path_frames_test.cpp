// Path traced frames as a whole: the same bytes however made, surfaces, samples that add up,
// counts.
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>

#include "unit/render/path_frames.h"

namespace insitu::test {
namespace {

using render::PathCounts;
using render::PathTracingSettings;
using render::Scattering;

bool same_bytes(const core::Image& a, const core::Image& b) {
  return a.rgba.size() == b.rgba.size() &&
         std::memcmp(a.rgba.data(), b.rgba.data(), a.rgba.size() * sizeof(float)) == 0;
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

/// Half of the light is gone at ln 2 / k into a homogeneous medium; the median of n stops has the
/// standard error 1 / (k sqrt(n)).
TEST(PathFrames, DepthIsWhereHalfOfThePathsStop) {
  RenderMesh mesh(5);
  const auto x = mesh.field("x", INSITU_VERTEX, x_of);
  const double k = 3;
  FrameSettings s = one_ray(8);
  s.volume = VolumeSettings{x, medium_of({1, 1, 1}, opacity_of(k), opacity_of(k))};
  s.volume->unit_distance = 1;
  s.path_tracing->samples = 201;
  s.depth = s.cell = true;
  const auto draw = [&] {
    return render::render_frame(mesh.sampler(), s, mesh.committed.threads, mesh.committed.memory);
  };
  const render::FrameImages images = draw();
  double sum = 0;
  for (std::size_t i = 0; i < 64; ++i) {
    sum += images.depth[i];
    const Vec3d at = s.camera.position + Vec3d{double(images.depth[i]), 0, 0};
    EXPECT_EQ(images.cell[i], mesh.sampler().locate(at).cell) << i;
  }
  EXPECT_NEAR(sum / 64, 1 + std::log(2.0) / k, most_errors / (k * std::sqrt(64.0 * 201)));
  // A surface in front of that is what is seen; behind a thin medium there is nothing.
  s.isosurfaces.push_back({x, {0.1}, 1, render::Color{1, 1, 1}});
  EXPECT_NEAR(draw().depth[9], 1.1, 1e-6);
  s.isosurfaces.clear();
  s.path_tracing->density = 0.1;
  EXPECT_EQ(draw().depth[9], HUGE_VALF);
  EXPECT_EQ(draw().cell[9], -1);
}

} // namespace
} // namespace insitu::test
