#pragma once

#include "commit/committed_mesh.h"
#include "scene/frames/frame_settings.h"
#include "scene/parse/frame_description.h"
#include "scene/run/plan.h"

namespace insitu::scene {

/// Adds what a frame, whose bodies and colours were read and which has decided, needs of the mesh
/// of one of its layers, and what it does without; with the first one what it needs for itself.
void plan_frame(const Frame& frame, std::size_t layer, const FrameSettingsMaker& settings,
                const FrameDecisions& decisions, const commit::CommittedMesh& mesh,
                const core::Threads& threads, Plan& plan);

} // namespace insitu::scene
