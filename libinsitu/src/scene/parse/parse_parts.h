#pragma once

#include <algorithm>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "scene/parse/cursor.h"
#include "scene/parse/description.h"

/// The sections of a scene. Only the files parse_*.cpp include this header. Each function returns
/// what it could read, and notes the problems in the Problems of the cursor.
namespace insitu::scene {

/// What the sections share.
struct ParseContext {
  std::string base_folder;
  Trigger trigger;                            ///< the trigger of the scene
  std::set<std::string> names;                ///< names of the probes, tracers and frames that were
                                              ///< read so far
  const std::vector<Probe>* probes = nullptr; ///< probes that were read so far
};

/// Counts of points, of pixels along a side, of cycles and of steps beyond these limits are slips
/// of the author.
constexpr std::int64_t most_points = 1'000'000'000;
constexpr std::int64_t most_levels = 1'000'000;
constexpr std::int64_t largest_image_side = 16384;
constexpr std::int64_t most_cycles = 1'000'000'000;
constexpr std::int64_t most_held_steps = 1'000'000;
constexpr std::int64_t most_steps = 1'000'000'000;
constexpr std::size_t most_isovalues = 256;

std::string resolve_path(const std::string& path, const std::string& base_folder);

/// Reads `every` and `when` of the map, and returns `fallback` where the map has neither.
Trigger parse_trigger(const MapReader& map, const Trigger& fallback);
/// Reads a condition. The optional is empty where the text is no condition.
std::optional<Expression> parse_condition(const Cursor& cursor);
LocatorOptions parse_locator(const Cursor& cursor);
std::optional<insitu_accuracy> parse_accuracy(const Cursor& cursor);
/// Reads `name`, which is required, must be fit for the name of a file, and must not be in use yet.
void parse_item_name(const MapReader& map, ParseContext& context, std::string& name);
/// Returns whether a text may stand in the name of a file: it stays within the folder, on every
/// file system.
bool fits_file_name(const std::string& text);
std::optional<Name> parse_name(const Cursor& cursor);
std::vector<Name> parse_names(const Cursor& cursor);
/// Reads a list of the words `formats`, with one word at least.
std::vector<TableFormat> parse_output(const Cursor& cursor,
                                      std::initializer_list<Choice<TableFormat>> formats);

FrameOfReference parse_frame_of_reference(const Cursor& cursor);
PointSource parse_points(const Cursor& cursor, const ParseContext& context,
                         const FrameOfReference& frame);

Probe parse_probe(const Cursor& cursor, ParseContext& context);
TracerEffects parse_tracer_effects(const Cursor& cursor);
Tracer parse_tracer(const Cursor& cursor, ParseContext& context);
Release parse_release(const Cursor& cursor);
OutputTimes parse_times(const Cursor& cursor);
CheckpointOptions parse_checkpoint(const Cursor& cursor);
RecordOptions parse_record(const Cursor& cursor);
/// How many steps are held.
int parse_hold(const Cursor& cursor);
/// Returns whether seeds are those of a probe, `{probe: name}`, which parse_seeds_of_probe then
/// reads.
bool names_probe(const Cursor& seeds);
void parse_seeds_of_probe(const Cursor& cursor, const ParseContext& context, bool has_frame,
                          Tracer& tracer);
Frame parse_frame(const Cursor& cursor, ParseContext& context);

/// The linear colour of what is given as displayed.
render::Color parse_color(const Cursor& cursor, const render::Color& fallback);
Component parse_component(const Cursor& cursor);
/// Reads `colors`, `range`, `scale`, `below`, `above` and `nan` of a map that may hold other keys
/// too.
ColorMapChoice parse_color_map(const MapReader& map, const ParseContext& context);
/// Reads a camera; on_earth: whether it belongs to a geocentric frame.
Camera parse_camera(const Cursor& cursor, bool on_earth);
Camera default_camera(bool on_earth);
/// Reads the path tracing of the map of a frame whose layers and effects are read. The result is
/// also there where an effect asks for path tracing.
std::optional<PathTracing> parse_path_tracing(const MapReader& map, const Frame& frame);
/// Reads a map of names and cameras.
std::vector<NamedCamera> parse_cameras(const Cursor& cursor, bool on_earth);
Volume parse_volume(const Cursor& cursor, const ParseContext& context);
std::vector<render::Light> parse_lights(const Cursor& cursor);
Occlusion parse_occlusion(const Cursor& cursor);
std::vector<render::Clip> parse_clips(const Cursor& cursor);
std::vector<Isosurface> parse_isosurfaces(const Cursor& cursor, const ParseContext& context);
Boundary parse_boundary(const Cursor& cursor, const ParseContext& context);
std::vector<Body> parse_bodies(const Cursor& cursor, const ParseContext& context);
BoxOutline parse_outline(const Cursor& cursor);
/// Reads what is written over the image: `scalar_bar`, `time_label` and `axes`.
void parse_labels(const MapReader& map, Frame& frame);

/// Reads a list of some of the words, with one word at least and no word twice.
template <class T>
std::vector<T> parse_words(const Cursor& cursor, std::initializer_list<Choice<T>> words,
                           const char* what) {
  std::vector<T> found;
  const auto items = cursor.items();
  if (items && items->empty()) {
    cursor.fail(std::string("at least one ") + what + " expected");
  }
  for (const Cursor& item : items ? *items : std::vector<Cursor>{}) {
    const auto word = item.choice(words);
    if (word && std::find(found.begin(), found.end(), *word) != found.end()) {
      item.fail(quote(item.node().text) + " is given twice");
    } else if (word) {
      found.push_back(*word);
    }
  }
  return found;
}

/// The name of an effect, and the effect, which is empty if this version does not have it.
template <class T>
struct EffectChoice {
  EffectChoice(const char* of_name, std::optional<T> what,
               std::function<void(const Cursor&)> read_options = nullptr)
      : name(of_name), effect(what), options(std::move(read_options)) {}

