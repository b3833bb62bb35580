#pragma once

#include <string>

#include "scene/parse/description.h"

namespace insitu::scene {

/// Returns the folder of the previews of a run that writes to a folder: its images have the names
/// of the run's own, and must not replace them.
std::string preview_folder(const std::string& output);

/// Returns the scene with its frames alone, each of which is drawn at each cycle, for a look at
/// them, into the preview_folder() of its output folder: images keep their aspect and fit into 160
/// x 120 pixels, at one sample a pixel (a path traced volume at 16 paths a pixel at most). There
/// are no probes, no tracers, no checkpoints, no
/// records and no page. Throws core::Error (INSITU_ERROR_SCENE)
/// for a scene without frames.
SceneDescription preview_of(SceneDescription scene);

} // namespace insitu::scene
