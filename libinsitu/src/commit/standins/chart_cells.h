#pragma once

#include <cstdint>
#include <limits>
#include <span>
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

/// What a chart takes from a mesh as a whole: the least of its cells' numbers, so those of parts of
/// a mesh add up. Latitudes are without sign, [0] north and [1] south.
struct ChartFacts {
  static constexpr double none = std::numeric_limits<double>::infinity();
  double west = none;               ///< longitude of the cells that can stay
  double polar[2] = {none, none};   ///< latitude of those that hold a pole
  double slanted[2] = {none, none}; ///< and, from 60 degrees on, of those that span 20 of longitude

  std::span<double> numbers() { return {&west, 5}; }
  void add(const ChartFacts& other);
  bool operator==(const ChartFacts&) const = default;
};
static_assert(sizeof(ChartFacts) == 5 * sizeof(double));

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

/// Finds them in two looks at all cells that exist. The arrays must be valid; cells with
/// coordinates that are not finite are passed over. The arguments must outlive the object.
class ChartSearch {
public:
  /// Throws Error(INSITU_ERROR_MESH): a latitude out of range; a cell that spans half a turn or
  /// more without being near a pole.
  ChartSearch(const std::string& mesh_name, const mesh::MeshView& mesh,
              const geo::ChartUnits& units, const core::Threads& threads);
  /// Of the cells that own points.
  const ChartFacts& facts() const { return facts_; }
  /// On the chart of these facts, of which those of the cells are a part. Throws
  /// Error(INSITU_ERROR_MESH) for a cell at a pole's chart that reaches to the equator.
  ChartCells find(const ChartFacts& whole) const;

private:
  /// A cell that cannot stay where it is.
  struct Odd {
    std::int64_t cell;
    geo::Pole pole; ///< none: it wraps
  };
  struct Look;
  const std::string& name_;
  const mesh::MeshView& mesh_;
  const geo::ChartUnits units_;
  const core::Threads& threads_;
  ChartFacts facts_;
  double east_ = -ChartFacts::none; ///< of all cells that can stay
  std::vector<Odd> odd_;            ///< in ascending order
};

/// The whole turns that bring a longitude within half a turn of the cell's first vertex'.
int turns_to(const geo::ChartUnits& units, double first, double longitude);

} // namespace insitu::commit
