#include "commands/render.h"

namespace insitu::bench {

std::optional<PeerFrame> draw_by_vtk(const workload::Mesh&, const std::vector<double>&,
                                     const render::FrameSettings&, int, std::string& why) {
  why = "this insitu-bench was built without VTK's volume rendering";
  return std::nullopt;
}

} // namespace insitu::bench
