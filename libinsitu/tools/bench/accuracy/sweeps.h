#pragma once

#include <memory>

#include "accuracy/sweep.h"
#include "commands.h"
#include "options.h"

/// The sweeps of `insitu-bench accuracy`. `quick` makes them small enough for a test; the shape of
/// the results stays. A sweep computes its own advice.
namespace insitu::bench::accuracy {

struct Extent {
  bool quick = true;
  int repetitions = 3;
};

/// Locator accuracy and method, on all shapes, jitters and twisted cells.
Sweep sweep_locate(const Extent& extent);
/// Newton's tolerance and limit of iterations; float against double far from the origin.
Sweep sweep_newton(const Extent& extent);
/// Integrators, their steps and tolerances, by faces or not.
Sweep sweep_advect(const Extent& extent);
/// Ray step, pre-integration, tolerance, space skipping.
Sweep sweep_volume(const Extent& extent);
/// Samples a pixel, single and multiple scattering.
Sweep sweep_path_tracing(const Extent& extent);
/// Dual mesh and the solver's own cells.
Sweep sweep_amr(const Extent& extent);
/// Refit, rebuild, or what the policy says, on a mesh that moves.
Sweep sweep_update(const Extent& extent);

/// All into one page, to be read from the top. effects: what that command found, or nothing.
std::string page(const std::vector<Sweep>& sweeps, const Output& effects,
                 const std::string& machine);

} // namespace insitu::bench::accuracy
