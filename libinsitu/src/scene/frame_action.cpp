#include "scene/frame_action.h"

#include <algorithm>
#include <optional>

#include "core/status.h"
#include "core/suggest.h"
#include "core/timer.h"
#include "output/overlay.h"
#include "output/png.h"
#include "render/frame.h"

namespace insitu::scene {

namespace {

render::Color to_linear(const Color& c) {
  return render::linear_of_srgb(c.red, c.green, c.blue);
}

/// How far apart the samples of a volume are, in typical cells.
double step_of(Accuracy accuracy) {
  switch (accuracy) {
  case Accuracy::fast: return 1.0;
  case Accuracy::standard: return 0.5;
  case Accuracy::exact: break;
  }
  return 0.25;
}

class FrameAction final : public Action {
public:
  FrameAction(const Frame& frame, const Environment& environment)
      : frame_(frame), environment_(environment) {
    // Colour maps are read now, so that a wrong one is told when the session opens.
    if (frame_.volume)
      volume_colors_ = color_map(frame_.volume->colors);
    for (const Isosurface& surface : frame_.isosurfaces) {
      const auto* by = std::get_if<ColorBy>(&surface.color);
      surface_colors_.push_back(by ? std::optional(color_map(by->colors)) : std::nullopt);
    }
  }

  const char* kind() const override { return "frame"; }
  const std::string& name() const override { return frame_.name; }
  const Trigger& trigger() const override { return frame_.trigger; }
  const Name& mesh_name() const override { return frame_.mesh; }

  void execute(query::CommittedMesh& mesh, const Step& step, bool due) override {
    if (!due)
      return;
    const core::Timer timer;
    core::Context& context = environment_.context;
    if (mesh.tree().empty())
      throw core::Error(INSITU_ERROR_MESH,
                        "mesh '" + mesh.mesh().name() + "' has no cell that could be drawn");
    render::FrameSettings settings;
    settings.width = frame_.size[0];
    settings.height = frame_.size[1];
    settings.camera = camera(mesh);
    settings.background = to_linear(frame_.background);
    settings.lighting.enabled =
        std::find(frame_.effects.begin(), frame_.effects.end(), FrameEffect::lighting) !=
        frame_.effects.end();
    std::optional<render::VertexAverage> average; // for as long as the frame is drawn
    if (frame_.volume)
      settings.volume = volume(mesh, *frame_.volume, average);
    for (std::size_t i = 0; i < frame_.isosurfaces.size(); ++i)
      settings.isosurfaces.push_back(isosurface(mesh, frame_.isosurfaces[i], surface_colors_[i]));
    core::Image image =
        render::render_frame(mesh.sampler(), settings, context.threads, context.memory);
    draw_overlays(image, settings, step);
    environment_.statistics.render_s += timer.seconds();

    const core::Timer output_timer;
    output::write_png(cycle_path(environment_, frame_.name, step.cycle, ".png"), image);
    environment_.statistics.output_s += output_timer.seconds();
    ++environment_.statistics.frames;
    ++environment_.statistics.files;
    ++drawn_;
  }

private:
  render::ColorMap color_map(const ColorMap& colors) const {
    try {
      return colors.path.empty() ? render::ColorMap::built_in(colors.name)
                                 : render::load_color_map(colors.path);
    } catch (const core::Error& e) {
      throw core::Error(e.status(), at_line(colors.line) + e.what());
    }
  }

  std::string at_line(int line) const {
    return line > 0 ? environment_.scene_file + ":" + std::to_string(line) + ": " : std::string();
  }

  render::ScalarField scalar(const query::CommittedMesh& mesh, const Name& name,
                             const Component& component) const {
    const mesh::FieldView field = find_field(mesh, name, environment_.scene_file);
    if (component.index >= field.components)
      throw core::Error(INSITU_ERROR_SCENE,
                        at_line(name.line) + "component " + std::to_string(component.index) +
                            " of field '" + name.text + "', which has " +
                            std::to_string(field.components));
    return {field, component.index};
  }

