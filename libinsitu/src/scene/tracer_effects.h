#pragma once

#include <string>
#include <vector>

#include "advect/effects.h"
#include "scene/action.h"

namespace insitu::scene {

/// The fields whose earlier step the effects use as well.
std::vector<std::string> effect_fields(const TracerEffects& effects);

/// The effects with the fields of this step, for one advance. earlier: the earlier step serves.
/// Throws as find_field().
advect::Effects effects_at(const Tracer& tracer, const query::CommittedMesh& mesh, const Step& step,
                           bool earlier, const std::string& scene_file);

} // namespace insitu::scene
