#pragma once

#include <span>

#include "insitu/insitu.h"

#include "geo/reference_frames.h"
#include "math/vec.h"
#include "scene/parse/description.h"

namespace insitu::scene {

/// A scene's frame as the API's struct, in degrees and metres, with depths if it says so; `mesh`
/// stands for the frame of the mesh, in its units.
insitu_frame to_api(const FrameOfReference& frame, const insitu_frame& mesh);

/// Converts points in place; nothing is done between equal frames. Throws core::Error naming the
/// point for values out of range, and for a conversion between Cartesian and geographic frames,
/// which has no meaning.
void convert_points(std::span<math::Vec3d> points, const insitu_frame& from,
                    const insitu_frame& to);

/// The frame as geo has it. Throws core::Error for numbers that are none of the API's.
geo::Frame to_geo(const insitu_frame& frame);

/// The caller's frame with its later members, whatever the header it was compiled with. Throws
/// core::Error unless it is sound.
insitu_frame read_frame(const insitu_frame& frame);

} // namespace insitu::scene
