#include <cmath>
#include <cstdio>
#include <string>

#include "advect/effects/mover.h"
#include "advect/integrate/check.h"
#include "core/status.h"

namespace insitu::advect {

namespace {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

[[noreturn]] void refuse(const std::string& what, const char* wanted, double value) {
  throw core::Error(INSITU_ERROR_ARGUMENT,
                    "tracer: " + what + " must be " + wanted + ", " + number(value) + " given");
}

void check_field(const FieldInTime& field, const char* of, int components, int or_components) {
  const auto check = [&](const mesh::FieldView* f) {
    if (f->components != components && f->components != or_components)
      throw core::Error(INSITU_ERROR_FIELD,
                        "tracer: field '" + std::string(f->name) + "' of " + of + " needs " +
                            std::to_string(components) +
                            (components == or_components ? std::string()
                                                         : " or " + std::to_string(or_components)) +
                            (or_components == 1 && components == 1 ? " component" : " components") +
                            ", it has " + std::to_string(f->components));
  };
  check(&field.now);
  for (const mesh::FieldView& f : field.earlier)
    check(&f);
}

void check_coefficient(const Coefficient& c) {
  if (c.field)
    check_field(*c.field, "diffusion", 1, 1);
  else if (!(c.constant >= 0.0) || !std::isfinite(c.constant))
    refuse("diffusion coefficient", "0 or more, and finite", c.constant);
}

void check_vector(const math::Vec3d& v, const std::string& what) {
  for (int a = 0; a < 3; ++a)
    if (!std::isfinite(v[a]))
      refuse(what, "finite", v[a]);
}

} // namespace

void check_effects(const Effects& effects) {
  for (const Drift& d : effects.drifts) {
    if (d.field)
      check_field(*d.field, "a drift", 1, effects.is_flat && d.field->now.components == 2 ? 2 : 3);
    check_vector(d.constant, "drift");
    check_vector(d.direction, "direction of a drift");
    if (!std::isfinite(d.factor))
      refuse("factor of a drift", "finite", d.factor);
  }
  if (effects.diffusion) {
    check_coefficient(effects.diffusion->horizontal);
    check_coefficient(effects.diffusion->vertical);
    if (!(effects.diffusion->step >= 0.0))
      refuse("step of diffusion", "positive", effects.diffusion->step);
  }
  if (effects.inertia) {
    if (!(effects.inertia->response_time > 0.0)) // so that NaN is refused
      refuse("response time", "positive", effects.inertia->response_time);
    check_vector(effects.inertia->acceleration, "acceleration");
    check_vector(effects.inertia->rotation, "rotation");
    if (effects.inertia->begins)
      check_vector(*effects.inertia->begins, "first velocity");
    if (!(effects.inertia->fluid_share >= 0.0 && effects.inertia->fluid_share <= 3.0))
      refuse("share of the fluid's acceleration", "from 0 to 3", effects.inertia->fluid_share);
  }
  if (effects.boundary &&
      !(effects.boundary->restitution >= 0.0 && effects.boundary->restitution <= 1.0))
    refuse("restitution", "from 0 to 1", effects.boundary->restitution);
}

void check_line_effects(const StreamlineSettings& settings) {
  const auto no = [](const char* what) {
    throw core::Error(INSITU_ERROR_ARGUMENT, std::string("streamlines: ") + what);
  };
  const Effects& effects = settings.effects;
  check_effects(effects);
  if (effects.diffusion)
    no("a random walk has no velocity to follow");
  if (effects.inertia && settings.direction != Direction::forward)
    no("particles with inertia are followed forward alone");
  if (effects.inertia && !std::isfinite(settings.duration))
    no("particles with inertia need a duration");
  if (effects.boundary && effects.boundary->response == AtBoundary::put_back)
    no("what is put back at a wall begins again without end");
  if (effects.boundary && effects.boundary->response == AtBoundary::reflect && !effects.inertia)
    no("a wall reflects what has inertia alone");
}

} // namespace insitu::advect
