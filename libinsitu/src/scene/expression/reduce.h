#pragma once

#include <string>

#include "commit/committed_mesh.h"
#include "core/parallel.h"
#include "scene/expression/reduction.h"
#include "scene/parse/names.h"

namespace insitu::scene {

/// Returns the minimum, maximum or mean of a field (for a vector field, of its magnitudes) over
/// owning cells, or over the vertices that they use. NaN values are left out; the result is NaN if
/// no value is left.
double reduce_field(const commit::CommittedMesh& mesh, const Name& field,
                    const std::string& scene_file, Reduction reduction,
                    const core::Threads& threads);

} // namespace insitu::scene
