#pragma once

#include <cstdint>
#include <optional>

#include "commit/earlier/cells_by_ids.h"
#include "mesh/cell_name.h"

namespace insitu::scene {

/// Finds the cells that a checkpoint names in a mesh, of whichever processes they are now.
class KeptCells {
public:
  /// How cells are known again: not at all, since they are others; by process, piece and number,
  /// where each process has those that it had; or by their global ids.
  enum class By { nothing, numbers, ids };

  /// The mesh must outlive the object, its cells stay until the last find().
  KeptCells(By by, const commit::CommittedMesh& mesh, int rank);

  /// Whether the mesh has the checkpoint's cells.
  bool stand() const { return by_ != By::nothing; }
  const commit::CommittedMesh& mesh() const { return mesh_; }
  /// The flat id of the cell in the mesh's view, if it is this process's; else -1.
  std::int64_t find(const mesh::CellName& name) const;

private:
  By by_;
  const commit::CommittedMesh& mesh_;
  int rank_;
  std::optional<commit::CellsByIds> ids_;
};

/// A cell of the mesh's view, with its global id if the cells are the solver's; nameless below 0.
mesh::CellName kept_name(const commit::CommittedMesh& mesh, std::int64_t flat, int rank);

/// Whether a checkpoint names cells besides their flat ids: those of several processes, and those
/// that have global ids.
bool names_cells(const commit::CommittedMesh& mesh, const parallel::World& world);

} // namespace insitu::scene
