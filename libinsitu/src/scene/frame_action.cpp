#include "scene/frame_action.h"

#include "core/status.h"

namespace insitu::scene {

std::unique_ptr<Action> make_frame_action(const Frame&, const Environment&) {
  throw core::Error(INSITU_ERROR_UNSUPPORTED, "frames: placeholder until render is there");
}

} // namespace insitu::scene
