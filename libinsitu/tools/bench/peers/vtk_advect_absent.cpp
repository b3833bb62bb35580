#include "commands/advect.h"

namespace insitu::bench {

std::vector<PeerLines> trace_by_vtk(const workload::Mesh&, const std::vector<double>&,
                                    const std::vector<math::Vec3d>&, double, double, double, int) {
  return {};
}

} // namespace insitu::bench