  const char* name;
  std::optional<T> effect;
  std::function<void(const Cursor&)> options; ///< reads the options of the effect; empty: it has no
                                              ///< options
};

/// Reads a list of effects, each of which is a name, or a map of a name and its options. Notes
/// unknown effects, repeated ones, and those that this version does not have.
template <class T>
std::vector<T> parse_effects(const Cursor& cursor, const std::vector<EffectChoice<T>>& known) {
  std::vector<T> effects;
  std::set<std::string> seen;
  std::vector<std::string> names;
  for (const auto& one : known) {
    names.emplace_back(one.name);
  }
  const auto items = cursor.items();
  for (const Cursor& item : items ? *items : std::vector<Cursor>{}) {
    const bool with_options = item.is_map() && item.node().entries.size() == 1;
    const std::string name = with_options     ? item.node().entries[0].key
                             : item.is_text() ? item.node().text
                                              : std::string();
    const auto found = std::find(names.begin(), names.end(), name);
    if (name.empty()) {
      item.expected("an effect's name, or a map of one name and its options");
    } else if (found == names.end()) {
      std::string all;
      for (const std::string& one : names) {
        all += (all.empty() ? "" : ", ") + one;
      }
      item.fail("effect " + quote(name) + " is unknown" + core::did_you_mean(name, names) +
                " (effects: " + all + ")");
    } else if (!known[static_cast<std::size_t>(found - names.begin())].effect) {
      item.fail("effect '" + name + "' is not available in this version");
    } else if (!seen.insert(name).second) {
      item.fail("effect '" + name + "' is given twice");
    } else {
      const EffectChoice<T>& choice = known[static_cast<std::size_t>(found - names.begin())];
      if (with_options && !choice.options) {
        item.fail("effect '" + name + "' has no options");
      } else {
        if (with_options) {
          choice.options(
              Cursor(*item.node().entries[0].value, item.path() + "." + name, item.problems()));
        }
        effects.push_back(*choice.effect);
      }
    }
  }
  return effects;
}

} // namespace insitu::scene
