#include "scene/frame_settings.h"

#include <algorithm>

#include "core/status.h"

namespace insitu::scene {

namespace {

render::Color to_linear(const Color& c) {
  return render::linear_of_srgb(c.red, c.green, c.blue);
}

render::Light to_render(const Light& light) {
  using Kind = render::Light::Kind;
  constexpr Kind kinds[] = {Kind::head, Kind::directional, Kind::point, Kind::dome};
  return {kinds[int(light.kind)], light.vector, float(light.intensity) * to_linear(light.color)};
}

render::Clip to_render(const Clip& clip) {
  using Kind = render::Clip::Kind;
  constexpr Kind kinds[] = {Kind::plane, Kind::box, Kind::sphere};
  return {kinds[int(clip.kind)], clip.point, clip.vector, clip.radius, clip.keep_inside};
}

/// How far apart the samples of a volume are, in typical cells.
double step_of(Accuracy accuracy) {
  switch (accuracy) {
  case Accuracy::fast:
    return 1.0;
  case Accuracy::standard:
    return 0.5;
  case Accuracy::exact:
    break;
  }
  return 0.25;
}

} // namespace

FrameSettingsMaker::FrameSettingsMaker(const Frame& frame, const Environment& environment)
    : frame_(frame), environment_(environment) {
  if (frame_.volume)
    volume_colors_ = color_map(frame_.volume->colors);
  for (const Isosurface& surface : frame_.isosurfaces) {
    const auto* by = std::get_if<ColorBy>(&surface.color);
    surface_colors_.push_back(by ? std::optional(color_map(by->colors)) : std::nullopt);
  }
  if (frame_.boundary)
    if (const auto* by = std::get_if<ColorBy>(&frame_.boundary->color))
      boundary_colors_ = color_map(by->colors);
  bodies_ = load_bodies();
}

render::FrameSettings FrameSettingsMaker::make(const query::CommittedMesh& mesh,
                                               render::Structures& structures,
                                               std::int64_t drawn) const {
  render::FrameSettings settings;
  settings.width = frame_.size[0];
  settings.height = frame_.size[1];
  settings.camera = camera(mesh, drawn);
  settings.background = to_linear(frame_.background);
  const auto asks_for = [&](FrameEffect effect) {
    return std::find(frame_.effects.begin(), frame_.effects.end(), effect) != frame_.effects.end();
  };
  settings.lighting.shadows = asks_for(FrameEffect::shadows);
  if (asks_for(FrameEffect::ambient_occlusion)) {
    settings.lighting.occlusion_samples = frame_.occlusion.samples;
    settings.lighting.occlusion_distance = frame_.occlusion.distance.value_or(0.0);
  }
  settings.lighting.enabled = asks_for(FrameEffect::lighting) || settings.lighting.shadows ||
                              settings.lighting.occlusion_samples > 0;
  for (const Light& light : frame_.lights)
    settings.lighting.lights.push_back(to_render(light));
  for (const Clip& clip : frame_.clips)
    settings.clips.push_back(to_render(clip));
  if (frame_.volume)
    settings.volume = volume(mesh, structures, *frame_.volume);
  for (std::size_t i = 0; i < frame_.isosurfaces.size(); ++i)
    settings.isosurfaces.push_back(
        isosurface(mesh, structures, frame_.isosurfaces[i], surface_colors_[i]));
  if (frame_.boundary)
    settings.boundary = boundary(mesh, structures, *frame_.boundary);
  settings.bodies = bodies_;
  if (frame_.outline)
    settings.outline = {to_linear(frame_.outline->color), frame_.outline->width};
  return settings;
}

render::ColorMap FrameSettingsMaker::color_map(const ColorMap& colors) const {
  try {
    return colors.path.empty() ? render::ColorMap::built_in(colors.name)
                               : render::load_color_map(colors.path);
  } catch (const core::Error& e) {
    throw core::Error(e.status(), at_line(colors.line) + e.what());
  }
}

std::string FrameSettingsMaker::at_line(int line) const {
  return line > 0 ? environment_.scene_file + ":" + std::to_string(line) + ": " : std::string();
}

render::ScalarField FrameSettingsMaker::scalar(const query::CommittedMesh& mesh, const Name& name,
                                               const Component& component) const {
  const mesh::FieldView field = find_field(mesh, name, environment_.scene_file);
  if (component.index >= field.components)
    throw core::Error(INSITU_ERROR_SCENE, at_line(name.line) + "component " +
                                              std::to_string(component.index) + " of field '" +
                                              name.text + "', which has " +
                                              std::to_string(field.components));
  return {field, component.index};
}

render::TransferFunction
FrameSettingsMaker::transfer(render::Structures& structures, const render::ScalarField& field,
                             const render::ColorMap& colors, const std::optional<ValueRange>& range,
                             const std::vector<OpacityPoint>& opacity) const {
  double low = 0, high = 1;
  if (range) {
    low = range->low;
    high = range->high;
  } else {
    const render::ScalarRange found = structures.scalar_range(field);
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

render::VolumeSettings FrameSettingsMaker::volume(const query::CommittedMesh& mesh,
                                                  render::Structures& structures,
                                                  const Volume& from) const {
  render::ScalarField field = scalar(mesh, from.field, from.component);
  const render::TransferFunction function =
      transfer(structures, field, *volume_colors_, from.range, from.opacity);
  if (from.smooth && field.field.association == INSITU_CELL)
    field = structures.average(field).field();
  render::VolumeSettings to{field,
                            function,
                            frame_.step * step_of(frame_.accuracy),
                            std::nullopt,
                            from.unit_distance.value_or(0.0),
                            to_api(frame_.accuracy)};
  return to;
}

render::IsosurfaceSettings
FrameSettingsMaker::isosurface(const query::CommittedMesh& mesh, render::Structures& structures,
                               const Isosurface& from,
                               const std::optional<render::ColorMap>& colors) const {
  render::IsosurfaceSettings to;
  to.field = scalar(mesh, from.field, from.component);
  to.values = from.values;
  to.opacity = from.opacity;
  constexpr render::Normals normals[] = {render::Normals::cell, render::Normals::smooth,
                                         render::Normals::central};
  to.normals = normals[int(from.normals)];
  to.search =
      from.search == RootSearch::exact ? render::RootSearch::exact : render::RootSearch::neubauer;
  if (const auto* by = std::get_if<ColorBy>(&from.color)) {
    const render::ScalarField field = scalar(mesh, by->field, by->component);
    to.color = render::ColorByField{field, transfer(structures, field, *colors, by->range, {})};
  } else {
    to.color = to_linear(std::get<Color>(from.color));
  }
  return to;
}

render::BoundarySettings FrameSettingsMaker::boundary(const query::CommittedMesh& mesh,
                                                      render::Structures& structures,
                                                      const Boundary& from) const {
  render::BoundarySettings to;
  to.opacity = from.opacity;
  if (const auto* by = std::get_if<ColorBy>(&from.color)) {
    const render::ScalarField field = scalar(mesh, by->field, by->component);
    to.color =
        render::ColorByField{field, transfer(structures, field, *boundary_colors_, by->range, {})};
  } else {
    to.color = to_linear(std::get<Color>(from.color));
  }
  return to;
}

std::vector<render::BodySettings> FrameSettingsMaker::load_bodies() const {
  std::vector<render::BodySettings> bodies;
  for (const Body& from : frame_.bodies) {
    try {
      bodies.push_back({std::make_shared<render::TriangleList>(render::read_stl(from.path)),
                        from.opacity, to_linear(from.color)});
    } catch (const core::Error& e) {
      throw core::Error(e.status(), at_line(from.line) + e.what());
    }
  }
  return bodies;
}

render::Camera FrameSettingsMaker::camera(const query::CommittedMesh& mesh,
                                          std::int64_t drawn) const {
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
    to = to.orbited(double(drawn) * from.orbit_azimuth_per_frame);
  return to;
}

} // namespace insitu::scene
