#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/image.h"
#include "measure.h"
#include "render/frame.h"
#include "workload/mesh.h"

namespace insitu::bench {

/// A frame by a peer.
struct PeerFrame {
  std::string name;
  std::int64_t cells = 0;       ///< that it draws
  double convert_seconds = 0.0; ///< from the mesh's cells to its own
  double first_seconds = 0.0;   ///< the first frame, with what it builds
  Series time;                  ///< of frames from then on, on one thread
  core::Image color;            ///< over black, linear
};

/// The volume of the settings by vtkUnstructuredGridVolumeRayCastMapper, on one thread. Empty
/// without VTK's rendering or a display; `why` then says so.
std::optional<PeerFrame> draw_by_vtk(const workload::Mesh& mesh, const std::vector<double>& field,
                                     const render::FrameSettings& settings, int repetitions,
                                     std::string& why);

} // namespace insitu::bench
