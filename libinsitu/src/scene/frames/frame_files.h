#pragma once

#include "render/frame.h"
#include "scene/run/environment.h"

namespace insitu::scene {

/// Writes the images that a frame asks for, in its formats, and a row of the frames' table for
/// each: row holds what their rows have in common. Colour keeps its alpha where the background has
/// less than 1. Counts the files. Throws core::Error.
void write_frame_files(const Frame& frame, const Environment& environment,
                       const render::FrameImages& images, CinemaRow row);

} // namespace insitu::scene
