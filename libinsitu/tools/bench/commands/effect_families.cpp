#include "commands/effect_families.h"

#include <cmath>
#include <memory>

#include "output/annotate/overlay.h"
#include "output/annotate/time_label.h"

namespace insitu::bench {

namespace {

using render::FrameSettings;

class Families {
public:
  Families(int size, const render::ScalarField& of_vertices, const render::ScalarField& of_cells,
           core::Memory& memory)
      : size_(size), vertices_(of_vertices), cells_(of_cells), memory_(memory) {}

  std::vector<EffectFamily> all() const { return {volumes(), cell_volumes(), surfaces(), paths()}; }

private:
  render::ScalarField field() const { return vertices_; }
  FrameSettings frame() const {
    FrameSettings s;
    s.width = s.height = size_;
    s.camera = render::Camera::around({0, 0, 0}, {1, 1, 1}, 30, 20);
    s.lighting.enabled = false;
    return s;
  }
  static render::TransferFunction function() {
    return {render::ColorMap::built_in("viridis"), 0.0, 1.2, {{0.35, 0.0}, {1.2, 0.2}}};
  }

  EffectFamily volumes() const {
    EffectFamily f{"volume", frame(), {}};
    f.bare.volume = render::VolumeSettings{field(), function()};
    f.bare.volume->skip_empty = false;
    f.effects = {
        {"space skipping", [](FrameSettings& s) { s.volume->skip_empty = true; }},
        {"half the step", [](FrameSettings& s) { s.volume->step_factor *= 0.5; }},
        {"error bound 0.01", [](FrameSettings& s) { s.volume->tolerance = 0.01; }},
        // Takes even steps, which an error bound does not.
        {"pre-integration", [](FrameSettings& s) { s.volume->preintegrated = true; }, false},
        {"gradient lighting",
         [](FrameSettings& s) {
           s.volume->shading = true;
           s.lighting.enabled = true;
         }},
        {"clip plane", [](FrameSettings& s) { s.clips.push_back(middle()); }},
        {"clip box", [](FrameSettings& s) { s.clips.push_back(box()); }},
        {"clip sphere", [](FrameSettings& s) { s.clips.push_back(sphere()); }},
        {"isosurface inside",
         [field = field()](FrameSettings& s) {
           s.isosurfaces.push_back({field, {0.8}, 0.5});
         },
         false},
        {"isosurface, volume shadows",
         [field = field()](FrameSettings& s) {
           s.isosurfaces.push_back({field, {0.8}, 0.5});
           s.lighting.enabled = s.lighting.shadows = s.lighting.volume_shadows = true;
           s.lighting.lights = {{render::Light::Kind::directional, {1, 1, 2}, {1, 1, 1}}};
         }},
        {"logarithmic colours",
         [](FrameSettings& s) {
           render::ColorMap colors = s.volume->function.colors();
           colors.set_scale(render::Scale::log);
           s.volume->function = {colors, 0.1, 1.2, s.volume->function.opacity_points()};
         }},
        {"images of depth and cell", [](FrameSettings& s) { s.depth = s.cell = true; }},
        {"scalar bar and time label", [](FrameSettings&) {}, true, draw_labels}};
    return f;
  }

  EffectFamily cell_volumes() const {
    EffectFamily f{cell_volume, frame(), {}};
    f.bare.volume = render::VolumeSettings{cells_, function()};
    f.bare.volume->skip_empty = false;
    f.effects = {{"averaged at vertices", [](FrameSettings&) {}}};
    return f;
  }

