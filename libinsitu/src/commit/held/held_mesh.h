#pragma once

#include "commit/committed_mesh.h"
#include "mesh/registered/given_copy.h"
#include "parallel/world.h"

namespace insitu::commit {

/// A mesh of steps that are held, apart from the solver: copies of its cells and of their places,
/// with the tree that the solver's mesh had. The steps between which the solver's stood still share
/// one, and put their values into it (mesh::ValuesGiven) when they are shown.
class HeldMesh {
public:
  /// Of a committed mesh. Throws core::Error (INSITU_ERROR_UNSUPPORTED for a mesh in device
  /// memory).
  HeldMesh(const CommittedMesh& of, core::Memory& memory);

  /// Copies what the mesh was given and commits it, on this process. values: of the same step.
  /// Returns whether that built a tree.
  bool copy(const mesh::ValuesGiven& values, const core::Threads& threads);
  /// Collective, after that and before anything else: other processes' cells.
  void meet(parallel::World& world, const core::Threads& threads);

  /// Puts values into the mesh, unless it has these. Returns whether that built a tree.
  bool put(const mesh::ValuesGiven& values, const core::Threads& threads);
  /// The values are about to go: others are put in before anything is asked.
  void forget(const mesh::ValuesGiven& values);

  /// Whether the solver's mesh stands as it was when this one was made.
  bool is_of(const CommittedMesh& mesh) const;
  CommittedMesh& mesh() { return mesh_; }
  const CommittedMesh& mesh() const { return mesh_; }

private:
  core::Memory* memory_;
  const CommittedMesh* of_; ///< until meet()
  std::uint64_t of_id_, topology_, geometry_;
  mesh::CellsGiven cells_;
  CommittedMesh mesh_;
  const mesh::ValuesGiven* values_ = nullptr; ///< those that are in the mesh
};

} // namespace insitu::commit
