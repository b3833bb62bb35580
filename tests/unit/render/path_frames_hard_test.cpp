// Path traced frames of what is hard, and what is refused.
#include <cmath>
#include <gtest/gtest.h>

#include "core/status.h"
#include "unit/render/path_frames.h"

namespace insitu::test {
namespace {

using render::PathCounts;
using render::Scattering;

bool is_finite(const core::Image& image) {
  for (const float v : image.rgba)
    if (!std::isfinite(v))
      return false;
  return true;
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
