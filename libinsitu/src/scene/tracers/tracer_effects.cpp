#include "scene/tracers/tracer_effects.h"

#include "core/status.h"
#include "scene/run/lookup.h"

namespace insitu::scene {
namespace {

/// Tracers of one scene walk ways of their own (FNV-1a of the name).
std::uint64_t seed_of(const Tracer& tracer) {
  std::uint64_t hash = 0xcbf29ce484222325ull;
  for (const char c : tracer.name)
    hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ull;
  return hash + std::uint64_t(tracer.effects.diffusion->seed);
}

bool lacks(const commit::CommittedMesh& mesh, const Name& field) {
  return mesh.mesh().view().cell_count() == 0 && !mesh.mesh().has_field(field.text);
}

class Resolver {
public:
  Resolver(const commit::CommittedMesh& mesh, int earlier, const std::string& scene_file)
      : mesh_(mesh), earlier_(earlier), scene_file_(scene_file) {}

  /// A process without cells may lack a field, whose values it does not need.
  advect::FieldInTime field(const Name& name, int components) const {
    if (lacks(mesh_, name))
      return {{name.text.c_str(), INSITU_VERTEX, components}, {}};
    advect::FieldInTime out{find_field(mesh_, name, scene_file_), {}};
    out.earlier = mesh_.mesh().earlier_fields(name.text);
    if (out.earlier.size() > std::size_t(earlier_))
      out.earlier.resize(std::size_t(earlier_));
    return out;
  }
  advect::Coefficient coefficient(const NumberOrField& from) const {
    advect::Coefficient out{from.number, {}};
    if (!from.field.empty())
      out.field = field(from.field, 1);
    return out;
  }

private:
  const commit::CommittedMesh& mesh_;
  int earlier_; ///< steps at most
  const std::string& scene_file_;
};

/// Whether the third axis of its coordinates points into the Earth. A geodetic mesh's vectors are
/// east, north and up whatever it counts.
bool points_down(const insitu_frame& frame) {
  return frame.kind == INSITU_FRAME_UTM && frame.vertical == INSITU_DOWN;
}

/// Densities: buoyancy, and with added mass the share of the fluid's acceleration (Maxey and Riley
/// 1983).
advect::Inertia inertia_of(const TracerEffects& effects, const insitu_frame& frame) {
  const InertiaEffect& from = *effects.inertia;
  advect::Inertia to;
  to.begins = from.velocity;
  to.rotation = effects.rotation.value_or(math::Vec3d{});
  // The axes are left-handed there, so that the product's components have the other sign.
  if (points_down(frame))
    to.rotation = -to.rotation;
  const double solid = from.density.value_or(1.0), fluid = from.fluid_density.value_or(0.0);
  if (from.added_mass)
    to.fluid_share = 3.0 * fluid / (2.0 * solid + fluid);
  to.acceleration = (1.0 - (from.added_mass ? to.fluid_share : fluid / solid)) * from.gravity;
  if (from.response_time) {
    to.response_time = *from.response_time;
  } else if (from.diameter) { // Stokes; with added mass, half of the fluid's goes along
    const double mass = from.added_mass ? solid + 0.5 * fluid : solid;
    to.response_time = mass * *from.diameter * *from.diameter / (18.0 * *from.viscosity);
  }
  return to;
}

advect::AtBoundary response_of(WallResponse response) {
  switch (response) {
  case WallResponse::leave:
    return advect::AtBoundary::leave;
  case WallResponse::stop:
    return advect::AtBoundary::stop;
  case WallResponse::slide:
    return advect::AtBoundary::slide;
  case WallResponse::put_back:
    return advect::AtBoundary::put_back;
  case WallResponse::reflect:
    break;
  }
  return advect::AtBoundary::reflect;
}

/// field(name): a field as drifts see it.
template <class Field>
std::vector<advect::Drift> drifts_of(const TracerEffects& from, const insitu_frame& frame,
                                     bool is_flat, Field&& field) {
  std::vector<advect::Drift> drifts;
  if (from.settling && is_flat && !from.settling->velocity)
    throw core::Error(INSITU_ERROR_UNSUPPORTED,
                      "settling: a speed, on a flat mesh, which has no third direction; give the "
                      "velocity");
  if (from.settling) {
    const math::Vec3d down =
        from.settling->down.value_or(math::Vec3d{0, 0, points_down(frame) ? 1.0 : -1.0});
    advect::Drift drift;
    drift.is_local = frame.kind == INSITU_FRAME_GEOCENTRIC;
    if (from.settling->velocity) {
      drift.constant = *from.settling->velocity;
      if (is_flat)
        drift.constant.z = 0.0;
    } else if (from.settling->speed.field.empty()) {
      drift.constant = from.settling->speed.number * down;
    } else {
      drift.field = field(from.settling->speed.field, 1);
      drift.direction = down;
      if (drift.field->now.components != 1) {
        throw core::Error(INSITU_ERROR_FIELD,
                          "the field '" + from.settling->speed.field.text +
                              "' of a settling speed needs 1 component, it has " +
                              std::to_string(drift.field->now.components));
      }
    }
    drifts.push_back(drift);
  }
  if (from.windage) {
    advect::Drift drift;
    drift.field = field(from.windage->field, 3);
    drift.factor = from.windage->factor;
    if (drift.field->now.components != 3 && !(is_flat && drift.field->now.components == 2)) {
      throw core::Error(INSITU_ERROR_FIELD, "the field '" + from.windage->field.text +
                                                "' of windage needs 3 components, it has " +
                                                std::to_string(drift.field->now.components));
    }
    drifts.push_back(drift);
  }
  return drifts;
}

/// Vectors count by their magnitude, as in the scene's other conditions. A process without cells
/// may lack the fields.
void add_removal(const RemoveEffect& remove, const commit::CommittedMesh& mesh, const Step& step,
                 const std::string& scene_file, advect::Effects& to) {
  for (const Expression::FieldUse& use : remove.when.uses()) {
    const Name name{use.field, remove.line};
    to.removes_by.push_back(lacks(mesh, name) ? mesh::FieldView{use.field.c_str(), INSITU_VERTEX, 1}
                                              : find_field(mesh, name, scene_file));
  }
  to.removes = [&remove, cycle = step.cycle, time = step.time](
                   const std::vector<double>& values, const query::Location&, const math::Vec3d&,
                   double age) { return remove.when.evaluate_at(cycle, time, age, values); };
}

} // namespace

std::vector<mesh::KeptField> effect_fields(const TracerEffects& effects, int steps) {
  std::vector<mesh::KeptField> fields;
  const auto add = [&](const Name& name, int of) {
    if (!name.empty())
      fields.push_back({name.text, of});
  };
  if (effects.diffusion) {
    add(effects.diffusion->horizontal.field, 1);
    add(effects.diffusion->vertical.field, 1);
  }
  if (effects.settling)
    add(effects.settling->speed.field, steps);
  if (effects.windage)
    add(effects.windage->field, steps);
  return fields;
}

advect::Effects effects_at(const Tracer& tracer, const commit::CommittedMesh& mesh,
                           const Step& step, int earlier, const std::string& scene_file) {
  const TracerEffects& from = tracer.effects;
  const Resolver resolve(mesh, earlier, scene_file);
  advect::Effects to;
  to.geocentric = mesh.reference_frame.kind == INSITU_FRAME_GEOCENTRIC;
  to.is_flat = mesh.is_flat();
  to.drifts =
      drifts_of(from, mesh.reference_frame, to.is_flat,
                [&](const Name& name, int components) { return resolve.field(name, components); });
  if (from.diffusion) {
    to.diffusion = advect::Diffusion{resolve.coefficient(from.diffusion->horizontal),
                                     mesh.is_flat() ? advect::Coefficient{}
                                                    : resolve.coefficient(from.diffusion->vertical),
                                     from.diffusion->step, seed_of(tracer)};
  }
  if (from.inertia)
    to.inertia = inertia_of(from, mesh.reference_frame);
  if (to.inertia && mesh.is_flat())
    to.inertia->acceleration.z = 0.0;
  if (from.boundary) {
    to.boundary.emplace();
    to.boundary->response = response_of(from.boundary->other);
    to.boundary->restitution = from.boundary->restitution;
    for (int a = 0; a < 3; ++a)
      to.boundary->periodic[a] = from.boundary->periodic[a];
  }
  if (from.remove)
    add_removal(*from.remove, mesh, step, scene_file, to);
  return to;
}

std::optional<advect::StepBefore> step_before(const Tracer& tracer, const commit::EarlierMesh& mesh,
                                              const insitu_frame& frame) {
  const std::optional<mesh::FieldView> velocity = mesh.field(tracer.velocity.text);
  for (const mesh::KeptField& of : effect_fields(tracer.effects, 1))
    if (!mesh.field(of.name))
      return std::nullopt;
  const bool is_flat = mesh.sampler().mesh().is_flat;
  if (!velocity || (velocity->components != 3 && !(is_flat && velocity->components == 2)))
    return std::nullopt;
  return advect::StepBefore{mesh.sampler(), *velocity,
                            drifts_of(tracer.effects, frame, is_flat, [&](const Name& name, int) {
                              return advect::FieldInTime{*mesh.field(name.text), {}};
                            })};
}

} // namespace insitu::scene
