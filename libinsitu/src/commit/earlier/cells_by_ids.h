#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "commit/committed_mesh.h"
#include "mesh/registered/earlier_step.h"
#include "parallel/world.h"

/// Cells that are known by their global ids, whichever process has them, of meshes whose cells are
/// the solver's, or parts of these: cells here are those of CommittedMesh::lent_view().
namespace insitu::commit {

/// Whether the cells of this process have ids: global ids, and of polyhedra such as leave room for
/// the number of a part.
bool are_known_by_ids(const CommittedMesh& mesh);
/// By which a cell is known in files, and between processes: its global id, and of a part of a
/// polyhedron with the number of the part.
std::int64_t id_of_cell(const CommittedMesh& mesh, std::int64_t flat);

/// Finds this process's cells by their ids.
class CellsByIds {
public:
  explicit CellsByIds(const CommittedMesh& mesh);
  /// The flat id of the cell that this process owns; -1: it has none of this name.
  std::int64_t find(const CellName& name) const;

private:
  bool of_parts_;
  std::vector<std::pair<std::int64_t, std::int64_t>> cells_; ///< ascending
};

/// The ids of this process's cells, ghosts among them; none if it has no such ids.
std::vector<std::int64_t> ids_of_cells(const CommittedMesh& mesh);

/// A sum over the cells that this process owns of hashes of their ids, shapes and their vertices'
/// ids, if these have some. Over all processes it wraps to the same number however cells are dealt.
std::uint64_t sum_of_cells(const CommittedMesh& mesh, const core::Threads& threads);

/// A step that was kept, on its own cells, of some of a mesh's cells.
struct StepPart {
  const mesh::EarlierStep* step;
  const mesh::MeshView* cells;
  std::span<const std::int64_t> ids; ///< [cell]
};

/// The fields of a step, without values, of the first process that has some (mine not null).
/// Collective; throws parallel::AgreedError.
mesh::EarlierStep fields_of_all(const mesh::EarlierStep* mine, parallel::World& world);

/// Brings a step on cells of all processes to the processes that have these cells now. parts: what
/// this process has of it, some or none; each cell is in one part, of some process. step: has the
/// fields of fields_of_all(), and becomes that of the mesh's own cells, with room for a halo behind
/// them; vertices of no own cell have zeros and stand where they are now. Returns false on all
/// processes alike if cells or fields are others: an id is missing, a shape is another, or cells
/// with a vertex in common do not agree on its place. Collective; throws parallel::AgreedError.
bool deal_by_ids(std::span<const StepPart> parts, const CommittedMesh& mesh, parallel::World& world,
                 mesh::EarlierStep& step);

} // namespace insitu::commit
