#include "scene/parse/parse_parts.h"

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

constexpr std::int64_t most_samples_per_pixel = 256;

void parse_samples(const MapReader& map, Frame& frame) {
  const auto samples = map.find("samples_per_pixel");
  const auto count = samples ? samples->integer(1, most_samples_per_pixel) : std::nullopt;
  if (!count || *count == 1) {
    return;
  }
  frame.samples_per_pixel = static_cast<int>(*count);
  if (frame.path_tracing && frame.path_tracing->samples < *count) {
    samples->fail("at most as many as the " + std::to_string(frame.path_tracing->samples) +
                  " 'samples' of 'path_tracing' expected, which are spread over them, " +
                  std::to_string(*count) + " found");
  }
  if (frame.geocentric && (frame.geocentric->globe || frame.geocentric->graticule)) {
    samples->fail("a frame with a 'globe' or a 'graticule' has one sample a pixel");
  }
}

/// A colour, `transparent`, or a map of both.
void parse_background(const Cursor& cursor, Frame& frame) {
  if (cursor.is_text() && cursor.node().text == "transparent") {
    frame.background_alpha = 0;
    return;
  }
  if (!cursor.is_map()) {
    frame.background = parse_color(cursor, frame.background);
    return;
  }
  const MapReader map(cursor, {"color", "alpha"});
  if (const auto color = map.find("color")) {
    frame.background = parse_color(*color, frame.background);
  }
  if (const auto alpha = map.require("alpha")) {
    assign(frame.background_alpha, alpha->number({0, 1}));
  }
}

/// The images' names, without cycle and ending, must be no other item's.
void claim_names(const Cursor& cursor, const Frame& frame, ParseContext& context) {
  std::vector<std::string> stems;
  for (const NamedCamera& camera : frame.cameras) {
    stems.push_back(frame.name + "_" + camera.name);
  }
  if (stems.empty()) {
    stems.push_back(frame.name);
  }
  for (const std::string& stem : stems) {
    for (const ImageKind kind : frame.images) {
      for (const std::string& mesh : image_meshes(frame, kind)) {
        const std::string name = image_stem(stem, kind, mesh);
        if (name != frame.name && !context.names.insert(name).second) {
          cursor.fail("its images would be called " + quote(name) +
                      ", a name that is already used in this scene");
        }
      }
    }
  }
}

Geocentric parse_geocentric(const Cursor& cursor) {
  Geocentric geocentric;
  geocentric.line = cursor.line();
  const MapReader map(cursor, {"exaggeration", "globe", "graticule"});
  if (const auto factor = map.find("exaggeration")) {
    assign(geocentric.exaggeration, factor->number({0, 1e6}));
  }
  if (const auto globe = map.find("globe")) {
    geocentric.globe = parse_color(*globe, render::linear_of_srgb(0.75, 0.72, 0.65));
  }
  if (const auto graticule = map.find("graticule")) {
    geocentric.graticule = graticule->number({0.001, 90});
  }
  return geocentric;
}

void parse_views(const MapReader& map, Frame& frame) {
  if (const auto geocentric = map.find("geocentric")) {
    frame.geocentric = parse_geocentric(*geocentric);
  }
  const bool on_earth = frame.geocentric.has_value();
  frame.camera = default_camera(on_earth);
  if (const auto camera = map.find("camera")) {
    frame.camera = parse_camera(*camera, on_earth);
  }
  if (const auto cameras = map.find("cameras")) {
    frame.cameras = parse_cameras(*cameras, on_earth);
    if (map.has("camera")) {
      cameras->fail("a frame has either a 'camera' or 'cameras'");
    }
  }
}

FrameLayer parse_layer(const MapReader& map, const ParseContext& context) {
  FrameLayer layer;
  if (const auto mesh = map.find("mesh")) {
    assign(layer.mesh, parse_name(*mesh));
  }
  if (const auto volume = map.find("volume")) {
    layer.volume = parse_volume(*volume, context);
  }
  if (const auto surfaces = map.find("isosurfaces")) {
    layer.isosurfaces = parse_isosurfaces(*surfaces, context);
  }
  if (const auto boundary = map.find("boundary")) {
    layer.boundary = parse_boundary(*boundary, context);
  }
  return layer;
}

