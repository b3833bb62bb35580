#pragma once

#include "advect/effects/drift.h"
#include "advect/field/chart_velocity.h"
#include "advect/field/crossing_velocity.h"
#include "advect/integrate/integrate.h"
#include "advect/lanes/lanes.h"

/// The integrations of the library's own fields, which are compiled once, in integrations.cpp and
/// integrations_crossing.cpp.
namespace insitu::advect {

extern template Stepping integration(LaneVelocity&, const IntegratorSettings&, double, double,
                                     State&, Work&, Visitor);
extern template Stepping integration(DriftVelocity&, const IntegratorSettings&, double, double,
                                     State&, Work&, Visitor);
extern template Stepping integration(ChartVelocity&, const IntegratorSettings&, double, double,
                                     State&, Work&, Visitor);
extern template Stepping integration(CrossingVelocity<DriftVelocity>&, const IntegratorSettings&,
                                     double, double, State&, Work&, Visitor);
extern template Stepping integration(CrossingVelocity<ChartVelocity>&, const IntegratorSettings&,
                                     double, double, State&, Work&, Visitor);

} // namespace insitu::advect
