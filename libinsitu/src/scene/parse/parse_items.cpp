#include <algorithm>
#include <type_traits>

#include "scene/parse/parse_parts.h"

namespace insitu::scene {
namespace {

IntegratorOptions parse_integrator(const Cursor& cursor) {
  IntegratorOptions options;
  const MapReader map(cursor, {"method", "face_aware", "step", "tolerance", "min_step",
                               "at_min_step", "max_step", "max_steps"});
  if (const auto method = map.find("method")) {
    assign(options.method,
           method->choice<IntegrationMethod>({{"euler", IntegrationMethod::euler},
                                              {"rk4", IntegrationMethod::rk4},
                                              {"bs32", IntegrationMethod::bs32},
                                              {"dopri5", IntegrationMethod::dopri5}}));
  }
  if (const auto aware = map.find("face_aware")) {
    assign(options.face_aware, aware->boolean());
  }
  if (const auto step = map.find("step")) {
    assign(options.step, step->number(positive));
  }
  if (const auto tolerance = map.find("tolerance")) {
    assign(options.tolerance, tolerance->number(positive));
  }
  if (const auto step = map.find("min_step")) {
    assign(options.min_step, step->number(positive));
  }
  if (const auto at = map.find("at_min_step")) {
    assign(options.at_min_step, at->choice<advect::AtMinStep>({{"end", advect::AtMinStep::end},
                                                               {"take", advect::AtMinStep::take}}));
    if (!map.has("min_step")) {
      at->fail("it says what becomes of particles at 'min_step', which is missing; an automatic "
               "smallest step is always taken");
    }
  }
  if (const auto step = map.find("max_step")) {
    assign(options.max_step, step->number(positive));
  }
  if (const auto steps = map.find("max_steps")) {
    assign(options.max_steps, steps->integer(1, most_steps));
  }
  if (options.method == IntegrationMethod::euler || options.method == IntegrationMethod::rk4) {
    for (const char* key : {"tolerance", "min_step", "at_min_step", "max_step"}) {
      if (const auto value = map.find(key)) {
        value->fail(std::string(options.method == IntegrationMethod::rk4 ? "rk4" : "euler") +
                    " has fixed steps; this key belongs to bs32 and dopri5");
      }
    }
  } else if (options.min_step && options.max_step && *options.min_step > *options.max_step) {
    cursor.fail("'min_step' is larger than 'max_step'");
  } else if (options.step && ((options.min_step && *options.step < *options.min_step) ||
                              (options.max_step && *options.step > *options.max_step))) {
    cursor.fail("'step' does not lie between 'min_step' and 'max_step'");
  }
  return options;
}

VertexSpacing parse_spacing(const Cursor& cursor) {
  VertexSpacing spacing;
  const MapReader map(cursor, {"length", "time"});
  if (const auto length = map.find("length")) {
    assign(spacing.length, length->number(positive));
  }
  if (const auto time = map.find("time")) {
    assign(spacing.time, time->number(positive));
  }
  if (map && map.has("length") == map.has("time")) {
    cursor.fail("either 'length' or 'time' expected");
  }
  return spacing;
}

TracerLimits parse_limits(const Cursor& cursor) {
  TracerLimits limits;
  const MapReader map(cursor, {"duration", "length"});
  if (const auto duration = map.find("duration")) {
    assign(limits.duration, duration->number(positive));
  }
  if (const auto length = map.find("length")) {
    assign(limits.length, length->number(positive));
  }
  return limits;
}

/// What probes and tracers have in common.
template <class Item>
void parse_common(const MapReader& map, ParseContext& context, const char* points_key,
                  PointSource& points, int& points_line, Item& item) {
  item.line = map.cursor().line();
  parse_item_name(map, context, item.name);
  if (const auto mesh = map.find("mesh")) {
    assign(item.mesh, parse_name(*mesh));
  }
  if (const auto frame = map.find("frame")) {
    item.frame = parse_frame_of_reference(*frame);
  }
  if (const auto source = map.require(points_key)) {
    points_line = source->line();
    if constexpr (std::is_same_v<Item, Tracer>) {
      if (names_probe(*source)) {
        parse_seeds_of_probe(*source, context, map.has("frame"), item);
      } else {
        points = parse_points(*source, context, item.frame);
      }
    } else {
      points = parse_points(*source, context, item.frame);
    }
  }
  if (const auto fields = map.find("fields")) {
    item.fields = parse_names(*fields);
  }
  if (const auto attached = map.find("attached")) {
    assign(item.attached,
           attached->choice<Attached>({{"lab", Attached::lab}, {"body", Attached::body}}));
  }
  if (const auto accuracy = map.find("accuracy")) {
    assign(item.accuracy, parse_accuracy(*accuracy));
  }
  item.trigger = parse_trigger(map, context.trigger);
}

bool has_periodic_sides(const TracerEffects& effects) {
  const auto& wall = effects.boundary;
  return wall && (wall->periodic[0] || wall->periodic[1] || wall->periodic[2]);
}

/// As advect::check_line_effects(), in the scene's words.
void check_line_effects(const Cursor& effects, const Tracer& tracer) {
  const TracerEffects& e = tracer.effects;
  if (e.diffusion) {
    effects.fail(
        "a random walk has no velocity whose streamlines there could be: 'diffusion' is for "
        "path- and streaklines");
  }
  if (e.inertia && tracer.direction != TracerDirection::forward) {
    effects.fail("backwards, drag makes every error grow without bound: 'inertia' on streamlines "
                 "needs 'direction: forward'");
  }
  if (e.inertia && !tracer.until.duration && !e.age_limit) {
    effects.fail(
        "particles with 'inertia' fly on from where the flow rests: on streamlines it needs "
        "'until: {duration}' or 'age_limit'");
  }
  if (e.boundary && e.boundary->other == WallResponse::put_back) {
    effects.fail(
        "'put_back' would begin a streamline again and again; its walls 'stop' it or let it "
        "'slide'");
  }
  if (e.boundary && e.boundary->other == WallResponse::reflect && !e.inertia) {
    effects.fail("without 'inertia', 'reflect' would throw a streamline to and fro before a wall; "
                 "its walls 'stop' it or let it 'slide'");
  }
}

/// As advect::Tracer::set_effects() of attached particles, in the scene's words.
void check_attached_effects(const Cursor& effects, const TracerEffects& e) {
  const std::pair<const char*, bool> moving[] = {
      {"diffusion", bool(e.diffusion)}, {"settling", bool(e.settling)},
      {"windage", bool(e.windage)},     {"inertia", bool(e.inertia)},
      {"coriolis", bool(e.rotation)},   {"boundary", bool(e.boundary)}};
  for (const auto& [name, asked] : moving) {
    if (asked) {
      effects.fail("'attached: body' moves particles with the mesh's material; '" +
                   std::string(name) +
                   "' moves them otherwise ('age_limit' and 'remove' end them, and may be asked "
                   "for)");
    }
  }
}

/// As advect::Tracer::set_effects(), in the scene's words.
void check_backward_effects(const Cursor& effects, const Tracer& tracer) {
  if (tracer.effects.diffusion) {
    effects.fail("a random walk has no way back: 'diffusion' needs 'direction: forward'");
  }
  if (tracer.effects.inertia) {
    effects.fail("backwards, drag makes every error grow without bound: 'inertia' needs "
                 "'direction: forward'");
  }
}

void refuse_on_streamlines(const Cursor& key, const Tracer& tracer, const std::string& why) {
  if (tracer.kind == TracerKind::streamline) {
    key.fail(why + "; this key belongs to path- and streaklines");
  }
}

void parse_kind_and_release(const MapReader& map, Tracer& tracer) {
  if (const auto kind = map.find("kind")) {
    assign(tracer.kind, kind->choice<TracerKind>({{"streamline", TracerKind::streamline},
                                                  {"pathline", TracerKind::pathline},
                                                  {"streakline", TracerKind::streakline}}));
  }
  if (tracer.kind == TracerKind::streakline) {
    tracer.release.every = 1;
  }
  if (const auto release = map.find("release")) {
    refuse_on_streamlines(*release, tracer, "streamlines begin anew whenever they are due");
    tracer.release = parse_release(*release);
  }
}

void parse_geodesics(const MapReader& map, Tracer& tracer) {
  const auto geodesics = map.find("geodesics");
  if (!geodesics) {
    return;
  }
  refuse_on_streamlines(*geodesics, tracer, "streamlines are of one time");
  tracer.geodesics =
      parse_words<TrackGeodesic>(*geodesics,
                                 {{"path_length", TrackGeodesic::path_length},
                                  {"release_distance", TrackGeodesic::release_distance},
                                  {"release_bearing", TrackGeodesic::release_bearing}},
                                 "column");
}

void parse_velocity(const MapReader& map, Tracer& tracer) {
  const bool attached = tracer.attached == Attached::body;
  if (const auto velocity = attached ? map.find("velocity") : map.require("velocity")) {
    assign(tracer.velocity, parse_name(*velocity));
  }
  if (const auto interpolation = map.find("time_interpolation")) {
    refuse_on_streamlines(*interpolation, tracer, "streamlines see one step alone");
    assign(tracer.time_interpolation, interpolation->choice<advect::TimeInterpolation>(
                                          {{"linear", advect::TimeInterpolation::linear},
                                           {"quadratic", advect::TimeInterpolation::quadratic},
                                           {"cubic", advect::TimeInterpolation::cubic}}));
  }
}

void parse_output_times(const MapReader& map, Tracer& tracer) {
  const auto times = map.find("times");
  if (!times) {
    return;
  }
  refuse_on_streamlines(*times, tracer, "streamlines are of one moment");
  for (const char* key : {"every", "when"}) {
    if (const auto value = map.find(key)) {
      value->fail("'times' says when the particles are written");
    }
  }
  tracer.times = parse_times(*times);
}

void parse_direction(const MapReader& map, Tracer& tracer) {
  const auto direction = map.find("direction");
  if (!direction) {
    return;
  }
  assign(tracer.direction,
         direction->choice<TracerDirection>({{"forward", TracerDirection::forward},
                                             {"backward", TracerDirection::backward},
                                             {"both", TracerDirection::both}}));
  if (tracer.kind != TracerKind::streamline && tracer.direction == TracerDirection::both) {
    direction->fail("path- and streaklines follow the run, whose time goes one way: forward, or "
                    "backward where steps are replayed in reverse");
  }
}

void parse_effects_on(const MapReader& map, Tracer& tracer) {
  const auto effects = map.find("effects");
  if (!effects) {
    return;
  }
  tracer.effects = parse_tracer_effects(*effects);
  if (tracer.kind == TracerKind::streamline) {
    check_line_effects(*effects, tracer);
  } else if (tracer.direction == TracerDirection::backward) {
    check_backward_effects(*effects, tracer);
  }
  if (has_periodic_sides(tracer.effects) &&
      std::find(tracer.geodesics.begin(), tracer.geodesics.end(), TrackGeodesic::path_length) !=
          tracer.geodesics.end()) {
    map.find("geodesics")
        ->fail("'path_length' adds up the ways from cycle to cycle, in which a "
               "passage through 'periodic' sides would count as one");
  }
}

/// Particles that go with the material are moved by nothing else.
void check_attached(const MapReader& map, const Tracer& tracer) {
  if (const auto effects = map.find("effects")) {
    check_attached_effects(*effects, tracer.effects);
  }
  for (const char* key : {"velocity", "time_interpolation", "integrator", "direction"}) {
    if (const auto value = map.find(key)) {
      value->fail("'attached: body' moves particles with the mesh's material; this key moves "
                  "them otherwise");
    }
  }
  if (tracer.kind == TracerKind::streamline) {
    map.find("attached")->fail("streamlines do not move with the material");
  }
}

void parse_tables(const MapReader& map, Tracer& tracer) {
  const auto output = map.find("output");
  if (!output) {
    return;
  }
  tracer.output = parse_output(
      *output,
      {{"csv", TableFormat::csv}, {"vtp", TableFormat::vtp}, {"netcdf", TableFormat::netcdf}});
  if (tracer.kind == TracerKind::streamline &&
      std::find(tracer.output.begin(), tracer.output.end(), TableFormat::netcdf) !=
          tracer.output.end()) {
    output->fail("netcdf is for path- and streaklines, which are trajectories in time");
  }
}

} // namespace

Probe parse_probe(const Cursor& cursor, ParseContext& context) {
  Probe probe;
  const MapReader map(cursor, {"name", "mesh", "points", "frame", "fields", "attached", "accuracy",
                               "outside", "greatest_distance", "output", "every", "when"});
  parse_common(map, context, "points", probe.points, probe.points_line, probe);
  if (const auto outside = map.find("outside")) {
    assign(probe.outside, outside->choice<insitu_outside>({{"none", INSITU_OUTSIDE_NONE},
                                                           {"nearest", INSITU_OUTSIDE_NEAREST}}));
  }
  if (const auto distance = map.find("greatest_distance")) {
    assign(probe.greatest_distance, distance->number(positive));
    if (probe.outside == INSITU_OUTSIDE_NONE) {
      distance->fail("says how far the nearest cell may be; 'outside: nearest' asks for it");
    }
  }
  if (probe.attached == Attached::body && std::holds_alternative<Curtain>(probe.points)) {
    map.find("attached")
        ->fail("a curtain stands where it is; its points do not go with the "
               "material");
  }
  if (const auto output = map.find("output")) {
    probe.output = parse_output(*output, {{"csv", TableFormat::csv},
                                          {"vtp", TableFormat::vtp},
                                          {"json", TableFormat::json},
                                          {"netcdf", TableFormat::netcdf}});
  }
  return probe;
}

Tracer parse_tracer(const Cursor& cursor, ParseContext& context) {
  Tracer tracer;
  const MapReader map(cursor, {"name",     "mesh",     "seeds",      "frame",
                               "kind",     "release",  "velocity",   "time_interpolation",
                               "times",    "spacing",  "integrator", "direction",
                               "until",    "effects",  "fields",     "geodesics",
                               "attached", "accuracy", "output",     "every",
                               "when"});
  parse_common(map, context, "seeds", tracer.seeds, tracer.seeds_line, tracer);
  parse_kind_and_release(map, tracer);
  parse_geodesics(map, tracer);
  parse_velocity(map, tracer);
  parse_output_times(map, tracer);
  if (const auto integrator = map.find("integrator")) {
    tracer.integrator = parse_integrator(*integrator);
  }
  parse_direction(map, tracer);
  if (const auto spacing = map.find("spacing")) {
    if (tracer.kind != TracerKind::streamline) {
      spacing->fail("path- and streaklines have a vertex for each time at which they are written: "
                    "see 'times'; this key belongs to streamlines");
    }
    tracer.spacing = parse_spacing(*spacing);
  }
  if (const auto until = map.find("until")) {
    tracer.until = parse_limits(*until);
  }
  parse_effects_on(map, tracer);
  if (tracer.attached == Attached::body) {
    check_attached(map, tracer);
  }
  parse_tables(map, tracer);
  return tracer;
}

} // namespace insitu::scene
