#pragma once

#include "query/committed_mesh.h"
#include "scene/plan.h"

namespace insitu::scene {

/// Adds what a committed mesh holds whatever the scene asks for, and what it does without.
void plan_mesh(const query::CommittedMesh& mesh, Plan& plan);

} // namespace insitu::scene
