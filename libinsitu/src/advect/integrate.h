#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "insitu/insitu.h"

#include "advect/dense.h"
#include "advect/integrators.h"
#include "advect/settings.h"

namespace insitu::advect {

/// Moves a particle from p.time until `to` (before p.time: backwards; may be infinite), or until
/// its path is max_length long. visit(p) is called at the start and after every step, except those
/// that only close in on an exit. A visitor that can be called with (p, DenseStep) is called so
/// after every step, those included, and at the start with p alone. Returns INSITU_END_ALIVE at
/// `to`, INSITU_END_EXPIRED at max_length, or why it ended. p.x is always a point found inside,
/// unless it was seeded outside or the mesh has moved away from it.
template <VelocityField F, class Visit>
insitu_ending integrate(F& velocity, const IntegratorSettings& settings, double to,
                        double max_length, State& p, Work& work, Visit&& visit);

} // namespace insitu::advect

#include "advect/integration.h"
