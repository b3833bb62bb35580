#pragma once

#include <cstddef>

#include "energy.h"
#include "methods/runner.h"
#include "workload/mesh.h"

namespace insitu::bench {

/// The box of make_box with a vertex field and the cells' ids as a cell field.
MethodMesh make_method_mesh(workload::Kind kind, workload::Spacing spacing, std::int64_t cells,
                            double jitter);
/// The same of make_twisted_box.
MethodMesh make_twisted_method_mesh(std::int64_t cells, double amplitude);

/// Ray methods are slow on processors: they answer the first of the points only, and bvh there the
/// first million.
std::size_t most_points(accel::Backend backend, accel::Method method);

/// Million of the runner's points a second: the median of a few runs; one where it takes long.
/// in_processor_time: of one thread, which others on the machine change least.
double time_rate(MethodRunner& runner, Wanted wanted, insitu_accuracy accuracy, std::size_t points,
                 int repetitions, bool in_processor_time = false);

/// What was drawn while points were answered for a second or more: counters tick slowly.
struct Drawn {
  double joules = 0.0, seconds = 0.0, millions = 0.0;
};
Drawn draw_power(MethodRunner& runner, EnergyMeter& meter, Wanted wanted, std::size_t points);

} // namespace insitu::bench
