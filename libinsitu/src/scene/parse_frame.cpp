#include "scene/parse_parts.h"

namespace insitu::scene {
namespace {

void parse_size(const Cursor& cursor, std::array<int, 2>& size) {
  const auto items = cursor.items();
  if (!items) {
    return;
  }
  if (items->size() != 2) {
    cursor.expected("a list of 2 integers, width and height");
    return;
  }
  for (std::size_t i = 0; i < 2; ++i) {
    if (const auto side = (*items)[i].integer(1, largest_image_side)) {
      size[i] = static_cast<int>(*side);
    }
  }
}

} // namespace

Frame parse_frame(const Cursor& cursor, ParseContext& context) {
  Frame frame;
  frame.line = cursor.line();
  const MapReader map(cursor, {"name", "mesh", "size", "background", "camera", "volume",
                               "isosurfaces", "lights", "clip", "scalar_bar", "time_label",
                               "effects", "path_tracing", "accuracy", "step", "every", "when"});
  parse_item_name(map, context, frame.name);
  if (const auto mesh = map.find("mesh")) {
    assign(frame.mesh, parse_name(*mesh));
  }
  if (const auto size = map.find("size")) {
    parse_size(*size, frame.size);
  }
  if (const auto background = map.find("background")) {
    frame.background = parse_color(*background, frame.background);
  }
  if (const auto camera = map.find("camera")) {
    frame.camera = parse_camera(*camera);
  }
  if (const auto volume = map.find("volume")) {
    frame.volume = parse_volume(*volume, context);
  }
  const auto surfaces = map.find("isosurfaces");
  if (surfaces) {
    frame.isosurfaces = parse_isosurfaces(*surfaces, context);
  }
  if (const auto lights = map.find("lights")) {
    frame.lights = parse_lights(*lights);
  }
  if (const auto clip = map.find("clip")) {
    frame.clips = parse_clips(*clip);
  }
  if (const auto bar = map.find("scalar_bar")) {
    assign(frame.scalar_bar, bar->boolean());
  }
  if (const auto label = map.find("time_label")) {
    assign(frame.time_label, label->boolean());
  }
  if (const auto effects = map.find("effects")) {
    frame.effects = parse_effects<FrameEffect>(
        *effects, {{"lighting", FrameEffect::lighting},
                   {"shadows", FrameEffect::shadows},
                   {"ambient_occlusion", FrameEffect::ambient_occlusion,
                    [&](const Cursor& options) { frame.occlusion = parse_occlusion(options); }},
                   {"single_scattering", FrameEffect::single_scattering},
                   {"multiple_scattering", FrameEffect::multiple_scattering}});
  }
  frame.path_tracing = parse_path_tracing(map, frame.effects);
  if (const auto accuracy = map.find("accuracy")) {
    assign(frame.accuracy, parse_accuracy(*accuracy));
  }
  if (const auto step = map.find("step")) {
    assign(frame.step, step->number({0.01, 100}));
  }
  if (map && !map.has("volume") &&
      (!surfaces || (surfaces->is_list() && frame.isosurfaces.empty()))) {
    cursor.fail("the frame draws nothing; give it a 'volume' or 'isosurfaces'");
  }
  frame.trigger = parse_trigger(map, context.trigger);
  return frame;
}

} // namespace insitu::scene
