#include "advect/integrate/integrations.h"

namespace insitu::advect {

template Stepping integration(CrossingVelocity<DriftVelocity>&, const IntegratorSettings&, double,
                              double, State&, Work&, Visitor);
template Stepping integration(CrossingVelocity<ChartVelocity>&, const IntegratorSettings&, double,
                              double, State&, Work&, Visitor);

} // namespace insitu::advect
