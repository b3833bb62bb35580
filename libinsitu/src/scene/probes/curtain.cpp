#include "scene/probes/curtain.h"

#include <cmath>
#include <numbers>

#include "scene/earth/cf.h"

namespace insitu::scene {

std::string level_name(const CurtainPlaces& curtain) {
  return cf_position(curtain.frame)[2].name;
}

CurtainSurface::CurtainSurface(const ScenePoints& from, const insitu_frame& mesh)
    : points(from.mesh_points), level_name_(level_name(*from.curtain)) {
  const CurtainPlaces& curtain = *from.curtain;
  const std::size_t stations = curtain.stations.size(), levels = curtain.levels.size();
  if (mesh.kind == INSITU_FRAME_GEODETIC) {
    const double turn = mesh.angle == INSITU_RADIANS ? 2 * std::numbers::pi : 360.0;
    for (std::size_t i = 1; i < points.size(); ++i) {
      const double before = points[i - 1].x;
      points[i].x -= turn * std::round((points[i].x - before) / turn);
    }
  }
  const auto id = [&](std::size_t station, std::size_t level) {
    return std::int64_t(station * levels + level);
  };
  for (std::size_t s = 0; s < stations; ++s)
    for (std::size_t l = 0; l < levels; ++l) {
      distances_.push_back(curtain.distances[s]);
      levels_.push_back(curtain.levels[l]);
      if (s + 1 < stations && l + 1 < levels)
        quads_.insert(quads_.end(), {id(s, l), id(s + 1, l), id(s + 1, l + 1), id(s, l + 1)});
    }
  if (levels == 1)
    line_ends_.push_back(std::int64_t(stations));
}

void CurtainSurface::add_to(output::VtkPolyData& data) const {
  data.line_ends = line_ends_;
  data.quads = quads_;
  data.point_data.push_back(output::vtk_array("distance", std::span<const double>(distances_)));
  data.point_data.push_back(output::vtk_array(level_name_, std::span<const double>(levels_)));
}

} // namespace insitu::scene
