#pragma once

#include "commit/committed_mesh.h"
#include "scene/run/plan.h"

namespace insitu::scene {

/// Adds what a committed mesh holds whatever the scene asks for, and what it does without.
void plan_mesh(const commit::CommittedMesh& mesh, Plan& plan);

} // namespace insitu::scene
