#include "scaling/cases.h"

namespace insitu::bench::scaling {

std::string launcher() {
  return {};
}

int run_on_mpi(const Options&, const std::function<void(const std::vector<Row>&)>&) {
  throw UsageError("scaling: this build has no MPI");
}

} // namespace insitu::bench::scaling
