#pragma once

#include <span>

#include "query/committed_mesh.h"
#include "render/triangle_surfaces.h"
#include "scene/frame_description.h"
#include "scene/plan.h"

namespace insitu::scene {

/// Adds what a frame, whose bodies were read, needs of a mesh, and what it does without. Throws
/// INSITU_ERROR_FIELD if it lacks a field.
void plan_frame(const Frame& frame, std::span<const render::BodySettings> bodies,
                const query::CommittedMesh& mesh, const core::Threads& threads, Plan& plan);

} // namespace insitu::scene
