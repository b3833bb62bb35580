#pragma once

#include <optional>
#include <string>
#include <vector>

#include "commit/committed_mesh.h"
#include "parallel/world.h"
#include "scene/parse/description.h"

namespace insitu::scene {

/// The places of a curtain, in the coordinates in which the scene gives it.
struct CurtainPlaces {
  insitu_frame frame = insitu_frame_default();
  std::vector<math::Vec3d> stations; ///< (x, y, 0) of each station
  std::vector<double> distances;     ///< [station] distance along the path: metres, or lengths of
                                     ///< the frame
  std::vector<double> levels;        ///< [level] third coordinates
};

/// The points of a scene in the coordinates of the mesh.
struct ScenePoints {
  std::vector<math::Vec3d> mesh_points;
  std::vector<std::string> names;       ///< [point] names of the points; empty: the points have
                                        ///< none
  std::optional<CurtainPlaces> curtain; ///< if given, the points are [station][level]
};
/// file: the text of a source that is a file, if it was read already; null: it is read.
ScenePoints resolve_points(const PointSource& source, const FrameOfReference& frame,
                           const commit::CommittedMesh& mesh, const std::string& scene_file,
                           const std::string* file = nullptr);
/// Returns the text of a source that is a file, which the root reads, on all processes. Collective.
/// Throws parallel::AgreedError.
std::string read_points_for_all(const PointSource& source, parallel::World& world);

} // namespace insitu::scene