  render::TransferFunction transfer(const query::CommittedMesh& mesh,
                                    const render::ScalarField& field,
                                    const render::ColorMap& colors,
                                    const std::optional<ValueRange>& range,
                                    const std::vector<OpacityPoint>& opacity) const {
    double low = 0, high = 1;
    if (range) {
      low = range->low;
      high = range->high;
    } else {
      const render::ScalarRange found =
          render::scalar_range(mesh.mesh().view(), field, environment_.context.threads);
      if (found.low <= found.high) { // else no value at all: nothing will be drawn
        low = found.low;
        high = found.high;
      }
    }
    std::vector<render::OpacityPoint> points;
    for (const OpacityPoint& p : opacity)
      points.push_back({p.value, p.opacity});
    return {colors, low, high, std::move(points)};
  }

  render::VolumeSettings volume(const query::CommittedMesh& mesh, const Volume& from,
                                std::optional<render::VertexAverage>& average) const {
    render::ScalarField field = scalar(mesh, from.field, from.component);
    const render::TransferFunction function =
        transfer(mesh, field, *volume_colors_, from.range, from.opacity);
    if (from.smooth && field.field.association == INSITU_CELL) {
      average.emplace(mesh.mesh().view(), field, environment_.context.threads,
                      environment_.context.memory);
      field = average->field();
    }
    render::VolumeSettings to{field, function,
                              frame_.step * step_of(frame_.accuracy), std::nullopt,
                              from.unit_distance.value_or(0.0), to_api(frame_.accuracy)};
    return to;
  }

  render::IsosurfaceSettings isosurface(const query::CommittedMesh& mesh, const Isosurface& from,
                                        const std::optional<render::ColorMap>& colors) const {
    render::IsosurfaceSettings to;
    to.field = scalar(mesh, from.field, from.component);
    to.values = from.values;
    to.opacity = from.opacity;
    if (const auto* by = std::get_if<ColorBy>(&from.color)) {
      const render::ScalarField field = scalar(mesh, by->field, by->component);
      to.color = render::ColorByField{field, transfer(mesh, field, *colors, by->range, {})};
    } else {
      to.color = to_linear(std::get<Color>(from.color));
    }
    return to;
  }

  render::Camera camera(const query::CommittedMesh& mesh) const {
    const Camera& from = frame_.camera;
    const math::Vec3d low = mesh.tree().bounds_min(), high = mesh.tree().bounds_max();
    render::Camera to;
    if (from.position) {
      to.position = *from.position;
      to.look_at = from.look_at.value_or(0.5 * (low + high));
      to.up = from.up;
      to.fov = from.fov;
    } else {
      to = render::Camera::around(low, high, from.azimuth, from.elevation, from.zoom, from.fov,
                                  double(frame_.size[0]) / frame_.size[1]);
    }
    if (from.orbit_azimuth_per_frame != 0.0)
      to = to.orbited(double(drawn_) * from.orbit_azimuth_per_frame);
    return to;
  }

  void draw_overlays(core::Image& image, const render::FrameSettings& settings,
                     const Step& step) const {
    output::Overlay overlay;
    overlay.background = settings.background;
    if (frame_.scalar_bar && settings.volume)
      output::draw_scalar_bar(image, settings.volume->function, frame_.volume->field.text, overlay);
    else if (frame_.scalar_bar)
      for (const render::IsosurfaceSettings& surface : settings.isosurfaces)
        if (const auto* by = std::get_if<render::ColorByField>(&surface.color)) {
          output::draw_scalar_bar(image, by->function, by->field.field.name, overlay);
          break;
        }
    if (frame_.time_label)
      output::draw_time_label(image, step.time, step.cycle, overlay);
  }

  Frame frame_;
  Environment environment_;
  std::optional<render::ColorMap> volume_colors_;
  std::vector<std::optional<render::ColorMap>> surface_colors_;
  std::int64_t drawn_ = 0; ///< frames so far, for the orbit
};

} // namespace

std::unique_ptr<Action> make_frame_action(const Frame& frame, const Environment& environment) {
  return std::make_unique<FrameAction>(frame, environment);
}

} // namespace insitu::scene
