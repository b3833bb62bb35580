#pragma once

#include <string>

#include "commit/committed_mesh.h"
#include "report/json.h"
#include "render/frame.h"
#include "setup.h"

namespace insitu::bench {

struct RefreshedFrames {
  std::string text;
  Json json; ///< an object
};

/// What frames keep is not made anew for new values: of a sparse volume and a lit isosurface, which
/// the settings are to show, before and after a commit of fields alone.
RefreshedFrames refresh_frames(Setup& setup, commit::CommittedMesh& mesh,
                               const render::FrameSettings& settings);

} // namespace insitu::bench
