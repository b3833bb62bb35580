#pragma once

#include <compare>
#include <cstdint>
#include <tuple>

namespace insitu::mesh {

/// A cell as all processes know it. Of the cells that hold a point the least owns it: by global
/// ids, where all cells have them, else by process, piece and cell; but cells in their own places
/// before copies on a chart. rank -1: none.
struct CellName {
  std::int64_t global = -1; ///< its global id; -1: the solver gives none
  std::int32_t rank = -1, piece = -1;
  std::int64_t cell = -1; ///< in the piece
  /// 0: where the solver has it; else a copy of a geodetic mesh's cell: moved by whole turns, on
  /// the chart turned north, on that turned south.
  std::int32_t chart = 0;
  std::int32_t copy = 0; ///< 1: the second one there; of what stands in for a polyhedron its number
  bool operator==(const CellName&) const = default;
  auto operator<=>(const CellName& b) const {
    return std::tie(chart, global, rank, piece, cell, copy) <=>
           std::tie(b.chart, b.global, b.rank, b.piece, b.cell, b.copy);
  }
};

} // namespace insitu::mesh