  EffectFamily surfaces() const {
    EffectFamily f{"isosurface", frame(), {}};
    f.bare.isosurfaces.push_back({field(), {0.5}, 1});
    f.effects = {
        {"lighting", [](FrameSettings& s) { s.lighting.enabled = true; }},
        {"shadows",
         [](FrameSettings& s) {
           s.lighting.enabled = s.lighting.shadows = true;
           s.lighting.lights = {{render::Light::Kind::directional, {1, 1, 2}, {1, 1, 1}}};
         }},
        {"ambient occlusion, 16 rays",
         [](FrameSettings& s) {
           s.lighting.enabled = true;
           s.lighting.occlusion_samples = 16;
         }},
        {"smooth normals, lit",
         [](FrameSettings& s) {
           s.lighting.enabled = true;
           s.isosurfaces[0].normals = render::Normals::smooth;
         }},
        {"central normals, lit",
         [](FrameSettings& s) {
           s.lighting.enabled = true;
           s.isosurfaces[0].normals = render::Normals::central;
         },
         false},
        {"search by cubics",
         [](FrameSettings& s) { s.isosurfaces[0].search = render::RootSearch::cubic; }, false},
        {"Neubauer's search",
         [](FrameSettings& s) { s.isosurfaces[0].search = render::RootSearch::neubauer; }, false},
        {"colours by field",
         [field = field()](FrameSettings& s) {
           for (render::IsosurfaceSettings& i : s.isosurfaces)
             i.color = render::ColorByField{field, function()};
         }},
        {"transparent",
         [](FrameSettings& s) {
           for (render::IsosurfaceSettings& i : s.isosurfaces)
             i.opacity = 0.5;
         }},
        {"second isovalue", [](FrameSettings& s) { s.isosurfaces[0].values.push_back(0.7); }},
        {"clip plane", [](FrameSettings& s) { s.clips.push_back(middle()); }},
        {"body of 4096 triangles", [](FrameSettings& s) { s.bodies.push_back(ball()); }},
        {"boundary, transparent",
         [](FrameSettings& s) {
           s.boundary = render::BoundarySettings{0.2, {}};
         }},
        {"outline", [](FrameSettings& s) { s.outline = render::OutlineSettings{}; }},
        {"images of depth and cell", [](FrameSettings& s) { s.depth = s.cell = true; }}};
    return f;
  }

  /// Of four paths a pixel, so that a frame takes about as long as one by marching.
  EffectFamily paths() const {
    EffectFamily f{"path tracing", frame(), {}};
    f.bare.volume = render::VolumeSettings{field(), function()};
    f.bare.path_tracing = render::PathTracingSettings{};
    f.bare.path_tracing->samples = 4;
    f.bare.path_tracing->scattering = render::Scattering::none;
    f.bare.lighting.lights = {{render::Light::Kind::directional, {1, 1, 2}, {1, 1, 1}},
                              {render::Light::Kind::dome, {}, {0.3f, 0.3f, 0.3f}}};
    f.effects = {
        {"single scattering",
         [](FrameSettings& s) { s.path_tracing->scattering = render::Scattering::single; }},
        {"multiple scattering",
         [](FrameSettings& s) { s.path_tracing->scattering = render::Scattering::multiple; }},
        {"multiple, anisotropy 0.6",
         [](FrameSettings& s) {
           s.path_tracing->scattering = render::Scattering::multiple;
           s.path_tracing->anisotropy = 0.6;
         }},
        {"accumulation", [sums = std::make_shared<render::PathSums>(memory_)](
                             FrameSettings& s) { s.path_tracing->sums = sums.get(); }},
        {"twice the samples", [](FrameSettings& s) { s.path_tracing->samples *= 2; }}};
    return f;
  }

  static void draw_labels(core::Image& image, const FrameSettings& s) {
    output::draw_scalar_bar(image, s.volume->function, "f");
    output::draw_time_label(image, output::TimeLabel()(0.25, 120));
  }
  /// A sphere of quads in two, each 64 around and 32 from pole to pole.
  static render::BodySettings ball() {
    auto list = std::make_shared<render::TriangleList>();
    list->source = "ball";
    const auto at = [](int i, int j) {
      const double a = 2 * M_PI * i / 64, b = M_PI * j / 32;
      return math::Vec3d{0.5 + 0.2 * std::sin(b) * std::cos(a),
                         0.5 + 0.2 * std::sin(b) * std::sin(a), 0.5 + 0.2 * std::cos(b)};
    };
    for (int j = 0; j < 32; ++j)
      for (int i = 0; i < 64; ++i)
        list->corners.insert(list->corners.end(), {at(i, j), at(i, j + 1), at(i + 1, j),
                                                   at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)});
    return {list};
  }

  static render::Clip box() { return {render::Clip::Kind::box, {0.1, 0.1, 0.1}, {0.9, 0.9, 0.6}}; }
  static render::Clip sphere() { return {render::Clip::Kind::sphere, {0.5, 0.5, 0.5}, {}, 0.4}; }
  static render::Clip middle() {
    render::Clip clip;
    clip.point = {0.5, 0.5, 0.5};
    clip.vector = {0, 1, 0};
    return clip;
  }

  int size_;
  render::ScalarField vertices_, cells_;
  core::Memory& memory_;
};

} // namespace

std::vector<EffectFamily> effect_families(int size, const render::ScalarField& of_vertices,
                                          const render::ScalarField& of_cells,
                                          core::Memory& memory) {
  return Families(size, of_vertices, of_cells, memory).all();
}

} // namespace insitu::bench
