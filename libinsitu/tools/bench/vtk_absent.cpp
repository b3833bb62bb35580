#include "options.h"
#include "vtk_parts.h"

namespace insitu::bench {

workload::Mesh read_vtu(const std::string& file) {
  throw UsageError("--mesh " + file + ": this insitu-bench was built without VTK");
}

std::vector<std::unique_ptr<Peer>> make_peers(const workload::Mesh&, const std::vector<double>&,
                                              const std::vector<std::string>&) {
  return {};
}

} // namespace insitu::bench
