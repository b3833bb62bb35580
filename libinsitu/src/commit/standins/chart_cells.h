#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/parallel.h"
#include "mesh/view.h"
#include "query/chart_image.h"

namespace insitu::commit {

/// A cell of a geodetic mesh that is located in a copy.
struct ChartCopy {
  geo::Pole pole;    ///< on the chart turned to it; none: moved by whole turns
  int turns;         ///< seam: added to a vertex' longitude, which the others are kept near to
  std::int64_t cell; ///< flat id
  double first;      ///< that vertex' longitude
};

/// Which cells cannot be located where their numbers say, and the points' images that follow.
///
///   wrapping   its longitudes jump (359.5 to 0.5), or lie beyond one turn of the others'
///   polar      it holds a pole, or has a vertex there whose longitude says nothing
///
/// Those are hidden. Wrapping ones are copied with continuous longitudes, once or, across the seam,
/// twice. Where there are polar ones, points from their lowest latitude on (and that of the cells
/// around, which span many degrees of longitude) have their images on a turned chart, and every
/// cell that reaches there is copied to it. A lattice whose last row lies at 90 degrees with a
/// longitude for every vertex has none of either.
struct ChartCells {
  query::ChartImage image;
  std::vector<std::int64_t> hidden; ///< flat ids, ascending
  std::vector<ChartCopy> copies;    ///< seam, north, south, each in ascending order
};

/// Looks at all cells that own points. The arrays must be valid; cells with coordinates that are
/// not finite are passed over. Throws Error(INSITU_ERROR_MESH): a latitude out of range; a cell
/// that spans half a turn or more without being near a pole.
ChartCells find_chart_cells(const std::string& mesh_name, const mesh::MeshView& mesh,
                            const geo::ChartUnits& units, const core::Threads& threads);

/// The whole turns that bring a longitude within half a turn of the cell's first vertex'.
int turns_to(const geo::ChartUnits& units, double first, double longitude);

} // namespace insitu::commit
