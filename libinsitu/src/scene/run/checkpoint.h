#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/archive.h"
#include "mesh/registered/cells_copy.h"
#include "mesh/registered/mesh.h"
#include "query/chart_image.h"

/// What a checkpoint holds besides the tracers.
namespace insitu::scene {

/// The earlier step of a mesh, and of which cells it is.
struct KeptMesh {
  std::string name;
  std::uint64_t fingerprint = 0;
  std::int64_t unguided = 0; ///< commit::CommittedMesh::unguided()
  mesh::EarlierStep step;
  std::optional<query::ChartImage> chart; ///< of a geodetic mesh: where its cells are

  /// cells: those of the step, or none.
  void keep(core::Archive& archive, mesh::CellsCopy& cells);
};

/// A hash of the cells' shapes and vertices in their order (FNV-1a): two meshes of the same
/// fingerprint have, but for a chance of 2^-64, the same topology.
std::uint64_t fingerprint(const mesh::MeshView& mesh, const core::Threads& threads);

/// Removes the files that checkpoint_path() names in the folder for cycles up to `cycle`, but for
/// the last `keep` of them; descends: for those down to it, where a run's cycles go down.
void remove_old_checkpoints(const std::string& folder, std::int64_t cycle, std::int64_t keep,
                            bool descends);
std::string checkpoint_path(const std::string& folder, std::int64_t cycle);

} // namespace insitu::scene
