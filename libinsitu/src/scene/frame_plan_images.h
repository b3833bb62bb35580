#pragma once

#include "query/committed_mesh.h"
#include "scene/frame_description.h"
#include "scene/plan.h"

namespace insitu::scene {

/// The part of plan_frame() that tells of images, what is written over them, and their files.
void plan_images(const Frame& frame, const query::CommittedMesh& mesh, Plan& plan);

} // namespace insitu::scene
