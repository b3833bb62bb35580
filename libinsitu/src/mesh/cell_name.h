#pragma once

#include <compare>
#include <cstdint>

namespace insitu::mesh {

/// A cell as all processes know it. Of the cells that hold a point the least owns it: by global
/// ids, where all cells have them, else by process, piece and cell. rank -1: none.
struct CellName {
  std::int64_t global = -1; ///< its global id; -1: the solver gives none
  std::int32_t rank = -1, piece = -1;
  std::int64_t cell = -1; ///< in the piece
  auto operator<=>(const CellName&) const = default;
};

} // namespace insitu::mesh
