#pragma once

#include <cstdint>
#include <span>

#include "commit/committed_mesh.h"
#include "mesh/registered/earlier_step.h"
#include "parallel/world.h"

/// The step before, brought to the processes that have its cells now, on meshes whose cells are the
/// solver's, copies or parts of these: cells here are those of CommittedMesh::mesh().view().
namespace insitu::commit {

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

/// Brings a step of the mesh's own cells, with room for its halo, to the processes that have these
/// cells in theirs. Collective; throws parallel::AgreedError.
void fill_halo(const CommittedMesh& mesh, parallel::World& world, mesh::EarlierStep& step);

} // namespace insitu::commit
