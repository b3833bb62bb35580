#pragma once

#include <optional>
#include <string>
#include <vector>

#include "advect/effects/effects.h"
#include "advect/field/crossing_velocity.h"
#include "commit/earlier/earlier_mesh.h"
#include "scene/parse/description.h"
#include "scene/run/step.h"

namespace insitu::scene {

/// The fields whose earlier steps the effects use as well: velocities of so many steps,
/// coefficients of one, since only on a straight line they stay positive.
std::vector<mesh::KeptField> effect_fields(const TracerEffects& effects, int steps);

/// The effects with the fields of this step, for one advance. earlier: how many steps before it may
/// serve. Throws as find_field().
advect::Effects effects_at(const Tracer& tracer, const commit::CommittedMesh& mesh,
                           const Step& step, int earlier, const std::string& scene_file);

/// The step before on its own cells, if all that moves the tracer's particles was kept of it.
/// frame: of effects_at()'s mesh.
std::optional<advect::StepBefore> step_before(const Tracer& tracer, const commit::EarlierMesh& mesh,
                                              const insitu_frame& frame);

} // namespace insitu::scene
