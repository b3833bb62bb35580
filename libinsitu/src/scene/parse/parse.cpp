#include "scene/parse/parse.h"

#include <filesystem>
#include <fstream>
#include <sstream>

#include "commit/halo/seam_faces.h"
#include "core/status.h"
#include "scene/parse/parse_parts.h"

namespace insitu::scene {
namespace {

constexpr std::int64_t scene_version = 1;

constexpr std::size_t longest_name = 100;

void parse_version(const MapReader& map) {
  const auto version = map.require("insitu");
  if (!version) {
    return;
  }
  const auto number = version->integer(1, std::numeric_limits<std::int32_t>::max());
  if (number && *number != scene_version) {
    version->fail("version " + std::to_string(*number) +
                  " of the scene format is not known to this library (" +
                  std::to_string(scene_version) + ")");
  }
}

template <class Item>
void parse_list(const MapReader& map, const char* key, ParseContext& context,
                Item (*parse)(const Cursor&, ParseContext&), std::vector<Item>& out) {
  const auto list = map.find(key);
  const auto items = list ? list->items() : std::nullopt;
  for (const Cursor& item : items ? *items : std::vector<Cursor>{}) {
    out.push_back(parse(item, context));
  }
}

} // namespace

SceneDescription parse_scene_file(const std::string& path) {
  return parse_scene_of_file(read_scene_file(path), path);
}

std::string read_scene_file(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    throw core::Error(INSITU_ERROR_FILE, "scene file '" + path + "' is a folder");
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    throw core::Error(INSITU_ERROR_FILE, "scene file '" + path + "' cannot be opened");
  }
  // One byte beyond the limit is enough for read_document() to refuse what is too long, without
  // reading it all.
  std::string text(largest_document + 4, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad()) {
    throw core::Error(INSITU_ERROR_FILE, "scene file '" + path + "' cannot be read");
  }
  text.resize(static_cast<std::size_t>(file.gcount()));
  return text;
}

SceneDescription parse_scene_of_file(std::string_view text, const std::string& path) {
  return parse_scene_text(text, path, std::filesystem::path(path).parent_path().string());
}

SceneDescription parse_scene_text(std::string_view text, const std::string& name,
                                  const std::string& base_folder,
                                  std::span<const RetiredKey> retired) {
  const YamlNodePtr root = read_document(text, name);
  Problems problems(name, retired);
  SceneDescription scene;
  scene.file = name;
  scene.text = text;
  scene.words = words_of(*root);
  const MapReader map(Cursor(*root, "", problems),
                      {"insitu", "output", "page", "locator", "seam_tolerance", "checkpoint",
                       "record", "hold", "every", "when", "probes", "tracers", "frames"});
  parse_version(map);
  if (const auto output = map.find("output")) {
    assign(scene.output, output->text());
  }
  if (const auto page = map.find("page")) {
    assign(scene.page, page->boolean());
  }
  if (const auto locator = map.find("locator")) {
    scene.locator = parse_locator(*locator);
  }
  if (const auto tolerance = map.find("seam_tolerance")) {
    assign(scene.seam_tolerance, tolerance->number({0.0, commit::SeamMismatches::most_tolerance}));
  }
  if (const auto checkpoint = map.find("checkpoint")) {
    scene.checkpoint = parse_checkpoint(*checkpoint);
  }
  if (const auto record = map.find("record")) {
    scene.record = parse_record(*record);
  }
  if (const auto hold = map.find("hold")) {
    scene.held_steps = parse_hold(*hold);
  }
  scene.trigger = parse_trigger(map, {});
  ParseContext context{base_folder, scene.trigger, {}, &scene.probes};
  parse_list(map, "probes", context, parse_probe, scene.probes);
  parse_list(map, "tracers", context, parse_tracer, scene.tracers);
  parse_list(map, "frames", context, parse_frame, scene.frames);
  const auto refuse_table = [&](const std::string& item, int line) {
    if (item == "data" && !scene.frames.empty()) {
      problems.add(line, "the name 'data' would make data.csv, which is the table of the frames; "
                         "give another one");
    }
  };
  for (const Probe& probe : scene.probes) {
    refuse_table(probe.name, probe.line);
  }
  for (const Tracer& tracer : scene.tracers) {
    refuse_table(tracer.name, tracer.line);
  }
  problems.throw_if_any();
  scene.warnings = problems.warnings();
  return scene;
}

