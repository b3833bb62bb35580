#pragma once

#include "commit/committed_mesh.h"
#include "scene/parse/frame_description.h"
#include "scene/run/plan.h"

namespace insitu::scene {

/// The part of plan_frame() that tells of images, what is written over them, and their files.
void plan_images(const Frame& frame, const commit::CommittedMesh& mesh, Plan& plan);

} // namespace insitu::scene
