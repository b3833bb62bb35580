#pragma once

#include <map>
#include <string>

#include "commit/committed_mesh.h"
#include "render/processes/frame_part.h"
#include "scene/frames/frame_decisions.h"
#include "scene/frames/frame_settings.h"
#include "scene/run/environment.h"

/// What the processes of a session find out together before they draw a frame. All calls are
/// collective and throw parallel::AgreedError.
namespace insitu::scene {

/// The fields that the frame names, as all processes have them.
FieldsByName frame_fields(const Frame& frame, const commit::CommittedMesh& mesh,
                          const Environment& environment);

/// Makes the facts that the mesh's samplers tell those of the whole mesh.
void know_whole_facts(commit::CommittedMesh& mesh, const Environment& environment);

/// Makes averages whole at the vertices of other processes' cells, where smooth normals need them.
void complete_averages(const FrameDecisions& decisions, const commit::CommittedMesh& mesh,
                       render::Structures& structures, parallel::World& world);

/// The ranges of all processes' values by which the frame colours and whose pass is decided.
RangesByColor frame_ranges(const FrameDecisions& decisions, render::Structures& structures,
                           parallel::World& world);

/// How the frame tells cells apart: by global ids where all have them, else by numbers that go on
/// from process to process.
render::FramePart frame_part(const commit::CommittedMesh& mesh, parallel::World& world);

} // namespace insitu::scene
