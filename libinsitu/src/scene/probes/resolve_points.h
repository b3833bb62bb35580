#pragma once

#include <optional>
#include <string>
#include <vector>

#include "commit/committed_mesh.h"
#include "scene/parse/description.h"

namespace insitu::scene {

/// Where a curtain stands, in the coordinates it was given in.
struct CurtainPlaces {
  insitu_frame frame = insitu_frame_default();
  std::vector<math::Vec3d> stations; ///< x, y, 0
  std::vector<double> distances;     ///< [station] along its path: metres, or lengths of the frame
  std::vector<double> levels;        ///< the third coordinates
};

/// Points of a scene in the mesh's coordinates.
struct ScenePoints {
  std::vector<math::Vec3d> mesh_points;
  std::vector<std::string> names;       ///< or empty
  std::optional<CurtainPlaces> curtain; ///< then the points are [station][level]
};
ScenePoints resolve_points(const PointSource& source, const FrameOfReference& frame,
                           const commit::CommittedMesh& mesh, const std::string& scene_file);

} // namespace insitu::scene
