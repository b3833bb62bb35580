#pragma once

#include <optional>
#include <vector>

#include "advect/particles.h"
#include "commit/committed_mesh.h"
#include "parallel/world.h"
#include "scene/checkpoint/kept_cells.h"

/// Particles of all processes in a checkpoint, and on their way back.
namespace insitu::scene {

/// At the root, in the order of ids.
struct KeptParticles {
  std::optional<advect::Particles> all; ///< of several processes
  std::vector<mesh::CellName> cells;    ///< [particle] nameless: it is in no cell
};

/// Collective; throws parallel::AgreedError. mesh: of the particles' cells; null: they are not
/// known.
void gather_kept(const advect::Particles& here, const commit::CommittedMesh* mesh,
                 parallel::World& world, core::Memory& memory, KeptParticles& kept);

/// Where the particles of a checkpoint go.
struct Homecoming {
  const commit::CommittedMesh& mesh;
  const KeptCells* cells; ///< null: nothing is known of the checkpoint's cells
  insitu_accuracy accuracy;
};

/// Takes the particles, which are all at the root, to the processes that have their cells; where
/// cells are others, to those that own the places of particles that are alive. Others stay at the
/// root. names: of their cells, at the root; none: of one process, whose flat ids they have. Can be
/// called again should it fail. Collective; throws parallel::AgreedError.
void deal_kept(advect::Particles& particles, const std::vector<mesh::CellName>& names,
               const Homecoming& home, parallel::World& world);

} // namespace insitu::scene
