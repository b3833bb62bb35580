#include "options.h"
#include "peers/vtk_parts.h"

namespace insitu::bench {

workload::Mesh read_vtu(const std::string& file) {
  throw UsageError("--mesh " + file + ": this insitu-bench was built without VTK");
}

Peers make_vtk_peers(const workload::Mesh&, const std::vector<double>&) {
  return {};
}

} // namespace insitu::bench
