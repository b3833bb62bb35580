#pragma once

#include <cstdint>
#include <string>

namespace insitu::scene {

/// The file of a scene's checkpoint at a cycle.
std::string checkpoint_path(const std::string& folder, std::int64_t cycle);

/// Removes the files that checkpoint_path() names in the folder for cycles up to `cycle`, but for
/// the last `keep` of them; descends: for those down to it, where a run's cycles go down.
void remove_old_checkpoints(const std::string& folder, std::int64_t cycle, std::int64_t keep,
                            bool descends);

} // namespace insitu::scene
