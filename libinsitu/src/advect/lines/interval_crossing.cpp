#include "advect/lines/interval_one_by_one.h"

namespace insitu::advect {

/// Without effects either step's cells hold the particles; walls and other displacements are those
/// of the current step alone.
void Interval::run_crossing() {
  const Between what = setup_ ? Between::current : Between::either;
  if (asked_.sampler.chart())
    carry([&] { return crossing<CrossingVelocity<ChartVelocity>>(what); });
  else
    carry([&] { return crossing<CrossingVelocity<DriftVelocity>>(what); });
}

} // namespace insitu::advect
