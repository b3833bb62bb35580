#include <cmath>

#include "scene/parse/parse_parts.h"

namespace insitu::scene {
namespace {

enum class TracerEffect {
  diffusion,
  settling,
  windage,
  inertia,
  coriolis,
  boundary,
  age_limit,
  remove
};

constexpr Interval not_negative{0};

/// A number of the interval, or a field's name.
NumberOrField parse_number_or_field(const Cursor& cursor, const Interval& interval) {
  NumberOrField out;
  const bool is_name = cursor.is_text() && !cursor.node().text.empty() &&
                       (cursor.node().quoted || cursor.node().text.find_first_not_of(
                                                    "0123456789+-.eE") != std::string::npos);
  if (is_name) {
    assign(out.field, parse_name(cursor));
  } else {
    assign(out.number, cursor.number(interval));
  }
  return out;
}

void parse_diffusion(const Cursor& cursor, TracerEffects& effects) {
  DiffusionEffect& d = effects.diffusion.emplace();
  const MapReader map(cursor, {"coefficient", "horizontal", "vertical", "step", "seed"});
  if (const auto both = map.find("coefficient")) {
    d.horizontal = d.vertical = parse_number_or_field(*both, not_negative);
  }
  for (const auto& [key, to] :
       {std::pair{"horizontal", &d.horizontal}, {"vertical", &d.vertical}}) {
    if (const auto one = map.find(key)) {
      if (map.has("coefficient")) {
        one->fail("either 'coefficient' or 'horizontal' and 'vertical'");
      }
      *to = parse_number_or_field(*one, not_negative);
    }
  }
  if (map && !map.has("coefficient") && !map.has("horizontal") && !map.has("vertical")) {
    cursor.fail("one of 'coefficient', 'horizontal', 'vertical' is missing");
  }
  if (const auto step = map.find("step")) {
    assign(d.step, step->number(positive));
  }
  if (const auto seed = map.find("seed")) {
    assign(d.seed, seed->integer(0, most_steps));
  }
}

void parse_settling(const Cursor& cursor, TracerEffects& effects) {
  SettlingEffect& s = effects.settling.emplace();
  const MapReader map(cursor, {"velocity", "speed", "down"});
  if (const auto velocity = map.find("velocity")) {
    s.velocity = velocity->vector();
  }
  if (const auto speed = map.find("speed")) {
    s.speed = parse_number_or_field(*speed, {});
  }
  if (map && map.has("velocity") == map.has("speed")) {
    cursor.fail("exactly one of 'velocity', 'speed' expected");
  }
  if (const auto down = map.find("down")) {
    if (map.has("velocity")) {
      down->fail("'down' belongs to 'speed'");
    }
    math::Vec3d to;
    assign(to, down->vector());
    const double length = std::hypot(to.x, to.y, to.z);
    if (!(length > 0.0)) {
      down->fail("a direction expected, [0, 0, 0] found");
    } else {
      s.down = to / length;
    }
  }
}

void parse_windage(const Cursor& cursor, TracerEffects& effects) {
  WindageEffect& w = effects.windage.emplace();
  const MapReader map(cursor, {"field", "factor"});
  if (const auto field = map.require("field")) {
    assign(w.field, parse_name(*field));
  }
  if (const auto factor = map.find("factor")) {
    assign(w.factor, factor->number());
  }
}

void parse_inertia(const Cursor& cursor, TracerEffects& effects) {
  InertiaEffect& i = effects.inertia.emplace();
  const MapReader map(cursor, {"response_time", "diameter", "density", "fluid_density", "viscosity",
                               "gravity", "added_mass", "velocity"});
  for (const auto& [key, to] : {std::pair{"response_time", &i.response_time},
                                {"diameter", &i.diameter},
                                {"density", &i.density},
                                {"fluid_density", &i.fluid_density},
                                {"viscosity", &i.viscosity}}) {
    if (const auto value = map.find(key)) {
      *to = value->number(positive);
    }
  }
  if (const auto gravity = map.find("gravity")) {
    assign(i.gravity, gravity->vector());
  }
  if (const auto mass = map.find("added_mass")) {
    assign(i.added_mass, mass->boolean());
  }
  if (const auto velocity = map.find("velocity")) {
    i.velocity = velocity->vector();
  }
  if (map.has("response_time") && map.has("diameter")) {
    cursor.fail("either 'response_time' or 'diameter'");
  }
  if (map.has("diameter") && !(map.has("density") && map.has("viscosity"))) {
    cursor.fail("'diameter' needs 'density' and 'viscosity'");
  }
  if (map.has("viscosity") && !map.has("diameter")) {
    cursor.fail("'viscosity' belongs to 'diameter'");
  }
  if (map.has("fluid_density") && !map.has("density")) {
    cursor.fail("'fluid_density' needs 'density'");
  }
  if (i.added_mass && !(map.has("density") && map.has("fluid_density"))) {
    cursor.fail("'added_mass' needs 'density' and 'fluid_density'");
  }
}

void parse_coriolis(const Cursor& cursor, TracerEffects& effects) {
  const MapReader map(cursor, {"rotation"});
  effects.rotation.emplace();
  if (const auto rotation = map.require("rotation")) {
    assign(*effects.rotation, rotation->vector());
  }
}

std::optional<WallResponse> parse_response(const Cursor& cursor) {
  return cursor.choice<WallResponse>({{"leave", WallResponse::leave},
                                      {"stop", WallResponse::stop},
                                      {"slide", WallResponse::slide},
                                      {"reflect", WallResponse::reflect},
                                      {"put_back", WallResponse::put_back}});
}

void parse_boundary_effect(const Cursor& cursor, TracerEffects& effects) {
  WallEffect& wall = effects.boundary.emplace();
  if (cursor.is_text()) {
    assign(wall.other, parse_response(cursor));
    return;
  }
  const MapReader map(cursor, {"periodic", "other", "restitution"});
  if (const auto periodic = map.find("periodic")) {
    for (const int axis : parse_words<int>(*periodic, {{"x", 0}, {"y", 1}, {"z", 2}}, "axis")) {
      wall.periodic[axis] = true;
    }
  }
  if (const auto other = map.find("other")) {
    assign(wall.other, parse_response(*other));
  }
  if (const auto restitution = map.find("restitution")) {
    assign(wall.restitution, restitution->number({0, 1}));
    if (wall.other != WallResponse::reflect) {
      restitution->fail("'restitution' belongs to 'other: reflect'");
    }
  }
}

void parse_remove(const Cursor& cursor, TracerEffects& effects) {
  const MapReader map(cursor, {"when"});
  const auto when = map.require("when");
  const auto text = when ? when->text() : std::nullopt;
  if (!text) {
    return;
  }
  try {
    effects.remove = RemoveEffect{Expression(*text, Expression::Scope::point), when->line()};
  } catch (const ExpressionError& error) {
    when->fail(describe(error, *text));
  }
}

} // namespace

TracerEffects parse_tracer_effects(const Cursor& cursor) {
  TracerEffects effects;
  const auto reader = [&effects](void (*read)(const Cursor&, TracerEffects&)) {
    return [&effects, read](const Cursor& options) { read(options, effects); };
  };
  const auto found = parse_effects<TracerEffect>(
      cursor, {{"diffusion", TracerEffect::diffusion, reader(parse_diffusion)},
               {"settling", TracerEffect::settling, reader(parse_settling)},
               {"windage", TracerEffect::windage, reader(parse_windage)},
               {"inertia", TracerEffect::inertia, reader(parse_inertia)},
               {"coriolis", TracerEffect::coriolis, reader(parse_coriolis)},
               {"boundary", TracerEffect::boundary, reader(parse_boundary_effect)},
               {"age_limit", TracerEffect::age_limit,
                [&](const Cursor& age) { effects.age_limit = age.number(positive); }},
               {"remove", TracerEffect::remove, reader(parse_remove)}});
  const auto items = cursor.items();
  for (const Cursor& item : items ? *items : std::vector<Cursor>{}) {
    if (item.is_text() && !found.empty()) {
      item.fail("effect '" + item.node().text + "' needs options: a map of its name and them");
    }
  }
  if (effects.rotation && !effects.inertia) {
    cursor.fail("'coriolis' acts on particles with a velocity of their own: add 'inertia' (without "
                "it the flow carries them, which has felt it already)");
  }
  return effects;
}

} // namespace insitu::scene
