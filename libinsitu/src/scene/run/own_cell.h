#pragma once

#include <cstdint>
#include <string>

#include "commit/committed_mesh.h"
#include "parallel/world.h"

namespace insitu::scene {

/// A cell of the own view of a mesh (mesh.mesh().own_view()) in the numbering of the solver; all
/// members are -1 outside.
struct OwnCell {
  std::int32_t piece = -1;
  std::int64_t cell = -1;
  std::int64_t flat = -1;   ///< id counted through the pieces, which tables without pieces name
  std::int64_t global = -1; ///< global id, if the mesh has those of cells
  std::int32_t process = -1;
  std::int32_t chart = -1; ///< where it was found, of its places (mesh::CellName)
};
OwnCell own_cell(const mesh::Mesh& mesh, std::int64_t flat, const parallel::World& world);
OwnCell own_cell(const mesh::MeshView& mesh, std::int64_t flat);
/// Returns the OwnCell of a cell of mesh.mesh().view() that holds the point.
OwnCell own_cell(const commit::CommittedMesh& mesh, std::int64_t flat, const math::Vec3d& at);
OwnCell own_cell(const commit::CommittedMesh& mesh, std::int64_t flat, const math::Vec3d& at,
                 const parallel::World& world);

/// Returns whether files name pieces beside cells: they do where a mesh has several pieces, and on
/// adaptive meshes, whose patches come and go, always. A table that grows keeps the answer of the
/// time when it was opened.
bool names_pieces(const mesh::Mesh& mesh);

/// How files name cells: by global ids alone where all processes have those of the mesh's cells,
/// so that files are the same on any number of processes; else by the cell, the piece where a
/// process names it, and the process where there are several. A table that grows keeps the names
/// of the time when it was opened.
struct CellNames {
  bool global = false, pieces = false, processes = false;

  std::int64_t cell(const OwnCell& own) const {
    return global ? own.global : pieces ? own.cell : own.flat;
  }
  /// Throws INSITU_ERROR_FIELD if a table that names cells by global ids cannot take rows with
  /// these names, since the mesh has no global ids any more.
  void require_for(const std::string& path, const CellNames& now) const;
};
/// Collective, with any mesh of that name on each process; it throws nothing.
CellNames name_cells(const mesh::Mesh& mesh, parallel::World& world);

} // namespace insitu::scene
