#pragma once

#include <span>

#include "insitu/insitu.h"
#include "math/vec.h"
#include "scene/description.h"

namespace insitu::scene {

/// A scene's frame as the API's struct; `mesh` stands for the frame of the mesh.
insitu_frame to_api(const FrameOfReference& frame, const insitu_frame& mesh);

/// Converts points in place; nothing is done between equal frames. Throws core::Error naming the
/// point for values out of range, and for a conversion between Cartesian and geographic frames, which
/// has no meaning.
void convert_points(std::span<math::Vec3d> points, const insitu_frame& from,
                    const insitu_frame& to, bool depth = false);

/// Throws core::Error unless the frame is sound and one that meshes may have in this version.
void check_mesh_frame(const insitu_frame& frame);

} // namespace insitu::scene
