#pragma once

#include <memory>

#include "scene/run/action.h"
#include "scene/run/environment.h"

namespace insitu::scene {

/// A frame of a scene: an image whenever due. The structures that it needs beyond the tree (value
/// ranges, cell values averaged to vertices) are made by the renderer when the frame is drawn.
std::unique_ptr<Action> make_frame_action(const Frame& frame, const Environment& environment);

} // namespace insitu::scene
