#pragma once

#include "scene/frames/frame_decisions.h"
#include "scene/parse/frame_description.h"
#include "scene/run/plan.h"

namespace insitu::scene {

/// The part of plan_frame() that tells of images, what is written over them, and their files.
void plan_images(const Frame& frame, const FrameDecisions& decisions, Plan& plan);

} // namespace insitu::scene
