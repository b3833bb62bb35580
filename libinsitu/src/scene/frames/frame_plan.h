#pragma once

#include "commit/committed_mesh.h"
#include "scene/frames/frame_settings.h"
#include "scene/parse/frame_description.h"
#include "scene/run/plan.h"

namespace insitu::scene {

/// Adds what a frame, whose bodies and colours were read and which has decided, needs of a mesh,
/// and what it does without.
void plan_frame(const Frame& frame, const FrameSettingsMaker& settings,
                const FrameDecisions& decisions, const commit::CommittedMesh& mesh,
                const core::Threads& threads, Plan& plan);

} // namespace insitu::scene
