#pragma once

#include <string>

#include "commit/committed_mesh.h"
#include "core/parallel.h"
#include "scene/expression/reduction.h"
#include "scene/parse/names.h"

namespace insitu::scene {

/// Minimum, maximum or mean of a field (of a vector field's magnitudes) over owning cells, or over
/// the vertices they use. NaN values are left out; NaN if nothing is left.
double reduce_field(const commit::CommittedMesh& mesh, const Name& field,
                    const std::string& scene_file, Reduction reduction,
                    const core::Threads& threads);

} // namespace insitu::scene
