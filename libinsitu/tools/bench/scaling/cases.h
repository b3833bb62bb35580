#pragma once

#include <functional>
#include <string>
#include <vector>

#include "options.h"
#include "parallel/world.h"
#include "scaling/cost_model.h"

namespace insitu::bench::scaling {

/// What one piece of work took and sent. Seconds are medians of the repetitions.
struct Row {
  std::string name;
  bool weak = false;
  int processes = 1;
  Cost model, counted;   ///< counted.items: as the model has them
  double seconds = 0;    ///< until the last process was done
  double work = 0;       ///< processor seconds outside of MPI, of all processes
  double imbalance = 1;  ///< work of the process with most over the mean
  double reductions = 0; ///< of each process
  double halo_cells = 0, halo_cells_by_model = 0; ///< of all processes; of halos alone
};

/// Runs all pieces of work; the rows are complete at the root. Collective.
std::vector<Row> measure(parallel::World& world, const Options& options);

/// Initialises MPI, runs that on all of its processes, and finalises it; returns an exit code. Only
/// the root gets rows.
int run_on_mpi(const Options& options, const std::function<void(const std::vector<Row>&)>& take);
/// The launcher of the MPI that run_on_mpi() is of; empty: this build has none.
std::string launcher();

} // namespace insitu::bench::scaling