/// Whether the map of a frame or of one of its meshes asks for something of the mesh, be it wrong.
bool shows_mesh(const MapReader& map) {
  const auto surfaces = map.find("isosurfaces");
  return map.has("volume") || map.has("boundary") ||
         (surfaces && !(surfaces->is_list() && surfaces->node().items.empty()));
}

std::vector<FrameLayer> parse_layers(const Cursor& cursor, const ParseContext& context) {
  std::vector<FrameLayer> layers;
  const auto items = cursor.items();
  if (items && items->empty()) {
    cursor.fail("at least one mesh expected");
  }
  for (const Cursor& item : items ? *items : std::vector<Cursor>{}) {
    const MapReader map(item, {"mesh", "volume", "isosurfaces", "boundary"});
    (void)map.require("mesh");
    layers.push_back(parse_layer(map, context));
    if (map && !shows_mesh(map)) {
      item.fail("nothing of the mesh is drawn; give it a 'volume', 'isosurfaces' or a 'boundary'");
    }
  }
  return layers;
}

/// Several meshes, or the one of the frame itself.
void parse_meshes(const MapReader& map, const ParseContext& context, Frame& frame) {
  const auto meshes = map.find("meshes");
  if (!meshes) {
    frame.layers = {parse_layer(map, context)};
    return;
  }
  for (const char* key : {"mesh", "volume", "isosurfaces", "boundary"}) {
    if (const auto own = map.find(key)) {
      own->fail("a frame with 'meshes' has it in their list");
    }
  }
  if (frame.geocentric && (frame.geocentric->globe || frame.geocentric->graticule)) {
    meshes->fail("a frame with 'meshes' has neither 'globe' nor 'graticule'");
  }
  std::vector<FrameLayer> layers = parse_layers(*meshes, context);
  if (layers.empty()) {
    return;
  }
  frame.layers = std::move(layers);
  for (const std::string& mesh : image_meshes(frame, ImageKind::cell)) {
    if (std::count(frame.images.begin(), frame.images.end(), ImageKind::cell) > 0 &&
        !mesh.empty() && !fits_file_name(mesh)) {
      meshes->fail(quote(mesh) + " cannot name a file, as the image of its cells would be");
    }
  }
}

/// What is drawn, and by which light.
void parse_drawn(const MapReader& map, const ParseContext& context, Frame& frame) {
  parse_meshes(map, context, frame);
  if (const auto bodies = map.find("bodies")) {
    frame.bodies = parse_bodies(*bodies, context);
  }
  if (const auto outline = map.find("outline")) {
    frame.outline = parse_outline(*outline);
  }
  if (const auto lights = map.find("lights")) {
    frame.lights = parse_lights(*lights);
  }
  if (const auto clip = map.find("clip")) {
    frame.clips = parse_clips(*clip);
  }
}

void parse_frame_effects(const MapReader& map, Frame& frame) {
  if (const auto effects = map.find("effects")) {
    frame.has_effects_key = true;
    frame.effects = parse_effects<FrameEffect>(
        *effects, {{"lighting", FrameEffect::lighting},
                   {"shadows", FrameEffect::shadows},
                   {"volume_shadows", FrameEffect::volume_shadows},
                   {"ambient_occlusion", FrameEffect::ambient_occlusion,
                    [&](const Cursor& options) { frame.occlusion = parse_occlusion(options); }},
                   {"single_scattering", FrameEffect::single_scattering},
                   {"multiple_scattering", FrameEffect::multiple_scattering}});
  }
}

void check_draws_something(const MapReader& map, const Frame& frame) {
  if (map && !shows_mesh(map) && !map.has("meshes") && frame.bodies.empty() && !frame.outline) {
    map.cursor().fail("the frame draws nothing; give it a 'volume', 'isosurfaces', 'boundary', "
                      "'bodies' or 'outline'");
  }
}

} // namespace