std::string resolve_path(const std::string& path, const std::string& base_folder) {
  return (std::filesystem::path(base_folder) / path).lexically_normal().string();
}

Trigger parse_trigger(const MapReader& map, const Trigger& fallback) {
  const auto every = map.find("every");
  const auto when = map.find("when");
  if (!every && !when) {
    return fallback;
  }
  Trigger trigger;
  if (every) {
    trigger.line = every->line();
    assign(trigger.every, every->integer(1, most_cycles));
  }
  if (when) {
    trigger.line = when->line();
    trigger.when = parse_condition(*when);
  }
  return trigger;
}

std::optional<Expression> parse_condition(const Cursor& cursor) {
  const auto text = cursor.text();
  if (!text) {
    return std::nullopt;
  }
  try {
    return Expression(*text);
  } catch (const ExpressionError& error) {
    cursor.fail(describe(error, *text));
    return std::nullopt;
  }
}

LocatorOptions parse_locator(const Cursor& cursor) {
  LocatorOptions options;
  options.line = cursor.line();
  const MapReader map(cursor, {"method", "backend", "builder"});
  using Method = std::optional<accel::Method>;
  using Backend = std::optional<accel::Backend>;
  if (const auto method = map.find("method")) {
    assign(
        options.choice.method,
        method->choice<Method>({{"auto", Method()},
                                {"bvh", accel::Method::bvh},
                                {"user_geometry", accel::Method::user_geometry},
                                {"replicated_faces", accel::Method::replicated_faces},
                                {"shared_faces", accel::Method::shared_faces},
                                {"shared_bilinear_faces", accel::Method::shared_bilinear_faces}}));
  }
  if (const auto backend = map.find("backend")) {
    assign(options.choice.backend, backend->choice<Backend>({{"auto", Backend()},
                                                             {"cpu", accel::Backend::cpu},
                                                             {"cuda", accel::Backend::cuda},
                                                             {"optix", accel::Backend::optix}}));
  }
  if (const auto builder = map.find("builder")) {
    assign(options.builder,
           builder->choice<accel::Builder>({{"auto", accel::Builder::automatic},
                                            {"morton", accel::Builder::morton},
                                            {"surface_area", accel::Builder::surface_area}}));
  }
  return options;
}

std::optional<insitu_accuracy> parse_accuracy(const Cursor& cursor) {
  return cursor.choice<insitu_accuracy>(
      {{"fast", INSITU_FAST}, {"standard", INSITU_STANDARD}, {"exact", INSITU_EXACT}});
}

bool fits_file_name(const std::string& text) {
  return !text.empty() && text.size() <= longest_name && text.front() != '.' &&
         text.front() != ' ' && text.back() != ' ' &&
         text.find_first_of("/\\:*?\"<>|\n\r\t") == std::string::npos;
}

void parse_item_name(const MapReader& map, ParseContext& context, std::string& name) {
  const auto cursor = map.require("name");
  const auto text = cursor ? cursor->text() : std::nullopt;
  if (!text) {
    return;
  }
  if (!fits_file_name(*text)) {
    cursor->fail(quote(*text) + " cannot name a file: at most " + std::to_string(longest_name) +
                 " bytes without / \\ : * ? \" < > |, not beginning with '.' nor with a space at "
                 "either end");
  } else if (!context.names.insert(*text).second) {
    cursor->fail("the name " + quote(*text) + " is already used in this scene");
  }
  name = *text;
}

std::optional<Name> parse_name(const Cursor& cursor) {
  auto text = cursor.text();
  return text ? std::optional<Name>({std::move(*text), cursor.line()}) : std::nullopt;
}

std::vector<Name> parse_names(const Cursor& cursor) {
  std::vector<Name> names;
  std::set<std::string> seen;
  const auto items = cursor.items();
  for (const Cursor& item : items ? *items : std::vector<Cursor>{}) {
    auto name = parse_name(item);
    if (name && !seen.insert(name->text).second) {
      item.fail(quote(name->text) + " is given twice");
    } else if (name) {
      names.push_back(std::move(*name));
    }
  }
  return names;
}

std::vector<TableFormat> parse_output(const Cursor& cursor,
                                      std::initializer_list<Choice<TableFormat>> formats) {
  return parse_words(cursor, formats, "format");
}

} // namespace insitu::scene
