#pragma once

#include <span>

#include "advect/exits.h"
#include "advect/particles.h"
#include "parallel/world.h"

namespace insitu::advect {

/// Tells how the particles of all processes left, each of which is where its last cell is owned:
/// sets their endings. inside: the tracer's cells here. Collective.
void tell_exits(parallel::World& world, Exits& exits, const query::Sampler& inside,
                std::span<const LeftAt> left, Particles& particles);

} // namespace insitu::advect
