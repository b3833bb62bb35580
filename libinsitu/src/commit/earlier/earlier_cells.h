#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/memory.h"
#include "core/parallel.h"
#include "mesh/box.h"
#include "mesh/cell_name.h"
#include "mesh/gridlet.h"
#include "mesh/registered/cells_copy.h"
#include "mesh/registered/earlier_step.h"
#include "parallel/world.h"

namespace insitu::commit {

/// Where a cell of an adaptive mesh's dual stands, or a leaf lies.
struct Spot {
  static constexpr std::uint8_t in_gridlet = 0xff;
  std::int32_t
      index[3]; ///< of its corner, of the leaf at its lowest vertex in a gridlet, or its own
  std::uint8_t depth;
  std::uint8_t kind; ///< amr::CornerKind's code, 0: at no corner; in_gridlet
  std::uint8_t unused[2] = {0, 0};
};
static_assert(sizeof(Spot) == 16);

/// What cells of a step that has passed are, and how they are found; those of a dual are right by
/// construction.
enum class CellsKind : std::int64_t { cells, dual_cells, leaves_by_places, dual_by_places };

/// Some cells of a step that has passed, with all that was kept of them: as one process tells them
/// to another, or those of several put together.
struct EarlierCells {
  std::vector<mesh::CellName> names;
  std::vector<std::int64_t> offsets{0}; ///< of ids; one more than cells
  std::vector<std::int64_t> ids;        ///< of vertices
  std::vector<std::uint8_t> types;
  std::vector<std::int8_t> poles; ///< geo::Pole of each cell; empty: none has one
  mesh::EarlierStep step;         ///< of these cells and vertices, of each field one step
  // Of an adaptive mesh's cells that are found by their places.
  mesh::Lattice lattice;
  std::vector<Spot> spots;             ///< of cells
  std::vector<mesh::Gridlet> gridlets; ///< in which some of them are, whole
  std::vector<Spot> leaves;            ///< those around, each once over all processes

  parallel::Parcel parcel(int to) const;
  /// The names' rank is that of the sender. Throws core::Error (INSITU_ERROR_INTERNAL).
  static EarlierCells read(const parallel::Parcel& parcel);
  /// Of several processes in the order of their names; vertices one process after the other.
  static EarlierCells joined(const std::vector<EarlierCells>& parts);

  std::size_t count() const { return names.size(); }
  /// The cells alone, those on each chart a piece. Vertices come in the order of these pieces, and
  /// so do the step's.
  mesh::CellsCopy copy(core::Memory& memory, const core::Threads& threads);
  /// Those that meet the boxes, of cells that are of a dual or leaves by places.
  EarlierCells in(std::span<const mesh::Box> boxes) const;
  /// Puts vertices into another order: that which is number[v] goes to v; -1: none, whose values
  /// are NaN. Ids are left as they are.
  void order_vertices(std::span<const std::int64_t> number);
};

} // namespace insitu::commit
