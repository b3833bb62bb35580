#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "output/vtk/xml_vtk.h"
#include "scene/probes/resolve_points.h"

/// How the points of a curtain are written.
namespace insitu::scene {

/// What a curtain's levels are: "depth", "height", or "z" in frames without one.
std::string level_name(const CurtainPlaces& curtain);

/// A curtain as a surface for VTK files: quads between neighbouring stations and levels, a line
/// along the stations of one level. Its points are the mesh's coordinates, but longitudes go on
/// from station to station without a jump where the path crosses the date line.
struct CurtainSurface {
  CurtainSurface(const ScenePoints& points, const insitu_frame& mesh);
  /// Cells and the point data distance and depth (or height, or z), which stay here.
  void add_to(output::VtkPolyData& data) const;

  std::vector<math::Vec3d> points;

private:
  std::string level_name_;
  std::vector<double> distances_, levels_; ///< [point]
  std::vector<std::int64_t> quads_, line_ends_;
};

} // namespace insitu::scene
