#include "advect/integrate/integrations.h"

namespace insitu::advect {

template Stepping integration(LaneVelocity&, const IntegratorSettings&, double, double, State&,
                              Work&, Visitor);
template Stepping integration(DriftVelocity&, const IntegratorSettings&, double, double, State&,
                              Work&, Visitor);
template Stepping integration(ChartVelocity&, const IntegratorSettings&, double, double, State&,
                              Work&, Visitor);

} // namespace insitu::advect
