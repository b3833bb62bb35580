#pragma once

#include "query/committed_mesh.h"
#include "scene/frame_description.h"
#include "scene/plan.h"

namespace insitu::scene {

/// Adds what a frame needs of a mesh, and what it does without. Throws INSITU_ERROR_FIELD if it
/// lacks a field.
void plan_frame(const Frame& frame, const query::CommittedMesh& mesh, Plan& plan);

} // namespace insitu::scene
