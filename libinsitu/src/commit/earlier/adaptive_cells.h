#pragma once

#include <cstdint>

#include "commit/earlier/earlier_cells.h"
#include "commit/earlier/earlier_mesh.h"
#include "core/archive.h"

namespace insitu::commit {

/// This process's own cells of an adaptive mesh on which a step was kept, as a checkpoint has them:
/// leaves, or cells of the dual, with all that says how they are found. Values are the step's.
class AdaptiveCells {
public:
  /// Of no adaptive mesh.
  AdaptiveCells() = default;
  /// Of the mesh's view; own: those of the step.
  AdaptiveCells(const Adaptive& mesh, const mesh::MeshView& view, const EarlierMesh::Own& own);
  bool empty() const { return kind_ == CellsKind::cells; }
  CellsKind kind() const { return kind_; }

  /// To a checkpoint or back.
  void keep(core::Archive& archive);
  /// The cells with a step of all vertices, or cells, of the view. process: that had them.
  EarlierCells with(const mesh::EarlierStep& step, int process) const;

private:
  void add_vertices(EarlierCells& to) const;

  CellsKind kind_ = CellsKind::cells;
  /// Of the dual the ids of cells that are in no gridlet alone, flat, and the points of the
  /// vertices behind those of gridlets; of leaves none. No offsets, no fields.
  EarlierCells cells_;
  std::int64_t in_gridlets_ = 0; ///< vertices
};

/// The name of an own cell: of a dual's that of all processes, of a leaf the solver's.
mesh::CellName name_of(const Adaptive& mesh, const EarlierMesh::Own& own, std::int64_t flat);

} // namespace insitu::commit
