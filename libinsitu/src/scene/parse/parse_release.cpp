#include "core/suggest.h"
#include "scene/parse/parse_parts.h"

namespace insitu::scene {

Release parse_release(const Cursor& cursor) {
  Release release;
  if (cursor.is_text()) {
    (void)cursor.choice<bool>({{"once", true}});
    return release;
  }
  if (!cursor.is_map()) {
    cursor.expected("once, or a map of every or interval, until and when,");
    return release;
  }
  const MapReader map(cursor, {"every", "interval", "until", "when"});
  if (const auto every = map.find("every")) {
    assign(release.every, every->integer(1, most_cycles));
  }
  if (const auto interval = map.find("interval")) {
    assign(release.interval, interval->number(positive));
  }
  if (const auto until = map.find("until")) {
    assign(release.until, until->number());
  }
  if (const auto when = map.find("when")) {
    release.line = when->line();
    release.when = parse_condition(*when);
  }
  if (map.has("every") ? map.has("interval") : !map.has("interval") && !map.has("when")) {
    cursor.fail("either 'every' (cycles) or 'interval' (time) expected, or 'when' alone");
  }
  return release;
}

OutputTimes parse_times(const Cursor& cursor) {
  OutputTimes times;
  if (cursor.is_list()) {
    assign(times.at, cursor.numbers(0));
    for (std::size_t k = 1; k < times.at.size(); ++k) {
      if (!(times.at[k - 1] < times.at[k])) {
        cursor.fail("times must ascend");
        break;
      }
    }
    return times;
  }
  if (!cursor.is_map()) {
    cursor.expected("a list of times, or a map of interval, from and until,");
    return times;
  }
  const MapReader map(cursor, {"interval", "from", "until"});
  if (const auto interval = map.require("interval")) {
    assign(times.interval, interval->number(positive));
  }
  if (const auto from = map.find("from")) {
    assign(times.from, from->number());
  }
  if (const auto until = map.find("until")) {
    assign(times.until, until->number());
  }
  return times;
}

CheckpointOptions parse_checkpoint(const Cursor& cursor) {
  CheckpointOptions options;
  const MapReader map(cursor, {"every", "keep"});
  if (const auto every = map.require("every")) {
    assign(options.every, every->integer(1, most_cycles));
  }
  if (const auto keep = map.find("keep")) {
    assign(options.keep, keep->integer(1, most_cycles));
  }
  return options;
}

RecordOptions parse_record(const Cursor& cursor) {
  RecordOptions options;
  const MapReader map(cursor, {"every"});
  if (const auto every = map.require("every")) {
    assign(options.every, every->integer(1, most_cycles));
  }
  return options;
}

int parse_hold(const Cursor& cursor) {
  const MapReader map(cursor, {"steps"});
  std::int64_t steps = 0;
  if (const auto given = map.require("steps")) {
    assign(steps, given->integer(1, most_held_steps));
  }
  return int(steps);
}

bool names_probe(const Cursor& seeds) {
  if (!seeds.is_map()) {
    return false;
  }
  const auto& entries = seeds.node().entries;
  return std::any_of(entries.begin(), entries.end(),
                     [](const auto& entry) { return entry.key == "probe"; });
}

void parse_seeds_of_probe(const Cursor& cursor, const ParseContext& context, bool has_frame,
                          Tracer& tracer) {
  const MapReader map(cursor, {"probe"});
  const auto name = map.find("probe");
  const auto text = name ? name->text() : std::nullopt;
  if (!text) {
    return;
  }
  const auto found = std::find_if(context.probes->begin(), context.probes->end(),
                                  [&](const Probe& p) { return p.name == *text; });
  if (found == context.probes->end()) {
    std::vector<std::string> names;
    for (const Probe& p : *context.probes) {
      names.push_back(p.name);
    }
    name->fail("the scene has no probe " + quote(*text) + core::did_you_mean(*text, names));
    return;
  }
  if (has_frame) {
    cursor.fail("the frame of these seeds is the probe's; leave 'frame' away");
  }
  tracer.seeds = found->points;
  tracer.frame = found->frame;
  if (tracer.mesh.empty()) {
    tracer.mesh = found->mesh;
  }
}

} // namespace insitu::scene
