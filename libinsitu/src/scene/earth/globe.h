#pragma once

#include "commit/committed_mesh.h"
#include "core/context.h"
#include "parallel/world.h"
#include "render/frame.h"
#include "scene/parse/frame_description.h"

namespace insitu::scene {

/// What of a geocentric frame is seen beside the mesh, as far as the frame asks for it, drawn into
/// the finished image: the WGS84 ellipsoid as land where the mesh does not cover it, lit from the
/// viewer, and meridians and parallels on it. images.depth must be there; land gets its own, and no
/// cell. A mesh is in front of the land where images.depth is less: what has not reached half its
/// opacity there is hidden. own: the mesh in its own coordinates, which tells what it covers, at
/// height 0 exactly; over several processes with the whole mesh's chart. Draws at the root.
/// Collective; the settings' camera and size are the same on all processes. Throws
/// parallel::AgreedError.
void draw_globe(const Geocentric& frame, const commit::CommittedMesh& own,
                const render::FrameSettings& settings, parallel::World& world,
                core::Context& context, render::FrameImages& images);

/// What it takes while it draws, for each pixel of 65 rows.
extern const std::int64_t globe_bytes_a_pixel;

} // namespace insitu::scene
