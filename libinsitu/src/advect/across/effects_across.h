#pragma once

#include <optional>

#include "advect/effects/mover.h"
#include "parallel/world.h"

namespace insitu::advect {

/// Makes what a setup knows of this process's cells that of all processes: coefficients of a walk
/// and the box with periodic sides. All have one, or none has. Collective; throws
/// parallel::AgreedError.
void share_effects(parallel::World& world, const query::Sampler& sampler,
                   const core::Threads& threads, std::optional<EffectSetup>& setup);

} // namespace insitu::advect
