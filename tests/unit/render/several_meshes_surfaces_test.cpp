// Surfaces and volumes of several meshes in one frame, against closed forms and one mesh of all
// cells.
#include "unit/render/several_meshes.h"

namespace insitu::test {
namespace {

TEST_F(SeveralMeshes, OpaqueSurfacesHideVolumesAndTransparentOnesSort) {
  const Medium fog{{{0, 0, 0}, {1, 1, 1}}, 0.7, 0.9};
  const Layer volume = layer(fog);
  const RayGenerator rays(frame.camera, frame.width, frame.height);
  // Planes across z, in the fog and before it.
  RenderMesh& box = mesh(cells_of({{-0.5, -0.5, -0.25}, {1.5, 1.5, 1.25}}, 3, 0));
  const auto z = box.field("z", INSITU_VERTEX, [](const Vec3d& p) { return p.z; });
  struct Plane {
    double z, opacity;
    Color color;
  };
  const std::vector<Plane> planes{
      {1.1, 0.3, {1, 0, 0}}, {0.75, 0.4, {0, 1, 0}}, {0.3, 1.0, {0, 0, 1}}};
  FrameSettings s = frame;
  for (const Plane& plane : planes)
    s.isosurfaces.push_back({z, {plane.z}, plane.opacity, plane.color});
  for (const bool reversed : {false, true}) {
    const core::Image image = reversed ? draw({{&box, s}, volume}) : draw({volume, {&box, s}});
    int opaque = 0;
    for (int y = 0; y < s.height; ++y)
      for (int x = 0; x < s.width; ++x) {
        const render::Ray ray = rays(x, y);
        const Stretch in = stretch_of(ray, fog.box),
                      whole = stretch_of(ray, {{-0.5, -0.5, -0.25}, {1.5, 1.5, 1.25}});
        double through = 1, before = in.from;
        Vec3d color;
        const auto fog_to = [&](double t) {
          const double to = std::clamp(t, before, in.to);
          const double alpha = 1 - std::pow(1 - fog.opacity, to - before);
          color += through * alpha * fog.grey * Vec3d{1, 1, 1};
          through *= 1 - alpha;
          before = to;
        };
        bool near_edge = false;
        for (const Plane& plane : planes) {
          const double t = (plane.z - ray.origin.z) / ray.direction.z;
          near_edge |= std::fabs(t - whole.from) < 1e-6 || std::fabs(t - whole.to) < 1e-6;
          if (t < whole.from || t > whole.to)
            continue;
          fog_to(t);
          color += through * plane.opacity * Vec3d{plane.color.r, plane.color.g, plane.color.b};
          through *= 1 - plane.opacity;
        }
        fog_to(in.to);
        if (near_edge)
          continue;
        opaque += through == 0;
        EXPECT_NEAR(image.pixel(x, y)[3], 1 - through, 1e-3); // rays end at an opacity of 0.999
        for (int c = 0; c < 3; ++c)
          EXPECT_NEAR(image.pixel(x, y)[3] * image.pixel(x, y)[c], color[c], 1e-3)
              << x << ", " << y;
      }
    EXPECT_GT(opaque, 100);
  }
}

/// The same cells as two meshes: isosurfaces, a boundary, lit by lights with shadows and occlusion,
/// volumes that cast shadows on each other. Lengths that follow from a mesh's size are given.
TEST_F(SeveralMeshes, PartsThatLieApartAreTheWholeWithItsShadows) {
  const TestMesh lower = cells_of({{0, 0, 0}, {1, 0.4, 1}}, 4);
  const TestMesh upper = cells_of({{0.25, 0.7, 0.2}, {0.75, 1, 0.7}}, 4);
  RenderMesh &a = mesh(lower), &b = mesh(upper), &all = mesh(together(lower, upper));
  const auto f = [](const Vec3d& p) { return p.x + 0.2 * p.y; };
  const auto settings = [&](RenderMesh& of, bool volume) {
    const auto field = of.field("f", INSITU_VERTEX, f);
    FrameSettings s = frame;
    s.lighting.enabled = s.lighting.shadows = true;
    s.lighting.lights = {{render::Light::Kind::directional, {0.2, 1, 0.1}}};
    s.lighting.occlusion_samples = 4;
    s.lighting.occlusion_distance = 0.5;
    s.boundary = render::BoundarySettings{0.6, Color{0.8f, 0.7f, 0.2f}};
    s.isosurfaces.push_back({field, {0.5}, 0.7, Color{0.1f, 0.3f, 0.9f}});
    if (volume) {
      s.lighting.volume_shadows = true;
      s.volume = VolumeSettings{field, constant_function(0.6)};
      s.volume->unit_distance = 1;
      s.volume->step = 0.02;
    }
    return s;
  };
  for (const bool volume : {false, true}) {
    const FrameSettings of_a = settings(a, volume), of_b = settings(b, volume);
    render::FrameStatistics statistics;
    const core::Image whole = all.draw(settings(all, volume));
    const core::Image both = draw({{&a, of_a}, {&b, of_b}}, 2, &statistics);
    EXPECT_GT(statistics.shadow_rays, 0);
    EXPECT_GT(statistics.occlusion_rays, 0);
    const core::Image alone = draw({{&a, of_a}});
    EXPECT_GT(difference(both, alone), 0.1);
    if (!volume) { // products of what comes through in another order
      EXPECT_LT(difference(whole, both), 1e-6);
      continue;
    }
    // The whole's volume ends within the box of both, the parts' at their own: by half a step.
    EXPECT_LT(difference(whole, both), 0.02);
  }
}

/// A cut mesh: see doc/design/frames.md. The volume's stretch that holds the cut is parted there.
TEST_F(SeveralMeshes, HalvesAreTheWhole) {
  const TestMesh cells = box_cells(6, Shape::hexahedron, 0.0);
  const auto [left, right] = halves_of(cells);
  RenderMesh &whole = mesh(cells), &a = mesh(left), &b = mesh(right);
  const auto f = [](const Vec3d& p) { return p.x * p.y + 0.3 * p.z; };
  const auto settings = [&](RenderMesh& of, bool surfaces, double step) {
    const auto field = of.field("f", INSITU_VERTEX, f);
    FrameSettings s = frame;
    s.lighting.enabled = true;
    if (surfaces) {
      s.isosurfaces.push_back({field, {0.3, 0.6}, 0.5, Color{0.1f, 0.3f, 0.9f}});
      return s;
    }
    s.volume = VolumeSettings{field, render::TransferFunction(render::ColorMap::built_in("viridis"),
                                                              0, 1.3, {{0, 0.1}, {1.3, 0.9}})};
    s.volume->unit_distance = 1;
    s.volume->step = step;
    s.volume->preintegrated = true;
    return s;
  };
  const auto error = [&](bool surfaces, double step) {
    return difference(whole.draw(settings(whole, surfaces, step)),
                      draw({{&a, settings(a, surfaces, step)}, {&b, settings(b, surfaces, step)}}));
  };
  EXPECT_EQ(error(true, 0), 0); // no ray of these meets a surface on the cut itself
  // Of second order in the step: values stand still from the last sample to the cut, and from there
  // to the first one behind.
  EXPECT_LT(error(false, 0.08), 1e-2);
  EXPECT_LT(error(false, 0.02), 1e-2 / 16);
}

TEST_F(SeveralMeshes, TouchingSurfacesKeepTheOrderOfTheMeshes) {
  RenderMesh& a = mesh(cells_of({{0, 0, 0}, {1, 1, 0.5}}, 3, 0));
  RenderMesh& b = mesh(cells_of({{0, 0, 0}, {1, 1, 0.5}}, 4, 0, Shape::tetrahedron));
  FrameSettings red = frame, blue = frame;
  red.boundary = render::BoundarySettings{1, Color{1, 0, 0}};
  blue.boundary = render::BoundarySettings{1, Color{0, 0, 1}};
  const core::Image first = draw({{&a, red}, {&b, blue}}), second = draw({{&b, blue}, {&a, red}});
  int covered = 0;
  for (int y = 0; y < frame.height; ++y)
    for (int x = 0; x < frame.width; ++x) {
      if (first.pixel(x, y)[3] == 0)
        continue;
      ++covered;
      EXPECT_EQ(first.pixel(x, y)[2], 0.0f) << x << ", " << y;
      EXPECT_EQ(second.pixel(x, y)[0], 0.0f) << x << ", " << y;
    }
  EXPECT_GT(covered, 200);
}

TEST_F(SeveralMeshes, ThreadsClipsSamplesAndEmptyMeshes) {
  const Box a{{0, 0, 0}, {1, 1, 1}}, b{{0.3, 0.2, 0.4}, {1.2, 0.7, 1.1}};
  frame.clips.push_back({render::Clip::Kind::plane, {0.5, 0.5, 0.5}, {1, 0, 0}});
  frame.samples_per_pixel = 4;
  frame.outline = render::OutlineSettings{};
  frame.outline->box = mesh::Box{{0, 0, 0}, {1.2, 1, 1.1}};
  Layer one = layer({a, 0.6, 0.9}), other = layer({b, 0.8, 0.1});
  other.settings.outline.reset();
  other.settings.boundary = render::BoundarySettings{0.5, Color{0, 1, 0}};
  const core::Image by_one = draw({one, other}, 1);
  for (const int threads : {2, 5})
    EXPECT_EQ(by_one.rgba, draw({one, other}, threads).rgba);
  RenderMesh& empty = mesh(TestMesh{});
  FrameSettings s = frame;
  s.outline.reset();
  EXPECT_EQ(by_one.rgba, draw({one, {&empty, s}, other}).rgba);
}

/// Each cell that is seen holds the place that is seen, in the mesh that the layer names: of media
/// in one place the one that hides more there; of a surface before them its mesh.
TEST_F(SeveralMeshes, CellsTellWhoseTheyAre) {
  const Medium thin{{{0, 0, 0}, {1, 1, 1}}, 0.9, 0.9},
      dense{{{0.3, 0.2, 0.4}, {1.2, 0.7, 1.1}}, 0.99, 0.1};
  std::vector<Layer> layers{layer(thin), layer(dense, 5)};
  RenderMesh& plate = mesh(cells_of({{0, 0, 1.2}, {0.4, 0.4, 1.3}}, 2, 0));
  layers.push_back({&plate, frame});
  layers[2].settings.boundary = render::BoundarySettings{1, Color{1, 0, 0}};
  const RayGenerator rays(frame.camera, frame.width, frame.height);
  for (const char* form : {"samples", "integrals", "paths"}) {
    SCOPED_TRACE(form);
    const bool is_traced = form == std::string("paths");
    for (Layer& of : layers) {
      of.settings.depth = of.settings.cell = true;
      if (of.settings.volume)
        of.settings.volume->preintegrated = form == std::string("integrals");
      if (is_traced)
        of.settings.path_tracing.emplace().samples = 16;
    }
    // Images are counted in the structures' memory.
    RenderMesh* const meshes_of[] = {layers[0].mesh, layers[1].mesh, &plate};
    int seen_of[3] = {};
    const auto check = [&](const FrameImages& images) {
      for (int y = 0; y < frame.height; ++y)
        for (int x = 0; x < frame.width; ++x) {
          const auto at = std::size_t(y * frame.width + x);
          if (images.cell[at] < 0) {
            EXPECT_EQ(images.depth[at], HUGE_VALF);
            continue;
          }
          const auto of = std::size_t(images.layer[at]);
          const render::Ray ray = rays(x, y);
          const Vec3d p = ray.origin + double(images.depth[at]) * ray.direction;
          ++seen_of[of];
          mesh::CellVertices cell;
          ASSERT_LT(images.cell[at], meshes_of[of]->sampler().mesh().cell_count());
          mesh::gather(meshes_of[of]->sampler().mesh(), images.cell[at], cell);
          mesh::Box box{cell.x[0], cell.x[0]};
          for (int v = 1; v < cell.count; ++v)
            box.extend({cell.x[v], cell.x[v]});
          // Samples stand for half a step about them.
          const double slack = is_traced ? 1e-5 : 0.15;
          box.low = box.low - slack * Vec3d{1, 1, 1};
          box.high = box.high + slack * Vec3d{1, 1, 1};
          EXPECT_TRUE(box.holds(p)) << x << ", " << y;
          const Stretch in = stretch_of(ray, dense.box);
          if (!is_traced && of < 2 && double(images.depth[at]) > in.from + slack &&
              double(images.depth[at]) < in.to - slack) {
            EXPECT_EQ(of, 1u) << x << ", " << y;
          }
        }
    };
    draw(layers, 2, nullptr, nullptr, check);
    for (const int seen : seen_of)
      EXPECT_GT(seen, 20);
  }
}

} // namespace
} // namespace insitu::test