std::vector<std::string> image_meshes(const Frame& frame, ImageKind kind) {
  std::vector<std::string> meshes;
  if (kind != ImageKind::cell || frame.layers.size() < 2) {
    return {""};
  }
  for (const FrameLayer& layer : frame.layers) {
    if (std::find(meshes.begin(), meshes.end(), layer.mesh.text) == meshes.end()) {
      meshes.push_back(layer.mesh.text);
    }
  }
  return meshes;
}

std::string image_stem(const std::string& name, ImageKind kind, const std::string& mesh) {
  if (!mesh.empty()) {
    return image_stem(name + "_" + mesh, kind);
  }
  switch (kind) {
  case ImageKind::color:
    break;
  case ImageKind::depth:
    return name + "_depth";
  case ImageKind::cell:
    return name + "_cell";
  }
  return name;
}

std::vector<NamedCamera> cameras_of(const Frame& frame) {
  return frame.cameras.empty() ? std::vector{NamedCamera{"", frame.camera}} : frame.cameras;
}

std::vector<const ColorBy*> colorings_of(const FrameLayer& layer) {
  std::vector<const ColorBy*> all;
  const auto add = [&](const SurfaceColor& color) {
    if (const auto* by = std::get_if<ColorBy>(&color)) {
      all.push_back(by);
    }
  };
  if (layer.volume) {
    all.push_back(&*layer.volume);
  }
  for (const Isosurface& surface : layer.isosurfaces) {
    add(surface.color);
  }
  if (layer.boundary) {
    add(layer.boundary->color);
  }
  return all;
}

std::vector<const ColorBy*> colorings_of(const Frame& frame) {
  std::vector<const ColorBy*> all;
  for (const FrameLayer& layer : frame.layers) {
    const std::vector<const ColorBy*> some = colorings_of(layer);
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

Frame parse_frame(const Cursor& cursor, ParseContext& context) {
  Frame frame;
  frame.line = cursor.line();
  const MapReader map(cursor, {"name",        "mesh",
                               "size",        "background",
                               "camera",      "cameras",
                               "images",      "format",
                               "volume",      "isosurfaces",
                               "boundary",    "bodies",
                               "outline",     "lights",
                               "clip",        "scalar_bar",
                               "time_label",  "axes",
                               "effects",     "path_tracing",
                               "geocentric",  "accuracy",
                               "step",        "every",
                               "when",        "samples_per_pixel",
                               "compositing", "meshes"});
  parse_item_name(map, context, frame.name);
  if (const auto size = map.find("size")) {
    parse_size(*size, frame.size);
  }
  if (const auto background = map.find("background")) {
    parse_background(*background, frame);
  }
  parse_views(map, frame);
  if (const auto images = map.find("images")) {
    frame.images = parse_words<ImageKind>(
        *images,
        {{"color", ImageKind::color}, {"depth", ImageKind::depth}, {"cell", ImageKind::cell}},
        "image");
  }
  if (const auto format = map.find("format")) {
    frame.formats = parse_words<ImageFormat>(
        *format, {{"png", ImageFormat::png}, {"exr", ImageFormat::exr}}, "format");
  }
  parse_drawn(map, context, frame);
  parse_labels(map, frame);
  parse_frame_effects(map, frame);
  frame.path_tracing = parse_path_tracing(map, frame);
  parse_samples(map, frame);
  if (const auto accuracy = map.find("accuracy")) {
    assign(frame.accuracy, parse_accuracy(*accuracy));
  }
  if (const auto step = map.find("step")) {
    assign(frame.step, step->number({0.01, 100}));
  }
  if (const auto compositing = map.find("compositing")) {
    assign(frame.compositing,
           compositing->choice<render::Compositing>({{"exact", render::Compositing::exact},
                                                     {"standard", render::Compositing::standard}}));
  }
  check_draws_something(map, frame);
  claim_names(cursor, frame, context);
  frame.trigger = parse_trigger(map, context.trigger);
  return frame;
}

} // namespace insitu::scene
