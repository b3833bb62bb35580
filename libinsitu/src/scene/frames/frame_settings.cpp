#include "scene/frames/frame_settings.h"

#include <algorithm>
#include <cmath>

#include "core/status.h"
#include "output/annotate/box_ticks.h"
#include "render/camera/camera_path.h"
#include "render/clip.h"
#include "scene/earth/geocentric_view.h"
#include "scene/run/lookup.h"

namespace insitu::scene {

namespace {

/// An automatic logarithmic range of a field that reaches 0 begins at this part of its greatest
/// value, as ParaView's does: the least value above 0 is often but what rounding left.
constexpr double automatic_decades = 1e-4;

/// How far apart the samples of a volume are, in typical cells.
double step_of(insitu_accuracy accuracy) {
  switch (accuracy) {
  case INSITU_FAST:
    return 1.0;
  case INSITU_STANDARD:
    return 0.5;
  case INSITU_EXACT:
    break;
  }
  return 0.25;
}

double diagonal(const mesh::Box& box) {
  const math::Vec3d size = box.size();
  return std::sqrt(dot(size, size));
}

render::Lighting lighting(const Frame& frame, const FrameDecisions& decisions) {
  render::Lighting to;
  to.enabled = decisions.lit;
  to.shadows = decisions.shadows.made;
  to.volume_shadows = decisions.volume_shadows.made;
  if (decisions.occlusion) {
    to.occlusion_samples = frame.occlusion.samples;
    to.occlusion_distance = frame.occlusion.distance.value_or(0.0);
  }
  to.lights = frame.lights;
  return to;
}

} // namespace

FrameSettingsMaker::FrameSettingsMaker(const Frame& frame, const Environment& environment)
    : frame_(frame), environment_(environment) {
  for (const ColorBy* by : colorings_of(frame_))
    maps_.emplace(by, color_map(by->colors));
  bodies_ = load_bodies();
}

render::FrameSettings FrameSettingsMaker::make(const FrameDecisions& decisions,
                                               const From& from) const {
  const FrameLayer& layer = frame_.layers[from.layer];
  const LayerDecisions& decided = decisions.layers[from.layer];
  render::FrameSettings settings;
  settings.width = frame_.size[0];
  settings.height = frame_.size[1];
  settings.samples_per_pixel = frame_.samples_per_pixel;
  settings.background = frame_.background;
  settings.background_alpha = float(frame_.background_alpha);
  settings.cell = decisions.cell.made;
  settings.depth = decisions.depth.made;
  settings.lighting = lighting(frame_, decisions);
  if (from.all && settings.lighting.occlusion_samples > 0 && !frame_.occlusion.distance)
    settings.lighting.occlusion_distance = 0.1 * diagonal(*from.all);
  settings.clips = frame_.clips;
  if (layer.volume)
    settings.volume = volume(from, *layer.volume, *decided.volume);
  if (frame_.path_tracing)
    settings.path_tracing = *frame_.path_tracing;
  for (std::size_t i = 0; i < layer.isosurfaces.size(); ++i)
    settings.isosurfaces.push_back(isosurface(from, layer.isosurfaces[i], decided.isosurfaces[i]));
  if (layer.boundary)
    settings.boundary = {layer.boundary->opacity,
                         surface_color(from, layer.boundary->color, decided.boundary)};
  if (!from.is_first)
    return settings;
  settings.bodies = bodies_;
  if (frame_.outline) {
    settings.outline = {frame_.outline->color, frame_.outline->width};
    if (from.all)
      settings.outline->box = *from.all;
  }
  return settings;
}

render::ColorMap FrameSettingsMaker::color_map(const ColorMapChoice& colors) const {
  try {
    render::ColorMap map = colors.path.empty() ? render::ColorMap::built_in(colors.name)
                                               : render::load_color_map(colors.path);
    if (colors.scale)
      map.set_scale(*colors.scale);
    if (colors.below)
      map.set_below(*colors.below);
    if (colors.above)
      map.set_above(*colors.above);
    if (colors.nan)
      map.set_nan_color(*colors.nan);
    if (map.scale() == render::Scale::log && colors.range && !(colors.range->low > 0))
      throw core::Error(INSITU_ERROR_SCENE, "colour map '" + map.name() +
                                                "' is logarithmic (UseLogScale): a range above 0 "
                                                "or 'scale: linear' expected");
    return map;
  } catch (const core::Error& e) {
    throw core::Error(e.status(), at_line(environment_.scene_file, colors.line) + e.what());
  }
}

render::TransferFunction
FrameSettingsMaker::transfer(const From& from, const Coloring& coloring,
                             const std::vector<OpacityPoint>& opacity) const {
  const render::ColorMap& colors = map_of(*coloring.by);
  double low = 0, high = 1;
  if (!coloring.pass) {
    low = coloring.by->colors.range->low;
    high = coloring.by->colors.range->high;
  } else {
    const render::ScalarRange found =
        from.ranges ? from.ranges->at(coloring.by) : from.structures.scalar_range(coloring.field);
    if (found.low <= found.high) { // else no value at all: nothing will be drawn
      low = found.low;
      high = found.high;
    }
    if (colors.scale() == render::Scale::log && !(low > 0)) {
      // Of a field that reaches 0, the highest decades; of one that is nowhere above it, all is
      // below the range.
      low = automatic_decades * high;
      if (!(low > 0))
        low = high = 1;
    }
  }
  std::vector<OpacityPoint> points = opacity;
  if (opacity.empty() && low < high) // those that came with the colours, if any did
    for (const render::MapOpacity& p : colors.opacity())
      points.push_back({colors.scale() == render::Scale::log ? low * std::pow(high / low, p.u)
                                                             : low + p.u * (high - low),
                        p.opacity});
  return {colors, low, high, std::move(points)};
}

std::variant<render::Color, render::ColorByField>
FrameSettingsMaker::surface_color(const From& from, const SurfaceColor& color,
                                  const std::optional<Coloring>& coloring) const {
  if (coloring)
    return render::ColorByField{coloring->field, transfer(from, *coloring)};
  return std::get<render::Color>(color);
}

render::VolumeSettings FrameSettingsMaker::volume(const From& made_of, const Volume& from,
                                                  const VolumeDecisions& decisions) const {
  render::TransferFunction function = transfer(made_of, decisions.coloring, from.opacity);
  function.set_nan_opacity(from.nan_opacity);
  render::ScalarField field = decisions.coloring.field;
  if (decisions.average)
    field = made_of.structures.average(field).field();
  render::VolumeSettings to{
      field,
      function,
      frame_.step * step_of(frame_.accuracy),
      std::nullopt,
      from.unit_distance.value_or(made_of.all ? 0.01 * diagonal(*made_of.all) : 0.0),
      frame_.accuracy};
  to.preintegrated = decisions.preintegration.made;
  to.shading = decisions.shading.made;
  if (decisions.step_levels)
    to.tolerance = from.tolerance;
  if (decisions.culling && *decisions.culling)
    to.culling = render::Culling::always;
  return to;
}

render::IsosurfaceSettings
FrameSettingsMaker::isosurface(const From& made_of, const Isosurface& from,
                               const IsosurfaceDecisions& decisions) const {
  render::IsosurfaceSettings to;
  to.field = decisions.field;
  to.values = from.values;
  to.opacity = from.opacity;
  to.normals = decisions.normals;
  to.search = from.search;
  to.color = surface_color(made_of, from.color, decisions.coloring);
  return to;
}

std::vector<render::BodySettings> FrameSettingsMaker::load_bodies() const {
  std::vector<render::BodySettings> bodies;
  for (const Body& from : frame_.bodies) {
    try {
      bodies.push_back({std::make_shared<render::TriangleList>(render::read_stl(
                            from.path, {environment_.context.memory, INSITU_MEMORY_FRAME})),
                        from.opacity, from.color});
    } catch (const core::Error& e) {
      throw core::Error(e.status(), at_line(environment_.scene_file, from.line) + e.what());
    }
  }
  return bodies;
}

namespace {

/// What follows from the mesh as it is now.
struct Bounds {
  math::Vec3d low, high;
  double aspect;
};

/// What fits the image: the mesh's box, with `fit: box` what clips leave of it, if anything. The
/// outline is not cut.
std::vector<math::Vec3d> corners_to_fit(const Frame& frame, render::Fit fit, const Bounds& bounds) {
  std::vector<render::Clip> clips;
  if (fit == render::Fit::box && !frame.outline)
    clips = frame.clips;
  std::vector<math::Vec3d> corners = render::clipped_corners(clips, bounds.low, bounds.high);
  return corners.empty() ? render::clipped_corners({}, bounds.low, bounds.high) : corners;
}

double aspect_of(const Frame& frame) {
  return double(frame.size[0]) / frame.size[1];
}

render::Camera placed(const Viewpoint& from, const Bounds& bounds) {
  render::Camera to;
  to.position = *from.position;
  to.look_at = from.look_at.value_or(0.5 * (bounds.low + bounds.high));
  to.up = from.up;
  to.fov = from.fov;
  return to;
}

/// Viewpoints along a path, one number of them at a time.
template <class Get>
double along(const Camera& camera, double place, const Get& get) {
  std::vector<double> at, values;
  for (const CameraKey& key : camera.path) {
    at.push_back(key.at);
    values.push_back(get(key));
  }
  return render::smooth(at, values, place);
}

/// A path of angles goes around the mesh's centre, whatever its bounds become.
Viewpoint view_along(const Camera& camera, double place) {
  Viewpoint view = camera;
  view.azimuth = along(camera, place, [](const CameraKey& k) { return k.azimuth; });
  view.elevation =
      std::clamp(along(camera, place, [](const CameraKey& k) { return k.elevation; }), -90.0, 90.0);
  view.zoom = std::exp(along(camera, place, [](const CameraKey& k) { return std::log(k.zoom); }));
  constexpr double half_degree = 3.14159265358979323846 / 360.0;
  view.fov = std::atan(std::exp(along(
                 camera, place,
                 [](const CameraKey& k) { return std::log(std::tan(half_degree * k.fov)); }))) /
             half_degree;
  return view;
}

render::Camera placed_along(const Camera& camera, double place, const Bounds& bounds) {
  std::vector<render::CameraKey> keys;
  for (const CameraKey& key : camera.path)
    keys.push_back({key.at, placed(key, bounds)});
  return render::CameraPath(std::move(keys)).at(place);
}

} // namespace

render::Camera FrameSettingsMaker::camera(const Camera& from, const Scenery& scenery,
                                          const Step& step, std::int64_t drawn) const {
  const Bounds bounds{scenery.box.low, scenery.box.high, aspect_of(frame_)};
  const double place = from.path_by_time ? step.time : double(step.cycle);
  const bool is_placed = (from.path.empty() ? from.position : from.path[0].position).has_value();
  Viewpoint view = from.path.empty() || is_placed ? Viewpoint(from) : view_along(from, place);
  const bool has_angles = view.has_angles || (!from.path.empty() && from.path[0].has_angles);
  if (scenery.is_flat && !has_angles && !from.on_earth) {
    view.azimuth = -90; // north is up
    view.elevation = 90;
  }
  render::Camera to;
  if (!is_placed)
    // An orthographic camera stands before the whole mesh.
    to = render::Camera::around(bounds.low, bounds.high, view.azimuth, view.elevation,
                                from.orthographic ? 1.0 : view.zoom, view.fov, bounds.aspect);
  if (!is_placed && from.on_earth)
    to = turned_to_local(to);
  if (is_placed)
    to = from.path.empty() ? placed(from, bounds) : placed_along(from, place, bounds);
  to = to.with_valid_up();
  if (from.orbit_azimuth_per_frame != 0.0)
    to = to.orbited(double(drawn) * from.orbit_azimuth_per_frame);
  const double zoom = is_placed ? 1.0 : view.zoom;
  const double margin = frame_.outline && frame_.outline->ticks ? output::box_label_margin
                                                                : render::Camera::default_margin;
  const std::vector<math::Vec3d> corners = corners_to_fit(frame_, from.fit, bounds);
  if (from.orthographic)
    to.orthographic_height =
        from.orthographic_height.value_or(to.height_for(corners, from.fit, bounds.aspect, margin)) /
        zoom;
  if (from.fit == render::Fit::box && !is_placed && !from.orthographic_height)
    to = to.fitted(corners, bounds.aspect, zoom, margin);
  return to;
}

std::vector<const render::TransferFunction*> functions_of(const render::FrameSettings& settings) {
  std::vector<const render::TransferFunction*> all;
  const auto add = [&](const std::variant<render::Color, render::ColorByField>& color) {
    if (const auto* by = std::get_if<render::ColorByField>(&color))
      all.push_back(&by->function);
  };
  if (settings.volume)
    all.push_back(&settings.volume->function);
  for (const render::IsosurfaceSettings& surface : settings.isosurfaces)
    add(surface.color);
  if (settings.boundary)
    add(settings.boundary->color);
  return all;
}

} // namespace insitu::scene
