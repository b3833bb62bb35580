#pragma once

#include <optional>
#include <span>

#include "advect/exits.h"
#include "commit/committed_mesh.h"
#include "query/some_cells.h"

namespace insitu::scene {

/// The cells that a tracer's particles move in, and those beyond its walls. Kept from step to step.
class TracerCells {
public:
  explicit TracerCells(core::Memory& memory)
      : memory_(&memory), with_values_(memory), left_out_(memory) {}

  /// The sampler of the mesh on the cells in which the velocity has values in all of these fields,
  /// of which the first is the current one; the mesh's own where none is blank. Until the next call
  /// or commit.
  query::Sampler sampler(const commit::CommittedMesh& mesh,
                         std::span<const mesh::FieldView> velocities, const core::Threads& threads);
  /// The same of an earlier mesh's sampler and the velocity on its cells.
  query::Sampler earlier_sampler(const query::Sampler& sampler, const mesh::FieldView& velocity,
                                 const core::Threads& threads);

  /// The cells that own no points though their ids and coordinates can be read; null: the mesh has
  /// none such.
  query::SomeCells* left_out(const commit::CommittedMesh& mesh, const core::Threads& threads);

private:
  /// What is known of the mesh that some cells are of.
  struct Versions {
    std::uint64_t mesh_id = 0, topology = 0, geometry = 0;
    query::SomeCells::Changed update(const commit::CommittedMesh& mesh);
  };

  core::Memory* memory_;
  query::SomeCells with_values_, left_out_;
  std::optional<query::SomeCells> earlier_;
  Versions of_values_, of_left_out_;
};

} // namespace insitu::scene
